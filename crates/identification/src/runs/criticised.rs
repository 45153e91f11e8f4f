use engine::{Run, RunView};
use model::Model;

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
    /// Whether runs are asked. Sensors without noise are stated by nobody.
    pub fn asks(&self, asked: Asked) -> bool {
        let stated = self.levels.is_some_and(|levels| levels.measurement.iter().all(|std| *std > 0.0));
        match asked {
            Asked::Stated => stated,
            Asked::Always => true,
            Asked::Never => false,
        }
    }

    /// Seconds that asking takes a thread for a row, to the order; see [`crate::Estimator::seconds_per_row`].
    pub fn seconds_per_row_asked(&self) -> f64 {
        if self.asks(Asked::Stated) { 6e-6 } else { 2.5e-4 }
    }

    /// Asks every run by itself what the model lacks; the estimates of those that reject it say so. Estimates are refined
    /// under the noise before, so that the verdict is about model and run, whichever estimator's it began with, and one is
    /// enough for all of them. `estimates`: those of `runs`, as [`RunEstimators::estimates`] orders them.
    pub fn criticise(&self, runs: &[Run], estimates: &mut [RunEstimate]) {
        let each = self.estimators.len().max(1);
        let (layout, model) =
            (self.vessel.model.layout().with_intercepts(), self.vessel.model.with_intercepts());
        // The last estimator that has one: those that simulate come after those that regress.
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

/// Runs that are judged side by side: their estimates lie at the same bounds, if at any, and are held there.
struct Alike {
    model: Model,
    runs: Vec<usize>,
    thetas: Vec<Vec<f64>>,
}

impl Alike {
    /// Adds a run, whose estimate is that of a model `held` at its bounds, to those that are like it.
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

/// Estimates of a run that rejects the model say so.
fn reject(estimates: &mut [RunEstimate]) {
    for estimate in estimates.iter_mut().filter(|estimate| estimate.estimate.is_some()) {
        estimate.status = EstimateStatus::Rejected;
    }
}
