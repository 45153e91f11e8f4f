use numerics::{dot, times};

use super::linear::Linear;
use crate::sensitivity::Slopes;

pub(crate) trait Residuals {
    type Error;
    /// Linearises problems at the requested points, all in the first call; not finite if the prediction diverges.
    fn linearize(&mut self, asked: &[Linearization]) -> Result<Vec<Linear>, Self::Error>;
    /// Whether [`Self::slopes`] is implemented and much faster.
    fn has_slopes(&self) -> bool {
        false
    }
    /// Whether the caller verifies minima that slopes alone indicate, see [`Minimum::look`].
    fn is_verified_later(&self) -> bool {
        false
    }
    /// Squared errors and their gradients only, with the weights of each problem's errors.
    fn slopes(&mut self, _asked: &[Linearization]) -> Vec<Slopes> {
        Vec::new()
    }
    /// Bounds of the unknowns, infinite at open ends; empty without bounds.
    fn bounds(&self) -> Vec<[f64; 2]> {
        Vec::new()
    }
}

pub(crate) struct Linearization {
    pub problem: usize,
    pub weighting: Weighting,
    pub point: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Weighting {
    /// Σ_d w_d Σ e_d².
    Fixed([f64; 3]),
    /// Σ_d N log(Σ e_d² + N floor_d): maximum likelihood of white errors with unknown variances, whose weights are one
    /// over the errors' own mean squares.
    Likelihood([f64; 3]),
}

impl Weighting {
    fn cost(&self, squares: [f64; 3], samples: f64) -> f64 {
        match self {
            Self::Fixed(weights) => (0..3).map(|d| weights[d] * squares[d]).sum(),
            Self::Likelihood(floor) => {
                (0..3).map(|d| samples * libm::log(squares[d] / samples + floor[d])).sum()
            }
        }
    }

    /// The variance of weighted errors with this cost; at least 1e-16, for exact data.
    fn variance(&self, cost: f64, samples: f64) -> f64 {
        match self {
            Self::Fixed(_) => (cost / (3.0 * samples).max(1.0)).max(1e-16),
            Self::Likelihood(_) => 1.0,
        }
    }

    /// The weights of errors whose sums of squares over `samples` samples are `squares`.
    pub(crate) fn weights(&self, squares: [f64; 3], samples: f64) -> [f64; 3] {
        match self {
            Self::Fixed(weights) => *weights,
            Self::Likelihood(floor) => [0, 1, 2].map(|d| (squares[d] / samples + floor[d]).recip()),
        }
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Minimum {
    pub point: Vec<f64>,
    /// At the point or, if that is `unseen` or not a minimum, maybe at a previous one.
    pub linear: Linear,
    /// Whether only slopes indicate this minimum.
    pub unseen: bool,
    pub status: Ended,
    pub steps: usize,
    pub held: Vec<usize>,
}

impl Minimum {
    pub(crate) fn look(&mut self, linear: Linear, weighting: Weighting) -> bool {
        let looked = Progress::new(weighting, Vec::new(), std::mem::take(&mut self.point), linear);
        let is_minimum = looked.ended == Some(Ended::Converged);
        (self.point, self.linear, self.unseen) = (looked.point, looked.linear, false);
        is_minimum
    }

    /// The inverse normal matrix of the free unknowns, zero for held ones, or an unknown without effect of its own.
    pub(crate) fn inverse(&self, weights: [f64; 3]) -> Result<Vec<f64>, usize> {
        let (mut normal, mut gradient) = self.linear.weighted(weights);
        let p = gradient.len();
        hold(&self.held, &mut normal, &mut gradient);
        let mut inverse = scaled_inverse(&normal, p)?;
        self.held.iter().for_each(|i| inverse[i * p + i] = 0.0);
        Ok(inverse)
    }

    /// The change of the unknowns if `part` is left out: H⁻¹g, H of the rest; or an unknown that the rest leaves open.
    pub(crate) fn without(&self, part: &Linear, weights: [f64; 3]) -> Result<Vec<f64>, usize> {
        let (whole, _) = self.linear.weighted(weights);
        let (left_out, mut gradient) = part.weighted(weights);
        let mut others: Vec<f64> = whole.iter().zip(left_out).map(|(whole, entry)| whole - entry).collect();
        hold(&self.held, &mut others, &mut gradient);
        Ok(times(&scaled_inverse(&others, gradient.len())?, &gradient))
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

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ended {
    /// The next step would change the prediction by less than [`ENOUGH`] standard errors.
    Converged,
    Stalled,
    Diverged,
    Singular(usize),
}

pub(crate) const STEPS: usize = 40;
/// Newton decrement √(gᵀH⁻¹g) in standard deviations of the errors, at which a point is a minimum.
const ENOUGH: f64 = 1e-5;
/// Sufficient decrement if rounding prevents any further improvement.
const ROUNDED: f64 = 1e-3;
/// Damping of the first step and largest damping, relative to the normal matrix's diagonal.
const DAMPING: [f64; 2] = [1e-4, 1e9];
/// Condition number of the scaled normal matrix from which an unknown counts as without effect.
const SINGULAR: f64 = 1e12;

/// Below this decrement, steps use the learnt second derivatives.
const NEAR: f64 = 3.0;
const SLOPING: f64 = 10.0;
/// The normal matrix is renewed if a step reduces the decrement to no less than this share.
const SLOW: f64 = 0.9;

#[derive(Clone, Debug)]
struct Progress {
    weighting: Weighting,
    bounds: Vec<[f64; 2]>,
    held: Vec<usize>,
    point: Vec<f64>,
    linear: Linear,
    cost: f64,
    /// The weighted normal matrix of `linear`, and its inverse; without held unknowns.
    normal: Vec<f64>,
    inverse: Vec<f64>,
    /// At the point, as is the cost.
    gradient: Vec<f64>,
    exact: bool,
    looks: bool,
    /// The second derivatives of the cost less the normal matrix; empty at first.
    second: Vec<f64>,
    damping: f64,
    decrement: f64,
    steps: usize,
    ended: Option<Ended>,
}

/// Minimises the squared errors of every problem from its start, with at most `steps` steps, by Levenberg and
/// Marquardt's method on all problems in lanes. Every problem has its own damping and end. Steps are clipped at
/// bounds; an unknown at a bound is held there if the errors would decrease beyond it. Near a minimum the normal
/// matrix is reused and slopes suffice, until it is found; there the problem is linearised again, unless the caller
/// does so.
pub(crate) fn minimize<R: Residuals>(
    residuals: &mut R,
    weighting: Vec<Weighting>,
    starts: Vec<Vec<f64>>,
    steps: usize,
) -> Result<Vec<Minimum>, R::Error> {
    let bounds = residuals.bounds();
    let clip =
        |(problem, (start, weighting))| Linearization { problem, weighting, point: clipped(start, &bounds) };
    let starts: Vec<Linearization> = starts.into_iter().zip(weighting).enumerate().map(clip).collect();
    let linears = residuals.linearize(&starts)?;
    let new = |(start, linear): (Linearization, _)| {
        Progress::new(start.weighting, bounds.clone(), start.point, linear)
    };
    let mut problems: Vec<Progress> = starts.into_iter().zip(linears).map(new).collect();
    let sloping = residuals.has_slopes();
    let asked = |problems: &mut [Progress], near: bool| -> Vec<Linearization> {
        let all = problems.iter_mut().enumerate();
        let open = all.filter(|(_, it)| it.is_open(steps) && (sloping && it.is_near()) == near);
        let ask = |(problem, progress): (_, &mut Progress)| Linearization {
            problem,
            weighting: progress.weighting,
            point: progress.trial(),
        };
        open.map(ask).collect()
    };
    while problems.iter().any(|problem| problem.is_open(steps)) {
        loop {
            let trials = asked(&mut problems, false);
            if trials.is_empty() {
                break;
            }
            let linears = residuals.linearize(&trials)?;
            for (trial, linear) in trials.into_iter().zip(linears) {
                problems[trial.problem].judge(trial.point, linear);
            }
        }
        loop {
            let trials = asked(&mut problems, true);
            if trials.is_empty() {
                break;
            }
            let slopes = residuals.slopes(&trials);
            for (trial, slopes) in trials.into_iter().zip(slopes) {
                problems[trial.problem].judge_slopes(trial.point, slopes, residuals.is_verified_later());
            }
        }
    }
    let ended = |p: Progress| Minimum {
        point: p.point,
        linear: p.linear,
        unseen: p.ended == Some(Ended::Converged) && !p.exact,
        status: p.ended.unwrap_or(Ended::Stalled),
        steps: p.steps,
        held: p.held,
    };
    Ok(problems.into_iter().map(ended).collect())
}

impl Progress {
    fn new(weighting: Weighting, bounds: Vec<[f64; 2]>, point: Vec<f64>, linear: Linear) -> Self {
        let cost = weighting.cost(linear.squares, linear.samples);
        let finite = cost.is_finite() && linear.finite();
        let mut progress = Self {
            weighting,
            bounds,
            held: Vec::new(),
            point,
            linear,
            cost,
            normal: Vec::new(),
            inverse: Vec::new(),
            gradient: Vec::new(),
            exact: true,
            looks: false,
            second: Vec::new(),
            damping: DAMPING[0],
            decrement: f64::INFINITY,
            steps: 0,
            ended: (!finite).then_some(Ended::Diverged),
        };
        if finite {
            progress.settle();
        }
        progress
    }

    fn is_open(&self, steps: usize) -> bool {
        self.ended.is_none() && (self.looks || self.steps < steps)
    }

    fn is_near(&self) -> bool {
        !self.looks && self.decrement <= SLOPING && self.held.is_empty()
    }

    fn trial(&mut self) -> Vec<f64> {
        if self.looks {
            return self.point.clone();
        }
        self.steps += 1;
        let (mut damped, p) = (self.normal.clone(), self.gradient.len());
        (0..p).for_each(|i| damped[i * p + i] *= 1.0 + self.damping);
        let step = self.newton_step(&damped).or_else(|| solved(damped, &self.gradient));
        let mut trial = self.point.clone();
        if let Some(step) = step {
            trial.iter_mut().zip(step).for_each(|(x, step)| *x += step);
        }
        clipped(trial, &self.bounds)
    }

    /// The step with second derivatives, if they are known and it reduces the cost.
    fn newton_step(&self, damped: &[f64]) -> Option<Vec<f64>> {
        if self.second.is_empty() || self.decrement > NEAR {
            return None;
        }
        let step = solved(damped.iter().zip(&self.second).map(|(n, s)| n + s).collect(), &self.gradient)?;
        let (decrease, without) = (dot(&step, &self.gradient), self.decrement.powi(2) * self.variance());
        (decrease > 0.0 && decrease < 4.0 * without).then_some(step)
    }

    fn variance(&self) -> f64 {
        self.weighting.variance(self.cost, self.linear.samples)
    }

    fn lessens(&self, cost: f64) -> bool {
        cost <= self.cost + 1e-12 * self.cost.abs()
    }

    fn judge(&mut self, trial: Vec<f64>, linear: Linear) {
        let cost = self.weighting.cost(linear.squares, linear.samples);
        if !(self.looks || linear.finite() && self.lessens(cost)) {
            return self.damp();
        }
        if self.looks {
            self.second.clear();
        } else {
            let weights = self.weighting.weights(linear.squares, linear.samples);
            let (normal, gradient) = linear.weighted(weights);
            self.learn(&trial, &normal, &gradient);
            self.damping = (0.1 * self.damping).max(1e-12);
        }
        (self.point, self.linear, self.cost) = (trial, linear, cost);
        (self.exact, self.looks) = (true, false);
        self.settle();
    }

    /// Judges a step by slopes; linearises at the last one, if not done `later`, at a bound, or if it gains little.
    fn judge_slopes(&mut self, trial: Vec<f64>, slopes: Slopes, later: bool) {
        let cost = self.weighting.cost(slopes.squares, self.linear.samples);
        if !self.lessens(cost) {
            self.looks = !self.exact;
            return if self.exact { self.damp() } else { self.second.clear() };
        }
        let normal = std::mem::take(&mut self.normal);
        self.learn(&trial, &normal, &slopes.gradient);
        (self.normal, self.gradient) = (normal, slopes.gradient);
        (self.point, self.cost, self.exact) = (trial, cost, false);
        self.damping = (0.1 * self.damping).max(1e-12);
        let before = self.measure();
        let (is_last, is_free) = (self.decrement < 0.5 * ENOUGH, self.pulled().is_empty());
        if is_last && is_free && later {
            self.ended = Some(Ended::Converged);
        }
        self.looks = is_last || self.decrement > SLOW * before || !is_free;
    }

    fn damp(&mut self) {
        self.second.clear();
        self.damping *= 10.0;
        if self.damping > DAMPING[1] {
            self.ended = Some(if self.decrement < ROUNDED { Ended::Converged } else { Ended::Stalled });
        }
    }

    /// Updates the second derivatives from a step s to `next`, along which the gradient changes by y: by the secant
    /// condition (N + S) s = y on the part S that the normal matrix N lacks, with the least change of S in the norm
    /// set by y, after sizing: Dennis, Gay & Welsch, *ACM Trans. Math. Softw.* 7 (1981). Not with unknowns held at
    /// bounds.
    fn learn(&mut self, next: &[f64], normal: &[f64], gradient: &[f64]) {
        let step: Vec<f64> = next.iter().zip(&self.point).map(|(new, old)| new - old).collect();
        let change = difference(&self.gradient, gradient);
        let along = dot(&change, &step);
        let rises = along > 0.0;
        if !(rises && self.held.is_empty()) {
            return self.second.clear();
        }
        let lacking = difference(&change, &times(normal, &step));
        let (p, wanted) = (step.len(), dot(&lacking, &step));
        self.second.resize(p * p, 0.0);
        let known = numerics::quadratic(&step, &self.second).abs();
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

    fn pulled(&self) -> Vec<usize> {
        let pulled = |(i, [low, high]): (usize, &[f64; 2])| {
            let (x, pull) = (self.point[i], self.gradient[i]);
            (x == *low && pull <= 0.0 || x == *high && pull >= 0.0).then_some(i)
        };
        self.bounds.iter().enumerate().filter_map(pulled).collect()
    }

    fn settle(&mut self) {
        let weights = self.weighting.weights(self.linear.squares, self.linear.samples);
        (self.normal, self.gradient) = self.linear.weighted(weights);
        self.held = self.pulled();
        hold(&self.held, &mut self.normal, &mut self.gradient);
        match scaled_inverse(&self.normal, self.gradient.len()) {
            Err(unknown) => self.ended = Some(Ended::Singular(unknown)),
            Ok(inverse) => {
                self.inverse = inverse;
                self.measure();
                if self.decrement < ENOUGH {
                    self.ended = Some(Ended::Converged);
                }
            }
        }
    }

    fn measure(&mut self) -> f64 {
        let square = numerics::quadratic(&self.gradient, &self.inverse);
        let decrement = (square.max(0.0) / self.variance()).sqrt();
        std::mem::replace(&mut self.decrement, decrement)
    }
}

fn solved(mut matrix: Vec<f64>, right: &[f64]) -> Option<Vec<f64>> {
    let mut solution = right.to_vec();
    numerics::solve(right.len(), &mut matrix, &mut solution)?;
    Some(solution)
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// The inverse of a normal matrix, or an unknown that has no effect of its own.
pub(crate) fn scaled_inverse(normal: &[f64], p: usize) -> Result<Vec<f64>, usize> {
    let sizes: Vec<f64> = (0..p).map(|i| normal[i * p + i].sqrt()).collect();
    if let Some(i) = sizes.iter().position(|s| !(*s > 0.0 && s.is_finite())) {
        return Err(i);
    }
    let scaled: Vec<f64> = (0..p * p).map(|k| normal[k] / (sizes[k / p] * sizes[k % p])).collect();
    let mut inverse = vec![0.0; p * p];
    let regular = numerics::inverse(p, &mut scaled.clone(), &mut inverse).is_some();
    if !regular || numerics::one_norm(p, &inverse) * numerics::one_norm(p, &scaled) > SINGULAR {
        return Err(numerics::weakest(p, &scaled).map_or(0, |weakest| weakest.dominant(p)));
    }
    (0..p * p).for_each(|k| inverse[k] /= sizes[k / p] * sizes[k % p]);
    Ok(inverse)
}
