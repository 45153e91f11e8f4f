use vessel::Model;

use super::problem::{Looked, Problem};
use super::recording::Recording;

/// Damping of the first step, and beyond which none helps, in shares of the curvature.
const DAMPING: [f64; 2] = [1e-6, 1e6];

/// When a search ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ending {
    /// Most slopes that are worth computing.
    pub steps: usize,
    /// Relative decrease of the loss that is not worth another.
    pub enough: f64,
}

/// Minimises loss(β) + ridge |β|² from `start` by Levenberg and Marquardt's method. None where the start leaves the limits.
pub(super) fn minimum(problem: &Problem, start: Vec<f64>, ridge: f64, ending: Ending) -> Option<Vec<f64>> {
    let cost = |beta: &[f64], looked: &Looked| cost(beta, looked, ridge);
    let mut beta = start;
    let mut looked = problem.look(&beta)?;
    let mut damping = DAMPING[0];
    for _ in 0..ending.steps {
        let Some(slopes) = problem.slopes(&beta, &looked) else { break };
        let before = cost(&beta, &looked);
        let taken = loop {
            let trial = stepped(&beta, &slopes.curvature, &slopes.descent, ridge, damping);
            let found = trial.and_then(|trial| problem.look(&trial).map(|looked| (trial, looked)));
            match found.filter(|(trial, looked)| cost(trial, looked) <= before) {
                Some(found) => break Some(found),
                None if damping > DAMPING[1] => break None,
                None => damping = (10.0 * damping).max(1e-3),
            }
        };
        let Some((trial, at)) = taken else { break };
        let gained = before - cost(&trial, &at);
        (beta, looked) = (trial, at);
        damping = (0.1 * damping).max(DAMPING[0]);
        if gained <= ending.enough * before {
            break;
        }
    }
    Some(beta)
}

fn cost(beta: &[f64], looked: &Looked, ridge: f64) -> f64 {
    looked.loss + ridge * beta.iter().map(|b| b * b).sum::<f64>()
}

/// The minimum from whichever of `starts` costs least: a path that went astray comes back.
pub(super) fn minimum_from<'s>(
    problem: &Problem,
    starts: impl Iterator<Item = &'s Vec<f64>>,
    ridge: f64,
    ending: Ending,
) -> Option<Vec<f64>> {
    let costs = starts.filter_map(|beta| Some((cost(beta, &problem.look(beta)?, ridge), beta)));
    let (_, start) = costs.min_by(|a, b| a.0.total_cmp(&b.0))?;
    minimum(problem, start.clone(), ridge, ending)
}

/// β + (H + ridge I + damping diag H)⁻¹ (g − ridge β); terms without effect stay.
fn stepped(beta: &[f64], curvature: &[f64], descent: &[f64], ridge: f64, damping: f64) -> Option<Vec<f64>> {
    let p = beta.len();
    let mut matrix = curvature.to_vec();
    let mut step: Vec<f64> = (0..p).map(|i| descent[i] - ridge * beta[i]).collect();
    for i in 0..p {
        let own = &mut matrix[i * p + i];
        *own = if *own > 0.0 { (1.0 + damping) * *own + ridge } else { 1.0 };
    }
    numerics::solve(p, &mut matrix, &mut step)?;
    let moved: Vec<f64> = beta.iter().zip(step).map(|(b, s)| b + s).collect();
    moved.iter().all(|b| b.is_finite()).then_some(moved)
}

/// Weight of the penalty that keeps collinear terms of the base structure in place.
const NEARLY_NONE: f64 = 1e-8;

/// θ of `model` by output errors over `recordings`, nearly without a penalty, from least squares or, where that diverges, from
/// nothing at all.
pub(super) fn started(
    model: &Model,
    recordings: &[&Recording],
    rate_hz: f64,
    ending: Ending,
) -> Option<Vec<f64>> {
    let none = vec![0.0; model.parameters()];
    let least = least_squares(model, recordings, rate_hz)?;
    let problem = Problem::new(model, recordings, rate_hz);
    let from = |start| minimum(&problem, start, NEARLY_NONE, ending);
    from(least).or_else(|| from(none)).map(|beta| problem.theta(&beta))
}

/// Scaled least-squares parameters of the increments.
pub(super) fn least_squares(model: &Model, recordings: &[&Recording], rate_hz: f64) -> Option<Vec<f64>> {
    let simple = Problem::increments(model, recordings, rate_hz);
    let none = vec![0.0; model.parameters()];
    minimum(&simple, none, NEARLY_NONE, Ending { steps: 1, enough: 0.0 })
}
