//! The search for least squares, by Levenberg's and Marquardt's method: problems side by side, each with its own damping and end.

use std::convert::Infallible;

use crate::{Watch, dot, iterate, quadratic, times};

/// A cost c to second order about a point: at a step s from it, c − 2 gᵀs + sᵀN s. For squared errors N is Σ J Jᵀ, of their
/// slopes J alone.
#[derive(Clone, Debug, Default)]
pub struct Expansion {
    /// c; not finite where a point has no cost.
    pub cost: f64,
    /// The cost of a standard deviation, which decrements are counted in.
    pub unit: f64,
    /// N, row-major.
    pub normal: Vec<f64>,
    /// g: minus half the slopes of the cost.
    pub gradient: Vec<f64>,
}

impl Expansion {
    /// Adds a prior: `weight` times the square of the `distance` of unknown `i` from its mean.
    pub fn add_prior(&mut self, i: usize, distance: f64, weight: f64) {
        let n = self.gradient.len();
        self.cost += weight * distance * distance;
        self.normal[i * n + i] += weight;
        self.gradient[i] -= weight * distance;
    }

    fn is_finite(&self) -> bool {
        self.cost.is_finite() && self.normal.iter().all(|x| x.is_finite())
    }
}

/// Huber's function of an RMS error, its square up to the knee and its tangent there beyond, and its derivative by the mean square.
pub fn huber(rms: f64, knee: f64) -> [f64; 2] {
    if rms <= knee { [rms * rms, 1.0] } else { [2.0 * knee * rms - knee * knee, knee / rms] }
}

/// A point of a problem, where something is wanted.
pub struct Linearization {
    /// Index of the problem.
    pub problem: usize,
    /// Its unknowns.
    pub point: Vec<f64>,
}

/// What is minimised. Problems differ in their data, and have the same unknowns and bounds. Sums S are kept of a point beside its
/// expansion; an error E says why there is none.
pub trait Residuals<S = (), E = Infallible> {
    /// Expands problems about the requested points, all in the first call.
    fn linearize(&mut self, asked: &[Linearization]) -> Result<Vec<(Expansion, S)>, E>;
    /// Whether [`Self::cost`] is implemented and much cheaper: then only lower points are expanded, and none where the search ends.
    fn has_costs(&self) -> bool {
        false
    }
    /// The cost alone. A point that is lower is the next to be expanded.
    fn cost(&mut self, _trial: &Linearization) -> f64 {
        f64::NAN
    }
    /// The last expansion, with this damping of unknowns that were eliminated from it; none without such.
    fn damped(&mut self, _damping: f64) -> Option<Expansion> {
        None
    }
    /// Bounds of the unknowns, infinite at open ends; empty without bounds.
    fn bounds(&self) -> Vec<[f64; 2]> {
        Vec::new()
    }
    /// Condition number of the scaled normal matrix from which an unknown counts as without effect of its own.
    fn condition(&self) -> f64 {
        SINGULAR
    }
}

/// When a search ends, and how it begins.
#[derive(Clone, Copy, Debug)]
pub struct Ending {
    /// Most steps.
    pub steps: usize,
    /// Newton decrement √(gᵀN⁻¹g) in standard deviations at which a point is a minimum.
    pub enough: f64,
    /// Damping of the first step, relative to the normal matrix's diagonal.
    pub damping: f64,
}

/// Where a search has ended.
#[derive(Clone, Debug)]
pub struct Minimum<S> {
    /// The unknowns.
    pub point: Vec<f64>,
    /// At the point or, where costs are known or it is not a minimum, maybe at a previous one.
    pub sums: S,
    /// How it has ended.
    pub status: Ended,
    /// Steps tried; where costs are known, those that were lower.
    pub steps: usize,
    /// Unknowns at a bound, beyond which the cost would decrease.
    pub held: Vec<usize>,
}

impl<S> Minimum<S> {
    /// The inverse of this normal matrix among free unknowns, zero for held ones, or an unknown without effect of its own.
    ///
    /// # Errors
    /// Such an unknown.
    pub fn inverse(&self, mut normal: Vec<f64>) -> Result<Vec<f64>, usize> {
        let p = self.point.len();
        hold(&self.held, &mut normal, &mut vec![0.0; p]);
        let mut inverse = scaled_inverse(&normal, p)?;
        self.held.iter().for_each(|i| inverse[i * p + i] = 0.0);
        Ok(inverse)
    }
}

/// Removes the `held` unknowns from the equations: their steps are zero.
fn hold(held: &[usize], normal: &mut [f64], gradient: &mut [f64]) {
    let p = gradient.len();
    for i in held {
        (0..p).for_each(|j| (normal[i * p + j], normal[j * p + i]) = (0.0, 0.0));
        (normal[i * p + i], gradient[*i]) = (1.0, 0.0);
    }
}

fn clipped(mut point: Vec<f64>, bounds: &[[f64; 2]]) -> Vec<f64> {
    point.iter_mut().zip(bounds).for_each(|(x, [low, high])| *x = x.clamp(*low, *high));
    point
}

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The next step would change the cost by less than is enough.
    Converged,
    /// No step is lower, or there were as many as may be.
    Stalled,
    /// A point has no cost, or no expansion.
    Diverged,
    /// This unknown has no effect of its own.
    Singular(usize),
}

/// Sufficient decrement if rounding prevents any further improvement.
const ROUNDED: f64 = 1e-3;
/// Largest damping.
const DAMPING: f64 = 1e9;
const SINGULAR: f64 = 1e12;

/// Below this decrement, steps use the learnt second derivatives.
const NEAR: f64 = 3.0;

/// What all problems of a search share.
struct Rules {
    ending: Ending,
    bounds: Vec<[f64; 2]>,
    condition: f64,
    /// Whether the last step is taken unseen: one that changes the cost by less than is enough.
    polishes: bool,
}

#[derive(Clone, Debug)]
struct Progress<S> {
    held: Vec<usize>,
    point: Vec<f64>,
    sums: S,
    /// Without held unknowns.
    here: Expansion,
    /// The second derivatives of the cost less the normal matrix; empty at first.
    second: Vec<f64>,
    damping: f64,
    decrement: f64,
    steps: usize,
    ended: Option<Ended>,
}

/// Minimises the cost of every problem from its start. Steps are clipped at bounds; an unknown at a bound is held there if the
/// cost would decrease beyond it. `watch` may end it with the best so far.
///
/// # Errors
/// Those of `residuals`.
pub fn minimize<S, E, R: Residuals<S, E>>(
    residuals: &mut R,
    starts: Vec<Vec<f64>>,
    ending: Ending,
    watch: &Watch,
) -> Result<Vec<Minimum<S>>, E> {
    let (bounds, condition) = (residuals.bounds(), residuals.condition());
    let rules = Rules { ending, bounds, condition, polishes: residuals.has_costs() };
    let clip = |(problem, start)| Linearization { problem, point: clipped(start, &rules.bounds) };
    let starts: Vec<Linearization> = starts.into_iter().enumerate().map(clip).collect();
    let looked = residuals.linearize(&starts)?.into_iter();
    let new = |(start, looked): (Linearization, _)| Progress::new(&rules, start.point, looked);
    let mut problems: Vec<Progress<S>> = starts.into_iter().zip(looked).map(new).collect();
    let mut failure = None;
    iterate("Levenberg–Marquardt", usize::MAX, watch, || {
        let goes_on = round(residuals, &rules, &mut problems);
        goes_on.unwrap_or_else(|error| {
            failure = Some(error);
            None
        })
    });
    let ended = |p: Progress<S>| Minimum {
        point: p.point,
        sums: p.sums,
        status: p.ended.unwrap_or(Ended::Stalled),
        steps: p.steps,
        held: p.held,
    };
    failure.map_or_else(|| Ok(problems.into_iter().map(ended).collect()), Err)
}

/// One step of every open problem; `None` if none is open.
fn round<S, E, R: Residuals<S, E>>(
    residuals: &mut R,
    rules: &Rules,
    problems: &mut [Progress<S>],
) -> Result<Option<()>, E> {
    let all = problems.iter_mut().enumerate().filter(|(_, progress)| progress.is_open(rules));
    let ask = |(problem, progress): (_, &mut Progress<S>)| Linearization {
        problem,
        point: progress.trial(residuals, rules),
    };
    let mut asked: Vec<Linearization> = all.map(ask).collect();
    if asked.is_empty() {
        return Ok(None);
    }
    if rules.polishes {
        asked.retain(|trial| {
            let cost = residuals.cost(trial);
            problems[trial.problem].judge_cost(rules, trial, cost)
        });
    }
    if !asked.is_empty() {
        let looked = residuals.linearize(&asked)?;
        for (trial, looked) in asked.into_iter().zip(looked) {
            problems[trial.problem].judge(rules, trial.point, looked);
        }
    }
    Ok(Some(()))
}

impl<S> Progress<S> {
    fn new(rules: &Rules, point: Vec<f64>, (here, sums): (Expansion, S)) -> Self {
        let finite = here.is_finite();
        let mut progress = Self {
            held: Vec::new(),
            point,
            sums,
            here,
            second: Vec::new(),
            damping: rules.ending.damping,
            decrement: f64::INFINITY,
            steps: 0,
            ended: (!finite).then_some(Ended::Diverged),
        };
        if finite {
            progress.settle(rules);
        }
        progress
    }

    fn is_open(&self, rules: &Rules) -> bool {
        self.ended.is_none() && self.steps < rules.ending.steps
    }

    fn trial<E, R: Residuals<S, E>>(&mut self, residuals: &mut R, rules: &Rules) -> Vec<f64> {
        self.steps += 1;
        let eliminated = residuals.damped(self.damping).map(|mut damped| {
            hold(&self.held, &mut damped.normal, &mut damped.gradient);
            damped
        });
        let here = eliminated.as_ref().unwrap_or(&self.here);
        let (mut damped, p) = (here.normal.clone(), self.point.len());
        (0..p).for_each(|i| damped[i * p + i] *= 1.0 + self.damping);
        let step = self.newton_step(&damped).or_else(|| solved(damped, &here.gradient));
        let mut trial = self.point.clone();
        if let Some(step) = step {
            trial.iter_mut().zip(step).for_each(|(x, step)| *x += step);
        }
        clipped(trial, &rules.bounds)
    }

    /// The step with second derivatives, if they are known and it reduces the cost.
    fn newton_step(&self, damped: &[f64]) -> Option<Vec<f64>> {
        if self.second.is_empty() || self.decrement > NEAR {
            return None;
        }
        let gradient = &self.here.gradient;
        let step = solved(damped.iter().zip(&self.second).map(|(n, s)| n + s).collect(), gradient)?;
        let (decrease, without) = (dot(&step, gradient), self.decrement.powi(2) * self.here.unit);
        (decrease > 0.0 && decrease < 4.0 * without).then_some(step)
    }

    /// Judges a step by what is there; one with a lower cost is taken as it is.
    fn judge(&mut self, rules: &Rules, trial: Vec<f64>, (there, sums): (Expansion, S)) {
        let finite = there.is_finite();
        if rules.polishes {
            self.ended = (!finite).then_some(Ended::Diverged);
        } else if finite && there.cost <= self.here.cost + 1e-12 * self.here.cost.abs() {
            self.learn(&trial, &there.normal, &there.gradient);
            self.relax();
        } else {
            return self.damp();
        }
        (self.point, self.sums, self.here) = (trial, sums, there);
        if self.ended.is_none() {
            self.settle(rules);
        }
    }

    /// Judges a step by its cost alone. Whether the problem is to be expanded there: not if the step is the last, or not lower.
    fn judge_cost(&mut self, rules: &Rules, trial: &Linearization, cost: f64) -> bool {
        let (lower, is_last) = (cost < self.here.cost, self.decrement < rules.ending.enough);
        if lower {
            (self.point, self.here.cost) = (trial.point.clone(), cost);
            self.relax();
        } else {
            self.steps -= 1;
            self.damp();
        }
        if is_last {
            self.ended = Some(Ended::Converged);
        }
        lower && self.is_open(rules)
    }

    fn relax(&mut self) {
        self.damping = (0.1 * self.damping).max(1e-12);
    }

    fn damp(&mut self) {
        self.second.clear();
        self.damping *= 10.0;
        if self.damping > DAMPING {
            self.ended = Some(if self.decrement < ROUNDED { Ended::Converged } else { Ended::Stalled });
        }
    }

    /// Updates the second derivatives from a step s to `next`, along which the gradient changes by y: by the secant
    /// condition (N + S) s = y on the part S that the normal matrix N lacks, with the least change of S in the norm
    /// set by y, after sizing: Dennis, Gay & Welsch, *ACM Trans. Math. Softw.* 7 (1981). Not with unknowns held at
    /// bounds.
    fn learn(&mut self, next: &[f64], normal: &[f64], gradient: &[f64]) {
        let step = difference(next, &self.point);
        let change = difference(&self.here.gradient, gradient);
        let along = dot(&change, &step);
        let rises = along > 0.0;
        if !(rises && self.held.is_empty()) {
            return self.second.clear();
        }
        let lacking = difference(&change, &times(normal, &step));
        let (p, wanted) = (step.len(), dot(&lacking, &step));
        self.second.resize(p * p, 0.0);
        let known = quadratic(&step, &self.second).abs();
        let size = if wanted.abs() < known { wanted.abs() / known } else { 1.0 };
        self.second.iter_mut().for_each(|entry| *entry *= size);
        let missed = difference(&lacking, &times(&self.second, &step));
        let share = dot(&missed, &step) / along;
        for (row, (missed_i, change_i)) in self.second.chunks_exact_mut(p).zip(missed.iter().zip(&change)) {
            for (entry, (missed_j, change_j)) in row.iter_mut().zip(missed.iter().zip(&change)) {
                *entry += (missed_i * change_j + change_i * missed_j - share * change_i * change_j) / along;
            }
        }
    }

    fn pulled(&self, rules: &Rules) -> Vec<usize> {
        let pulled = |(i, [low, high]): (usize, &[f64; 2])| {
            let (x, pull) = (self.point[i], self.here.gradient[i]);
            (x == *low && pull <= 0.0 || x == *high && pull >= 0.0).then_some(i)
        };
        rules.bounds.iter().enumerate().filter_map(pulled).collect()
    }

    fn settle(&mut self, rules: &Rules) {
        self.held = self.pulled(rules);
        hold(&self.held, &mut self.here.normal, &mut self.here.gradient);
        match regular_inverse(&self.here.normal, self.point.len(), rules.condition) {
            Err(unknown) => self.ended = Some(Ended::Singular(unknown)),
            Ok(inverse) => {
                let square = quadratic(&self.here.gradient, &inverse);
                self.decrement = (square.max(0.0) / self.here.unit).sqrt();
                let polished = rules.polishes && self.steps < rules.ending.steps;
                if self.decrement < rules.ending.enough && !polished {
                    self.ended = Some(Ended::Converged);
                }
            }
        }
    }
}

fn solved(mut matrix: Vec<f64>, right: &[f64]) -> Option<Vec<f64>> {
    let mut solution = right.to_vec();
    crate::solve(right.len(), &mut matrix, &mut solution)?;
    Some(solution)
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// The inverse of a normal matrix, or an unknown that has no effect of its own.
///
/// # Errors
/// Such an unknown.
pub fn scaled_inverse(normal: &[f64], p: usize) -> Result<Vec<f64>, usize> {
    regular_inverse(normal, p, SINGULAR)
}

fn regular_inverse(normal: &[f64], p: usize, most: f64) -> Result<Vec<f64>, usize> {
    let sizes: Vec<f64> = (0..p).map(|i| normal[i * p + i].sqrt()).collect();
    if let Some(i) = sizes.iter().position(|s| !(*s > 0.0 && s.is_finite())) {
        return Err(i);
    }
    let scaled: Vec<f64> = (0..p * p).map(|k| normal[k] / (sizes[k / p] * sizes[k % p])).collect();
    let mut inverse = vec![0.0; p * p];
    let regular = crate::inverse(p, &mut scaled.clone(), &mut inverse).is_some();
    if !regular || crate::one_norm(p, &inverse) * crate::one_norm(p, &scaled) > most {
        return Err(crate::weakest(p, &scaled).map_or(0, |weakest| weakest.dominant(p)));
    }
    (0..p * p).for_each(|k| inverse[k] /= sizes[k / p] * sizes[k % p]);
    Ok(inverse)
}
