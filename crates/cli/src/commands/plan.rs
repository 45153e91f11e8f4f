//! `plan`: one trajectory with every maneuver as often as the design requires.

use std::path::{Path, PathBuf};

use clap::{Args, Parser};
use plan::voyage::Place;
use study::plan::{Begun, FollowFiles, SoFar, place};

use crate::cli::{Common, LimitFlags, check_positive, given};
use crate::failure::Failure;
use crate::plan::{MAIN, VoyageFiles, Wanted, plan_problem, plan_voyage};
use crate::stage::{Summary, Task};

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
pub struct PlanArguments {
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
struct How {
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

impl Task for PlanArguments {
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

// `plan resume`: the rest of a trial, from the ship's position; `plan follow`: the same from her positions so far.

/// The files of a plan that was begun.
#[derive(Args)]
struct Rest {
    /// The plan that was begun
    #[arg(long, value_name = "plan.json")]
    plan: PathBuf,
    /// The vessel, or the model identified so far
    #[arg(long, visible_alias = "model", value_name = "vessel.toml")]
    vessel: PathBuf,
    /// The maneuvers' trajectories (simulate dictionary)
    #[arg(long, value_name = "dictionary.parquet")]
    trajectories: PathBuf,
    /// Chart, lattice, safety, start and goal, as the plan was made with
    #[arg(long, value_name = "plan.toml")]
    config: PathBuf,
    #[command(flatten)]
    how: How,
}

impl Rest {
    fn plan(&self, so_far: SoFar, common: &Common, stage: &str) -> Result<Summary, Failure> {
        let begun = Begun { plan: &self.plan, so_far };
        let files = VoyageFiles {
            vessel: &self.vessel,
            config: &self.config,
            trajectories: &self.trajectories,
            dictionary: self.how.dictionary.as_deref(),
            design: None,
            beyond_range: self.how.beyond_range,
            begun: Some(begun),
        };
        let out = common.main_output(MAIN, files.inputs().chain(begun.files()))?;
        self.how.plan(&files, &out, common, stage)
    }
}

/// Plans the rest of a trial that was interrupted or driven off, or has a maneuver to repeat, from where the ship is
#[derive(Parser)]
#[command(
    name = "resume",
    after_help = "Example:\n  plan resume --plan out/helsinki/plan.json --done 4 --from 24.96,60.14,135,half \
    --vessel pipelines/helsinki/vessel.toml --trajectories out/helsinki/dictionary.parquet \
    --dictionary pipelines/helsinki/dictionary.toml --config pipelines/helsinki/plan.toml --out out/rest/plan.json"
)]
pub struct Resume {
    /// How many of its steps are done; maneuvers among them are not repeated
    #[arg(long, value_name = "STEPS")]
    done: usize,
    /// Where the ship goes on, in degrees, and its speed mode if it is under way
    #[arg(long, value_name = "LON,LAT,HEADING[,MODE]", value_parser = place, allow_hyphen_values = true)]
    from: Place,
    #[command(flatten)]
    rest: Rest,
}

impl Task for Resume {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        self.rest.plan(SoFar::Steps(self.done, &self.from), common, "plan resume")
    }
}

/// Finds where the ship is in a plan by her positions so far, and plans the rest from there
#[derive(Parser)]
#[command(
    name = "follow",
    after_help = "Example:\n  plan follow --plan out/helsinki/plan.json --positions positions.csv \
    --vessel pipelines/helsinki/vessel.toml --trajectories out/helsinki/dictionary.parquet \
    --dictionary pipelines/helsinki/dictionary.toml --config pipelines/helsinki/plan.toml --set plan.safety.runs=64 --out out/rest/plan.json\n\n\
    positions.csv has the columns time (seconds since the departure, or 2026-06-01T08:00:00Z), longitude_deg, latitude_deg and, \
    if known, heading_deg and speed_m_s. Beside the plan of the rest stands follow.json: what is done, and how much of the \
    information it has. With nothing left to plan, it stands alone."
)]
pub struct Follow {
    /// The positions since the departure: a table, or NMEA 0183 in a file called .nmea
    #[arg(long, value_name = "positions.csv")]
    positions: PathBuf,
    /// How far from its track a step may be sailed to count as done (default: tolerance, spread and what positions may be off)
    #[arg(long, value_name = "METRES")]
    within_m: Option<f64>,
    /// The longest time between two positions within a maneuver
    #[arg(long, value_name = "SECONDS", default_value_t = 30.0)]
    max_gap_s: f64,
    #[command(flatten)]
    rest: Rest,
}

impl Task for Follow {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let Self { positions, within_m, max_gap_s, rest } = self;
        check_positive("--within-m", *within_m)?;
        check_positive("--max-gap-s", Some(*max_gap_s))?;
        let files = FollowFiles { plan: &rest.plan, positions, within_m: *within_m, max_gap_s: *max_gap_s };
        rest.plan(SoFar::Positions(files), common, "plan follow")
    }
}
