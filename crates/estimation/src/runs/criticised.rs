use ship::engine::{Run, RunView};
use ship::model::Model;

use super::estimators::RunEstimators;
use crate::criticism::{Subject, criticise_each};
use crate::predictor::InitialState;
use crate::{EstimateStatus, RunEstimate};

refusal::choices! {
    /// Which runs are asked what the model lacks.
    pub enum Asked {
        /// Those whose disturbances are stated.
        Stated = "stated",
        /// All; noise that is not stated is looked for in every run, which takes a third of a second for each.
        Always = "always",
        /// None.
        Never = "never",
    }
}

impl RunEstimators<'_> {
    /// Whether runs are tested; those of a ship with forces are not. The noise of a sensor is never exactly zero.
    pub fn asks(&self, asked: Asked) -> bool {
        if self.vessel.model.forces.is_some() {
            return false;
        }
        let stated = self.levels.is_some_and(|levels| levels.measurement.iter().all(|std| *std > 0.0));
        match asked {
            Asked::Stated => stated,
            Asked::Always => true,
            Asked::Never => false,
        }
    }

    /// Seconds of a test per row and thread, order of magnitude; see [`crate::Estimator::seconds_per_row`].
    pub fn seconds_per_row_asked(&self) -> f64 {
        if self.asks(Asked::Stated) { 6e-6 } else { 2.5e-4 }
    }

    /// Tests on every run by itself what the model lacks; the estimates of runs that reject it are marked. Estimates
    /// are first refined under the noise, so that the verdict depends on model and run, not on the estimator, and one
    /// is enough for all of them. `estimates`: those of `runs`, as [`RunEstimators::estimates`] orders them.
    pub fn criticise(&self, runs: &[Run], estimates: &mut [RunEstimate]) {
        let each = self.estimators.len().max(1);
        let (layout, model) =
            (self.vessel.model.layout().with_intercepts(), self.vessel.model.with_intercepts());
        // The last estimator with an estimate: those that simulate come after those that regress.
        let found = |own: &[RunEstimate]| {
            own.iter().rev().find_map(|e| e.estimate.as_ref().map(|(theta, _)| theta.clone()))
        };
        let mut alike: Vec<Alike> = Vec::new();
        for (run, own) in estimates.chunks(each).enumerate() {
            if let Some(theta) = found(own) {
                Alike::add(&mut alike, model.held_at_bounds(&layout.woven(&theta, [0.0; 3])), run);
            }
        }
        for Alike { model, runs: asked, thetas } in &alike {
            let views: Vec<RunView> = asked.iter().map(|run| runs[*run].view()).collect();
            let subject = Subject {
                model,
                runs: &views,
                rate_hz: self.vessel.sample_rate_hz,
                known_start: self.initial == InitialState::Known,
                levels: self.levels.filter(|_| self.asks(Asked::Stated)),
                names: &[],
            };
            for (run, found) in asked.iter().zip(criticise_each(&subject, thetas)) {
                if found.is_some_and(|found| found.rejected) {
                    reject(&mut estimates[run * each..(run + 1) * each]);
                }
            }
        }
    }
}

/// Runs that are tested together: their estimates are held at the same bounds, if at any.
struct Alike {
    model: Model,
    runs: Vec<usize>,
    thetas: Vec<Vec<f64>>,
}

impl Alike {
    /// Adds a run, whose estimate is that of a model `held` at its bounds, to those with the same bounds.
    fn add(all: &mut Vec<Self>, held: (Model, Vec<f64>), run: usize) {
        let (model, theta) = held;
        match all.iter_mut().find(|alike| alike.model == model) {
            Some(alike) => {
                alike.runs.push(run);
                alike.thetas.push(theta);
            }
            None => all.push(Self { model, runs: vec![run], thetas: vec![theta] }),
        }
    }
}

/// Marks the estimates of a run that rejects the model.
fn reject(estimates: &mut [RunEstimate]) {
    for estimate in estimates.iter_mut().filter(|estimate| estimate.estimate.is_some()) {
        estimate.status = EstimateStatus::Rejected;
    }
}
