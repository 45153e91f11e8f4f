//! The criterion that shares are best for.

use std::collections::BTreeMap;
use std::path::Path;

use artifact::{Provenance, read_toml};
use clap::ValueEnum;
use optimal_design::{
    Bounds, Candidates, CountOptions, Counted, Covariance, Design, Error, Norm, Options, count_segments,
    solve_covariance, solve_within,
};
use serde::Deserialize;
use vessel::nearest;

use super::matrices::middle;
use super::refusal::no_design;
use crate::documents::{DegreeStructure, ExpectedDisturbances, MomentsDocument};
use crate::failure::Failure;
use crate::instruments::Removal;

/// The criteria by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CriterionName {
    /// log|det| of the information matrix (the paper's)
    DHessian,
    /// log det of the estimate's covariance
    D,
    /// Sum of the variances
    A,
    /// Sum of the variances relative to the parameters' squares
    ARelative,
    /// Largest eigenvalue of the covariance
    E,
}

impl CriterionName {
    /// As `design.json` has it.
    pub fn title(self) -> &'static str {
        match self {
            Self::DHessian => "D",
            Self::D => "covariance D",
            Self::A => "covariance A",
            Self::ARelative => "covariance relative A",
            Self::E => "covariance E",
        }
    }
}

/// Which parameters relative errors are relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Relative {
    /// The nominal ones
    Nominal,
    /// Those that the disturbances were linearised with: the true ones where they are known
    Value,
}

/// `weights.toml`: parameter → weight of its variance.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WeightsFile {
    weight: BTreeMap<String, f64>,
}

/// Exponent of the power mean that stands for the largest eigenvalue: within log(eigenvalues)/s of it.
const LARGEST: f64 = 16_777_216.0;
/// What the search for the largest eigenvalue can reach.
const E_TOLERANCE: f64 = 1e-7;

/// What is maximised.
pub enum Criterion {
    /// log|det| of the information matrix.
    Information(Candidates),
    /// A criterion of the covariance, with the weight of every parameter.
    Covariance {
        /// The criterion.
        covariance: Box<Covariance>,
        /// In the order of the parameters.
        weights: Vec<f64>,
    },
}

impl Criterion {
    /// The criterion `name` of `information`, the candidates of `moments`, which stand in `file`.
    ///
    /// # Errors
    /// Moments without expected disturbances, weights of unknown parameters or out of range, a parameter of zero that errors
    /// are to be relative to; a covariance that is singular, naming the parameter.
    pub fn new(
        name: CriterionName,
        file: &Path,
        moments: &MomentsDocument,
        information: Candidates,
        removal: Removal,
        weights: Vec<f64>,
    ) -> Result<Self, Failure> {
        let norm = match name {
            CriterionName::DHessian => return Ok(Self::Information(information)),
            CriterionName::D => Norm::LogDet,
            CriterionName::A | CriterionName::ARelative => Norm::PowerMean(1.0),
            CriterionName::E => Norm::PowerMean(LARGEST),
        };
        let middle = middle(file, moments, removal)?;
        let rows = lifted(&moments.degrees, &weights, removal);
        let covariance =
            Covariance::new(&information, &middle, &rows, norm).map_err(|e| no_design(file, moments, e))?;
        Ok(Self::Covariance { covariance: Box::new(covariance), weights })
    }

    /// The best shares within `bounds`.
    ///
    /// # Errors
    /// As the solvers.
    pub fn solve(&self, bounds: &Bounds, options: &Options) -> Result<Design, Error> {
        match self {
            Self::Information(candidates) => solve_within(candidates, bounds, options),
            Self::Covariance { covariance, .. } => {
                let mut options = *options;
                if matches!(covariance.norm(), Norm::PowerMean(s) if s == LARGEST) {
                    options.tolerance = options.tolerance.max(E_TOLERANCE);
                }
                solve_covariance(covariance, bounds, &options)
            }
        }
    }

    /// The best counts.
    ///
    /// # Errors
    /// As [`count_segments`].
    pub fn count(
        &self,
        shares: &[f64],
        total: u64,
        limits: Option<&[u64]>,
        options: &CountOptions,
    ) -> Result<Counted, Error> {
        match self {
            Self::Information(candidates) => {
                let (scaled, offset) = candidates.scaled()?;
                let mut counted = count_segments(&scaled, shares, total, limits, options)?;
                counted.value += offset;
                counted.apportioned += offset;
                Ok(counted)
            }
            Self::Covariance { covariance, .. } => {
                count_segments(covariance.as_ref(), shares, total, limits, options)
            }
        }
    }

    /// The efficiency of other shares against `design`'s. `parameters`: their number.
    pub fn efficiency(&self, design: &Design, shares: &[f64], parameters: usize) -> f64 {
        match self {
            Self::Information(candidates) => design.efficiency(candidates, shares, parameters),
            Self::Covariance { covariance, .. } => covariance.efficiency(design, shares),
        }
    }

    /// [`Criterion::efficiency`] of every candidate on its own.
    pub fn single_efficiencies(&self, design: &Design, parameters: usize) -> Vec<f64> {
        match self {
            Self::Information(candidates) => design.single_efficiencies(candidates, parameters),
            Self::Covariance { covariance, .. } => {
                let mut alone = vec![0.0; design.shares.len()];
                let mut single = |q: usize| {
                    alone[q] = 1.0;
                    let efficiency = covariance.efficiency(design, &alone);
                    alone[q] = 0.0;
                    efficiency
                };
                (0..design.shares.len()).map(&mut single).collect()
            }
        }
    }
}

/// The weight of every parameter: 1, 1/θ², or those of a file, in which parameters that are not named count nothing.
///
/// # Errors
/// Usage where the criterion has no weights; a weight of an unknown parameter or below zero; a parameter of zero.
pub fn weights(
    name: CriterionName,
    relative: Relative,
    given: Option<&Path>,
    file: &Path,
    moments: &MomentsDocument,
    provenance: &mut Provenance,
) -> Result<Vec<f64>, Failure> {
    let parameters: Vec<&str> =
        moments.degrees.iter().flat_map(|d| d.parameters.iter().map(String::as_str)).collect();
    match (given, name) {
        (Some(path), CriterionName::A | CriterionName::ARelative | CriterionName::E) => {
            let (written, digest) = read_toml::<WeightsFile>(path)?;
            provenance.inputs.insert("weights".into(), digest);
            check_weights(path, &written.weight, &parameters)?;
            Ok(parameters.iter().map(|p| written.weight.get(*p).copied().unwrap_or(0.0)).collect())
        }
        (Some(_), _) => Err(Failure::Usage(
            "--weights: found weights for a D-criterion, which no weights change, expected --criterion a, a-relative or e; \
             leave them out"
                .into(),
        )),
        (None, CriterionName::ARelative) => relative_weights(relative, file, moments, &parameters),
        (None, _) => Ok(vec![1.0; parameters.len()]),
    }
}

fn relative_weights(
    relative: Relative,
    file: &Path,
    moments: &MomentsDocument,
    parameters: &[&str],
) -> Result<Vec<f64>, Failure> {
    // Without disturbances the criterion itself is refused.
    let Some(disturbances) = &moments.disturbances else { return Ok(vec![1.0; parameters.len()]) };
    let of = |d: &ExpectedDisturbances, name: &str| match relative {
        Relative::Nominal => d.nominal.get(name).copied(),
        Relative::Value => d.parameters.get(name).copied(),
    };
    let weight = |name: &&str| match of(disturbances, name) {
        Some(theta) if theta != 0.0 && theta.is_finite() => Ok(1.0 / (theta * theta)),
        found => Err(Failure::refuse(
            file,
            &format!("parameter `{name}`"),
            &found.map_or("no value".into(), |v| format!("{v}")),
            "a value other than 0 that its error can be relative to",
            match relative {
                Relative::Nominal => "take --relative-to value, or name --weights",
                Relative::Value => "name --weights",
            },
        )),
    };
    parameters.iter().map(weight).collect()
}

fn check_weights(path: &Path, written: &BTreeMap<String, f64>, parameters: &[&str]) -> Result<(), Failure> {
    if let Some(unknown) = written.keys().find(|key| !parameters.contains(&key.as_str())) {
        let remedy = match nearest(unknown, parameters.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "name one of them".into(),
        };
        let expected = format!("a parameter: one of {}", parameters.join(", "));
        return Err(Failure::refuse(path, "`weight`", &format!("`{unknown}`"), &expected, &remedy));
    }
    if let Some((name, weight)) = written.iter().find(|(_, w)| !(w.is_finite() && **w >= 0.0)) {
        let thing = format!("`weight` of `{name}`");
        return Err(Failure::refuse(path, &thing, &weight.to_string(), "zero or more", "correct it"));
    }
    match written.values().any(|w| *w > 0.0) {
        true => Ok(()),
        false => Err(Failure::refuse(path, "`weight`", "none above zero", "at least one", "add one")),
    }
}

/// Weights of all rows: 0 for intercepts.
fn lifted(degrees: &[DegreeStructure], weights: &[f64], removal: Removal) -> Vec<f64> {
    let mut rest = weights.iter().copied();
    let mut out = Vec::new();
    for degree in degrees {
        out.extend(rest.by_ref().take(degree.parameters.len()));
        if removal == Removal::Complete {
            out.push(0.0);
        }
    }
    out
}
