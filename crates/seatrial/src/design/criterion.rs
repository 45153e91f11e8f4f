//! The criterion that shares are best for.

use std::path::Path;

use clap::ValueEnum;
use design::{
    Bounds, Candidates, CountOptions, Counted, Covariance, Design, Error, Norm, Objective, Options,
    Restriction, Robust, Selected, count_segments, select, solve_covariance, solve_robust, solve_within,
};

use super::matrices::{Estimated, information};
use super::models::{covariance, robust};
use crate::failure::Failure;
use crate::instruments::Removal;
use study::documents::MomentsDocument;

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
    /// Variance of free runs over the validation maneuvers (with --for output-error)
    V,
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
            Self::V => "covariance V",
        }
    }
}

/// How the criteria of several models become one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OverModels {
    /// The mean of their logarithms
    Mean,
    /// The worst one's
    Worst,
}

/// What is asked for.
pub struct Asked<'a> {
    /// The criterion.
    pub name: CriterionName,
    /// The estimate that it is about.
    pub estimated: Estimated,
    /// Weight of every parameter's variance.
    pub weights: Vec<f64>,
    /// Moments of the same maneuvers with other models, with their files.
    pub also: &'a [(&'a Path, MomentsDocument)],
    /// How the models become one.
    pub over: OverModels,
}

/// Exponent of the power mean that stands for the largest eigenvalue: within log(eigenvalues)/s of it.
pub(super) const LARGEST: f64 = 16_777_216.0;
/// What the search for the largest eigenvalue, or for the worst model, can reach.
const E_TOLERANCE: f64 = 1e-7;
/// What is maximised.
pub enum Criterion {
    /// log|det| of the information matrix.
    Information(Candidates),
    /// A criterion of the covariance.
    Covariance(Box<CovarianceCriterion>),
}

/// A criterion of the covariance, of one model or several.
pub struct CovarianceCriterion {
    /// The criterion for the model of the moments themselves.
    pub covariance: Covariance,
    /// Weights of the parameters' variances, in their order.
    pub weights: Vec<f64>,
    /// Over all models, where there are several.
    pub robust: Option<Robust>,
}

impl Criterion {
    /// The criterion that is asked for, of `moments`, which stand in `file`.
    ///
    /// # Errors
    /// Moments without expected disturbances or without what the estimator needs; a covariance that is singular, naming the
    /// parameter; moments of other maneuvers among the other models.
    pub fn new(asked: &Asked, file: &Path, moments: &MomentsDocument) -> Result<Self, Failure> {
        let information = information(file, moments, asked.estimated)?;
        if asked.name == CriterionName::DHessian {
            return Ok(Self::Information(information));
        }
        let covariance = covariance(asked, file, moments, &information)?;
        let robust = if asked.also.is_empty() { None } else { Some(robust(asked, moments, &covariance)?) };
        let weights = asked.weights.clone();
        Ok(Self::Covariance(Box::new(CovarianceCriterion { covariance, weights, robust })))
    }

    /// The best shares within `bounds`.
    ///
    /// # Errors
    /// As the solvers.
    pub fn solve(&self, bounds: &Bounds, options: &Options) -> Result<Design, Error> {
        let rough = Options { tolerance: options.tolerance.max(E_TOLERANCE), ..*options };
        match self {
            Self::Information(candidates) => solve_within(candidates, bounds, options),
            Self::Covariance(c) => match (&c.robust, c.covariance.norm()) {
                (Some(robust), _) => solve_robust(robust, bounds, &rough),
                (None, Norm::PowerMean(s)) if s == LARGEST => solve_covariance(&c.covariance, bounds, &rough),
                (None, _) => solve_covariance(&c.covariance, bounds, options),
            },
        }
    }

    /// The best shares under a restriction.
    ///
    /// # Errors
    /// As [`select`].
    pub fn select(
        &self,
        relaxed: &Design,
        bounds: &Bounds,
        restriction: &Restriction,
        options: &Options,
    ) -> Result<Selected, Error> {
        let options = &Options { tolerance: options.tolerance.max(E_TOLERANCE), ..*options };
        match self {
            Self::Information(candidates) => {
                let (scaled, offset) = candidates.scaled()?;
                let mut own = relaxed.clone();
                own.log_det -= offset;
                let mut found = select(&scaled, &own, bounds, restriction, options)?;
                found.value += offset;
                Ok(found)
            }
            Self::Covariance(c) => match &c.robust {
                Some(robust) => select(robust, relaxed, bounds, restriction, options),
                None => select(&c.covariance, relaxed, bounds, restriction, options),
            },
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
            Self::Covariance(c) => match &c.robust {
                Some(robust) => count_segments(robust, shares, total, limits, options),
                None => count_segments(&c.covariance, shares, total, limits, options),
            },
        }
    }

    /// The value at `shares`; `None` where it is not defined.
    pub fn value(&self, shares: &[f64]) -> Option<f64> {
        match self {
            Self::Information(candidates) => candidates.value(shares, &mut design::Evaluation::default()),
            Self::Covariance(c) => match &c.robust {
                Some(robust) => robust.value(shares, &mut design::RobustPoint::default()),
                None => c.covariance.value(shares, &mut design::CovariancePoint::default()),
            },
        }
    }

    /// g_q of every candidate at `shares`; `None` where the criterion is not defined.
    pub fn sensitivities(&self, shares: &[f64]) -> Option<Vec<f64>> {
        fn of<O: Objective>(objective: &O, shares: &[f64]) -> Option<Vec<f64>> {
            let mut at = O::Point::default();
            objective.evaluate(shares, &mut at)?;
            Some((0..objective.len()).map(|q| objective.sensitivity(q, &at)).collect())
        }
        match self {
            Self::Information(candidates) => of(candidates, shares),
            Self::Covariance(c) => {
                c.robust.as_ref().map_or_else(|| of(&c.covariance, shares), |r| of(r, shares))
            }
        }
    }

    /// What the criterion gains per log of time spent at fixed shares.
    pub fn degree(&self) -> f64 {
        match self {
            Self::Information(candidates) => Objective::degree(candidates),
            Self::Covariance(c) => c.covariance.degree(),
        }
    }

    /// The efficiency of other shares against `design`'s. `parameters`: their number.
    pub fn efficiency(&self, design: &Design, shares: &[f64], parameters: usize) -> f64 {
        match self {
            Self::Information(candidates) => design.efficiency(candidates, shares, parameters),
            Self::Covariance(_) => {
                let value = self.value(shares);
                value.map_or(0.0, |value| ((value - design.log_det) / self.degree()).exp())
            }
        }
    }

    /// [`Criterion::efficiency`] of every candidate on its own.
    pub fn single_efficiencies(&self, design: &Design, parameters: usize) -> Vec<f64> {
        if let Self::Information(candidates) = self {
            return design.single_efficiencies(candidates, parameters);
        }
        let mut alone = vec![0.0; design.shares.len()];
        let mut single = |q: usize| {
            alone[q] = 1.0;
            let efficiency = self.efficiency(design, &alone, parameters);
            alone[q] = 0.0;
            efficiency
        };
        (0..design.shares.len()).map(&mut single).collect()
    }
}

/// Whether the instruments' mean leaves an intercept among the unknowns.
pub(super) fn intercepts(removal: Removal) -> bool {
    removal == Removal::Complete
}
