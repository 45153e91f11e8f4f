//! Fits of a ship with a sign turned, beside the one as written.

use numerics::distributions::normal_tails;
use ship::forces::Forces;

use super::turn::{Alternative, Turn};
use crate::fitting::pass::Pass;
use crate::fitting::{Fit, Prior, Problem, Recording};

/// Most steps of a fit that is only to be compared.
const STEPS: usize = 10;
/// A sign is wrong where the cost is lower by at least this share with it turned …
const SHARE: f64 = 0.05;
/// … and chance makes any of the signs look so with less than this probability.
const LEVEL: f64 = 0.01;

/// A sign that was turned.
#[derive(Clone, Debug, PartialEq)]
pub struct TurnedSign {
    /// What was turned.
    pub turn: Turn,
    /// By which share the cost falls; below 0 where it rises, none where no simulation with it is finite.
    pub share: Option<f64>,
    /// Windows that are followed better.
    pub better: usize,
    /// All windows.
    pub windows: usize,
    /// How probable it is by chance that any of the signs seems as wrong.
    pub p_value: f64,
    /// Whether recordings speak for it.
    pub wrong: bool,
}

impl Problem<'_> {
    /// The sign of `own` turned, one of `count` signs.
    pub(crate) fn turned(&self, fit: &Fit, alternative: &Alternative, count: usize) -> TurnedSign {
        let as_written = Pass::new(self, fit.first).window_costs(fit);
        let none = TurnedSign {
            turn: alternative.turn.clone(),
            share: None,
            better: 0,
            windows: as_written.len(),
            p_value: 1.0,
            wrong: false,
        };
        let Some((other, windows)) = self.fitted_as(fit, alternative) else { return none };
        let gains: Vec<f64> = as_written.iter().zip(&windows).map(|(old, new)| old - new).collect();
        let share = fit.share(fit.cost - other.cost);
        let p_value = if share > 0.0 { (count as f64 * chance(&gains)).min(1.0) } else { 1.0 };
        TurnedSign {
            share: Some(share),
            better: gains.iter().filter(|gain| **gain > 0.0).count(),
            p_value,
            wrong: share >= SHARE && p_value < LEVEL,
            ..none
        }
    }

    /// The fit of the ship `own`, from the numbers of `fit` or those before it, whichever cost less, and the costs of its windows.
    fn fitted_as(&self, fit: &Fit, own: &Alternative) -> Option<(Fit, Vec<f64>)> {
        let inputs = match own.negated {
            Some(channel) => changed(self, channel, |all| all.iter().map(|own| -own).collect()),
            None => self.recordings.iter().map(|own| own.inputs.to_vec()).collect(),
        };
        let problem = self.with_inputs(&own.forces, &inputs)?;
        let problem = problem.with_priors(self.priors_of(own));
        let pass = Pass::new(&problem, fit.first);
        let starts = [self.theta_of(own, &fit.theta), self.theta_of(own, &self.forces.nominal())];
        let costs = starts.map(|theta| (pass.cost_from(&theta), theta));
        let (_, theta) = costs.into_iter().min_by(|one, other| one.0.total_cmp(&other.0))?;
        let (best, _) = pass.search(&theta, STEPS).ok()?;
        let windows = pass.window_costs(&best);
        Some((best, windows))
    }

    /// The recordings with these rows of inputs, for a ship with as many channels.
    pub(crate) fn with_inputs<'b>(
        &'b self,
        forces: &'b Forces,
        inputs: &'b [Vec<f64>],
    ) -> Option<Problem<'b>> {
        let with = |(old, inputs): (&Recording<'b>, &'b Vec<f64>)| Recording { inputs, ..*old };
        let recordings = self.recordings.iter().zip(inputs).map(with).collect();
        Problem::new(forces, recordings, self.width, self.settings).ok()
    }

    /// Numbers of the ship as written for that of `own`; both have the same parameters.
    fn theta_of(&self, own: &Alternative, theta: &[f64]) -> Vec<f64> {
        let value = |parameter: &ship::forces::Parameter| {
            let at = self.forces.parameters().iter().position(|old| old.name == parameter.name);
            at.map_or(parameter.nominal, |at| own.value(&parameter.name, theta[at]))
        };
        own.forces.parameters().iter().map(value).collect()
    }

    fn priors_of(&self, alternative: &Alternative) -> Vec<Option<Prior>> {
        let prior = |parameter: &ship::forces::Parameter| {
            let at = self.forces.parameters().iter().position(|old| old.name == parameter.name)?;
            self.priors[at].map(|old| Prior { mean: alternative.value(&parameter.name, old.mean), ..old })
        };
        alternative.forces.parameters().iter().map(prior).collect()
    }
}

impl Pass<'_> {
    /// What each window adds to the cost.
    pub(crate) fn window_costs(&self, fit: &Fit) -> Vec<f64> {
        let groups = self.groups.iter().zip(&fit.starts);
        let errors = groups.flat_map(|(group, starts)| self.errors(group, &fit.theta, starts));
        errors.map(|own| self.share(&own) * own.cost(self.settings.knee)).collect()
    }
}

/// The rows of inputs of all recordings with the column `channel` changed.
pub(crate) fn changed(problem: &Problem, channel: usize, by: impl Fn(&[f64]) -> Vec<f64>) -> Vec<Vec<f64>> {
    let width = problem.width;
    let one = |recording: &Recording| {
        let mut inputs = recording.inputs.to_vec();
        let column: Vec<f64> = inputs.iter().skip(channel).step_by(width).copied().collect();
        inputs.iter_mut().skip(channel).step_by(width).zip(by(&column)).for_each(|(own, new)| *own = new);
        inputs
    };
    problem.recordings.iter().map(one).collect()
}

/// How probable a mean of `gains` so far from 0 is by chance.
fn chance(gains: &[f64]) -> f64 {
    let count = gains.len() as f64;
    let mean = gains.iter().sum::<f64>() / count;
    let square = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>();
    if gains.len() < 2 || square <= 0.0 {
        return 1.0;
    }
    normal_tails(mean * count / (square * count / (count - 1.0)).sqrt())
}
