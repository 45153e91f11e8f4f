//! `plan resume`: the rest of a trial, from the ship's position.

use std::path::PathBuf;

use clap::Parser;
use study::plan::place;
use trial::voyage::Place;

use super::plan::How;
use crate::cli::Common;
use crate::failure::Failure;
use crate::plan::{MAIN, Resumed, VoyageFiles};
use crate::stage::{Summary, Task};

/// Plans the rest of a trial from where the ship is, after some steps of its plan: interrupted, driven off, or with a maneuver to repeat
#[derive(Parser)]
#[command(
    name = "resume",
    after_help = "Example:\n  plan resume --plan out/helsinki/plan.json --done 4 --from 24.96,60.14,135,half \
    --vessel pipelines/helsinki/vessel.toml --trajectories out/helsinki/dictionary.parquet \
    --config pipelines/helsinki/plan.toml --out out/rest/plan.json"
)]
pub struct Arguments {
    /// The plan that was begun
    #[arg(long, value_name = "plan.json")]
    plan: PathBuf,
    /// How many of its steps are done; maneuvers among them are not repeated
    #[arg(long, value_name = "STEPS")]
    done: usize,
    /// Where the ship goes on, in degrees, and its speed mode if it is under way
    #[arg(long, value_name = "LON,LAT,HEADING[,MODE]", value_parser = place, allow_hyphen_values = true)]
    from: Place,
    /// The vessel
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

impl Task for Arguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let files = VoyageFiles {
            vessel: &self.vessel,
            config: &self.config,
            trajectories: &self.trajectories,
            dictionary: self.how.dictionary.as_deref(),
            design: None,
            beyond_range: self.how.beyond_range,
            resumed: Some(Resumed { plan: &self.plan, done: self.done, from: &self.from }),
        };
        let out = common.main_output(MAIN, files.inputs().chain([&*self.plan]))?;
        self.how.plan(&files, &out, common, "plan resume")
    }
}
