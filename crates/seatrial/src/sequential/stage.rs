use std::path::{Path, PathBuf};

use artifact::{Provenance, TableWriter, commit, encode_block, read_toml, stage_document};
use identification::predictor::InitialState;
use identification::{MeanRemoval, Noise};
use serde_json::json;
use vessel::{LANES, Source, Vessel};

use super::knowledge::Knowledge;
use super::planner::Planner;
use super::summary::document;
use super::table::{Row, schema, table};
use super::trial::Trial;
use super::voyage::Voyage;
use super::{CrudeAbout, SequentialFile};
use crate::cli::beside;
use crate::estimators::{Estimator, RunEstimators};
use crate::failure::Failure;
use crate::ordered::ordered;
use crate::progress::Progress;
use crate::simulate::refuse_endless;
use crate::simulate::sea::Sea;
use crate::stage::Summary;
use study::campaign_file::CampaignFile;
use study::files::{read_campaign, read_dictionary, read_vessel};

/// What is asked for.
pub struct Wanted<'a> {
    /// `vessel.toml`.
    pub vessel: &'a Path,
    /// `dictionary.toml`.
    pub dictionary: &'a Path,
    /// `campaign.toml`: the disturbances.
    pub campaign: &'a Path,
    /// `sequential.toml`.
    pub config: &'a Path,
    /// Replaces the campaign's seed.
    pub seed: Option<u64>,
    /// Main output.
    pub out: PathBuf,
    /// No progress.
    pub quiet: bool,
}

/// Runs the Monte Carlo study: sequential.parquet with a row per realization, arm and round, sequential.json.
///
/// # Errors
/// Refused files; rounds too short; maneuvers that the vessel cannot hold; a first design that cannot be made; no estimate
/// at all.
pub fn run(wanted: &Wanted, mut provenance: Provenance) -> Result<Summary, Failure> {
    let vessel = read_vessel(wanted.vessel, &mut provenance)?;
    let generator = read_dictionary(wanted.dictionary, &vessel, &mut provenance)?;
    let campaign = read_campaign(wanted.campaign, &mut provenance)?;
    let (config, digest) = read_toml::<SequentialFile>(wanted.config)?;
    provenance.inputs.insert("config".into(), digest);
    config.check().map_err(|e| Failure::invalid(wanted.config, &e))?;
    let seed = wanted.seed.unwrap_or(campaign.seed);
    provenance.settings.insert("seed".into(), json!(seed));
    let truth = truth(&vessel, wanted.vessel)?;
    let knowledge = knowledge(&config, wanted.config, &vessel, &truth, seed)?;
    let ends = ends(&config, &vessel, wanted.config)?;
    let noise = noise(&campaign, wanted.campaign)?;
    let planner = Planner::new(wanted.dictionary, &vessel, &generator, noise)?;
    let informed = planner
        .shares(&truth, &knowledge.sizes(&truth), &Voyage::default(), ends[0])
        .ok_or_else(|| unexcited(wanted.dictionary))?;
    let trial = Trial {
        sea: Sea::new(wanted.vessel, &vessel, &campaign)?,
        generator: &generator,
        dictionary_file: wanted.dictionary,
        planner,
        estimators: RunEstimators {
            vessel: &vessel,
            vessel_file: wanted.vessel,
            file: wanted.config,
            estimators: vec![Estimator::OutputError],
            removal: MeanRemoval::Complete,
            initial: InitialState::Known,
            levels: Some(campaign.levels(vessel.sample_rate_hz)),
        },
        knowledge,
        truth,
        informed,
        ends,
        random_segments: campaign.random.map_or(5, |random| random.segments as usize),
        seed,
    };
    let rows = realizations(&trial, &config, wanted.quiet)?;
    publish(wanted, &provenance, &trial, &config, &rows, vessel.sample_rate_hz)
}

fn publish(
    wanted: &Wanted,
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
            wanted.config.display(),
            config.realizations
        )));
    }
    let document = document(config, rows, &trial.ends, trial.planner.maneuvers().len(), rate_hz);
    let mut writer = TableWriter::create(&wanted.out, &schema(), provenance)?;
    writer.push(encode_block(&schema(), &table(rows, rate_hz))?)?;
    let beside = beside(&wanted.out, "sequential.json");
    commit(vec![writer.finish()?, stage_document(beside, provenance, &document)?])?;
    let said = document.statements.join("; ");
    Ok(Summary {
        line: format!("{}: {} realizations; {said}", wanted.out.display(), config.realizations),
        json: json!({"out": wanted.out, "realizations": config.realizations, "statements": document.statements}),
    })
}

/// The true parameters; errors are relative to them.
fn truth(vessel: &Vessel, file: &Path) -> Result<Vec<f64>, Failure> {
    let truth = vessel.parameters(Source::Value).map_err(|e| Failure::invalid(file, &e))?;
    match vessel.model.parameter_names().zip(&truth).find(|(_, value)| **value == 0.0) {
        None => Ok(truth),
        Some((name, _)) => {
            let expected = "a true parameter that is not zero, since errors are relative to it";
            Err(Failure::refuse(
                file,
                &format!("parameter `{name}`, `value`"),
                "0",
                expected,
                "leave its term out",
            ))
        }
    }
}

fn knowledge(
    config: &SequentialFile,
    file: &Path,
    vessel: &Vessel,
    truth: &[f64],
    seed: u64,
) -> Result<Knowledge, Failure> {
    let about = match config.crude_about {
        CrudeAbout::Value => truth.to_vec(),
        CrudeAbout::Nominal => vessel.nominal.clone(),
    };
    let floor = config.floors(vessel, &about).map_err(|e| Failure::invalid(file, &e))?;
    Ok(Knowledge { about, spread: config.nominal_spread, floor, seed })
}

/// The levels that designs and expected errors are predicted from.
fn noise(campaign: &CampaignFile, file: &Path) -> Result<Noise, Failure> {
    let refuse = |thing: &str, found: &str, expected: &str, remedy: &str| {
        Err(Failure::refuse(file, thing, found, expected, remedy))
    };
    let Some(noise) = campaign.noise().filter(|_| campaign.wind.is_none()) else {
        let expected = "no current or a white one, which errors are predicted for";
        let remedy = "take a campaign without wind and lasting currents";
        return refuse("disturbances", "wind or a lasting current", expected, remedy);
    };
    if noise.measurement.contains(&0.0) {
        let expected = "noise in u, v and r, which errors are predicted from";
        return refuse("`measurement`", "a standard deviation of 0", expected, "state what the sensors have");
    }
    Ok(noise)
}

/// Samples sailed by the end of every round.
fn ends(config: &SequentialFile, vessel: &Vessel, file: &Path) -> Result<Vec<usize>, Failure> {
    let (rounds, samples) = (config.rounds as usize, vessel.samples(config.duration_s));
    refuse_endless(file, "`duration_s`", samples)?;
    let least = 2 * (vessel.model.parameters() + vessel.model.degrees.len());
    if samples / rounds < least {
        let found = format!("{rounds} rounds of {samples} samples");
        let expected = format!("at least {least} samples per round, twice the parameters and intercepts");
        let remedy = "take fewer, or lengthen `duration_s`";
        return Err(Failure::refuse(file, "`rounds`", &found, &expected, remedy));
    }
    Ok((1..=rounds).map(|round| round * samples / rounds).collect())
}

fn unexcited(dictionary: &Path) -> Failure {
    let (found, expected) = ("maneuvers that do not excite every parameter", "a dictionary that does");
    Failure::refuse(dictionary, "maneuvers", found, expected, "add a maneuver; see `design`")
}

fn realizations(trial: &Trial, config: &SequentialFile, quiet: bool) -> Result<Vec<Row>, Failure> {
    let count = config.realizations;
    let progress = Progress::new("realizations", count as usize, quiet);
    let work = |group: usize| {
        let first = (group * LANES) as u32;
        let numbers = first..count.min(first + LANES as u32);
        let advance = numbers.len();
        let rows = trial.realizations(numbers);
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
