//! `sequential`: trials designed in rounds.

use std::path::{Path, PathBuf};

use clap::Parser;
use estimation::Estimator;
use estimation::predictor::InitialState;
use estimation::runs::{AdditionalUnknowns, RunEstimators};
use files::{Provenance, Work};
use numerics::LANES;
use refusal::Invalid;
use regression::MeanRemoval;
use serde_json::json;
use study::files::{StageOfTerms, read_campaign, read_dictionary, read_sequential};
use study::sequential::{SequentialFile, columns, document, rows};
use trial::rounds::{self, Arm, Row, Trial};

use crate::cli::{Common, Sharding, beside, budget};
use crate::failure::{Failure, Progress};
use crate::inputs::{self, Made};
use crate::simulate::Files;
use crate::stage::{Summary, Task};

/// Simulates trials that are designed in rounds, from a crude model, beside trials that are designed once; writes
/// sequential.parquet and sequential.json
#[derive(Parser)]
#[command(
    name = "sequential",
    after_help = "Example:\n  sequential --vessel pipelines/paper/vessel.toml --dictionary pipelines/paper/dictionary.toml \
    --campaign pipelines/paper/campaign.toml --config pipelines/sequential/sequential.toml --out sequential.parquet"
)]
pub struct SequentialArguments {
    /// The vessel, with its true parameters
    #[arg(long, visible_alias = "model", value_name = "vessel.toml")]
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
    sharding: Sharding,
}

/// The usual name of the table.
const MAIN: &str = "sequential.parquet";

impl Task for SequentialArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("sequential");
        let inputs = [&self.vessel, &self.dictionary, &self.campaign, &self.config].into_iter();
        let out = common.main_output(MAIN, inputs.chain(&self.sharding.gather))?;
        let vessel = StageOfTerms::Sequential.read_simulated(&self.vessel, &mut provenance)?;
        let generator = read_dictionary(&self.dictionary, &vessel, &mut provenance)?;
        let campaign = read_campaign(&self.campaign, &mut provenance)?;
        let config = read_sequential(&self.config, &mut provenance)?;
        let seed = common.seed.unwrap_or(campaign.seed);
        provenance.settings.insert("seed".into(), json!(seed));
        let of = |file: &'_ Path| {
            let file = file.to_owned();
            move |e: Invalid| Failure::invalid(&file, &e)
        };
        rounds::truth(&vessel).map_err(of(&self.vessel))?;
        let knowledge = config.knowledge(&vessel, seed).map_err(of(&self.config))?;
        let rounds = config.rounds as usize;
        let ends = rounds::ends(&vessel, config.duration_s, rounds).map_err(of(&self.config))?;
        self.check_room(&config)?;
        let noise = campaign.predictable_noise().map_err(of(&self.campaign))?;
        let sea = campaign.sea(&vessel).map_err(of(&self.vessel))?;
        let estimators = RunEstimators {
            vessel: &vessel,
            estimators: vec![Estimator::OutputError],
            removal: MeanRemoval::Complete,
            initial: InitialState::Known,
            additional: AdditionalUnknowns::default(),
            levels: Some(campaign.levels(vessel.sample_rate_hz)),
        };
        let segments = campaign.random.map_or(5, |random| random.segments as usize);
        let files = Files {
            vessel: &self.vessel,
            dictionary: &self.dictionary,
            campaign: &self.config,
            sea: &self.campaign,
            design: &self.config,
        };
        let trial = Trial::new(sea, &generator, noise, estimators, knowledge, ends, segments)
            .map_err(|e| files.refused(e))?;
        let (document, rate_hz) = (beside(&out, MAIN, "sequential.json"), vessel.sample_rate_hz);
        let outputs = [out.as_path(), document.as_path()];
        let made = if self.sharding.gathers() {
            let shards = &self.sharding.gather;
            Made::gathered(shards, outputs, &columns(rate_hz), provenance, |reader| rows(reader, rate_hz))?
        } else {
            provenance.shard = self.sharding.shard;
            realized(&trial, &files, (config.realizations, rate_hz), outputs, (provenance, common.quiet))?
        };
        publish(self, &document, made, &trial, (&config, rate_hz))
    }
}

impl SequentialArguments {
    /// Refuses more realizations than fit into memory: their rows are kept for the summary while they are converted
    /// to columns.
    fn check_room(&self, config: &SequentialFile) -> Result<(), Failure> {
        let (realizations, rounds) = (config.realizations, config.rounds);
        let rows = f64::from(realizations) * Arm::ALL.len() as f64 * f64::from(rounds);
        let found = format!("{realizations} realizations of {rounds} rounds");
        let remedy = "take fewer `realizations`, or --shard";
        let work = Work { file: &self.config, thing: "`realizations`", found: &found, remedy };
        let part = f64::from(self.sharding.shard.map_or(1, |shard| shard.count));
        Ok(budget().memory(work, 2.0 * rows / part * size_of::<Row>() as f64)?)
    }
}

fn publish(
    a: &SequentialArguments,
    file: &Path,
    made: Made<Row>,
    trial: &Trial,
    (config, rate_hz): (&SequentialFile, f64),
) -> Result<Summary, Failure> {
    if let Some(shard) = made.provenance.shard {
        return made.publish_shard(shard, "rows");
    }
    let Made { table, provenance, rows } = made;
    let (out, count) = (table.path().to_owned(), config.realizations);
    if rows.iter().all(|row| row.parameter_error.is_none()) {
        return Err(Failure::NoAnswer(format!(
            "{}: rounds: found no estimate in any of {count} realizations, expected some that converge; lengthen `duration_s`, or \
             give the vessel a nominal model nearer to it",
            a.config.display(),
        )));
    }
    let summary = rounds::Summary::new(&rows, trial.ends(), config.accuracy, rate_hz);
    let document = document(config, summary, trial.maneuvers());
    let said: Vec<String> =
        trial.statement().into_iter().chain(document.statements.iter().cloned()).collect();
    let said = said.join("; ");
    let details = json!({"realizations": count, "statements": document.statements});
    inputs::publish(table, file, &provenance, || Ok(document))?;
    Ok(Summary::of(&out, format!("{count} realizations; {said}"), details))
}

/// The rows of this shard, or all.
fn realized(
    trial: &Trial,
    files: &Files,
    (count, rate_hz): (u32, f64),
    out: [&Path; 2],
    (provenance, quiet): (Provenance, bool),
) -> Result<Made<Row>, Failure> {
    let together = together(count);
    let groups = (count as usize).div_ceil(together);
    let mine = provenance.shard.map_or(groups, |shard| shard.range(groups).len());
    // Every round of every arm is simulated and estimated from the beginning.
    let each = Arm::ALL.len() as f64 * trial.ends().iter().sum::<usize>() as f64;
    let seconds = (mine * together) as f64 * each * Estimator::OutputError.seconds_per_row();
    let progress = Progress::new("realizations", mine * together, quiet).foretold(seconds);
    Made::computed(out, &columns(rate_hz), provenance, groups, |group| {
        let first = (group * together) as u32;
        let numbers = first..count.min(first + together as u32);
        let advance = numbers.len();
        let rows = trial.realizations(numbers).map_err(|e| files.refused(e));
        progress.advance(advance);
        rows
    })
}

/// Realizations that are computed together. With more of them, fewer lanes are idle while some searches continue;
/// with few realizations only one group of lanes, so that all shards and threads have work.
fn together(count: u32) -> usize {
    (count as usize / (8 * LANES)).clamp(1, 4) * LANES
}
