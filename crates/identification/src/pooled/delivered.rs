use std::collections::HashMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vessel::{DegreeOfFreedom, Model};

use super::{DegreeTrust, Estimated, Part, Pool, Regressions, SourceErrors};
use crate::{Estimator, Sums};

/// The model that an estimate delivers, whole: with it others simulate what was validated.
#[derive(Clone, Debug, PartialEq)]
pub struct Delivered {
    /// θ̂: surge, sway, yaw.
    pub theta: Vec<f64>,
    /// What u, v \[m/s\], r \[rad/s\] gain in a sample whatever the vessel does: the intercepts, and the constant that was
    /// known before.
    pub constant: [f64; 3],
    /// Covariance of the estimates; none where a degree of freedom has no standard errors.
    pub covariance: Option<Covariance>,
    /// θ̂ and constant by least squares of the same data, to be compared with.
    pub least_squares: Option<(Vec<f64>, [f64; 3])>,
    /// Standard deviation of what the terms leave of the increments: u, v \[m/s\], r \[rad/s\] per sample.
    pub increment_std: [f64; 3],
    /// RMSE of free simulations over the recordings that were fitted; none where one diverges.
    pub output_rmse: Option<[f64; 3]>,
    /// One entry per run or recording.
    pub recordings: Vec<RecordingConstant>,
    /// What the data covered: states, inputs, measured disturbances.
    pub covered: Vec<Covered>,
}

/// Covariance of estimates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Covariance {
    /// Whether those of different degrees of freedom were estimated together; else the entries between them are 0.
    pub joint: bool,
    /// Names of the parameters; `surge constant` and the like where the constants are among them.
    pub names: Vec<String>,
    /// As many rows as names, row-major.
    pub entries: Vec<f64>,
}

/// What the increments of one recording gain on the terms: a steady force, current or sensor error of that day.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordingConstant {
    /// Its name.
    pub source: String,
    /// Regression pairs.
    pub samples: u64,
    /// Mean of Δu − φᵀθ̂ per sample.
    pub constant_u: f64,
    /// Of sway speed.
    pub constant_v: f64,
    /// Of yaw rate.
    pub constant_r: f64,
}

/// The range of a channel in the data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Covered {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Least value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
}

impl Delivered {
    /// What `found` delivers, which was fitted to `parts`; none unless all degrees of freedom have an estimate.
    pub(super) fn new(
        pool: &Pool,
        found: &Estimated,
        parts: &[Part],
        degrees: &[DegreeTrust],
        sources: &[SourceErrors],
    ) -> Option<Self> {
        let (theta, intercepts) = found.theta()?;
        let known = pool.model.constant;
        let beyond = |intercepts: [f64; 3]| [0, 1, 2].map(|d| known[d] + intercepts[d]);
        Some(Self {
            constant: beyond(intercepts),
            covariance: covariance(&pool.model, found, degrees),
            least_squares: pool.least_squares(found).map(|(theta, own)| (theta, beyond(own))),
            increment_std: increment_std(pool, parts, &theta, intercepts),
            output_rmse: pooled_rmse(sources),
            recordings: recordings(&pool.vessel.model, found.squares(), parts, &theta),
            covered: covered(&pool.model, parts),
            theta,
        })
    }
}

/// That of an output-error estimate is of all unknowns together; else each degree of freedom has its own.
fn covariance(model: &Model, found: &Estimated, degrees: &[DegreeTrust]) -> Option<Covariance> {
    let simulated = found.output_error.as_ref().filter(|_| found.used == [Estimator::OutputError; 3]);
    if let Some((whole, _)) = simulated {
        let name = |(d, name): (usize, &str)| match name {
            "intercept" => format!("{} constant", DegreeOfFreedom::ALL[d].name()),
            name => name.to_owned(),
        };
        let names = model.layout().degrees().zip(model.parameter_names()).map(name).collect();
        return Some(Covariance { joint: true, names, entries: whole.covariance.clone() });
    }
    let of = |degree: &DegreeTrust| -> Option<Vec<f64>> {
        degree.parameters.iter().map(|p| p.standard_error).collect()
    };
    let errors: Vec<Vec<f64>> = degrees.iter().map(of).collect::<Option<_>>()?;
    let (all, mut first) = (errors.iter().map(Vec::len).sum::<usize>(), 0);
    let mut entries = vec![0.0; all * all];
    for (degree, errors) in degrees.iter().zip(&errors) {
        let (correlation, p) = (degree.correlation.as_ref()?, errors.len());
        for (k, entry) in correlation.iter().enumerate() {
            entries[(first + k / p) * all + first + k % p] = entry * errors[k / p] * errors[k % p];
        }
        first += p;
    }
    let names = degrees.iter().flat_map(|d| &d.parameters).map(|p| p.name.clone()).collect();
    Some(Covariance { joint: false, names, entries })
}

/// Standard deviations of Δy − φᵀθ̂ − c over all parts.
fn increment_std(pool: &Pool, parts: &[Part], theta: &[f64], intercepts: [f64; 3]) -> [f64; 3] {
    let (layout, mut squares, mut samples) = (pool.vessel.model.layout(), [0.0; 3], 0.0);
    pool.regressions(parts, false).each(&mut |_, regression| {
        samples += regression.samples as f64;
        for (d, degree) in regression.degrees.iter().enumerate() {
            let own = &theta[layout.terms(d)];
            for (k, target) in degree.target.iter().enumerate() {
                let predicted: f64 = degree.phi(k).iter().zip(own).map(|(f, t)| f * t).sum();
                squares[d] += (target - predicted - intercepts[d]).powi(2);
            }
        }
    });
    squares.map(|sum| (sum / f64::max(samples, 1.0)).sqrt())
}

fn pooled_rmse(sources: &[SourceErrors]) -> Option<[f64; 3]> {
    let (mut squares, mut samples) = ([0.0; 3], 0.0);
    for source in sources.iter().filter(|source| source.samples > 0) {
        let (errors, n) = (source.errors?, source.samples as f64);
        let rmse = [errors.rmse_u, errors.rmse_v, errors.rmse_r];
        squares.iter_mut().zip(rmse).for_each(|(sum, rmse)| *sum += n * rmse * rmse);
        samples += n;
    }
    (samples > 0.0).then(|| squares.map(|sum| (sum / samples).sqrt()))
}

/// By recording, from the sums of `parts` with their regressors as instruments.
fn recordings(model: &Model, sums: &[Sums], parts: &[Part], theta: &[f64]) -> Vec<RecordingConstant> {
    let (mut places, mut found) = (HashMap::new(), Vec::<RecordingConstant>::new());
    let layout = model.layout();
    for (part, sums) in parts.iter().zip(sums) {
        let place = *places.entry(part.source.as_str()).or_insert(found.len());
        if place == found.len() {
            let source = part.source.clone();
            found.push(RecordingConstant {
                source,
                samples: 0,
                constant_u: 0.0,
                constant_v: 0.0,
                constant_r: 0.0,
            });
        }
        let own = &mut found[place];
        own.samples += sums.samples;
        let all = [&mut own.constant_u, &mut own.constant_v, &mut own.constant_r];
        for (d, sum) in all.into_iter().enumerate() {
            *sum += sums.degrees[d].residual(&theta[layout.terms(d)]);
        }
    }
    for one in &mut found {
        let samples = one.samples.max(1) as f64;
        let all = [&mut one.constant_u, &mut one.constant_v, &mut one.constant_r];
        all.into_iter().zip(model.constant).for_each(|(sum, known)| *sum = *sum / samples + known);
    }
    found
}

pub(crate) fn covered(model: &Model, parts: &[Part]) -> Vec<Covered> {
    let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; model.variables.len()];
    let mut add = |variable: usize, value: f64| {
        let [low, high] = &mut ranges[variable];
        (*low, *high) = (low.min(value), high.max(value));
    };
    for part in parts {
        part.measured.chunks_exact(3).for_each(|row| (0..3).for_each(|d| add(d, row[d])));
        let rows = part.exogenous.chunks_exact(model.exogenous().max(1));
        rows.for_each(|row| row.iter().enumerate().for_each(|(i, value)| add(3 + i, *value)));
    }
    let range = |(variable, [low, high]): (&vessel::Variable, [f64; 2])| Covered {
        name: variable.name.clone(),
        unit: variable.unit.clone(),
        low,
        high,
    };
    model.variables.iter().zip(ranges).map(range).collect()
}
