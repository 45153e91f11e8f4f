//! Estimates that minimise the errors of predicted states.
//!
//! A predictor advances the state sample by sample with the model, x̂(k+1) = x̂(k) + φ(x̂(k))ᵀθ. Without gains it is
//! a free simulation, and the estimate one of *output error*; with the gains of an extended Kalman filter it is
//! corrected at every sample, and the estimate is one of *prediction error*, for runs with process noise. Forward
//! sensitivities ∂x̂/∂(θ, x̂(0)) are propagated with it (`sensitivity`), [`numerics::LANES`] runs at once;
//! [`numerics::least_squares`] takes the steps.

mod linear;
mod output_error;
mod prediction_error;

use numerics::least_squares::{Ended, Minimum};
use regression::Direction;
use ship::model::ParameterLayout;

pub(crate) use linear::{ENDING, Weighting, inverse, linearize, linearize_each, without};
pub use linear::{InitialState, Linear, Unknown};
pub(crate) use numerics::least_squares::scaled_inverse;
pub use output_error::output_error;
pub(crate) use prediction_error::errors_by_blocks;
pub use prediction_error::{innovations, prediction_error};

pub use crate::sensitivity::{
    Drift, Flow, ForceNoise, NoiseModel, Recordings, Sensitivities, Step, free_sweep,
};

#[derive(Clone, Debug)]
struct EstimateErrors {
    pub each: Vec<f64>,
    /// The covariance of the unknowns, as many rows, row-major; none where errors are the largest of several.
    pub covariance: Option<Vec<f64>>,
    /// Whether they are approximate, since errors follow no known kind of noise.
    pub approximate: bool,
}

impl EstimateErrors {
    /// Those on the diagonal of `covariance`.
    pub fn of(covariance: Vec<f64>) -> Self {
        Self { each: roots(&covariance), covariance: Some(covariance), approximate: false }
    }

    /// The larger of both, unknown by unknown, which no covariance belongs to.
    pub fn largest(self, other: Self) -> Self {
        let each = self.each.into_iter().zip(other.each).map(|(a, b)| a.max(b)).collect();
        Self { each, covariance: None, approximate: self.approximate || other.approximate }
    }

    /// With every error times `factor`.
    pub fn times(self, factor: f64) -> Self {
        let each = self.each.into_iter().map(|error| factor * error).collect();
        Self { each, covariance: self.covariance.map(|covariance| scaled(covariance, factor)), ..self }
    }
}

pub(crate) fn scaled(mut covariance: Vec<f64>, factor: f64) -> Vec<f64> {
    covariance.iter_mut().for_each(|entry| *entry *= factor * factor);
    covariance
}

/// The part of the `covariance` of all unknowns of a model that the terms' parameters have.
pub(crate) fn of_terms(layout: ParameterLayout, covariance: &[f64]) -> Vec<f64> {
    let all = covariance.len().isqrt();
    let numbers: Vec<usize> = (0..layout.parameters()).collect();
    let places = layout.theta(&numbers);
    places.iter().flat_map(|i| places.iter().map(move |j| covariance[i * all + j])).collect()
}

/// `covariance` without the rows and columns of parameters that are held: those whose standard error is 0.
pub(crate) fn held(mut covariance: Vec<f64>, standard_errors: &[f64]) -> Vec<f64> {
    let p = standard_errors.len();
    for (i, _) in standard_errors.iter().enumerate().filter(|(_, error)| **error == 0.0) {
        for j in 0..p {
            covariance[i * p + j] = 0.0;
            covariance[j * p + i] = 0.0;
        }
    }
    covariance
}

pub(crate) fn roots(covariance: &[f64]) -> Vec<f64> {
    let p = covariance.len().isqrt();
    covariance.iter().step_by(p + 1).map(|variance| variance.sqrt()).collect()
}

/// How standard errors are computed.
#[derive(Clone, Copy)]
pub enum Spread<'a> {
    /// By leaving out each of ten blocks of samples: for any kind of errors, and approximate.
    Blocks,
    /// From stated disturbances, propagated through the model to first order.
    Stated(&'a NoiseModel),
    /// The same from disturbances found for a run, by its index, at its estimate.
    Found(&'a (dyn Fn(usize, &[f64]) -> FoundSpread + Sync)),
}

/// Disturbances that were found for a run.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundSpread {
    /// The plausible ones, of which the largest standard error is used; if empty, blocks are left out.
    pub levels: Vec<NoiseModel>,
    /// Factor on standard errors.
    pub factor: f64,
    /// Whether waves move the ship, so that there are no standard errors.
    pub waves: bool,
}

/// The outcome for one run.
#[derive(Clone, Debug, PartialEq)]
pub enum RunFit {
    /// An estimate.
    Converged(Fitted),
    /// No minimum after this many steps, or none at all from a start that diverges.
    NotConverged(usize),
    /// A direction of the parameters does not change the prediction.
    NotIdentifiable(Direction),
}

/// An estimate of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// θ̂: surge, sway, yaw.
    pub parameters: Vec<f64>,
    /// Standard error of each.
    pub standard_errors: Vec<f64>,
    /// Their covariance, as many rows, row-major; none where the errors are the largest under several kinds of noise.
    pub covariance: Option<Vec<f64>>,
    /// One per degree of freedom; zero if the model has none.
    pub intercepts: [f64; 3],
    /// Estimated minus given initial state.
    pub offset: [f64; 3],
    /// The current \[m/s\] and its standard errors, if estimated.
    pub current: Option<[[f64; 2]; 2]>,
    /// Root mean square errors of the prediction in u, v \[m/s\], r \[rad/s\].
    pub rmse: [f64; 3],
    /// Steps of the search.
    pub steps: usize,
    /// Whether standard errors are approximate, since errors follow no known kind of noise.
    pub approximate: bool,
}

fn fit(
    runs: &Recordings,
    minimum: &Minimum<Linear>,
    errors: Option<EstimateErrors>,
    unknown: Unknown,
) -> RunFit {
    let layout = runs.model.layout();
    let (point, all) = (&minimum.point, layout.parameters());
    let free = unknown.free(runs.model);
    let entry = |of: &[f64], i: usize| {
        free.iter().position(|unknown| *unknown == all + i).map_or(0.0, |place| of[place])
    };
    let place = |unknown: usize| {
        let mut terms = (0..3).map(|d| (d, layout.terms(d)));
        terms.find(|(_, terms)| terms.contains(&unknown)).map(|(d, terms)| (d, unknown - terms.start))
    };
    match (minimum.status, errors) {
        (Ended::Singular(unknown), _) => place(unknown)
            .map_or(RunFit::NotConverged(minimum.steps), |(degree, parameter)| {
                RunFit::NotIdentifiable(Direction { degree, parameter })
            }),
        // Every parameter of a degree of freedom is at a bound: there is no estimate.
        (Ended::Converged, Some(_)) if all_held(layout, minimum).is_some() => {
            let degree = all_held(layout, minimum).unwrap_or_default();
            RunFit::NotIdentifiable(Direction { degree, parameter: 0 })
        }
        (Ended::Converged, Some(EstimateErrors { each: errors, covariance, approximate })) => {
            RunFit::Converged(Fitted {
                parameters: layout.theta(&point[..all]),
                standard_errors: layout.theta(&errors[..all]),
                covariance: covariance.map(|covariance| of_terms(layout, &covariance)),
                intercepts: layout.intercepts(point),
                offset: [0, 1, 2].map(|d| entry(point, d)),
                current: unknown.current.map(|_| [point, &errors].map(|of| [3, 4].map(|i| entry(of, i)))),
                rmse: minimum.sums.squares.map(|s| (s / minimum.sums.samples).sqrt()),
                steps: minimum.steps,
                approximate,
            })
        }
        _ => RunFit::NotConverged(minimum.steps),
    }
}

fn all_held(layout: ParameterLayout, minimum: &Minimum<Linear>) -> Option<usize> {
    (0..3).find(|d| layout.terms(*d).all(|i| minimum.held.contains(&i)))
}
