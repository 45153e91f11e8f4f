//! What errors the estimate of an experiment foretells, from the information of the whole sequence.

use estimation::parameter_error;
use estimation::pooled::{Covariance, Uncertain};
use numerics::statistics::median;
use numerics::{scaled_inverse, times};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::Streams;
use ship::model::Source;

use super::Arranging;
use super::whole::Information;
use crate::moments::Estimated;

/// Errors that estimates of many trials of the same experiment have: medians over estimates drawn from their predicted
/// distribution, to first order in their errors. Where the true parameters are known, priors pull every estimate the same way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Foretold {
    /// Median parameter error, as validations define it.
    pub parameter_error: f64,
    /// Median simulation error over the validation maneuvers; null without some.
    pub simulation_error: Option<f64>,
    /// How many estimates were drawn.
    pub draws: u32,
}

/// Estimates that are drawn, and the seed of their random numbers.
const DRAWS: (u32, u64) = (4000, 1);

impl Arranging<'_> {
    /// Of an output-error estimate of the experiment from `initial` under `exogenous`; `None` of other estimates, or where its
    /// information is singular.
    pub(super) fn foretold(&self, initial: [f64; 3], exogenous: &[f64]) -> Option<Foretold> {
        let Estimated::OutputError { current } = self.estimated else { return None };
        // Not of what is left out of the information.
        self.moments.disturbances.as_ref().filter(|own| !own.lasting_current_left_out)?;
        let model = self.moments.output_error.as_ref()?;
        let (g, rows, n) = (model.g.as_deref().unwrap_or_default(), &model.rows, model.rows.len());
        let samples = exogenous.len() / self.vessel.model.exogenous().max(1);
        let theta = self.ordered(&model.parameters)?;
        let place = |name: &String| self.vessel.model.parameter_names().position(|own| own == name);
        let places: Vec<Option<usize>> = rows.iter().map(place).collect();
        let Information { information, mut middle } = self.informed(initial, exogenous, current)?;
        let inverse = scaled_inverse(n, &information)?;
        let mut center = theta.clone();
        if let Some(prior) = self.moments.prior.as_ref().filter(|_| model.simulated_with == Source::Value) {
            // The ship is known: what priors say of her is off by as much as it is, in every trial.
            let mut known = vec![0.0; n * n];
            prior.add_to(&mut known, rows, samples as f64);
            middle.iter_mut().zip(&known).for_each(|(own, known)| *own -= known);
            let off = |place: &Option<usize>| place.map_or(0.0, |i| self.vessel.nominal[i] - theta[i]);
            let pulled = times(&inverse, &times(&known, &places.iter().map(off).collect::<Vec<_>>()));
            places.iter().zip(pulled).for_each(|(place, own)| {
                if let Some(i) = *place {
                    center[i] += own;
                }
            });
        }
        let entries = numerics::congruence(n, &inverse, &middle);
        let entries = entries.into_iter().map(|entry| entry / samples as f64).collect();
        let covariance = Covariance { joint: true, names: rows.clone(), entries, parts: None };
        let estimates = Uncertain::new(self.vessel, center, &covariance)?;
        let streams = Streams::new(DRAWS.1, "foretold");
        let errors = (0..DRAWS.0).map(|draw| {
            let drawn = estimates.drawn(&streams, draw);
            let off: Vec<f64> =
                places.iter().map(|place| place.map_or(0.0, |i| drawn[i] - theta[i])).collect();
            let square: f64 = times(g, &off).iter().zip(&off).map(|(own, off)| own * off).sum();
            (parameter_error(&drawn, &theta), square.max(0.0).sqrt())
        });
        let (parameters, simulations): (Vec<f64>, Vec<f64>) = errors.unzip();
        Some(Foretold {
            parameter_error: median(parameters)?,
            simulation_error: model.g.as_ref().and(median(simulations)),
            draws: DRAWS.0,
        })
    }
}
