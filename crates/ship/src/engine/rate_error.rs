//! How well the parts of a step follow the whole one.

use crate::model::{Model, RateChange, Vessel};
use refusal::Invalid;

use crate::engine::{Compiled, simulate_one};

/// The most that a whole step's parts may be off, in standard deviations of each state.
const MOST: f64 = 0.002;

/// Sums over simulated runs of a model whose samples are parts of a step, see [`RateChange::Divided`].
#[derive(Clone, Debug)]
pub struct Divided {
    whole: Model,
    lower: Model,
    by: usize,
    /// Samples of the runs, and sums of their states and squares.
    count: f64,
    sums: [[f64; 2]; 3],
    /// Squares of the differences between this order and the one below.
    orders: [f64; 3],
    /// Whole steps, and squares of the differences to their parts.
    steps: f64,
    parts: [f64; 3],
    /// The first point at which the step does not go on forward, in words.
    backward: Option<String>,
}

/// Most points of the range of validity at which the step is tried, and settings of each channel: the ends and evenly between.
const MOST_POINTS: usize = 20_000;
const MOST_SETTINGS: usize = 9;

impl Divided {
    /// Without any run; `None` where a sample of `model` is no part of a step.
    pub fn new(model: &Model) -> Option<Self> {
        let RateChange::Divided { by, order } = model.pace else { return None };
        let at = |pace: RateChange| Model { pace, ..model.clone() };
        Some(Self {
            whole: at(RateChange::Own),
            lower: at(RateChange::Divided { by, order: order - 1 }),
            by: by as usize,
            count: 0.0,
            sums: [[0.0; 2]; 3],
            orders: [0.0; 3],
            steps: 0.0,
            parts: [0.0; 3],
            backward: None,
        })
    }

    /// Adds a run of `model`, from which this was made: N × exogenous, (N+1) × 3 states.
    pub fn add(&mut self, model: &Model, parameters: &[f64], exogenous: &[f64], states: &[f64]) {
        let width = model.exogenous().max(1);
        let initial = [states[0], states[1], states[2]];
        let lower = simulate_one(&self.lower, parameters, initial, exogenous);
        for (state, lower) in states.chunks_exact(3).zip(lower.chunks_exact(3)) {
            self.count += 1.0;
            for d in 0..3 {
                self.sums[d][0] += state[d];
                self.sums[d][1] += state[d] * state[d];
                self.orders[d] += (state[d] - lower[d]).powi(2);
            }
        }
        // The same inputs, held for whole steps.
        let rows: Vec<&[f64]> = exogenous.chunks_exact(width).step_by(self.by).collect();
        let held: Vec<f64> = rows.concat();
        let parts: Vec<f64> = rows.iter().flat_map(|row| row.repeat(self.by)).collect();
        let whole = simulate_one(&self.whole, parameters, initial, &held);
        let parts = simulate_one(model, parameters, initial, &parts);
        for (step, parts) in whole.chunks_exact(3).zip(parts.chunks_exact(3).step_by(self.by)) {
            self.steps += 1.0;
            (0..3).for_each(|d| self.parts[d] += (step[d] - parts[d]).powi(2));
        }
        let mut compiled = Compiled::new(&self.whole, parameters);
        for (state, row) in whole.chunks_exact(3).zip(&rows) {
            let state = [state[0], state[1], state[2]];
            compiled.look(state, row, None);
            if self.backward.is_none() && !goes_forward(compiled.slopes()) {
                self.backward = Some(point(state, &[]));
            }
        }
    }

    /// Tries the step over the range of validity of `vessel`, from which this was made: over the ranges of u, v, r and of the
    /// inputs, on a grid of at most 20,000 points with their ends. Where it states none, or an input has none, nothing is tried.
    pub fn add_range(&mut self, vessel: &Vessel, parameters: &[f64]) {
        let inputs: Option<Vec<[f64; 2]>> = vessel.actuators.iter().map(|actuator| actuator.range).collect();
        let (Some(motion), Some(inputs)) = (vessel.motion, inputs) else { return };
        // An input that follows another one has no range of its own.
        let free: Vec<usize> = (0..inputs.len()).filter(|i| vessel.couplings[*i].is_none()).collect();
        let ranges: Vec<[f64; 2]> = motion.into_iter().chain(free.iter().map(|i| inputs[*i])).collect();
        let count = settings(ranges.len());
        let names: Vec<&str> =
            vessel.model.input_variables().iter().map(|variable| variable.name.as_str()).collect();
        let mut compiled = Compiled::new(&self.whole, parameters);
        for number in 0..count.saturating_pow(ranges.len() as u32).min(MOST_POINTS) {
            let mut rest = number;
            let at: Vec<f64> = ranges
                .iter()
                .map(|[low, high]| {
                    let place = rest % count;
                    rest /= count;
                    low + (high - low) * place as f64 / (count - 1) as f64
                })
                .collect();
            let mut row = vec![0.0; inputs.len()];
            free.iter().zip(&at[3..]).for_each(|(i, value)| row[*i] = *value);
            for i in 0..row.len() {
                if let Some((leader, factor)) = vessel.couplings[i] {
                    row[i] = factor * row[leader];
                }
            }
            let state = [at[0], at[1], at[2]];
            compiled.look(state, &self.whole.undisturbed(&row), None);
            if !goes_forward(compiled.slopes()) {
                let named: Vec<(&str, f64)> = names.iter().copied().zip(row).collect();
                self.backward.get_or_insert(point(state, &named));
                return;
            }
        }
    }

    /// Adds the runs that another has seen.
    pub fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.steps += other.steps;
        for d in 0..3 {
            (0..2).for_each(|i| self.sums[d][i] += other.sums[d][i]);
            self.orders[d] += other.orders[d];
            self.parts[d] += other.parts[d];
        }
        self.backward = self.backward.take().or_else(|| other.backward.clone());
    }

    /// Root mean squares in standard deviations of u, v and r: what the parts of steps are off from these, and the difference
    /// between the formula's order and the one below.
    ///
    /// # Errors
    /// A step that does not go on forward; parts that are off by more than 0.2 % of a standard deviation.
    pub fn errors(&self) -> Result<[[f64; 3]; 2], Invalid> {
        let remedy = "take a rate nearer to the vessel's, or a vessel with `model = \"forces\"`";
        if let Some(point) = &self.backward {
            return Err(Invalid::new(
                "sampling rate",
                format!("a step with an eigenvalue that is not above 0, at {point}"),
                "positive eigenvalues of the step, which alone can be divided",
                "take the vessel's rate, or a slower one",
            ));
        }
        let deviation = |d: usize| {
            let [sum, squares] = self.sums[d];
            let mean = sum / self.count;
            (squares / self.count - mean * mean).max(0.0).sqrt()
        };
        let share = |square: f64, count: f64, d: usize| {
            let off = (square / count).sqrt();
            if off <= 1e-12 { 0.0 } else { off / deviation(d) }
        };
        let parts = [0, 1, 2].map(|d: usize| share(self.parts[d], self.steps, d));
        let orders = [0, 1, 2].map(|d: usize| share(self.orders[d], self.count, d));
        match parts.iter().position(|share| share.is_nan() || *share > MOST) {
            None => Ok([parts, orders]),
            Some(d) => {
                let state = ["u", "v", "r"][d];
                let given = format!(
                    "{:.2} % of the standard deviation of {state} between a step and its parts",
                    100.0 * parts[d]
                );
                Err(Invalid::new("sampling rate", given, format!("at most {} %", 100.0 * MOST), remedy))
            }
        }
    }

    /// The statement about it.
    ///
    /// # Errors
    /// As [`Self::errors`].
    pub fn statement(&self) -> Result<String, Invalid> {
        let [parts, orders] = self.errors()?;
        let percent = |all: [f64; 3]| all.map(|share| format!("{:.3}", 100.0 * share)).join(", ");
        Ok(format!(
            "Newton's forward formula of order {}: {} steps differ from one of the vessel's by {} % of the standard deviations of u, v, \
             r, order {} from order {} by {} %",
            crate::model::ORDER,
            self.by,
            percent(parts),
            crate::model::ORDER,
            crate::model::ORDER - 1,
            percent(orders)
        ))
    }
}

/// A state and inputs in words.
fn point([u, v, r]: [f64; 3], inputs: &[(&str, f64)]) -> String {
    let inputs: String = inputs.iter().map(|(name, value)| format!(", {name} = {value:.4}")).collect();
    format!("u = {u:.4} m/s, v = {v:.4} m/s, r = {r:.4} rad/s{inputs}")
}

/// How many settings each of so many channels has on a grid; two at least.
fn settings(channels: usize) -> usize {
    let fits = |count: &usize| count.saturating_pow(channels as u32) <= MOST_POINTS;
    (2..=MOST_SETTINGS).rev().find(fits).unwrap_or(2)
}

/// Whether all eigenvalues of I + J have positive real parts (Routh and Hurwitz), where `slopes` is J.
fn goes_forward(slopes: [[f64; 3]; 3]) -> bool {
    let mut m = slopes;
    (0..3).for_each(|d| m[d][d] += 1.0);
    let minor = |i: usize, k: usize| m[i][i] * m[k][k] - m[i][k] * m[k][i];
    let trace = m[0][0] + m[1][1] + m[2][2];
    let minors = minor(0, 1) + minor(0, 2) + minor(1, 2);
    let determinant = m[0][0] * minor(1, 2) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    trace > 0.0 && determinant > 0.0 && trace * minors > determinant
}
