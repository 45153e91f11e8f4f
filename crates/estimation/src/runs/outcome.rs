use numerics::lanes::{groups, interleave};
use refusal::Invalid;
use regression::runs::{NominalDiverged, Prepared};
use regression::{Direction, Excitation, MeanRemoval, Noise, Outcome, estimate_prefiltered};
use ship::engine::Run;
use ship::model::Vessel;
use thiserror::Error;

use crate::predictor::{NoiseModel, RunFit};
use crate::{EstimateStatus, Estimator, RunEstimate};

#[derive(Clone)]
pub(super) struct RunOutcome {
    pub status: EstimateStatus,
    pub estimate: Option<(Vec<f64>, Vec<f64>)>,
    pub covariance: Option<Vec<f64>>,
    /// Intercepts, if they were estimated with the parameters; else they are the mean residuals.
    pub intercepts: Option<[f64; 3]>,
    pub current: Option<[[f64; 2]; 2]>,
}

/// The result of instrumental variables, or least squares, on one run, and its excitation.
#[derive(Clone)]
pub(super) struct Regressed {
    pub outcome: RunOutcome,
    pub condition: [f64; 3],
    /// Per degree of freedom the index of the parameter.
    pub weakest: [usize; 3],
}

impl RunOutcome {
    pub(super) fn theta(&self) -> Option<&[f64]> {
        self.estimate.as_ref().map(|(theta, _)| theta.as_slice())
    }

    fn none(status: EstimateStatus) -> Self {
        Self { status, estimate: None, covariance: None, intercepts: None, current: None }
    }
}

impl From<&RunFit> for RunOutcome {
    fn from(fit: &RunFit) -> Self {
        match fit {
            RunFit::Converged(fitted) => Self {
                status: if fitted.standard_errors.iter().any(|error| error.is_nan()) {
                    EstimateStatus::Waves
                } else if fitted.approximate {
                    EstimateStatus::Approximate
                } else {
                    EstimateStatus::Identified
                },
                estimate: Some((fitted.parameters.clone(), fitted.standard_errors.clone())),
                covariance: fitted.covariance.clone(),
                intercepts: Some(fitted.intercepts),
                current: fitted.current,
            },
            RunFit::NotConverged(_) => Self::none(EstimateStatus::NotConverged),
            RunFit::NotIdentifiable(_) => Self::none(EstimateStatus::NotIdentifiable),
        }
    }
}

impl Regressed {
    pub(super) fn new(run: &Run, outcome: Outcome, excitation: [Excitation; 3]) -> Result<Self, RunError> {
        let weakest = [0, 1, 2].map(|d: usize| excitation[d].weakest);
        let condition = excitation.map(|e| e.condition);
        match outcome {
            Outcome::Identified(regression) => {
                let estimate = Some((regression.parameters, regression.standard_errors));
                let covariance = Some(regression.covariance);
                let outcome =
                    RunOutcome { estimate, covariance, ..RunOutcome::none(EstimateStatus::Identified) };
                Ok(Self { outcome, condition, weakest })
            }
            Outcome::NotIdentifiable(Direction { degree, parameter }) => {
                let outcome = RunOutcome::none(EstimateStatus::NotIdentifiable);
                Ok(Self { outcome, condition, weakest }.unidentified(degree, parameter))
            }
            Outcome::TooShort => {
                Err(RunError::TooShort { design: run.design.clone(), run: run.run, samples: run.samples() })
            }
        }
    }

    pub(super) fn without(mut self, status: EstimateStatus) -> Self {
        self.outcome = RunOutcome::none(status);
        self
    }

    pub(super) fn unidentified(mut self, degree: usize, parameter: usize) -> Self {
        self.outcome = RunOutcome::none(EstimateStatus::NotIdentifiable);
        self.weakest[degree] = parameter;
        self.condition[degree] = f64::INFINITY;
        self
    }

    pub(super) fn estimate(
        &self,
        vessel: &Vessel,
        run: &Run,
        estimator: Estimator,
        outcome: &RunOutcome,
    ) -> RunEstimate {
        let named = |d: usize| vessel.model.degrees[d].parameters[self.weakest[d]].clone();
        RunEstimate {
            design: run.design.clone(),
            run: run.run,
            estimator,
            status: outcome.status,
            estimate: outcome.estimate.clone(),
            condition: self.condition,
            weakest: [0, 1, 2].map(named),
        }
    }
}

/// Why runs cannot be estimated at all.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RunError {
    /// There are no instruments.
    #[error(transparent)]
    Diverged(#[from] NominalDiverged),
    /// Estimates of a ship with forces that cannot be.
    #[error("{0}")]
    Forces(Invalid),
    /// A degree of freedom has no fewer unknowns (parameters and intercepts) than the run has samples.
    #[error("design {design}, run {run} has {samples} samples, no more than unknowns")]
    TooShort {
        /// The run's design.
        design: String,
        /// The run's number.
        run: i32,
        /// Its samples.
        samples: usize,
    },
}

impl RunError {
    /// The invalid part: of the vessel if its nominal model diverges, else of the runs.
    pub fn invalid(&self) -> Invalid {
        match self {
            Self::Diverged(diverged) => diverged.invalid(),
            Self::Forces(invalid) => invalid.clone(),
            Self::TooShort { design, run, samples } => Invalid::new(
                format!("design {design}, run {run}"),
                format!("{samples} samples"),
                "more samples than unknowns (parameters and intercepts of a degree of freedom)",
                "lengthen the run, or remove the mean over the whole run",
            ),
        }
    }
}

/// Refinements after which the estimate is a good start for searches.
const ROUNDS: usize = 2;
/// Converged if a round changes no parameter by more than this share of its standard error.
const ENOUGH: f64 = 0.01;

/// Parameters near those of `runs`, from the estimates `iv`: with instruments and filter of the estimate, or of the
/// nominal model where its simulation diverges.
pub(super) fn refined(
    vessel: &Vessel,
    runs: &[Run],
    iv: &[Regressed],
    removal: MeanRemoval,
    levels: Option<&NoiseModel>,
) -> Vec<Option<Vec<f64>>> {
    let noise = levels.and_then(NoiseModel::white);
    let lengths: Vec<usize> = runs.iter().map(Run::samples).collect();
    let group = |group: std::ops::Range<usize>| {
        let mut batch = Refinement::new(vessel, &runs[group.clone()], &iv[group], removal, noise);
        for round in 0..ROUNDS {
            if batch.done.iter().all(|done| *done) {
                break;
            }
            batch.round(round == 0);
        }
        batch.thetas
    };
    groups(&lengths).into_iter().flat_map(group).collect()
}

struct Refinement<'a> {
    vessel: &'a Vessel,
    removal: MeanRemoval,
    noise: Option<Noise>,
    runs: Prepared<'a>,
    thetas: Vec<Option<Vec<f64>>>,
    models: Vec<Vec<f64>>,
    done: Vec<bool>,
}

impl<'a> Refinement<'a> {
    fn new(
        vessel: &'a Vessel,
        runs: &[Run],
        iv: &[Regressed],
        removal: MeanRemoval,
        noise: Option<Noise>,
    ) -> Self {
        let thetas: Vec<Option<Vec<f64>>> =
            iv.iter().map(|r| r.outcome.theta().map(<[f64]>::to_vec)).collect();
        Self {
            vessel,
            removal,
            noise,
            runs: Prepared::regressed(vessel, runs),
            models: thetas.iter().map(|theta| theta.as_ref().unwrap_or(&vessel.nominal).clone()).collect(),
            done: thetas.iter().map(Option::is_none).collect(),
            thetas,
        }
    }

    fn round(&mut self, first: bool) {
        let parameters = interleave(&self.models.iter().map(Vec::as_slice).collect::<Vec<_>>());
        self.runs.simulate(&parameters);
        let batch = self.runs.batch();
        let outcomes = estimate_prefiltered(&batch, &parameters, self.removal, self.noise.as_ref());
        for (lane, outcome) in outcomes.into_iter().enumerate().take(self.thetas.len()) {
            let diverged = self.runs.diverged(lane).is_some();
            if diverged && first && self.models[lane] != self.vessel.nominal {
                self.models[lane].clone_from(&self.vessel.nominal);
            } else {
                self.take(lane, (!diverged).then_some(outcome));
            }
        }
    }

    fn take(&mut self, lane: usize, outcome: Option<Outcome>) {
        if self.done[lane] {
            return;
        }
        let Some(Outcome::Identified(next)) = outcome else {
            self.done[lane] = true;
            return;
        };
        if let Some(theta) = &self.thetas[lane] {
            let moves = next.parameters.iter().zip(theta).zip(&next.standard_errors);
            // At a bound a parameter neither moves nor has an error.
            let still = |moved: f64| moved <= ENOUGH || moved.is_nan();
            self.done[lane] = moves.map(|((a, b), se)| (a - b).abs() / se).all(still);
        }
        self.models[lane].clone_from(&next.parameters);
        self.thetas[lane] = Some(next.parameters);
    }
}
