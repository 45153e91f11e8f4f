//! `plan resume`: the rest of a trial, from the ship's position; `plan follow`: the same from her positions so far.

use std::path::PathBuf;

use clap::{Args, Parser};
use plan::voyage::Place;
use study::plan::{Begun, FollowFiles, SoFar, place};

use super::plan::How;
use crate::cli::{Common, check_positive};
use crate::failure::Failure;
use crate::plan::{MAIN, VoyageFiles};
use crate::stage::{Summary, Task};

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
