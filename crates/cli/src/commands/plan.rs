//! `plan`: one trajectory with every maneuver as often as the design requires.

use std::path::{Path, PathBuf};

use crate::cli::{Common, given};
use crate::failure::Failure;
use crate::limits::LimitFlags;
use crate::plan::{MAIN, VoyageFiles, Wanted, plan_problem, plan_voyage};
use crate::stage::{Summary, Task};
use clap::Parser;

/// Plans a trial on a chart: the provably shortest track, with routes for the bridge; or solves a lattice problem
#[derive(Parser)]
#[command(
    name = "plan",
    after_help = "Example:\n  plan --vessel pipelines/helsinki/vessel.toml --trajectories out/helsinki/dictionary.parquet \
    --dictionary pipelines/helsinki/dictionary.toml --config pipelines/helsinki/plan.toml --out out/helsinki/plan.json\n  \
    plan --problem fixtures/lattice/channel.json --out plan.json\n\n\
    Beside the plan of a trial stand track.parquet, track.geojson, route.rtz, .gpx and .plan, map.json (what the map \
    shows) and map.svg.\n\n\
    --memory-mib counts every phase, and 24 MiB of the program's own; without it 4096 MiB at most."
)]
pub struct Arguments {
    /// A lattice problem to solve instead of a chart (schema experiment-lattice-planning/1)
    #[arg(long, value_name = "problem.json", conflicts_with_all = ["vessel", "trajectories", "config", "dictionary", "design", "export_problem"])]
    problem: Option<PathBuf>,
    /// The vessel
    #[arg(long, visible_alias = "model", required_unless_present = "problem", value_name = "vessel.toml")]
    vessel: Option<PathBuf>,
    /// The maneuvers' trajectories (simulate dictionary)
    #[arg(long, required_unless_present = "problem", value_name = "dictionary.parquet")]
    trajectories: Option<PathBuf>,
    /// Chart, lattice, safety, counts, start and goal
    #[arg(long, required_unless_present = "problem", value_name = "plan.toml")]
    config: Option<PathBuf>,
    /// The design, for counts that follow from its shares
    #[arg(long, value_name = "design.json")]
    design: Option<PathBuf>,
    #[command(flatten)]
    how: How,
}

/// Options of planning a trial.
#[derive(clap::Args)]
pub(super) struct How {
    /// The dictionary of the trajectories: maneuvers that react to the ship are sailed by their own commands
    #[arg(long, value_name = "dictionary.toml")]
    pub(super) dictionary: Option<PathBuf>,
    /// Write a plan whose check runs aground or breaks the margin, too; every output is labelled as unsafe
    #[arg(long)]
    allow_unsafe: bool,
    /// Write the lattice problem that was solved, too: for other solvers, and for --problem
    #[arg(long, value_name = "problem.json")]
    export_problem: Option<PathBuf>,
    /// Allow inputs that the logs of a model from logs do not cover; plan and report say where maneuvers leave them
    #[arg(long)]
    pub(super) beyond_range: bool,
    #[command(flatten)]
    limits: LimitFlags,
}

impl Task for Arguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        if let Some(problem) = &self.problem {
            let limits = self.how.limits.limits(common)?;
            let out = common.main_output(MAIN, [problem])?;
            return plan_problem(problem, &out, &limits, common.provenance("plan"));
        }
        let files = VoyageFiles {
            vessel: given(&self.vessel, "vessel")?,
            config: given(&self.config, "config")?,
            trajectories: given(&self.trajectories, "trajectories")?,
            dictionary: self.how.dictionary.as_deref(),
            design: self.design.as_deref(),
            beyond_range: self.how.beyond_range,
            begun: None,
        };
        let out = common.main_output(MAIN, files.inputs())?;
        self.how.plan(&files, &out, common, "plan")
    }
}

impl How {
    /// Plans a trial on a chart.
    pub(super) fn plan(
        &self,
        files: &VoyageFiles,
        out: &Path,
        common: &Common,
        stage: &str,
    ) -> Result<Summary, Failure> {
        let (limits, seed) = (self.limits.limits(common)?, common.seed.unwrap_or(1));
        let wanted = Wanted { out, problem: self.export_problem.as_deref(), unsafe_too: self.allow_unsafe };
        plan_voyage(files, &wanted, &limits, seed, common.provenance(stage))
    }
}
