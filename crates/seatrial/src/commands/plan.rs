//! `plan`: one trajectory that uses every maneuver as often as the design wants.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::cli::{Common, budget, given};
use crate::failure::Failure;
use crate::plan::{Limits, MAIN, VoyageFiles, Wanted, plan_problem, plan_voyage};
use crate::stage::{Summary, Task};
use clap::{Parser, ValueEnum};
use lattice::{Engine, Options};

/// Plans a trial as one trajectory on a chart, provably the cheapest, with routes for the bridge; or solves a lattice problem
#[derive(Parser)]
#[command(
    name = "plan",
    after_help = "Example:\n  plan --vessel pipelines/helsinki/vessel.toml --trajectories out/helsinki/dictionary.parquet \
    --config pipelines/helsinki/plan.toml --out out/helsinki/plan.json\n  \
    plan --problem fixtures/lattice/channel.json --out plan.json\n\n\
    Without --memory-mib it takes at most 4096 MiB, on any machine that has them."
)]
pub struct Arguments {
    /// A lattice problem to solve instead of a chart (schema experiment-lattice-planning/1)
    #[arg(long, value_name = "problem.json", conflicts_with_all = ["vessel", "trajectories", "config", "design", "export_problem"])]
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

/// How a trial is planned.
#[derive(clap::Args)]
pub(super) struct How {
    /// Stop after this time, all phases counted, with the best plan so far and its gap
    #[arg(long, value_name = "SECONDS")]
    time_limit_s: Option<f64>,
    /// Write a plan whose check runs aground or breaks the margin, too; every output is labelled as unsafe
    #[arg(long)]
    allow_unsafe: bool,
    /// Write the lattice problem that was solved, too: for other solvers, and for --problem
    #[arg(long, value_name = "problem.json")]
    export_problem: Option<PathBuf>,
    /// How to search
    #[arg(long, value_enum, default_value_t = EngineChoice::Auto)]
    engine: EngineChoice,
}

#[derive(Clone, Copy, ValueEnum)]
enum EngineChoice {
    /// Exhaustive where it fits in the memory, otherwise Lagrangian
    Auto,
    /// Every state in order of cost
    Exhaustive,
    /// Bounds from priced counts, a beam for plans, A* for the proof
    Lagrangian,
}

impl Task for Arguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        if let Some(problem) = &self.problem {
            let limits = self.how.limits(common)?;
            let out = common.main_output(MAIN, [problem])?;
            return plan_problem(problem, &out, &limits, common.provenance("plan"));
        }
        let files = VoyageFiles {
            vessel: given(&self.vessel, "vessel")?,
            config: given(&self.config, "config")?,
            trajectories: given(&self.trajectories, "trajectories")?,
            design: self.design.as_deref(),
            resumed: None,
        };
        let inputs = [files.vessel, files.config, files.trajectories].into_iter().chain(files.design);
        let out = common.main_output(MAIN, inputs)?;
        self.how.plan(&files, &out, common, "plan")
    }
}

impl How {
    fn limits(&self, common: &Common) -> Result<Limits, Failure> {
        let time = match self.time_limit_s {
            Some(s) if !(s.is_finite() && s > 0.0 && s < 1e9) => {
                let message = format!("--time-limit-s: found {s}, expected seconds above 0; correct it");
                return Err(Failure::Usage(message));
            }
            time => time.map(Duration::from_secs_f64),
        };
        Ok(Limits {
            engine: match self.engine {
                EngineChoice::Auto => Engine::Auto,
                EngineChoice::Exhaustive => Engine::Exhaustive,
                EngineChoice::Lagrangian => Engine::Lagrangian,
            },
            memory_bytes: memory_bytes(common),
            started: Instant::now(),
            time,
            quiet: common.quiet,
        })
    }

    /// Plans a trial on a chart.
    pub(super) fn plan(
        &self,
        files: &VoyageFiles,
        out: &Path,
        common: &Common,
        stage: &str,
    ) -> Result<Summary, Failure> {
        let (limits, seed) = (self.limits(common)?, common.seed.unwrap_or(1));
        let wanted = Wanted { out, problem: self.export_problem.as_deref(), unsafe_too: self.allow_unsafe };
        plan_voyage(files, &wanted, &limits, seed, common.provenance(stage))
    }
}

/// What chart, lattice and search may take: what there is, but no more than usual where nobody asks for more, for a search
/// grows into all that it may have, and a plan should not depend on the machine.
fn memory_bytes(common: &Common) -> u64 {
    let usual = common.memory_mib.map_or(Options::default().memory_bytes as f64, |_| f64::INFINITY);
    budget().bytes().min(usual) as u64
}
