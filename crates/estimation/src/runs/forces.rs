//! Output error of single runs of a ship with forces.

use rayon::prelude::*;
use refusal::Invalid;
use regression::Noise;
use ship::engine::Run;
use ship::model::{ForceModel, Vessel};

use super::RunEstimators;
use super::outcome::RunError;
use crate::estimator::AdditionalUnknowns;
use crate::fitting::{MeasuredRun, PredictedErrors, Prior, SimulatedRun, Unfit};
use crate::predictor::{Flow, InitialState, NoiseModel};
use crate::{EstimateCovariance, EstimateStatus, Estimator, RunEstimate};

impl Estimator {
    /// Refuses an estimator from terms per sample for a `vessel` with forces.
    ///
    /// # Errors
    /// Names the estimator.
    pub fn check(self, vessel: &Vessel) -> Result<(), Invalid> {
        if self == Self::OutputError {
            return Ok(());
        }
        let remedy = "take the estimator `output-error`, which fits forces".to_owned();
        vessel.check_terms(self.name()).map_err(|e| Invalid { remedy, ..e })
    }
}

/// What estimates cannot be made of, by the part at fault.
#[derive(Clone, Debug, PartialEq)]
pub enum Unsuited {
    /// The vessel.
    Vessel(Invalid),
    /// The runs, or what is said of them.
    Runs(Invalid),
}

impl From<Unsuited> for Invalid {
    fn from(refused: Unsuited) -> Self {
        match refused {
            Unsuited::Vessel(invalid) | Unsuited::Runs(invalid) => invalid,
        }
    }
}

/// The noise that errors of a ship with forces are predicted from.
fn white(levels: Option<&NoiseModel>) -> Result<Noise, Invalid> {
    let refused = |found: &str, remedy: &str| {
        let expected =
            "white noise in u, v and r and at most a white current, which errors of forces are weighed by";
        Err(Invalid::new("disturbances", found, expected, remedy))
    };
    let Some(levels) = levels else {
        return refused(
            "none stated",
            "add --campaign campaign.toml, or fit the run by `estimate --fit together`",
        );
    };
    let current = match levels.current {
        Flow::Still => 0.0,
        Flow::White { std } => std,
        Flow::Markov { .. } => {
            return refused("a current that lasts", "fit the run by `estimate --fit together`");
        }
    };
    if levels.force.is_some() || levels.drift.is_some() {
        return refused("wind, or errors that drift", "fit the run by `estimate --fit together`");
    }
    match levels.measurement.contains(&0.0) {
        true => refused("no noise in a state", "state what the sensor has, however little"),
        false => Ok(Noise { measurement: levels.measurement, current }),
    }
}

impl RunEstimators<'_> {
    /// Refuses estimators that the vessel's model does not have, and of a ship with forces what estimates of runs cannot do.
    ///
    /// # Errors
    /// Of the vessel: an estimator. Of the runs: noise that is not stated or not white; a start that is not known; unknowns besides
    /// her parameters.
    pub fn check(&self) -> Result<(), Unsuited> {
        let refused = self.estimators.iter().try_for_each(|estimator| estimator.check(self.vessel));
        refused.map_err(Unsuited::Vessel)?;
        if self.vessel.model.has_regressors() {
            return Ok(());
        }
        if self.initial != InitialState::Known {
            let (start, expected) =
                ("measured ones", "simulated runs, whose start is known, of a ship with forces");
            let remedy = "fit them by `estimate --fit together`";
            return Err(Unsuited::Runs(Invalid::new("runs", start, expected, remedy)));
        }
        if self.additional != AdditionalUnknowns::default() {
            let expected = "the parameters of a ship with forces alone";
            let invalid = Invalid::new("unknowns", "additional ones", expected, "leave out their flags");
            return Err(Unsuited::Runs(invalid));
        }
        white(self.levels.as_ref()).map(|_| ()).map_err(Unsuited::Runs)
    }

    pub(super) fn by_forces(
        &self,
        moved: &ForceModel,
        runs: &[Run],
    ) -> Result<Vec<(RunEstimate, EstimateCovariance)>, RunError> {
        self.check().map_err(|refused| RunError::Forces(refused.into()))?;
        let noise = white(self.levels.as_ref()).map_err(RunError::Forces)?;
        let single = Single { vessel: self.vessel, moved, noise };
        let estimates: Vec<_> = runs.par_iter().map(|run| single.estimate(run)).collect();
        let rows = |(estimate, covariance): &(RunEstimate, EstimateCovariance)| {
            let row = |estimator: &Estimator| RunEstimate { estimator: *estimator, ..estimate.clone() };
            self.estimators.iter().map(|estimator| (row(estimator), covariance.clone())).collect::<Vec<_>>()
        };
        Ok(estimates.iter().flat_map(rows).collect())
    }
}

struct Single<'a> {
    vessel: &'a Vessel,
    moved: &'a ForceModel,
    noise: Noise,
}

impl Single<'_> {
    fn estimate(&self, run: &Run) -> (RunEstimate, EstimateCovariance) {
        let (status, weakest, condition, estimate, covariance) = match self.search(run) {
            Ok((theta, PredictedErrors { covariance, condition, weakest })) => {
                let errors = (0..theta.len()).map(|i| covariance[i * (theta.len() + 1)].sqrt()).collect();
                let weakest = self.moved.forces.parameters()[weakest].name.clone();
                (EstimateStatus::Identified, weakest, condition, Some((theta, errors)), Some(covariance))
            }
            Err((status, weakest)) => (status, weakest, f64::INFINITY, None, None),
        };
        let row = RunEstimate {
            design: run.design.clone(),
            run: run.run,
            estimator: Estimator::OutputError,
            status,
            estimate,
            condition: [condition; 3],
            weakest: [0, 1, 2].map(|_| weakest.clone()),
        };
        (row, covariance)
    }

    /// The most probable numbers and their errors; else why there are none, and the number that is to blame.
    fn search(&self, run: &Run) -> Result<(Vec<f64>, PredictedErrors), (EstimateStatus, String)> {
        let Self { vessel, moved, noise } = self;
        let simulated = SimulatedRun {
            initial: run.initial,
            inputs: &run.exogenous,
            width: vessel.model.exogenous(),
            sample_s: moved.sample_s,
        };
        let measured = MeasuredRun { run: simulated, measured: &run.measured, noise: noise.measurement };
        let theta = match measured.most_probable(&moved.forces, &self.priors(), &vessel.nominal) {
            Ok(theta) => theta,
            Err(Unfit::Undetermined(name)) => return Err((EstimateStatus::NotIdentifiable, name)),
            Err(_) => return Err((EstimateStatus::NotConverged, self.first())),
        };
        let information = simulated.information(&moved.forces, &theta, noise);
        let errors = information.and_then(|sums| sums.errors(&self.known(), &self.free(&theta)));
        Ok((theta, errors.ok_or_else(|| (EstimateStatus::NotIdentifiable, self.first()))?))
    }

    fn priors(&self) -> Vec<Option<Prior>> {
        let prior = |(deviation, mean): (Option<f64>, &f64)| {
            deviation.map(|deviation| Prior { mean: *mean, deviation })
        };
        self.deviations().zip(&self.vessel.nominal).map(prior).collect()
    }

    fn deviations(&self) -> impl Iterator<Item = Option<f64>> {
        self.moved.forces.parameters().iter().map(|parameter| parameter.prior)
    }

    fn known(&self) -> Vec<f64> {
        self.deviations().map(|prior| prior.map_or(0.0, |deviation| deviation.powi(-2))).collect()
    }

    fn free(&self, theta: &[f64]) -> Vec<bool> {
        let parameters = self.moved.forces.parameters().iter();
        theta.iter().zip(parameters).map(|(value, parameter)| !parameter.bounds.contains(value)).collect()
    }

    fn first(&self) -> String {
        self.moved.forces.parameters().first().map_or(String::new(), |parameter| parameter.name.clone())
    }
}
