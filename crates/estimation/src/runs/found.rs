use regression::{Direction, Excitation, Outcome};
use ship::engine::Run;
use ship::model::Vessel;

use super::error::RunError;
use crate::predictor::Fit;
use crate::{EstimateStatus, Estimator, RunEstimate};

/// The result of an estimator on one run.
#[derive(Clone)]
pub(super) struct Found {
    pub status: EstimateStatus,
    pub estimate: Option<(Vec<f64>, Vec<f64>)>,
    /// The covariance of the parameters, if known.
    pub covariance: Option<Vec<f64>>,
    /// Intercepts, if they were estimated with the parameters; else they are the mean residuals.
    pub intercepts: Option<[f64; 3]>,
    /// The current, and its standard errors, if estimated.
    pub current: Option<[[f64; 2]; 2]>,
}

/// The result of instrumental variables, or least squares, on one run, and its excitation.
#[derive(Clone)]
pub(super) struct Regressed {
    pub found: Found,
    pub condition: [f64; 3],
    /// Per degree of freedom the index of the parameter.
    pub weakest: [usize; 3],
}

impl Found {
    /// θ̂, where there is one.
    pub(super) fn theta(&self) -> Option<&[f64]> {
        self.estimate.as_ref().map(|(theta, _)| theta.as_slice())
    }

    fn none(status: EstimateStatus) -> Self {
        Self { status, estimate: None, covariance: None, intercepts: None, current: None }
    }
}

impl From<&Fit> for Found {
    fn from(fit: &Fit) -> Self {
        match fit {
            Fit::Converged(found) => Self {
                status: if found.standard_errors.iter().any(|error| error.is_nan()) {
                    EstimateStatus::Waves
                } else if found.approximate {
                    EstimateStatus::Approximate
                } else {
                    EstimateStatus::Identified
                },
                estimate: Some((found.parameters.clone(), found.standard_errors.clone())),
                covariance: found.covariance.clone(),
                intercepts: Some(found.intercepts),
                current: found.current,
            },
            Fit::NotConverged(_) => Self::none(EstimateStatus::NotConverged),
            Fit::NotIdentifiable(_) => Self::none(EstimateStatus::NotIdentifiable),
        }
    }
}

impl Regressed {
    /// The `outcome` of `run`.
    ///
    /// # Errors
    /// A run that is too short.
    pub(super) fn new(run: &Run, outcome: Outcome, excitation: [Excitation; 3]) -> Result<Self, RunError> {
        let weakest = [0, 1, 2].map(|d: usize| excitation[d].weakest);
        let condition = excitation.map(|e| e.condition);
        match outcome {
            Outcome::Identified(found) => {
                let estimate = Some((found.parameters, found.standard_errors));
                let covariance = Some(found.covariance);
                let found = Found { estimate, covariance, ..Found::none(EstimateStatus::Identified) };
                Ok(Self { found, condition, weakest })
            }
            Outcome::NotIdentifiable(Direction { degree, parameter }) => {
                let found = Found::none(EstimateStatus::NotIdentifiable);
                Ok(Self { found, condition, weakest }.unidentified(degree, parameter))
            }
            Outcome::TooShort => {
                Err(RunError::TooShort { design: run.design.clone(), run: run.run, samples: run.samples() })
            }
        }
    }

    /// The same without an estimate.
    pub(super) fn without(mut self, status: EstimateStatus) -> Self {
        self.found = Found::none(status);
        self
    }

    /// The same without an estimate, because of this parameter.
    pub(super) fn unidentified(mut self, degree: usize, parameter: usize) -> Self {
        self.found = Found::none(EstimateStatus::NotIdentifiable);
        self.weakest[degree] = parameter;
        self.condition[degree] = f64::INFINITY;
        self
    }

    /// The estimate `found` of `run`, with this excitation.
    pub(super) fn estimate(
        &self,
        vessel: &Vessel,
        run: &Run,
        estimator: Estimator,
        found: &Found,
    ) -> RunEstimate {
        let named = |d: usize| vessel.model.degrees[d].parameters[self.weakest[d]].clone();
        RunEstimate {
            design: run.design.clone(),
            run: run.run,
            estimator,
            status: found.status,
            estimate: found.estimate.clone(),
            condition: self.condition,
            weakest: [0, 1, 2].map(named),
        }
    }
}
