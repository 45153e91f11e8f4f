//! What the estimates of all runs say together: `estimate.json`.

use std::collections::BTreeMap;

use artifact::Provenance;
use vessel::{DegreeOfFreedom, Vessel};

use super::{Row, Status};
use crate::documents::{DegreeSummary, DesignSummary, EstimateDocument, EstimatorSummary, ParameterSummary};
use numerics::statistics::{mean, quantile, sorted, spread};

/// The document of all `rows`, which the settings of `provenance` name the leading estimator of.
pub fn summarize(provenance: &Provenance, vessel: &Vessel, rows: &[Row]) -> EstimateDocument {
    let setting = |key: &str| provenance.settings.get(key).and_then(|v| v.as_str()).unwrap_or("").to_owned();
    let names = estimators(rows);
    let of = |name: &str| {
        design_summaries(vessel, &rows.iter().filter(|r| r.estimator == name).collect::<Vec<_>>())
    };
    let summary = |name: &&str| EstimatorSummary { estimator: (*name).to_owned(), designs: of(name) };
    EstimateDocument {
        estimator: setting("estimator"),
        mean_removal: setting("mean_removal"),
        designs: of(&setting("estimator")),
        compared: (names.len() > 1).then(|| names.iter().map(summary).collect()),
        trust: None,
    }
}

/// The estimators of the rows, in their order.
pub fn estimators(rows: &[Row]) -> Vec<&str> {
    distinct(rows.iter().map(|row| row.estimator.as_str()))
}

/// Every one of `names` once, in their order.
pub fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut once: Vec<&str> = Vec::new();
    for name in names {
        if !once.contains(&name) {
            once.push(name);
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
    let count = |status: Status| rows.iter().filter(|r| r.status == status).count() as u64;
    let by = |names: &[&str]| rows.iter().any(|r| names.contains(&r.estimator.as_str()));
    DesignSummary {
        design: design.to_owned(),
        runs: rows.len() as u64,
        identified: rows.iter().filter(|r| r.estimate.is_some()).count() as u64,
        not_converged: by(&["output-error", "prediction-error"]).then(|| count(Status::NotConverged)),
        kept: by(&["refined-iv"]).then(|| count(Status::Kept)),
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
