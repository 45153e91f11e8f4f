//! Instrumental variables where the nominal model diverges.

use std::slice;

use numerics::Lane;
use regression::runs::Prepared;
use regression::{InstrumentKind, Instruments};
use ship::engine::Run;

use super::error::RunError;
use super::estimators::RunEstimators;
use super::found::Regressed;
use crate::EstimateStatus;
use crate::predictor::Fit;

impl RunEstimators<'_> {
    /// Estimates by instruments of the nominal model. Where it diverges over a run, they are those of the model of
    /// least output error over this run: to the first order its errors are means over the run, so that its simulated
    /// states know little of the noise at one sample. A run over which the search for that model does not converge has no
    /// estimate.
    ///
    /// # Errors
    /// A run over which the nominal model diverges and that determines no other; one that is too short.
    pub(super) fn instrumented(&self, runs: &[Run]) -> Result<Vec<Regressed>, RunError> {
        match self.regressed(InstrumentKind::Nominal, runs) {
            Err(RunError::Diverged(_)) => runs.iter().map(|run| self.instrumented_alone(run)).collect(),
            all => all,
        }
    }

    fn instrumented_alone(&self, run: &Run) -> Result<Regressed, RunError> {
        let one = slice::from_ref(run);
        let diverged = match self.regressed(InstrumentKind::Nominal, one) {
            Err(RunError::Diverged(at)) => RunError::Diverged(at),
            found => return found.map(|mut own| own.remove(0)),
        };
        let simple = self.regressed(InstrumentKind::Regressors, one)?.remove(0);
        let Some(start) = simple.found.theta() else { return Err(diverged) };
        let own = match self.output_error(one, &[Some(start.to_vec())], slice::from_ref(&simple), false).pop()
        {
            Some(Fit::Converged(own)) => self.instrumented_by(run, &own.parameters)?,
            _ => None,
        };
        Ok(own.unwrap_or_else(|| simple.without(EstimateStatus::NotConverged)))
    }

    /// The estimate of `run` with instruments simulated by the parameters `theta`; `None` where these diverge.
    fn instrumented_by(&self, run: &Run, theta: &[f64]) -> Result<Option<Regressed>, RunError> {
        let mut prepared = Prepared::regressed(self.vessel, slice::from_ref(run));
        prepared.simulate(&theta.iter().copied().map(Lane::splat).collect::<Vec<_>>());
        if prepared.diverged(0).is_some() {
            return Ok(None);
        }
        let batch = prepared.batch();
        let (outcome, excitation) =
            Instruments::new(&batch, self.removal).estimate_with_excitation(&batch).swap_remove(0);
        let mut own = Regressed::new(run, outcome, excitation)?;
        if own.found.status == EstimateStatus::Identified {
            own.found.status = EstimateStatus::OwnInstruments;
        }
        Ok(Some(own))
    }
}
