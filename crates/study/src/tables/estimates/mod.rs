//! The table of estimates: one row per run.

pub mod covariances;

use std::collections::BTreeMap;
use std::path::Path;

use estimation::runs::RunEstimators;
use estimation::{EstimateStatus, Estimator, RepeatedEstimates, TRUSTED, relative_norms};
use files::{Columns, Error, Provenance, Staged, TableReader, commit, stage_set_document};
use numerics::statistics::{quantile, quantile_interval, sorted, wilson};
use refusal::listed;
use regression::pooled::Recorded;
use serde::de::DeserializeOwned;
use ship::model::{DegreeOfFreedom, Vessel};

use crate::documents::{
    ConstrainedParameter, DegreeSummary, DesignSummary, EstimateDocument, EstimatorSummary, ParameterSummary,
    bounded,
};
use crate::tables::trajectories::KeptRuns;

pub use estimation::RunEstimate as Row;

/// Schema id of estimates.
pub const ID: &str = "estimates";
/// Version of the schema.
pub const VERSION: u32 = 1;

/// Bytes of memory of a row in a growing list.
pub fn row_bytes(vessel: &Vessel) -> f64 {
    let heap = 16 * vessel.model.parameters() + 80;
    // A growing list is copied into one of twice its length.
    (3 * size_of::<Row>() + heap) as f64
}

/// The columns for `vessel`.
pub fn columns(vessel: &Vessel) -> Columns<Row> {
    let mut columns = Columns::<Row>::new(ID, VERSION)
        .text("design", |r| &r.design, |r, design| r.design = design.to_owned())
        .integer("run", "1", |r| r.run, |r, run| r.run = run)
        .choice("estimator", |r| r.estimator, |r, estimator| r.estimator = estimator)
        .choice("status", |r| r.status, |r, status| r.status = status);
    let parameters = vessel.model.parameter_names().zip(vessel.model.parameter_units());
    for (i, (name, unit)) in parameters.enumerate() {
        columns = columns
            .optional(
                name,
                &unit,
                move |r| r.estimate.as_ref().map(|(theta, _)| theta[i]),
                move |r, value| {
                    r.estimate.iter_mut().for_each(|(theta, _)| theta[i] = value.unwrap_or(f64::NAN));
                },
            )
            .optional(
                format!("{name}_se"),
                &unit,
                move |r| r.estimate.as_ref().map(|(_, se)| se[i]).filter(|se| !se.is_nan()),
                move |r, value| {
                    r.estimate.iter_mut().for_each(|(_, se)| se[i] = value.unwrap_or(f64::NAN));
                },
            );
    }
    for (d, name) in blocks(vessel).iter().copied().enumerate() {
        let finite = move |r: &Row| Some(r.condition[d]).filter(|c| c.is_finite());
        columns = columns
            .optional(format!("condition_{name}"), "1", finite, move |r, condition| {
                r.condition[d] = condition.unwrap_or(f64::INFINITY);
            })
            .text(
                format!("weakest_{name}"),
                move |r| &r.weakest[d],
                move |r, weakest| {
                    r.weakest[d] = weakest.to_owned();
                },
            );
    }
    columns
}

/// What has a condition number of its own: each degree of freedom; the numbers of a ship with forces together.
fn blocks(vessel: &Vessel) -> &'static [&'static str] {
    if vessel.model.has_regressors() { &["surge", "sway", "yaw"] } else { &["forces"] }
}

/// Whether the table `file` has all parameters of `vessel`.
///
/// # Errors
/// See [`TableReader::open`].
pub fn of_all(file: &Path, vessel: &Vessel) -> Result<bool, Error> {
    let table = TableReader::open(file, ID, VERSION)?;
    let there = |name: &str| table.columns().iter().any(|column| column.name == name);
    Ok(vessel.model.parameter_names().all(there))
}

/// Reads block `i` of `reader`.
///
/// # Errors
/// Damaged blocks; an estimate that lacks a parameter.
pub fn rows(reader: &TableReader, vessel: &Vessel, file: &Path, i: usize) -> Result<Vec<Row>, Error> {
    let absent = vec![f64::NAN; vessel.model.parameters()];
    let blank = Row {
        design: String::new(),
        run: 0,
        estimator: Estimator::Iv,
        status: EstimateStatus::NotIdentifiable,
        estimate: Some((absent.clone(), absent)),
        condition: [f64::INFINITY; 3],
        weakest: [const { String::new() }; 3],
    };
    let mut rows = columns(vessel).read_block(reader, i, &blank)?;
    for (number, row) in rows.iter_mut().enumerate() {
        if !row.status.estimated() {
            row.estimate = None;
        }
        let Some((theta, se)) = &row.estimate else { continue };
        let waves = row.status == EstimateStatus::Waves;
        let se: &[f64] = if waves { &[] } else { se };
        if theta.iter().chain(se).any(|value| !value.is_finite()) {
            return Err(incomplete(file, number));
        }
        let no_estimate = theta.iter().find(|value| value.abs() > MOST);
        if let Some(value) = no_estimate.or(se.iter().find(|se| !is_error(**se))) {
            return Err(implausible(file, number, *value));
        }
    }
    Ok(rows)
}

/// Above it squares, and with them the statistics of a table, overflow.
const MOST: f64 = 1e150;

/// Refuses a row of `file` with `value`, which no stage writes.
pub(crate) fn implausible(file: &Path, row: usize, value: f64) -> Error {
    let expected = format!("magnitudes up to {MOST:e}, and errors from 0");
    let remedy = "run the stage that writes it again";
    crate::refuse(file, &format!("row {row}"), &format!("{value:e}"), &expected, remedy)
}

/// Whether an error or a score is valid.
pub(crate) fn is_error(value: f64) -> bool {
    (0.0..=MOST).contains(&value)
}

fn incomplete(file: &Path, row: usize) -> Error {
    let estimated = EstimateStatus::ALL.into_iter().filter(|status| status.estimated());
    let named: Vec<String> = estimated.map(|estimated| format!("`{estimated}`")).collect();
    let expected = format!("all parameters where the status is {}", listed(&named));
    crate::refuse(file, &format!("row {row}"), "an absent parameter", &expected, "run `estimate` again")
}

/// Publishes `table`, the files `beside` it that there are, and the `document` that vouches for all of them. A shard is
/// published alone.
///
/// # Errors
/// Output that fails; what `data` refuses.
pub fn publish(
    table: Staged,
    beside: [Option<Staged>; 2],
    document: &Path,
    provenance: &Provenance,
    data: impl FnOnce() -> Result<EstimateDocument, Error>,
) -> Result<(), Error> {
    if provenance.shard.is_some() {
        return commit(vec![table]);
    }
    let mut staged = vec![table];
    staged.extend(beside.into_iter().flatten());
    staged.push(stage_set_document(document, provenance, &data()?, &staged)?);
    commit(staged)
}

/// Why none of the runs has an estimate: the reason for the first of measured runs; else the number of failed
/// searches, or the parameter that no run excites. `None` if some have one.
///
/// # Errors
/// A damaged block.
pub fn unidentified(
    estimators: &RunEstimators,
    runs: &KeptRuns,
    rows: &[Row],
) -> Result<Option<String>, Error> {
    if rows.is_empty() || rows.iter().any(|r| r.estimate.is_some()) {
        return Ok(None);
    }
    let searched = rows.iter().filter(|r| r.status == EstimateStatus::NotConverged).count();
    let first = runs.block(0)?;
    let why = match first.first().and_then(|run| Some((run.run, estimators.collinear(run)?))) {
        Some((run, found)) => format!(
            "{} runs: found none that is identifiable (run {run}: {}), expected one; add maneuvers that vary these terms, \
             or hold them near the nominal model: estimate --fit together --prior 0.03",
            rows.len(),
            found.words
        ),
        None if searched > 0 => format!(
            "estimates by {}: found {searched} of {} runs whose search ended nowhere and no estimate, expected a minimum; \
             try `iv`, or a nominal model nearer to the vessel",
            rows[0].estimator,
            rows.len()
        ),
        None => unexcited(estimators.vessel, &rows[0]),
    };
    Ok(Some(why))
}

/// The parameter that the run does not excite.
fn unexcited(vessel: &Vessel, row: &Row) -> String {
    if !vessel.model.has_regressors() {
        return format!(
            "parameter `{}`: found no run and no prior that determines it, expected one; add a maneuver that does, or a `prior`, \
             or fix it",
            row.weakest[0]
        );
    }
    let degree = (0..3).find(|d| row.condition[*d].is_infinite()).unwrap_or(0);
    let (parameter, equation) = (&row.weakest[degree], &vessel.model.degrees[degree]);
    let index = equation.parameters.iter().position(|p| p == parameter).unwrap_or(0);
    format!(
        "parameter `{parameter}` ({}): found no run that excites it, expected its term `{}` to vary independently of \
         the others; add a maneuver in which it does",
        DegreeOfFreedom::ALL[degree].name(),
        equation.terms[index].text
    )
}

// Statistics of the estimates of all runs: `estimate.json`.

/// The setting with the noise under which runs were tested for what the model lacks.
pub const CRITICISED: &str = "criticised";

/// The document of all `rows` of `file`, whose `provenance` has settings with the leading estimator and the mean
/// removal.
///
/// # Errors
/// Settings without them.
pub fn summarize(
    file: &Path,
    provenance: &Provenance,
    vessel: &Vessel,
    rows: &[Row],
) -> Result<EstimateDocument, Error> {
    let names = estimators(rows);
    let criticised = criticised(provenance);
    let of = |estimator: Estimator| {
        let of_estimator: Vec<&Row> = rows.iter().filter(|r| r.estimator == estimator).collect();
        design_summaries(vessel, &of_estimator, criticised)
    };
    let summary = |estimator: &Estimator| EstimatorSummary { estimator: *estimator, designs: of(*estimator) };
    let leading = setting(file, provenance, "estimator")?;
    Ok(EstimateDocument {
        seed: crate::seed(provenance),
        trusted_within: Some(TRUSTED),
        designs: of(leading),
        compared: (names.len() > 1).then(|| names.iter().map(summary).collect()),
        constrained: ConstrainedParameter::all(vessel, None),
        ..EstimateDocument::new(leading, setting(file, provenance, "mean_removal")?)
    })
}

/// Whether the runs were tested for what the model lacks, as noted by `estimate`.
pub fn criticised(provenance: &Provenance) -> bool {
    provenance.settings.contains_key(CRITICISED)
}

fn setting<T: DeserializeOwned>(file: &Path, provenance: &Provenance, key: &str) -> Result<T, Error> {
    let setting = provenance.settings.get(key).cloned().unwrap_or_default();
    serde_json::from_value(setting.clone()).map_err(|_| {
        let (thing, given) = (format!("setting `{key}`"), setting.to_string());
        crate::refuse(file, &thing, &given, "one that `estimate` writes", "run `estimate` again")
    })
}

/// The estimators of the rows, in their order.
pub fn estimators(rows: &[Row]) -> Vec<Estimator> {
    distinct(rows.iter().map(|row| row.estimator))
}

/// Every one of `all` once, in their order.
pub fn distinct<T: PartialEq>(all: impl Iterator<Item = T>) -> Vec<T> {
    let mut once: Vec<T> = Vec::new();
    for one in all {
        if !once.contains(&one) {
            once.push(one);
        }
    }
    once
}

fn design_summaries(vessel: &Vessel, rows: &[&Row], criticised: bool) -> Vec<DesignSummary> {
    let mut designs: Vec<&str> = rows.iter().map(|r| r.design.as_str()).collect();
    designs.dedup();
    let of_design = |design: &str| rows.iter().copied().filter(|r| r.design == design).collect::<Vec<_>>();
    designs.iter().map(|design| design_summary(vessel, design, &of_design(design), criticised)).collect()
}

fn design_summary(vessel: &Vessel, design: &str, rows: &[&Row], criticised: bool) -> DesignSummary {
    let count = |status: EstimateStatus| rows.iter().filter(|r| r.status == status).count() as u64;
    let by = |which: fn(Estimator) -> bool| rows.iter().any(|r| which(r.estimator));
    let repeats: Vec<RepeatedEstimates> =
        (0..vessel.model.parameters()).map(|i| repeated(i, rows, vessel.value[i])).collect();
    let norms = relative_norms(&repeats);
    let ratios = || repeats.iter().filter_map(RepeatedEstimates::se_ratio);
    DesignSummary {
        design: design.to_owned(),
        runs: rows.len() as u64,
        identified: rows.iter().filter(|r| r.estimate.is_some()).count() as u64,
        not_converged: by(Estimator::searches).then(|| count(EstimateStatus::NotConverged)),
        rejected: criticised.then(|| count(EstimateStatus::Rejected)),
        relative_bias: norms.map(|[bias, ..]| bias),
        relative_spread: norms.map(|[_, spread, _]| spread),
        relative_rms: norms.map(|[.., rms]| rms),
        se_ratio_min: ratios().reduce(f64::min),
        se_ratio_max: ratios().reduce(f64::max),
        parameters: parameters(vessel, &repeats, rows),
        degrees: blocks(vessel).iter().enumerate().map(|(d, name)| degree_summary((d, name), rows)).collect(),
    }
}

fn repeated(i: usize, rows: &[&Row], truth: Option<f64>) -> RepeatedEstimates {
    let identified = || rows.iter().filter_map(|r| r.estimate.as_ref());
    let values: Vec<f64> = identified().map(|(theta, _)| theta[i]).collect();
    let errors: Vec<f64> = identified().map(|(_, se)| se[i]).collect();
    RepeatedEstimates::new(&values, &errors, truth)
}

fn parameters(vessel: &Vessel, found: &[RepeatedEstimates], rows: &[&Row]) -> Vec<ParameterSummary> {
    let (bounded, bounds) = (bounded(&vessel.model), vessel.model.bounds().unwrap_or_default());
    let at_bound = |i: usize| {
        let estimates = rows.iter().filter_map(|r| r.estimate.as_ref());
        bounded[i].then(|| estimates.filter(|(theta, _)| bounds[i].contains(&theta[i])).count() as u64)
    };
    let names = vessel.model.parameter_names().zip(vessel.model.parameter_units());
    let summary =
        |(i, ((name, unit), found)): (usize, ((&str, String), &RepeatedEstimates))| ParameterSummary {
            name: name.to_owned(),
            unit,
            truth: vessel.value[i],
            nominal: vessel.nominal[i],
            mean: found.mean,
            spread: found.spread,
            predicted_se: found.predicted_se,
            at_bound: at_bound(i),
            relative_bias: found.relative_bias,
            relative_spread: found.relative_spread,
            se_ratio: found.se_ratio(),
            se_trusted: Some(found.se_trusted()),
        };
    names.zip(found).enumerate().map(summary).collect()
}

fn degree_summary((d, name): (usize, &str), rows: &[&Row]) -> DegreeSummary {
    let conditions = sorted(rows.iter().map(|r| Some(r.condition[d])));
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for row in rows {
        *counts.entry(row.weakest[d].as_str()).or_default() += 1;
    }
    let (weakest, count) = counts.into_iter().max_by_key(|(_, count)| *count).unwrap_or(("", 0));
    DegreeSummary {
        name: name.to_owned(),
        condition_median: quantile(&conditions, 0.5),
        condition_median_interval: Some(quantile_interval(&conditions, 0.5)),
        condition_max: quantile(&conditions, 1.0),
        weakest_parameter: weakest.to_owned(),
        weakest_share: count as f64 / rows.len().max(1) as f64,
        weakest_share_interval: wilson(count as u64, rows.len() as u64),
    }
}

/// Name of the setting with the seed of simulated runs.
pub const SEED: &str = "seed";

/// The seed of simulated runs; `None` for measured ones.
pub fn seed(provenance: &Provenance) -> Option<u64> {
    provenance.settings.get(SEED)?.as_u64()
}

/// Notes in `provenance` the seed of its simulated input `of`.
pub fn note_seed(of: &Provenance, provenance: &mut Provenance) {
    if let Some(seed) = of.settings.get(SEED) {
        provenance.settings.insert(SEED.into(), seed.clone());
    }
}
