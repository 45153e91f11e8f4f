use std::path::{Path, PathBuf};

use artifact::{Provenance, TableWriter, commit, encode_block, read_toml, stage_document};
use serde_json::json;
use identification::Noise;
use identification::pooled::Lifted;
use vessel::{Current, Source};

use super::SequentialFile;
use super::arm::{Arm, Trial};
use super::planner::Planner;
use super::table::{Row, schema, table};
use crate::campaign_file::CampaignFile;
use crate::cli::{Summary, beside};
use crate::documents::{ArmPoint, ArmSummary, SequentialDocument, Stopping};
use crate::failure::Failure;
use crate::ordered::ordered;
use crate::progress::Progress;
use crate::statistics::{mean, quantile, sorted};
use crate::study_files::{read_campaign, read_dictionary, read_vessel};

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

/// Realizations that are worked on together.
const CHUNK: usize = 8;

/// Runs the Monte Carlo study: sequential.parquet with a row per arm, realization and round, sequential.json.
///
/// # Errors
/// Refused files; rounds shorter than a sample; maneuvers that the vessel cannot hold; a first design that cannot be made.
pub fn run(wanted: &Wanted, mut provenance: Provenance) -> Result<Summary, Failure> {
    let vessel = read_vessel(wanted.vessel, &mut provenance)?;
    let generator = read_dictionary(wanted.dictionary, &vessel, &mut provenance)?;
    let campaign = read_campaign(wanted.campaign, &mut provenance)?;
    let (config, digest) = read_toml::<SequentialFile>(wanted.config)?;
    provenance.inputs.insert("config".into(), digest);
    config.check().map_err(|e| Failure::invalid(wanted.config, &e))?;
    let truth = vessel.parameters(Source::Value).map_err(|e| Failure::invalid(wanted.vessel, &e))?;
    let noise = noise(&campaign, wanted.campaign)?;
    let planner = Planner::new(&vessel.model, &generator, noise)
        .map_err(|e| Failure::invalid(wanted.dictionary, &e))?;
    let ends = ends(&config, vessel.samples(config.duration_s), wanted.config)?;
    let informed = planner.shares(&truth, None, ends[ends.len() - 1]).ok_or_else(|| {
        let (found, expected) = ("maneuvers that do not excite every parameter", "a dictionary that does");
        Failure::refuse(wanted.dictionary, "maneuvers", found, expected, "add a maneuver; see `design`")
    })?;
    let seed = wanted.seed.unwrap_or(campaign.seed);
    provenance.settings.insert("seed".into(), json!(seed));
    let trial = Trial {
        model: &vessel.model,
        truth,
        nominal: vessel.nominal.clone(),
        generator: &generator,
        disturbances: campaign.disturbances(),
        planner,
        informed,
        config: &config,
        random_segments: campaign.random.map_or(5, |random| random.segments as usize),
        ends,
        lifted: Lifted::new(&vessel.model),
        std: noise.measurement.map(|std| if std > 0.0 { std } else { 1.0 }),
        rate_hz: vessel.sample_rate_hz,
        seed,
    };
    let rows = realizations(&trial, wanted)?;
    let document = document(&trial, &rows, vessel.sample_rate_hz);
    let mut writer = TableWriter::create(&wanted.out, &schema(), &provenance)?;
    writer.push(encode_block(&schema(), &table(&rows, vessel.sample_rate_hz))?)?;
    let beside = beside(&wanted.out, "sequential.json");
    commit(vec![writer.finish()?, stage_document(beside, &provenance, &document)?])?;
    let said = document.statements.join("; ");
    Ok(Summary {
        line: format!("{}: {} realizations; {said}", wanted.out.display(), config.realizations),
        json: json!({"out": wanted.out, "realizations": config.realizations, "statements": document.statements}),
    })
}

/// The levels that designs and standard errors are predicted from.
fn noise(campaign: &CampaignFile, file: &Path) -> Result<Noise, Failure> {
    let disturbances = campaign.disturbances();
    let current = match disturbances.current {
        Current::None | Current::White { .. } if campaign.wind.is_none() => disturbances.current.std_m_s(),
        _ => {
            let expected = "no current or a white one, which predicted standard errors are for";
            let remedy = "take a campaign without wind and lasting currents";
            return Err(Failure::refuse(file, "disturbances", "wind or a lasting current", expected, remedy));
        }
    };
    let m = disturbances.measurement;
    Ok(Noise { measurement: [m.std_u_m_s, m.std_v_m_s, m.std_r_rad_s], current })
}

/// Samples sailed by the end of every round.
fn ends(config: &SequentialFile, samples: usize, file: &Path) -> Result<Vec<usize>, Failure> {
    let rounds = config.rounds as usize;
    if samples < rounds {
        let found = format!("{rounds} rounds of {samples} samples");
        let expected = "at least one sample per round";
        return Err(Failure::refuse(
            file,
            "`rounds`",
            &found,
            expected,
            "take fewer, or lengthen `duration_s`",
        ));
    }
    Ok((1..=rounds).map(|round| round * samples / rounds).collect())
}

fn realizations(trial: &Trial, wanted: &Wanted) -> Result<Vec<Row>, Failure> {
    let count = trial.config.realizations as usize;
    let progress = Progress::new("realizations", count, wanted.quiet);
    let work = |chunk: usize| {
        let numbers = chunk * CHUNK..count.min((chunk + 1) * CHUNK);
        let advance = numbers.len();
        let rows = numbers.map(|number| trial.realization(number as u32)).collect::<Result<Vec<_>, _>>();
        progress.advance(advance);
        rows.map(|rows| rows.concat()).map_err(|e| Failure::invalid(wanted.dictionary, &e))
    };
    let mut rows = Vec::new();
    ordered(0..count.div_ceil(CHUNK), work, |own| {
        rows.extend(own);
        Ok::<(), Failure>(())
    })?;
    Ok(rows)
}

fn document(trial: &Trial, rows: &[Row], rate_hz: f64) -> SequentialDocument {
    let arms: Vec<ArmSummary> = Arm::ALL.into_iter().map(|arm| summary(trial, rows, arm, rate_hz)).collect();
    let stopping = stopping(trial, rows, rate_hz);
    SequentialDocument {
        realizations: u64::from(trial.config.realizations),
        rounds: u64::from(trial.config.rounds),
        duration_s: trial.config.duration_s,
        nominal_spread: trial.config.nominal_spread,
        accuracy: trial.config.accuracy,
        statements: statements(&arms, &stopping, trial.config.accuracy),
        arms,
        stopping,
    }
}

fn summary(trial: &Trial, rows: &[Row], arm: Arm, rate_hz: f64) -> ArmSummary {
    let point = |(round, end): (usize, &usize)| {
        let own: Vec<&Row> =
            rows.iter().filter(|row| row.arm == arm && row.round as usize == round).collect();
        let errors = sorted(own.iter().map(|row| row.parameter_error));
        let predicted = sorted(own.iter().map(|row| row.predicted_error));
        let share = |count: usize| count as f64 / own.len().max(1) as f64;
        let within = |row: &&&Row| row.parameter_error.is_some_and(|e| e <= trial.config.accuracy);
        ArmPoint {
            time_s: *end as f64 / rate_hz,
            median: quantile(&errors, 0.5),
            q90: quantile(&errors, 0.9),
            predicted: quantile(&predicted, 0.5),
            within: share(own.iter().filter(within).count()),
            failed: own.iter().filter(|row| row.parameter_error.is_none()).count() as u64,
            undesigned: own.iter().filter(|row| !row.designed).count() as u64,
        }
    };
    ArmSummary { name: arm.name().to_owned(), points: trial.ends.iter().enumerate().map(point).collect() }
}

/// Where the sequential trials would have stopped.
fn stopping(trial: &Trial, rows: &[Row], rate_hz: f64) -> Stopping {
    let (mut times, mut errors) = (Vec::new(), Vec::new());
    for number in 0..trial.config.realizations {
        let reached = |row: &&Row| row.predicted_error.is_some_and(|e| e <= trial.config.accuracy);
        let own = rows.iter().filter(|row| row.arm == Arm::Sequential && row.realization == number);
        if let Some(row) = own.into_iter().find(reached) {
            times.push(row.samples as f64 / rate_hz);
            errors.push(row.parameter_error);
        }
    }
    Stopping {
        reached: times.len() as u64,
        mean_time_s: mean(&times),
        median_error: quantile(&sorted(errors.into_iter()), 0.5),
    }
}

fn statements(arms: &[ArmSummary], stopping: &Stopping, accuracy: f64) -> Vec<String> {
    let last = |arm: Arm| arms[arm as usize].points.last().and_then(|point| point.median);
    let mut out = Vec::new();
    let medians = [Arm::Sequential, Arm::OneShot, Arm::Informed, Arm::Random].map(last);
    if let [Some(sequential), Some(one_shot), Some(informed), Some(random)] = medians {
        out.push(format!(
            "median parameter error after the whole time: designed in rounds {sequential:.2}, once from the crude model \
             {one_shot:.2}, once from the truth {informed:.2}, at random {random:.2}"
        ));
        if let Some(time) = reached(&arms[Arm::Sequential as usize].points, one_shot) {
            let whole = arms[0].points.last().map_or(0.0, |point| point.time_s);
            out.push(format!(
                "in rounds the one-shot design's {one_shot:.2} of {whole:.0} s takes {time:.0} s"
            ));
        }
    }
    out.push(match stopping.mean_time_s {
        Some(time) => {
            format!(
                "{} trials stop at the accuracy of {accuracy}, after {time:.0} s on average",
                stopping.reached
            )
        }
        None => format!("no trial reaches the accuracy of {accuracy}"),
    });
    out
}

/// Time at which the median falls to `error`, interpolated between rounds in the logarithm of the error.
fn reached(points: &[ArmPoint], error: f64) -> Option<f64> {
    let known: Vec<(f64, f64)> = points.iter().filter_map(|p| Some((p.time_s, p.median?))).collect();
    if known.first().is_some_and(|first| first.1 <= error) {
        return Some(known[0].0);
    }
    let pair = known.windows(2).find(|pair| pair[0].1 > error && pair[1].1 <= error)?;
    let [(t0, e0), (t1, e1)] = [pair[0], pair[1]];
    Some(t0 + (t1 - t0) * (e0.ln() - error.ln()) / (e0.ln() - e1.ln()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_of_an_error_lies_between_its_rounds() {
        let point = |time_s: f64, median: f64| ArmPoint {
            time_s,
            median: Some(median),
            q90: None,
            predicted: None,
            within: 0.0,
            failed: 0,
            undesigned: 0,
        };
        let points = [point(10.0, 4.0), point(20.0, 2.0), point(30.0, 1.0)];
        assert_eq!(reached(&points, 5.0), Some(10.0));
        assert_eq!(reached(&points, 0.5), None);
        assert!((reached(&points, 2f64.sqrt()).unwrap() - 25.0).abs() < 1e-12);
    }
}
