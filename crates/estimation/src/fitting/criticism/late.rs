//! Inputs that act later than they are logged.

use super::turned::changed;
use crate::fitting::{Fit, Pass, Problem};

/// Most steps of a fit that is only to be compared.
const STEPS: usize = 6;
/// Times that are tried, in those of the score.
const TIMES: [f64; 4] = [0.5, 1.0, 1.5, 2.0];

/// How an input acts late.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lateness {
    /// After a dead time.
    DeadTime,
    /// With a lag of first order.
    Lag,
}

/// An input that may act later than the model has it.
#[derive(Clone, Debug, PartialEq)]
pub struct LateInput {
    /// The input.
    pub input: String,
    /// By how much it acts later by its score \[s\]; below 0 earlier.
    pub late_s: f64,
    /// The standard error of that.
    pub standard_error: f64,
    /// By which share the cost would fall.
    pub share: f64,
    /// How probable it is in a right model that any candidate seems as likely.
    pub p_value: f64,
    /// What fits best, if the input acts late: its kind, its time \[s\], and by which share the cost then falls.
    pub best: Option<(Lateness, f64, f64)>,
    /// The share of the other kind at its best time.
    pub other: Option<f64>,
}

impl Lateness {
    /// The column `all`, linear between samples `sample_s` apart, as it acts.
    fn of(self, all: &[f64], seconds: f64, sample_s: f64) -> Vec<f64> {
        match self {
            Self::DeadTime => ship::forces::late(all, seconds, 0.0, sample_s),
            Self::Lag => ship::forces::late(all, 0.0, seconds, sample_s),
        }
    }
}

impl Problem<'_> {
    /// The best time \[s\] of this kind for the input in column `channel`, about `late_s`, and by which share of the cost of
    /// `fit` it falls then.
    pub(crate) fn late(&self, fit: &Fit, channel: usize, kind: Lateness, late_s: f64) -> Option<(f64, f64)> {
        let tried = TIMES.iter().filter_map(|times| {
            let seconds = times * late_s;
            let cost = self.late_cost(fit, channel, |own| kind.of(own, seconds, self.settings.sample_s))?;
            Some((seconds, fit.share(fit.cost - cost)))
        });
        tried.max_by(|one, other| one.1.total_cmp(&other.1))
    }

    fn late_cost(&self, fit: &Fit, channel: usize, acts: impl Fn(&[f64]) -> Vec<f64>) -> Option<f64> {
        let inputs = changed(self, channel, acts);
        let problem = self.with_inputs(self.forces, &inputs)?.with_priors(self.priors.clone());
        Pass::new(&problem, fit.first).search(&fit.theta, STEPS).ok().map(|(fit, _)| fit.cost)
    }
}
