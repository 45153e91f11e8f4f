//! Statistics of the estimates of all runs: `estimate.json`.

use std::collections::BTreeMap;
use std::path::Path;

use estimation::{EstimateStatus, Estimator, RepeatedEstimates, TRUSTED, relative_norms};
use files::{Error, Provenance};
use numerics::statistics::{quantile, quantile_interval, sorted, wilson};
use serde::de::DeserializeOwned;
use ship::model::Vessel;

use super::{Row, blocks};
use crate::documents::{
    ConstrainedParameter, DegreeSummary, DesignSummary, EstimateDocument, EstimatorSummary, ParameterSummary,
    bounded,
};

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
        let own: Vec<&Row> = rows.iter().filter(|r| r.estimator == estimator).collect();
        design_summaries(vessel, &own, criticised)
    };
    let summary = |estimator: &Estimator| EstimatorSummary { estimator: *estimator, designs: of(*estimator) };
    let leading = setting(file, provenance, "estimator")?;
    Ok(EstimateDocument {
        estimator: leading,
        mean_removal: setting(file, provenance, "mean_removal")?,
        seed: crate::seed(provenance),
        trusted_within: Some(TRUSTED),
        designs: of(leading),
        compared: (names.len() > 1).then(|| names.iter().map(summary).collect()),
        constrained: ConstrainedParameter::all(vessel, None),
        trust: None,
    })
}

/// Whether the runs were tested for what the model lacks, as noted by `estimate`.
pub fn criticised(provenance: &Provenance) -> bool {
    provenance.settings.contains_key(CRITICISED)
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

fn design_summaries(vessel: &Vessel, rows: &[&Row], criticised: bool) -> Vec<DesignSummary> {
    let mut designs: Vec<&str> = rows.iter().map(|r| r.design.as_str()).collect();
    designs.dedup();
    let own = |design: &str| rows.iter().copied().filter(|r| r.design == design).collect::<Vec<_>>();
    designs.iter().map(|design| design_summary(vessel, design, &own(design), criticised)).collect()
}

fn design_summary(vessel: &Vessel, design: &str, rows: &[&Row], criticised: bool) -> DesignSummary {
    let count = |status: EstimateStatus| rows.iter().filter(|r| r.status == status).count() as u64;
    let by = |which: fn(Estimator) -> bool| rows.iter().any(|r| which(r.estimator));
    let found: Vec<RepeatedEstimates> =
        (0..vessel.model.parameters()).map(|i| repeated(i, rows, vessel.value[i])).collect();
    let norms = relative_norms(&found);
    let ratios = || found.iter().filter_map(RepeatedEstimates::se_ratio);
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
        parameters: parameters(vessel, &found, rows),
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
