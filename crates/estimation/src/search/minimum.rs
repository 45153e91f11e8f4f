use std::collections::BTreeMap;

use numerics::{Watch, iterate};
use regression::{Equations, bounded};
use ship::model::Model;

use crate::search::problem::{Looked, Problem, Slopes};
use crate::search::recording::Recording;

/// Damping of the first step, and the largest one that is tried, as shares of the curvature.
const DAMPING: [f64; 2] = [1e-6, 1e6];

/// When a search ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ending {
    /// Maximum number of steps.
    pub steps: usize,
    /// The search ends at a smaller relative decrease of the loss.
    pub enough: f64,
}

/// Minimises loss(β) + ridge |β|² within the bounds of β from `start` by Levenberg and Marquardt's method. `None` if
/// the start is outside the limits.
pub(crate) fn minimum(problem: &Problem, start: Vec<f64>, ridge: f64, ending: Ending) -> Option<Vec<f64>> {
    let cost = |beta: &[f64], looked: &Looked| cost(beta, looked, ridge);
    let mut beta = problem.within(start);
    let mut looked = problem.look(&beta)?;
    let mut damping = DAMPING[0];
    iterate("Levenberg–Marquardt", ending.steps, &Watch::default(), || {
        let slopes = problem.slopes(&beta, &looked)?;
        let before = cost(&beta, &looked);
        let taken = loop {
            let trial = stepped(problem, &beta, &slopes, [ridge, damping]);
            let found = trial.and_then(|trial| problem.look(&trial).map(|looked| (trial, looked)));
            match found.filter(|(trial, looked)| cost(trial, looked) <= before) {
                Some(found) => break Some(found),
                None if damping > DAMPING[1] => break None,
                None => damping = (10.0 * damping).max(1e-3),
            }
        };
        let (trial, at) = taken?;
        let gained = before - cost(&trial, &at);
        (beta, looked) = (trial, at);
        damping = (0.1 * damping).max(DAMPING[0]);
        let enough = gained <= ending.enough * before;
        (!enough).then_some(())
    });
    Some(beta)
}

fn cost(beta: &[f64], looked: &Looked, ridge: f64) -> f64 {
    looked.loss + ridge * beta.iter().map(|b| b * b).sum::<f64>()
}

/// The minimum from the one of `starts` that costs least, so that a path recovers from a bad fit.
pub(crate) fn minimum_from<'s>(
    problem: &Problem,
    starts: impl Iterator<Item = &'s Vec<f64>>,
    ridge: f64,
    ending: Ending,
) -> Option<Vec<f64>> {
    let costs = starts.filter_map(|beta| Some((cost(beta, &problem.look(beta)?, ridge), beta)));
    let (_, start) = costs.min_by(|a, b| a.0.total_cmp(&b.0))?;
    minimum(problem, start.clone(), ridge, ending)
}

/// β + (H + ridge I + damping diag H)⁻¹ (g − ridge β), or the minimum of the same quadratic within the bounds if that
/// leaves them; terms without effect stay.
fn stepped(problem: &Problem, beta: &[f64], slopes: &Slopes, [ridge, damping]: [f64; 2]) -> Option<Vec<f64>> {
    let p = beta.len();
    let mut matrix = slopes.curvature.clone();
    let mut step: Vec<f64> = (0..p).map(|i| slopes.descent[i] - ridge * beta[i]).collect();
    for i in 0..p {
        let own = &mut matrix[i * p + i];
        *own = if *own > 0.0 { (1.0 + damping) * *own + ridge } else { 1.0 };
    }
    let bounds: BTreeMap<usize, [f64; 2]> = problem.bounded().collect();
    let whole = (!bounds.is_empty()).then(|| (matrix.clone(), step.clone()));
    numerics::solve(p, &mut matrix, &mut step)?;
    if let Some((matrix, right)) = whole {
        return limited(&matrix, &right, beta, &bounds, step);
    }
    let moved: Vec<f64> = beta.iter().zip(step).map(|(b, s)| b + s).collect();
    moved.iter().all(|b| b.is_finite()).then_some(moved)
}

/// β and the step that solves its equations within `bounds` of β; `step` is the unbounded one.
fn limited(
    matrix: &[f64],
    right: &[f64],
    beta: &[f64],
    bounds: &BTreeMap<usize, [f64; 2]>,
    step: Vec<f64>,
) -> Option<Vec<f64>> {
    let p = beta.len();
    let left: BTreeMap<usize, [f64; 2]> =
        bounds.iter().map(|(i, ends)| (*i, ends.map(|end| end - beta[*i]))).collect();
    let equations = Equations { a: matrix, b: right, bounds: &left };
    let solve = |free: &[usize], mut right: Vec<f64>| {
        let n = free.len();
        let mut own: Vec<f64> = (0..n * n).map(|k| matrix[free[k / n] * p + free[k % n]]).collect();
        let mut inverse = vec![0.0; n * n];
        numerics::inverse(n, &mut own, &mut inverse).ok_or(0_usize)?;
        right = numerics::times(&inverse, &right);
        Ok((right, inverse))
    };
    let (step, _) = bounded(&equations, step, solve).ok()?;
    let mut moved: Vec<f64> = beta.iter().zip(&step).map(|(b, s)| b + s).collect();
    for (i, ends) in bounds {
        // Exactly at a bound, without rounding.
        let at = (0..2).find(|end| step[*i] == left[i][*end]);
        moved[*i] = at.map_or(moved[*i].clamp(ends[0], ends[1]), |end| ends[end]);
    }
    moved.iter().all(|b| b.is_finite()).then_some(moved)
}

/// Weight of the penalty that keeps collinear terms of the base structure in place.
const NEARLY_NONE: f64 = 1e-8;

/// θ of `model` by output errors over `recordings`, nearly without a penalty, from least squares or, if that
/// diverges, from zero.
pub(crate) fn started(
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
pub(crate) fn least_squares(model: &Model, recordings: &[&Recording], rate_hz: f64) -> Option<Vec<f64>> {
    let simple = Problem::increments(model, recordings, rate_hz);
    let none = vec![0.0; model.parameters()];
    minimum(&simple, none, NEARLY_NONE, Ending { steps: 1, enough: 0.0 })
}
