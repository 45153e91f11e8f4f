//! Limits of motion and rates, kept by an augmented Lagrangian: c = |x|/limit − 1 ≤ 0 at every sample, with a multiplier of its own.
//!
//! Source: Nocedal & Wright 2006, Numerical optimization, chapter 17.

use numerics::bounded::Objective;

use super::criterion::{Forward, TraceCriterion};
use super::signal::{Signal, centred};

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
    /// The largest share of a limit that states (rows × 3) and inputs (rows × inputs) reach: of u, v, r, of every input, and of
    /// every input's rate.
    pub fn reached(&self, states: &[f64], inputs: &[f64]) -> Vec<f64> {
        let width = self.inputs.len();
        let largest =
            |values: &mut dyn Iterator<Item = f64>| values.fold(0.0_f64, |most, x| most.max(x.abs()));
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

/// The criterion with the cost of limits at the present multipliers.
pub(super) struct Lagrangian<'a> {
    pub criterion: &'a TraceCriterion<'a>,
    pub signal: Signal<'a>,
    pub limits: &'a SignalLimits,
    /// Relative margin of the search below the limits.
    pub margin: f64,
    /// Weight of a violation.
    pub weight: f64,
    /// Of the states, (N+1) × 3, then of the inputs' steps, (N−1) × inputs.
    pub multipliers: Vec<f64>,
    /// The best inputs within all limits, with their corrections.
    pub best: Option<(f64, Vec<f64>)>,
    pub evaluations: usize,
}

/// A point that was evaluated.
pub(super) struct Point {
    forward: Forward,
    inputs: Vec<f64>,
    exogenous: Vec<f64>,
}

impl Lagrangian<'_> {
    /// The run of corrections `x`.
    pub(super) fn run(&mut self, x: &[f64]) -> Option<Forward> {
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

    /// max(0, ν + μ c) of every constraint.
    fn forces(&self, constraints: &[(f64, f64)]) -> Vec<f64> {
        let force = |(nu, (c, _)): (&f64, &(f64, f64))| (nu + self.weight * c).max(0.0);
        self.multipliers.iter().zip(constraints).map(force).collect()
    }

    /// Updates the multipliers at the point; returns the largest violation of the limits less their margin.
    pub(super) fn update(&mut self, x: &[f64]) -> Option<f64> {
        let (_, point) = self.value(x)?;
        let constraints = self.constraints(&point.forward.states, &point.inputs);
        self.multipliers = self.forces(&constraints);
        Some(constraints.iter().fold(0.0, |most, (c, _)| most.max(*c)))
    }
}

impl Objective for Lagrangian<'_> {
    type Point = Point;

    fn value(&mut self, x: &[f64]) -> Option<(f64, Point)> {
        self.evaluations += 1;
        let inputs = self.signal.inputs(x);
        let exogenous = self.criterion.model.undisturbed(&inputs);
        let forward = self.criterion.forward(&exogenous)?;
        let forces = self.forces(&self.constraints(&forward.states, &inputs));
        let cost = |(force, nu): (&f64, &f64)| (force * force - nu * nu) / (2.0 * self.weight);
        let cost: f64 = forces.iter().zip(&self.multipliers).map(cost).sum();
        Some((libm::log(forward.value) + cost, Point { forward, inputs, exogenous }))
    }

    fn gradient(&self, point: &Point) -> Vec<f64> {
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

    fn keep(&mut self, x: &[f64], point: &Point) {
        let better = self.best.as_ref().is_none_or(|(value, _)| point.forward.value < *value);
        if better && self.limits.kept(&point.forward.states, &point.inputs) {
            self.best = Some((point.forward.value, x.to_vec()));
        }
    }
}
