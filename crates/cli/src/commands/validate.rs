//! `validate`: validation of the estimated models.

use std::path::{Path, PathBuf};

use clap::Parser;
use estimation::{ValidationRuns, not_relative};
use files::{Provenance, TableReader};
use serde_json::json;
use ship::model::Vessel;
use study::campaign_file::CampaignFile;
use study::estimates;
use study::files::{read_any_simulated, read_campaign};
use study::scores::{self, Row};
use study::trajectories::refuse_shard;

use crate::cli::{Common, Sharding, beside, given};
use crate::failure::{Failure, Progress};
use crate::inputs::{self, Made};
use crate::stage::{Summary, Task};

/// Scores each estimate by how far its parameters and simulations are off; writes scores.parquet and validation.json
#[derive(Parser)]
#[command(
    name = "validate",
    after_help = "Example:\n  validate --vessel pipelines/paper/vessel.toml \
    --campaign pipelines/paper/campaign.toml --estimates estimates.parquet --validation validation.parquet \
    --out scores.parquet"
)]
pub struct ValidateArguments {
    /// The vessel
    #[arg(long, visible_alias = "model", value_name = "vessel.toml")]
    vessel: PathBuf,
    /// The bounds below which an estimate counts as good
    #[arg(long, value_name = "campaign.toml")]
    campaign: PathBuf,
    /// The estimates
    #[arg(long, required_unless_present = "gather", value_name = "estimates.parquet")]
    estimates: Option<PathBuf>,
    /// Runs to simulate freely and compare with
    #[arg(long, value_name = "validation.parquet")]
    validation: PathBuf,
    #[command(flatten)]
    sharding: Sharding,
}

/// The usual name of the table.
const MAIN: &str = "scores.parquet";

/// Samples of validation runs per second that a thread simulates and compares, order of magnitude: the paper's on a
/// server of 2024 (0.04 s for a thousand estimates and a thousand samples).
const SIMULATED_PER_SECOND: f64 = 2.5e7;

impl Task for ValidateArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("validate");
        let vessel = read_any_simulated(&self.vessel, &mut provenance)?;
        let config = read_campaign(&self.campaign, &mut provenance)?;
        let validation = validation_runs(&self.validation, &vessel, &mut provenance)?;
        let inputs = [&self.vessel, &self.campaign, &self.validation].into_iter();
        let inputs = inputs.chain(&self.estimates).chain(&self.sharding.gather);
        let out = common.main_output(MAIN, inputs)?;
        let document = beside(&out, MAIN, "validation.json");
        let made = match self.sharding.gathers() {
            true => {
                let shards = &self.sharding.gather;
                Made::gathered(shards, [&out, &document], &scores::columns(), provenance, scores::rows)?
            }
            false => self.computed(&vessel, &validation, provenance, [&out, &document], common.quiet)?,
        };
        Ok(publish(&config, &validation, &document, made)?.also(not_relative(&vessel)))
    }
}

impl ValidateArguments {
    /// Scores the estimates of this shard, or all.
    fn computed(
        &self,
        vessel: &Vessel,
        validation: &ValidationRuns,
        mut provenance: Provenance,
        out: [&Path; 2],
        quiet: bool,
    ) -> Result<Made<Row>, Failure> {
        let file = given(&self.estimates, "estimates")?;
        let reader = TableReader::open(file, estimates::ID, estimates::VERSION)?;
        reader.require(&estimates::columns(vessel).schema().columns)?;
        if let Some(shard) = &reader.provenance().shard {
            return Err(refuse_shard(file, shard).into());
        }
        provenance.made("estimates", file, reader.digest(), reader.provenance())?;
        study::note_seed(reader.provenance(), &mut provenance);
        provenance.shard = self.sharding.shard;
        let truth: Option<Vec<f64>> = vessel.value.iter().copied().collect();
        let blocks = self.sharding.shard.map_or(reader.blocks(), |s| s.range(reader.blocks()).len());
        let share = blocks as f64 / reader.blocks().max(1) as f64;
        let seconds = share * reader.rows() as f64 * validation.samples() as f64 / SIMULATED_PER_SECOND;
        let progress = Progress::new("blocks of estimates", blocks, quiet).foretold(seconds);
        let score = |i: usize| {
            let score = validation.score(&estimates::rows(&reader, vessel, file, i)?, truth.as_deref());
            progress.advance(1);
            Ok(score)
        };
        let made = Made::computed(out, &scores::columns(), provenance, reader.blocks(), score)?;
        match scores::doubled(&made.rows) {
            None => Ok(made),
            Some(row) => Err(Failure::refuse(
                file,
                &format!("design {}, run {}", row.design, row.run),
                &format!("its estimate by {} twice", row.estimator),
                "every estimate once",
                "estimate again",
            )),
        }
    }
}

fn validation_runs<'a>(
    file: &Path,
    vessel: &'a Vessel,
    provenance: &mut Provenance,
) -> Result<ValidationRuns<'a>, Failure> {
    let reader = inputs::trajectories(file, "validation", vessel, provenance)?;
    let runs = inputs::all(file, &reader, vessel)?;
    ValidationRuns::new(vessel, runs).ok_or_else(|| {
        Failure::refuse(file, "rows", "none", "at least one run", "simulate the validation again")
    })
}

fn publish(
    config: &CampaignFile,
    validation: &ValidationRuns,
    document: &Path,
    made: Made<Row>,
) -> Result<Summary, Failure> {
    let Made { table, provenance, rows } = made;
    let out = table.path().to_owned();
    let found = study::validated(&rows, config.bounds(), validation.samples(), &provenance);
    let diverged: u64 = found.designs.iter().map(|d| d.diverged).sum();
    let summary = Summary::of(
        &out,
        format!("{} runs, {diverged} diverged", rows.len()),
        json!({"runs": rows.len(), "diverged": diverged, "designs": found.designs}),
    );
    inputs::publish(table, document, &provenance, || Ok(found))?;
    Ok(summary)
}
