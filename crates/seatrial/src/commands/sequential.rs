//! `sequential`: trials designed in rounds.

use std::path::{Path, PathBuf};

use artifact::{Provenance, TableWriter, Work, commit_with_document};
use clap::Parser;
use identification::predictor::InitialState;
use identification::runs::RunEstimators;
use identification::{Estimator, MeanRemoval};
use serde_json::json;
use study::files::{read_campaign, read_dictionary, read_sequential, read_simulated};
use study::sequential::{SequentialFile, columns, document};
use trial::rounds::{self, Arm, Row, Trial};
use vessel::{Invalid, LANES};

use crate::cli::{Common, beside, budget};
use crate::failure::Failure;
use crate::ordered::ordered;
use crate::progress::Progress;
use crate::simulate::Files;
use crate::stage::{Summary, Task};

/// Designs, simulates and estimates in rounds, from a crude model, against designs made once, over Monte Carlo; writes
/// sequential.parquet and sequential.json
#[derive(Parser)]
#[command(
    name = "sequential",
    after_help = "Example:\n  sequential --vessel pipelines/paper/vessel.toml --dictionary pipelines/paper/dictionary.toml \
    --campaign pipelines/paper/campaign.toml --config pipelines/sequential/sequential.toml --out sequential.parquet"
)]
pub struct Arguments {
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
}

impl Task for Arguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("sequential");
        let inputs = [&self.vessel, &self.dictionary, &self.campaign, &self.config];
        let out = common.main_output("sequential.parquet", inputs)?;
        let vessel = read_simulated(&self.vessel, &mut provenance)?;
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
        let rows = f64::from(config.realizations) * (Arm::ALL.len() * rounds) as f64;
        let found = format!("{} realizations of {rounds} rounds", config.realizations);
        let remedy = "take fewer `realizations`";
        let work = Work { file: &self.config, thing: "`realizations`", found: &found, remedy };
        // Rows are kept for their summary while they are made columns.
        budget().memory(work, 2.0 * rows * size_of::<Row>() as f64)?;
        let noise = campaign.predictable_noise().map_err(of(&self.campaign))?;
        let sea = campaign.sea(&vessel).map_err(of(&self.vessel))?;
        let estimators = RunEstimators {
            vessel: &vessel,
            estimators: vec![Estimator::OutputError],
            removal: MeanRemoval::Complete,
            initial: InitialState::Known,
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
        let rows = realizations(&trial, &files, config.realizations, common.quiet)?;
        publish((self, &out), &provenance, &trial, &config, &rows, vessel.sample_rate_hz)
    }
}

fn publish(
    (a, out): (&Arguments, &Path),
    provenance: &Provenance,
    trial: &Trial,
    config: &SequentialFile,
    rows: &[Row],
    rate_hz: f64,
) -> Result<Summary, Failure> {
    if rows.iter().all(|row| row.parameter_error.is_none()) {
        return Err(Failure::NoAnswer(format!(
            "{}: rounds: found no estimate in any of {} realizations, expected some that converge; lengthen `duration_s`, or \
             give the vessel a nominal model nearer to it",
            a.config.display(),
            config.realizations
        )));
    }
    let summary = rounds::Summary::new(rows, trial.ends(), config.accuracy, rate_hz);
    let document = document(config, summary, trial.maneuvers());
    let columns = columns(rate_hz);
    let summary = beside(out, "sequential.parquet", "sequential.json");
    let mut writer = TableWriter::create(out, columns.schema(), provenance)?.with_document(&summary);
    writer.push(columns.encode(rows)?)?;
    commit_with_document(writer.finish()?, &summary, provenance, &document)?;
    let (count, said) = (config.realizations, document.statements.join("; "));
    let told = json!({"realizations": count, "statements": document.statements});
    Ok(Summary::of(out, format!("{count} realizations; {said}"), told))
}

fn realizations(trial: &Trial, files: &Files, count: u32, quiet: bool) -> Result<Vec<Row>, Failure> {
    // Every round of every arm is simulated and estimated from its start.
    let rows = f64::from(count) * Arm::ALL.len() as f64 * trial.ends().iter().sum::<usize>() as f64;
    let seconds = rows * Estimator::OutputError.seconds_per_row();
    let progress = Progress::new("realizations", count as usize, quiet).foretold(seconds);
    let work = |group: usize| {
        let first = (group * LANES) as u32;
        let numbers = first..count.min(first + LANES as u32);
        let advance = numbers.len();
        let rows = trial.realizations(numbers).map_err(|e| files.refused(e));
        progress.advance(advance);
        rows
    };
    let mut rows = Vec::new();
    ordered(0..(count as usize).div_ceil(LANES), work, |own| {
        rows.extend(own);
        Ok::<(), Failure>(())
    })?;
    Ok(rows)
}
