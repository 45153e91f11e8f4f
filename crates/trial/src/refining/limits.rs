//! Limits of inputs, rates and motion: stated, those of generated candidates, or the extremes of the start.

use std::collections::BTreeMap;

use estimation::refine::{MARGIN, SignalLimits};
use maneuver::{Generator, InputLimit};
use refusal::Invalid;
use ship::model::Vessel;

use super::{Refusal, Start};
use crate::arranging::generated_limits;
use crate::campaign;

/// Stated limits; of states and rates largest moduli.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StatedLimits {
    /// Of u, v \[m/s\] and r \[rad/s\].
    pub states: [Option<f64>; 3],
    /// Of inputs by name, in their units.
    pub inputs: BTreeMap<String, InputLimit>,
    /// Of the inputs' rates by name, per second.
    pub rates: BTreeMap<String, f64>,
}

/// The limits with their names.
#[derive(Clone, Debug)]
pub struct Limits {
    /// `u_m_s`, `v_m_s`, `r_rad_s`, `inputs.…`, `rates.…`.
    pub names: Vec<String>,
    /// In the same order, in the limits' units; infinite without limit.
    pub allowed: Vec<f64>,
    /// In the form of the search.
    pub signal: SignalLimits,
}

/// The states' keys.
pub const STATES: [&str; 3] = ["u_m_s", "v_m_s", "r_rad_s"];

impl Limits {
    /// Limits, and the start that keeps them: inputs of `start` that jump follow it as fast as they may, less what the search
    /// needs.
    ///
    /// # Errors
    /// A limit of inputs or motion that the start exceeds; a quantity without a limit that is constant in the start; slowed
    /// inputs that make the simulation diverge.
    pub fn new(
        stated: &StatedLimits,
        vessel: &Vessel,
        generator: &Generator,
        start: Start,
    ) -> Result<(Self, Start), Refusal> {
        let model = &vessel.model;
        let inputs = model.input_names();
        let generated = generated_limits(generator);
        let largest = |values: &[f64], i: usize, width: usize| {
            values.iter().skip(i).step_by(width).fold(0.0_f64, |most, x| most.max(x.abs()))
        };
        let rate = |name: &&str| {
            let known = stated.rates.get(*name).or_else(|| generated?.rates.get(*name)).copied();
            known.unwrap_or(f64::INFINITY)
        };
        let rates: Vec<f64> = inputs.iter().map(rate).collect();
        let steps: Vec<f64> = rates.iter().map(|rate| rate / vessel.sample_rate_hz).collect();
        let slower: Vec<f64> = steps.iter().map(|step| step * (1.0 - 2.0 * MARGIN)).collect();
        let start = start.within_rates(vessel, &slower)?;
        let generated_states = generated.map(|g| [g.u_m_s, g.v_m_s, g.r_rad_s]);
        let state = |d: usize| {
            stated.states[d]
                .or(generated_states.map(|g| g[d]))
                .unwrap_or_else(|| largest(&start.states, d, 3))
        };
        let input = |(i, name): (usize, &&str)| {
            let known = stated.inputs.get(*name).or_else(|| generated?.inputs.get(*name)).copied();
            let limit = known.unwrap_or_else(|| largest(&start.inputs, i, inputs.len()).into());
            vessel.actuators[i].range.map_or(limit, |range| limit.within(range))
        };
        let states = [0, 1, 2].map(state);
        let ranges: Vec<InputLimit> = inputs.iter().enumerate().map(input).collect();
        let under = |table: &'static str| inputs.iter().map(move |name| format!("{table}.{name}"));
        let limits = Self {
            names: STATES
                .map(str::to_owned)
                .into_iter()
                .chain(under("inputs"))
                .chain(under("rates"))
                .collect(),
            allowed: states.into_iter().chain(ranges.iter().map(InputLimit::modulus)).chain(rates).collect(),
            signal: SignalLimits {
                states,
                inputs: ranges.iter().map(|range| [range.low, range.high]).collect(),
                steps,
            },
        };
        limits.check(&start)?;
        Ok((limits, start))
    }

    /// The largest moduli of an experiment, in the limits' units, at a sampling rate of `rate_hz`.
    pub fn moduli(&self, states: &[f64], inputs: &[f64], rate_hz: f64) -> Vec<f64> {
        let width = self.signal.inputs.len();
        let unit = SignalLimits {
            states: [1.0; 3],
            inputs: vec![[-1.0, 1.0]; width],
            steps: vec![1.0 / rate_hz; width],
        };
        unit.reached(states, inputs)
    }

    fn check(&self, start: &Start) -> Result<(), Refusal> {
        if let Some(i) = self.allowed.iter().position(|limit| *limit == 0.0) {
            let still = Invalid::new(
                format!("`{}` of the design's experiment", self.names[i]),
                "zero all the time, and no limit is stated",
                "a limit, or an experiment that moves it",
                "state it in --limits limits.toml",
            );
            return Err(campaign::Refusal::Design(still).into());
        }
        let reached = self.signal.reached(&start.states, &start.inputs);
        let most = (0..reached.len()).max_by(|i, j| reached[*i].total_cmp(&reached[*j])).unwrap_or(0);
        if reached[most] <= 1.0 + 1e-9 {
            return Ok(());
        }
        Err(Refusal::Limits(Invalid::new(
            format!("limit `{}`", self.names[most]),
            format!("{} in the design's experiment", reached[most] * self.allowed[most]),
            format!("at most {}", self.allowed[most]),
            "begin with a design that keeps it, or state a wider one in --limits",
        )))
    }
}
