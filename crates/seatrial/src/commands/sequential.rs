//! `sequential`: trials designed in rounds.

use std::path::PathBuf;

use crate::cli::{Common, provenance};
use crate::failure::Failure;
use crate::sequential;
use crate::stage::{Summary, Task};
use clap::Parser;

/// Designs, sails and estimates in rounds, from a crude model, against designs made once, over Monte Carlo; writes
/// sequential.parquet and sequential.json
#[derive(Parser)]
#[command(
    name = "sequential",
    version,
    after_help = "Example:\n  sequential --vessel pipelines/paper/vessel.toml --dictionary pipelines/paper/dictionary.toml \
    --campaign pipelines/paper/campaign.toml --config pipelines/sequential/sequential.toml --out sequential.parquet"
)]
pub struct Arguments {
    /// The vessel, with its true parameters
    #[arg(long, value_name = "vessel.toml")]
    vessel: PathBuf,
    /// The maneuvers
    #[arg(long, value_name = "dictionary.toml")]
    dictionary: PathBuf,
    /// The disturbances
    #[arg(long, value_name = "campaign.toml")]
    campaign: PathBuf,
    /// Rounds, sea time, accuracy
    #[arg(long, value_name = "sequential.toml")]
    config: PathBuf,
    #[command(flatten)]
    common: Common,
}

impl Task for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn run(&self) -> Result<Summary, Failure> {
        stage(self)
    }
}

fn stage(a: &Arguments) -> Result<Summary, Failure> {
    let inputs = [a.vessel.as_path(), &a.dictionary, &a.campaign, &a.config];
    let wanted = sequential::Wanted {
        vessel: &a.vessel,
        dictionary: &a.dictionary,
        campaign: &a.campaign,
        config: &a.config,
        seed: a.common.seed,
        out: a.common.main_output("sequential.parquet", &inputs)?,
        quiet: a.common.quiet,
    };
    sequential::run(&wanted, provenance("sequential"))
}
