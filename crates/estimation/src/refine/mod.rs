//! Input signals that minimise the variance of an output-error estimate, by adjoint gradients.
//!
//! One experiment is a run of N samples from a given state. The objective is f = log tr(G cov θ̃) with cov θ̃ = F⁻¹(E + P)F⁻¹
//! of its free simulation ([`crate::output_information`]) and G the weights of the parameters' variances. Its
//! gradient by all inputs of all samples takes one pass forward and one backward ([`TraceCriterion`]); [`refine`]
//! follows it within limits of the inputs, of their rates and of the simulated motion.

mod criterion;

use numerics::bounded::{Objective, minimise};
use numerics::{Watch, iterate};

pub use criterion::{Forward, TraceCriterion};

/// The effort and resolution of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Samples between the knots of a correction; 1 corrects every sample.
    pub knot: usize,
    /// Maximum number of iterations, of all rounds.
    pub iterations: usize,
}

/// Refined inputs.
#[derive(Clone, Debug)]
pub struct Refined {
    /// N × inputs.
    pub inputs: Vec<f64>,
    /// The experiment at the start.
    pub before: Forward,
    /// The refined one; as at the start if nothing better was found within the limits.
    pub after: Forward,
    /// Number of iterations.
    pub iterations: usize,
    /// Number of simulations.
    pub evaluations: usize,
    /// Whether the search converged: a round gained less than one in ten thousand.
    pub settled: bool,
}

/// Maximum iterations of a round; few are shared among rounds, since the cost of violations has to grow.
const ROUND: usize = 60;
const ROUNDS: usize = 12;
/// Cost of a violation in the first round, its growth by round, and its greatest.
const WEIGHTS: [f64; 3] = [3.0, 2.0, 3e3];
/// Margin of the search below limits of motion and rates, as a part of them.
pub const MARGIN: f64 = 5e-4;
const GAIN: f64 = 1e-4;

/// Minimises `criterion` from inputs `start`, N × inputs, within `limits`, which `start` must keep, those of rates by
/// more than [`MARGIN`]: a correction is linear between knots, so that it slows no input that rises and falls between two. The
/// result keeps the limits. `None` if the criterion is not defined at the start. `watch` may end it with the best so far.
pub fn refine(
    criterion: &TraceCriterion,
    start: &[f64],
    limits: &SignalLimits,
    effort: &Effort,
    watch: &Watch,
) -> Option<Refined> {
    let signal = Signal::new(start, &limits.inputs, effort.knot);
    let [low, high] = signal.bounds();
    let mut x = vec![0.0; low.len()];
    let states = 3 * (start.len() / limits.inputs.len().max(1) + 1);
    let mut lagrangian = Lagrangian {
        criterion,
        signal,
        limits,
        margin: MARGIN,
        weight: WEIGHTS[0],
        multipliers: vec![0.0; states + start.len().saturating_sub(limits.inputs.len())],
        best: None,
        evaluations: 0,
    };
    let before = lagrangian.run(&x)?;
    lagrangian.best = Some((before.value, x.clone()));
    let (mut iterations, mut settled) = (0, false);
    iterate("augmented Lagrangian", effort.iterations, &Watch::default(), || {
        let known = lagrangian.best.as_ref().map_or(f64::INFINITY, |(value, _)| *value);
        let round = ROUND.min(effort.iterations.div_ceil(ROUNDS)).min(effort.iterations - iterations);
        iterations += minimise(&mut lagrangian, &mut x, [&low, &high], round, watch).max(1);
        let violation = lagrangian.update(&x)?;
        let now = lagrangian.best.as_ref().map_or(f64::INFINITY, |(value, _)| *value);
        let heaviest = lagrangian.weight >= WEIGHTS[2];
        settled = heaviest && violation < MARGIN && known - now < GAIN * now;
        lagrangian.weight = (WEIGHTS[1] * lagrangian.weight).min(WEIGHTS[2]);
        (iterations < effort.iterations && !settled && !watch.ended()).then_some(())
    });
    let best = lagrangian.best.take().map_or(x, |(_, x)| x);
    let after = lagrangian.run(&best)?;
    let inputs = lagrangian.signal.inputs(&best);
    Some(Refined { inputs, before, after, iterations, evaluations: lagrangian.evaluations, settled })
}

// Limits of motion and rates, kept by an augmented Lagrangian: c = |x|/limit − 1 ≤ 0 at every sample, with a multiplier of its own.
//
/// Limits of a signal.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalLimits {
    /// Largest moduli of u, v \[m/s\] and r \[rad/s\] in the simulation.
    pub states: [f64; 3],
    /// Lowest and highest value of every input.
    pub inputs: Vec<[f64; 2]>,
    /// Largest modulus of every input's change from one sample to the next; infinite without limit.
    pub steps: Vec<f64>,
}

impl SignalLimits {
    /// The largest share of its limit that each of u, v, r, every input and every input's rate reaches, row by row.
    pub fn reached(&self, states: &[f64], inputs: &[f64]) -> Vec<f64> {
        let width = self.inputs.len();
        let largest = |all: &mut dyn Iterator<Item = f64>| all.fold(0.0_f64, |most, x| most.max(x.abs()));
        let state = |d: usize| largest(&mut states.iter().skip(d).step_by(3).copied()) / self.states[d];
        let input = |i: usize| {
            let [middle, half] = centred(self.inputs[i]);
            largest(&mut inputs.iter().skip(i).step_by(width).map(|x| x - middle)) / half
        };
        let change = |e: usize| inputs[e + width] - inputs[e];
        let step = |i: usize| {
            let places = (i..inputs.len().saturating_sub(width)).step_by(width);
            largest(&mut places.map(change)) / self.steps[i]
        };
        (0..3).map(state).chain((0..width).map(input)).chain((0..width).map(step)).collect()
    }

    /// Whether all are kept, up to rounding.
    pub fn kept(&self, states: &[f64], inputs: &[f64]) -> bool {
        self.reached(states, inputs).iter().all(|share| *share <= 1.0 + 1e-9)
    }
}

struct Lagrangian<'a> {
    pub criterion: &'a TraceCriterion<'a>,
    pub signal: Signal<'a>,
    pub limits: &'a SignalLimits,
    pub margin: f64,
    pub weight: f64,
    /// Of the states, (N+1) × 3, then of the inputs' steps, (N−1) × inputs.
    pub multipliers: Vec<f64>,
    pub best: Option<(f64, Vec<f64>)>,
    pub evaluations: usize,
}

struct EvaluatedPoint {
    forward: Forward,
    inputs: Vec<f64>,
    exogenous: Vec<f64>,
}

impl Lagrangian<'_> {
    fn run(&mut self, x: &[f64]) -> Option<Forward> {
        self.value(x).map(|(_, point)| point.forward)
    }

    /// All c with their derivatives ±1/limit, in the order of the multipliers.
    fn constraints(&self, states: &[f64], inputs: &[f64]) -> Vec<(f64, f64)> {
        let width = self.limits.inputs.len();
        let share = 1.0 - self.margin;
        let of = |x: f64, limit: f64| (x.abs() / (share * limit) - 1.0, x.signum() / (share * limit));
        let states = states.iter().enumerate().map(|(e, x)| of(*x, self.limits.states[e % 3]));
        let steps =
            (width..inputs.len()).map(|e| of(inputs[e] - inputs[e - width], self.limits.steps[e % width]));
        states.chain(steps).collect()
    }

    fn forces(&self, constraints: &[(f64, f64)]) -> Vec<f64> {
        let force = |(nu, (c, _)): (&f64, &(f64, f64))| (nu + self.weight * c).max(0.0);
        self.multipliers.iter().zip(constraints).map(force).collect()
    }

    /// Updates the multipliers at the point; returns the largest violation of the limits less their margin.
    fn update(&mut self, x: &[f64]) -> Option<f64> {
        let (_, point) = self.value(x)?;
        let constraints = self.constraints(&point.forward.states, &point.inputs);
        self.multipliers = self.forces(&constraints);
        Some(constraints.iter().fold(0.0, |most, (c, _)| most.max(*c)))
    }
}

impl Objective for Lagrangian<'_> {
    type Point = EvaluatedPoint;

    fn value(&mut self, x: &[f64]) -> Option<(f64, EvaluatedPoint)> {
        self.evaluations += 1;
        let inputs = self.signal.inputs(x);
        let exogenous = self.criterion.model.undisturbed(&inputs);
        let forward = self.criterion.forward(&exogenous)?;
        let forces = self.forces(&self.constraints(&forward.states, &inputs));
        let cost = |(force, nu): (&f64, &f64)| (force * force - nu * nu) / (2.0 * self.weight);
        let cost: f64 = forces.iter().zip(&self.multipliers).map(cost).sum();
        Some((libm::log(forward.value) + cost, EvaluatedPoint { forward, inputs, exogenous }))
    }

    fn gradient(&self, point: &EvaluatedPoint) -> Vec<f64> {
        let constraints = self.constraints(&point.forward.states, &point.inputs);
        let forces = self.forces(&constraints);
        let slopes: Vec<f64> = forces.iter().zip(&constraints).map(|(f, (_, slope))| f * slope).collect();
        let (states, steps) = slopes.split_at(point.forward.states.len());
        let mut gradient = self.criterion.gradient(&point.forward, &point.exogenous, states);
        let width = self.limits.inputs.len();
        for (e, slope) in steps.iter().enumerate() {
            gradient[e + width] += slope;
            gradient[e] -= slope;
        }
        self.signal.gathered(&gradient)
    }

    fn keep(&mut self, x: &[f64], point: &EvaluatedPoint) {
        let better = self.best.as_ref().is_none_or(|(value, _)| point.forward.value < *value);
        if better && self.limits.kept(&point.forward.states, &point.inputs) {
            self.best = Some((point.forward.value, x.to_vec()));
        }
    }
}

/// Corrections of inputs at knots, `knot` samples apart, in units of half the width of the inputs' limits.
struct Signal<'a> {
    start: &'a [f64],
    limits: &'a [[f64; 2]],
    knot: usize,
}

impl<'a> Signal<'a> {
    fn new(start: &'a [f64], limits: &'a [[f64; 2]], knot: usize) -> Self {
        Self { start, limits, knot }
    }

    fn samples(&self) -> usize {
        self.start.len() / self.limits.len().max(1)
    }

    /// Knots of every input: the first at sample 0, the last at the last sample or after it.
    fn knots(&self) -> usize {
        self.samples().saturating_sub(1).div_ceil(self.knot) + 1
    }

    /// The knot before sample `k`, and the fraction of the way to the next.
    fn place(&self, k: usize) -> (usize, f64) {
        (k / self.knot, (k % self.knot) as f64 / self.knot as f64)
    }

    /// Bounds of the corrections that keep every sample within the limits: those of the nearest samples.
    fn bounds(&self) -> [Vec<f64>; 2] {
        let width = self.limits.len();
        let mut low = vec![f64::NEG_INFINITY; self.knots() * width];
        let mut high = vec![f64::INFINITY; self.knots() * width];
        for (k, row) in self.start.chunks_exact(width).enumerate() {
            let (knot, share) = self.place(k);
            let touched = if share > 0.0 { knot..knot + 2 } else { knot..knot + 1 };
            for (i, x) in touched.flat_map(|m| row.iter().enumerate().map(move |(i, x)| (m * width + i, x))) {
                let [middle, half] = centred(self.limits[i % width]);
                let start = ((x - middle) / half).clamp(-1.0, 1.0);
                low[i] = low[i].max(-1.0 - start);
                high[i] = high[i].min(1.0 - start);
            }
        }
        let unused = |x: &f64| x.is_infinite();
        low.iter_mut().chain(&mut high).filter(|x| unused(x)).for_each(|x| *x = 0.0);
        [low, high]
    }

    /// The inputs of corrections, N × inputs, never beyond the limits by rounding.
    fn inputs(&self, corrections: &[f64]) -> Vec<f64> {
        let width = self.limits.len();
        let of = |(e, x): (usize, &f64)| {
            let (knot, share) = self.place(e / width);
            let at = |m: usize| corrections.get(m * width + e % width).copied().unwrap_or(0.0);
            let correction =
                if share > 0.0 { (1.0 - share) * at(knot) + share * at(knot + 1) } else { at(knot) };
            let [low, high] = self.limits[e % width];
            let [_, half] = centred([low, high]);
            if correction == 0.0 { *x } else { (x + half * correction).clamp(low, high) }
        };
        self.start.iter().enumerate().map(of).collect()
    }

    fn gathered(&self, slopes: &[f64]) -> Vec<f64> {
        let width = self.limits.len();
        let mut out = vec![0.0; self.knots() * width];
        for (e, slope) in slopes.iter().enumerate() {
            let (knot, share) = self.place(e / width);
            let slope = slope * centred(self.limits[e % width])[1];
            out[knot * width + e % width] += (1.0 - share) * slope;
            if share > 0.0 {
                out[(knot + 1) * width + e % width] += share * slope;
            }
        }
        out
    }
}

fn centred([low, high]: [f64; 2]) -> [f64; 2] {
    [0.5 * (low + high), 0.5 * (high - low)]
}
