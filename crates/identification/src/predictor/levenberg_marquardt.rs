use super::sums::Linear;
use numerics::{dot, times};

/// Several least-squares problems that are linearised in one pass.
pub(crate) trait Residuals {
    /// Why data cannot be looked at.
    type Error;
    /// Linearises problems at the points that are asked for, each problem at one at most and all of them at first; numbers that
    /// are not finite where the prediction leaves every bound. Problems that have ended are not asked for any more.
    fn linearize(&mut self, asked: &[Asked]) -> Result<Vec<Linear>, Self::Error>;
    /// Within which the unknowns stay, infinite at open ends; empty without bounds.
    fn bounds(&self) -> Vec<[f64; 2]> {
        Vec::new()
    }
}

/// The point of a problem, by its place among all.
pub(crate) struct Asked {
    pub problem: usize,
    pub point: Vec<f64>,
}

/// How the squared errors of u, v, r are weighed against each other.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Weighting {
    /// Σ_d w_d Σ e_d².
    Fixed([f64; 3]),
    /// Σ_d N log(Σ e_d² + N floor_d): maximum likelihood of white errors with unknown variances, whose weights are one
    /// over the errors' own mean squares.
    Likelihood([f64; 3]),
}

impl Weighting {
    fn cost(&self, linear: &Linear) -> f64 {
        match self {
            Self::Fixed(weights) => (0..3).map(|d| weights[d] * linear.squares[d]).sum(),
            Self::Likelihood(floor) => {
                let n = linear.samples;
                (0..3).map(|d| n * libm::log(linear.squares[d] / n + floor[d])).sum()
            }
        }
    }

    /// Of weighted errors; that of exact data counts as 1e-16.
    fn variance(&self, linear: &Linear) -> f64 {
        match self {
            Self::Fixed(_) => (self.cost(linear) / (3.0 * linear.samples).max(1.0)).max(1e-16),
            Self::Likelihood(_) => 1.0,
        }
    }

    pub(crate) fn weights(&self, linear: &Linear) -> [f64; 3] {
        match self {
            Self::Fixed(weights) => *weights,
            Self::Likelihood(floor) => {
                [0, 1, 2].map(|d| (linear.squares[d] / linear.samples + floor[d]).recip())
            }
        }
    }
}

/// How a problem ended.
#[derive(Clone, Debug)]
pub(crate) struct Minimum {
    pub point: Vec<f64>,
    /// At the point.
    pub linear: Linear,
    pub status: Ended,
    /// Steps tried.
    pub steps: usize,
    /// Unknowns at a bound beyond which the errors would be less; empty where there are no bounds.
    pub held: Vec<usize>,
}

impl Minimum {
    /// The inverse of the normal matrix of the unknowns that are not held, rows and columns of those zero, or an unknown that
    /// has no effect of its own.
    pub(crate) fn inverse(&self, weights: [f64; 3]) -> Result<Vec<f64>, usize> {
        let (mut normal, mut gradient) = self.linear.weighted(weights);
        let p = gradient.len();
        hold(&self.held, &mut normal, &mut gradient);
        let mut inverse = scaled_inverse(&normal, p)?;
        self.held.iter().for_each(|i| inverse[i * p + i] = 0.0);
        Ok(inverse)
    }

    /// By how much the unknowns change, to first order, where a `part` of what the problem is made of is left out: H⁻¹g, H of
    /// the others and g of the part; or an unknown of which the others tell nothing.
    pub(crate) fn without(&self, part: &Linear, weights: [f64; 3]) -> Result<Vec<f64>, usize> {
        let (whole, _) = self.linear.weighted(weights);
        let (own, mut gradient) = part.weighted(weights);
        let mut others: Vec<f64> = whole.iter().zip(own).map(|(whole, own)| whole - own).collect();
        hold(&self.held, &mut others, &mut gradient);
        Ok(times(&scaled_inverse(&others, gradient.len())?, &gradient))
    }
}

/// Takes the unknowns `held` out of the equations: their steps are zero.
fn hold(held: &[usize], normal: &mut [f64], gradient: &mut [f64]) {
    let p = gradient.len();
    for i in held {
        (0..p).for_each(|j| (normal[i * p + j], normal[j * p + i]) = (0.0, 0.0));
        (normal[i * p + i], gradient[*i]) = (1.0, 0.0);
    }
}

/// `point` within `bounds`.
fn clipped(mut point: Vec<f64>, bounds: &[[f64; 2]]) -> Vec<f64> {
    point.iter_mut().zip(bounds).for_each(|(x, [low, high])| *x = x.clamp(*low, *high));
    point
}

/// Why a problem ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ended {
    /// The next step would change the prediction by less than [`ENOUGH`] standard errors.
    Converged,
    /// It would not, after all steps that were allowed or with none that helps.
    Stalled,
    /// The start's prediction leaves every bound.
    Diverged,
    /// This unknown does not change the prediction by itself.
    Singular(usize),
}

/// Most steps that are worth trying.
pub(crate) const STEPS: usize = 40;
/// Newton decrement √(gᵀH⁻¹g) in standard deviations of the errors, at which a point is a minimum.
const ENOUGH: f64 = 1e-5;
/// Decrement that is good enough where rounding lets no step help any more.
const ROUNDED: f64 = 1e-3;
/// Damping of the first step and beyond which no step helps, on the scale of the normal matrix's diagonal.
const DAMPING: [f64; 2] = [1e-4, 1e9];
/// Condition number of the scaled normal matrix from which an unknown counts as without effect.
const SINGULAR: f64 = 1e12;

/// Decrement from which on steps count on what was learnt of the second derivatives of the predictions.
const NEAR: f64 = 3.0;

/// A problem on its way.
#[derive(Clone, Debug)]
struct Progress {
    weighting: Weighting,
    bounds: Vec<[f64; 2]>,
    held: Vec<usize>,
    point: Vec<f64>,
    linear: Linear,
    cost: f64,
    /// What the normal matrix lacks of the cost's second derivatives; nothing at first.
    second: Vec<f64>,
    damping: f64,
    decrement: f64,
    steps: usize,
    ended: Option<Ended>,
}

/// Minimises the squared errors of every problem from its start, with at most `steps` steps, by Levenberg and Marquardt's
/// method on all problems side by side. Every problem has its own damping and end. Steps are cut off at bounds; an unknown at a
/// bound that the errors pull it beyond is held there.
pub(crate) fn minimize<R: Residuals>(
    residuals: &mut R,
    weighting: Vec<Weighting>,
    starts: Vec<Vec<f64>>,
    steps: usize,
) -> Result<Vec<Minimum>, R::Error> {
    let bounds = residuals.bounds();
    let clip = |(problem, start)| Asked { problem, point: clipped(start, &bounds) };
    let starts: Vec<Asked> = starts.into_iter().enumerate().map(clip).collect();
    let linears = residuals.linearize(&starts)?;
    let each = weighting.into_iter().zip(starts).zip(linears);
    let new = |((weighting, start), linear): ((_, Asked), _)| {
        Progress::new(weighting, bounds.clone(), start.point, linear)
    };
    let mut problems: Vec<Progress> = each.map(new).collect();
    for _ in 0..steps {
        let open = problems.iter_mut().enumerate().filter(|(_, own)| own.ended.is_none());
        let trials: Vec<Asked> = open.map(|(problem, own)| Asked { problem, point: own.trial() }).collect();
        if trials.is_empty() {
            break;
        }
        let linears = residuals.linearize(&trials)?;
        for (Asked { problem, point }, linear) in trials.into_iter().zip(linears) {
            problems[problem].judge(point, linear);
        }
    }
    let ended = |p: Progress| Minimum {
        point: p.point,
        linear: p.linear,
        status: p.ended.unwrap_or(Ended::Stalled),
        steps: p.steps,
        held: p.held,
    };
    Ok(problems.into_iter().map(ended).collect())
}

impl Progress {
    fn new(weighting: Weighting, bounds: Vec<[f64; 2]>, point: Vec<f64>, linear: Linear) -> Self {
        let cost = weighting.cost(&linear);
        let mut progress = Self {
            weighting,
            bounds,
            held: Vec::new(),
            point,
            linear,
            cost,
            second: Vec::new(),
            damping: DAMPING[0],
            decrement: f64::INFINITY,
            steps: 0,
            ended: None,
        };
        if cost.is_finite() && progress.linear.finite() {
            progress.settle();
        } else {
            progress.ended = Some(Ended::Diverged);
        }
        progress
    }

    /// The point after a damped step.
    fn trial(&mut self) -> Vec<f64> {
        self.steps += 1;
        let (mut normal, mut gradient) = self.linear.weighted(self.weighting.weights(&self.linear));
        let p = gradient.len();
        hold(&self.held, &mut normal, &mut gradient);
        (0..p).for_each(|i| normal[i * p + i] *= 1.0 + self.damping);
        let step = self.newton_step(&normal, &gradient).or_else(|| solved(normal, &gradient));
        let mut trial = self.point.clone();
        if let Some(step) = step {
            trial.iter_mut().zip(step).for_each(|(x, step)| *x += step);
        }
        clipped(trial, &self.bounds)
    }

    /// The step with second derivatives, where they are known and it lessens the cost.
    fn newton_step(&self, normal: &[f64], gradient: &[f64]) -> Option<Vec<f64>> {
        if self.second.is_empty() || self.decrement > NEAR {
            return None;
        }
        let step = solved(normal.iter().zip(&self.second).map(|(n, s)| n + s).collect(), gradient)?;
        let (decrease, without) =
            (dot(&step, gradient), self.decrement.powi(2) * self.weighting.variance(&self.linear));
        (decrease > 0.0 && decrease < 4.0 * without).then_some(step)
    }

    /// Takes a step that does not raise the cost; rounding is no rise.
    fn judge(&mut self, trial: Vec<f64>, linear: Linear) {
        let cost = self.weighting.cost(&linear);
        if linear.finite() && cost <= self.cost + 1e-12 * self.cost.abs() {
            self.learn(&trial, &linear);
            (self.point, self.linear, self.cost) = (trial, linear, cost);
            self.damping = (0.1 * self.damping).max(1e-12);
            self.settle();
        } else {
            self.second.clear();
            self.damping *= 10.0;
            if self.damping > DAMPING[1] {
                self.ended = Some(if self.decrement < ROUNDED { Ended::Converged } else { Ended::Stalled });
            }
        }
    }

    /// Learns of the second derivatives from a step s to `next`, along which the gradient changes by y: by the secant condition
    /// (N + S) s = y on the part S that the normal matrix N lacks, with the least change of S in the norm that y sets; sized before.
    /// Dennis, Gay & Welsch, *ACM Trans. Math. Softw.* 7 (1981). Nothing is learnt where bounds hold unknowns.
    fn learn(&mut self, next: &[f64], linear: &Linear) {
        let (_, before) = self.linear.weighted(self.weighting.weights(&self.linear));
        let (normal, after) = linear.weighted(self.weighting.weights(linear));
        let step: Vec<f64> = next.iter().zip(&self.point).map(|(new, old)| new - old).collect();
        let change: Vec<f64> = before.iter().zip(&after).map(|(before, after)| before - after).collect();
        let along = dot(&change, &step);
        let rises = along > 0.0;
        if !(rises && self.held.is_empty()) {
            return self.second.clear();
        }
        let lacking = difference(&change, &times(&normal, &step));
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

    /// Looks whether the point is a minimum, or has none.
    fn settle(&mut self) {
        let (mut normal, mut gradient) = self.linear.weighted(self.weighting.weights(&self.linear));
        let pulled = |(i, [low, high]): (usize, &[f64; 2])| {
            let (x, pull) = (self.point[i], gradient[i]);
            (x == *low && pull <= 0.0 || x == *high && pull >= 0.0).then_some(i)
        };
        self.held = self.bounds.iter().enumerate().filter_map(pulled).collect();
        hold(&self.held, &mut normal, &mut gradient);
        match scaled_inverse(&normal, gradient.len()) {
            Err(unknown) => self.ended = Some(Ended::Singular(unknown)),
            Ok(inverse) => {
                let square = numerics::quadratic(&gradient, &inverse);
                self.decrement = (square.max(0.0) / self.weighting.variance(&self.linear)).sqrt();
                if self.decrement < ENOUGH || square == 0.0 {
                    self.ended = Some(Ended::Converged);
                }
            }
        }
    }
}

/// The solution of `matrix` x = `right`, if there is one.
fn solved(mut matrix: Vec<f64>, right: &[f64]) -> Option<Vec<f64>> {
    let mut solution = right.to_vec();
    numerics::solve(right.len(), &mut matrix, &mut solution)?;
    Some(solution)
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// The inverse of a normal matrix, or the unknown that has no effect of its own.
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
