//! What the estimates of all runs say together: `estimate.json`.

use std::collections::BTreeMap;
use std::path::Path;

use artifact::{Error, Provenance};
use identification::{EstimateStatus, Estimator};
use serde::de::DeserializeOwned;
use vessel::{DegreeOfFreedom, Vessel};

use super::Row;
use crate::documents::{DegreeSummary, DesignSummary, EstimateDocument, EstimatorSummary, ParameterSummary};
use numerics::statistics::{mean, quantile, sorted, spread};

/// The document of all `rows` of `file`, whose `provenance` has settings that name the leading estimator and how the mean
/// was removed.
///
/// # Errors
/// Settings that name neither.
pub fn summarize(
    file: &Path,
    provenance: &Provenance,
    vessel: &Vessel,
    rows: &[Row],
) -> Result<EstimateDocument, Error> {
    let names = estimators(rows);
    let of = |estimator: Estimator| {
        design_summaries(vessel, &rows.iter().filter(|r| r.estimator == estimator).collect::<Vec<_>>())
    };
    let summary = |estimator: &Estimator| EstimatorSummary { estimator: *estimator, designs: of(*estimator) };
    let leading = setting(file, provenance, "estimator")?;
    Ok(EstimateDocument {
        estimator: leading,
        mean_removal: setting(file, provenance, "mean_removal")?,
        designs: of(leading),
        compared: (names.len() > 1).then(|| names.iter().map(summary).collect()),
        trust: None,
    })
}

fn setting<T: DeserializeOwned>(file: &Path, provenance: &Provenance, key: &str) -> Result<T, Error> {
    let found = provenance.settings.get(key).cloned().unwrap_or_default();
    serde_json::from_value(found.clone()).map_err(|_| {
        let (thing, found) = (format!("setting `{key}`"), found.to_string());
        crate::refuse(file, &thing, &found, "one that `estimate` writes", "run `estimate` again")
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

fn design_summaries(vessel: &Vessel, rows: &[&Row]) -> Vec<DesignSummary> {
    let mut designs: Vec<&str> = rows.iter().map(|r| r.design.as_str()).collect();
    designs.dedup();
    let own = |design: &str| rows.iter().copied().filter(|r| r.design == design).collect::<Vec<_>>();
    designs.iter().map(|design| design_summary(vessel, design, &own(design))).collect()
}

fn design_summary(vessel: &Vessel, design: &str, rows: &[&Row]) -> DesignSummary {
    let names = vessel.model.parameter_names().zip(vessel.model.parameter_units()).enumerate();
    let count = |status: EstimateStatus| rows.iter().filter(|r| r.status == status).count() as u64;
    let by = |which: fn(Estimator) -> bool| rows.iter().any(|r| which(r.estimator));
    DesignSummary {
        design: design.to_owned(),
        runs: rows.len() as u64,
        identified: rows.iter().filter(|r| r.estimate.is_some()).count() as u64,
        not_converged: by(Estimator::searches).then(|| count(EstimateStatus::NotConverged)),
        kept: by(|e| e == Estimator::RefinedIv).then(|| count(EstimateStatus::Kept)),
        parameters: names.map(|(i, (name, unit))| parameter_summary(vessel, i, name, unit, rows)).collect(),
        degrees: DegreeOfFreedom::ALL.into_iter().map(|d| degree_summary(d, rows)).collect(),
    }
}

fn parameter_summary(vessel: &Vessel, i: usize, name: &str, unit: String, rows: &[&Row]) -> ParameterSummary {
    let identified = || rows.iter().filter_map(|r| r.estimate.as_ref());
    let values: Vec<f64> = identified().map(|(theta, _)| theta[i]).collect();
    let errors = sorted(identified().map(|(_, se)| Some(se[i])));
    ParameterSummary {
        name: name.to_owned(),
        unit,
        truth: vessel.value[i],
        nominal: vessel.nominal[i],
        mean: mean(&values),
        spread: spread(&values),
        predicted_se: quantile(&errors, 0.5),
    }
}

fn degree_summary(d: DegreeOfFreedom, rows: &[&Row]) -> DegreeSummary {
    let conditions = sorted(rows.iter().map(|r| Some(r.condition[d as usize])));
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for row in rows {
        *counts.entry(row.weakest[d as usize].as_str()).or_default() += 1;
    }
    let (weakest, count) = counts.into_iter().max_by_key(|(_, count)| *count).unwrap_or(("", 0));
    DegreeSummary {
        name: d.name().to_owned(),
        condition_median: quantile(&conditions, 0.5),
        condition_max: quantile(&conditions, 1.0),
        weakest_parameter: weakest.to_owned(),
        weakest_share: count as f64 / rows.len().max(1) as f64,
    }
}
