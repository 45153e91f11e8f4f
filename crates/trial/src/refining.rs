//! Refines the input signals of a designed experiment within limits.

use std::collections::BTreeMap;

use estimation::output_information;
use estimation::refine::{Effort, MARGIN, Refined, SignalLimits, TraceCriterion, refine};
use maneuver::{Generator, InputLimit};
use numerics::Watch;
use refusal::Invalid;
use regression::Noise;
use ship::engine::{check_diverged, simulate_one};
use ship::model::{Source, Vessel};
use thiserror::Error;

use crate::arranging::generated_limits;
use crate::campaign::{self, Parts};
use crate::moments::rows;

/// Time between the knots of the piecewise linear change of the start's inputs \[s\].
const KNOT_S: f64 = 1.0;

/// Why an experiment cannot be refined, by the part at fault.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Refusal {
    /// The experiment: zero parameters of the vessel, a motion that diverges or that the model cannot hold, a
    /// quantity without a limit that is constant.
    #[error(transparent)]
    Trial(#[from] campaign::Refusal),
    /// A limit that the start exceeds.
    #[error("limits: {0}")]
    Limits(Invalid),
    /// A start without information about a parameter.
    #[error("the start does not distinguish `{parameter}` from the other parameters")]
    NotIdentifiable {
        /// Its name, or an intercept's.
        parameter: String,
    },
}

/// A refined experiment with its inputs.
#[derive(Clone, Debug)]
pub struct Refinement {
    /// The experiment at the start.
    pub start: RefinementStart,
    /// The limits.
    pub limits: Limits,
    /// Samples between the knots of the change of the start's inputs.
    pub knot: usize,
    /// The result.
    pub refined: Refined,
}

impl Refinement {
    /// Follows the gradient of the criterion from `start` within `limits`, in at most `iterations`
    /// iterations; `watch` may end it sooner.
    ///
    /// # Errors
    /// [`Refusal::NotIdentifiable`].
    pub fn search(
        vessel: &Vessel,
        start: RefinementStart,
        limits: Limits,
        iterations: usize,
        watch: &Watch,
    ) -> Result<Self, Refusal> {
        let knot = ((KNOT_S * vessel.sample_rate_hz).round() as usize).max(1);
        let effort = Effort { knot, iterations };
        match refine(&start.criterion(vessel), &start.inputs, &limits.signal, &effort, watch) {
            Some(refined) => Ok(Self { start, limits, knot, refined }),
            None => Err(Refusal::NotIdentifiable { parameter: start.weakest(vessel) }),
        }
    }

    /// The efficiency relative to the start: value before over value after, the factor by which time is saved.
    pub fn efficiency(&self) -> f64 {
        self.refined.before.value / self.refined.after.value
    }

    /// Whether nothing better was found.
    pub fn unchanged(&self) -> bool {
        self.refined.inputs == self.start.inputs
    }
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

impl Limits {
    /// Limits, and the start that keeps them: inputs of `start` that jump follow it as fast as they may, less what the search
    /// needs.
    ///
    /// # Errors
    /// A limit of inputs or motion that the start exceeds; a quantity without a limit that is constant in the start; slowed
    /// inputs that make the simulation diverge.
    pub fn new(
        vessel: &Vessel,
        generator: &Generator,
        start: RefinementStart,
    ) -> Result<(Self, RefinementStart), Refusal> {
        let model = &vessel.model;
        let inputs = model.input_names();
        let (stated, generated) = (generator.stated_limits(), generated_limits(generator));
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
        let stated_states = [stated.u_m_s, stated.v_m_s, stated.r_rad_s];
        let state = |d: usize| {
            let known = stated_states[d].or(generated_states.map(|g| g[d]));
            known.unwrap_or_else(|| largest(&start.states, d, 3))
        };
        let input = |(i, name): (usize, &&str)| {
            let known = stated.inputs.get(*name).or_else(|| generated?.inputs.get(*name)).copied();
            let limit = known.unwrap_or_else(|| largest(&start.inputs, i, inputs.len()).into());
            vessel.actuators[i].range.map_or(limit, |range| limit.within(range))
        };
        let states = [0, 1, 2].map(state);
        let ranges: Vec<InputLimit> = inputs.iter().enumerate().map(input).collect();
        let under = |table: &'static str| inputs.iter().map(move |name| format!("{table}.{name}"));
        let of_states = ["u_m_s", "v_m_s", "r_rad_s"].map(str::to_owned).into_iter();
        let limits = Self {
            names: of_states.chain(under("inputs")).chain(under("rates")).collect(),
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
        let (ranges, steps) = (vec![[-1.0, 1.0]; width], vec![1.0 / rate_hz; width]);
        SignalLimits { states: [1.0; 3], inputs: ranges, steps }.reached(states, inputs)
    }

    fn check(&self, start: &RefinementStart) -> Result<(), Refusal> {
        if let Some(i) = self.allowed.iter().position(|limit| *limit == 0.0) {
            let still = Invalid::new(
                format!("`{}` of the design's experiment", self.names[i]),
                "zero all the time, and no limit is stated",
                "a limit, or an experiment that moves it",
                "state it in the table [limits] of the dictionary",
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
            "begin with a design that keeps it, or state a wider one in [limits] of the dictionary",
        )))
    }
}

/// Inputs, initial state and the data to evaluate them.
#[derive(Clone, Debug)]
pub struct RefinementStart {
    /// N × inputs.
    pub inputs: Vec<f64>,
    /// u, v \[m/s\], r \[rad/s\].
    pub initial: [f64; 3],
    /// Simulated states, (N+1) × 3.
    pub states: Vec<f64>,
    /// Which parameters it is simulated with, and errors are relative to: the true ones if the vessel has them.
    pub source: Source,
    /// These parameters.
    pub parameters: Vec<f64>,
    /// Weight of every parameter's variance, 1/θ².
    pub weights: Vec<f64>,
    /// The disturbances of the experiment.
    pub noise: Noise,
    /// Names of the inputs that follow the design's experiment as fast as their rates allow, instead of jumping with it.
    pub slowed: Vec<String>,
}

impl RefinementStart {
    /// The experiment of `plan`: maneuvers of `generator` and their samples.
    ///
    /// # Errors
    /// A maneuver that the model cannot hold; parameters of zero; a simulation that diverges.
    pub fn new(
        vessel: &Vessel,
        generator: &Generator,
        plan: &[(usize, usize)],
        noise: Noise,
    ) -> Result<Self, campaign::Refusal> {
        let mut parts = Parts::default();
        parts.make(generator, plan).map_err(campaign::Refusal::Dictionary)?;
        let (initial, inputs) = parts.joined(plan);
        let source = vessel.best_known();
        let parameters = vessel.parameters(source).map_err(campaign::Refusal::Vessel)?;
        let weights = weights(vessel, &parameters)?;
        let states = states(vessel, &parameters, initial, &inputs)?;
        Ok(Self { inputs, initial, states, source, parameters, weights, noise, slowed: Vec::new() })
    }

    /// The experiment with inputs that change by no more than `steps` from sample to sample, by input: over the whole of it, as
    /// inputs jump where one maneuver ends and the next begins.
    ///
    /// # Errors
    /// A simulation that diverges.
    pub fn within_rates(self, vessel: &Vessel, steps: &[f64]) -> Result<Self, campaign::Refusal> {
        let (inputs, slowed) = slowed(&self.inputs, steps);
        if slowed.is_empty() {
            return Ok(self);
        }
        let states = states(vessel, &self.parameters, self.initial, &inputs)?;
        let names = vessel.model.input_names();
        let slowed = slowed.into_iter().map(|i| names[i].to_owned()).collect();
        Ok(Self { inputs, states, slowed, ..self })
    }

    /// The criterion of runs from the same initial state.
    pub fn criterion<'a>(&'a self, vessel: &'a Vessel) -> TraceCriterion<'a> {
        let Self { parameters, weights, noise, initial, .. } = self;
        TraceCriterion { model: &vessel.model, parameters, weights, noise: *noise, initial: *initial }
    }

    /// The parameter with the least information in the experiment.
    fn weakest(&self, vessel: &Vessel) -> String {
        let exogenous = vessel.model.undisturbed(&self.inputs);
        let information =
            output_information(&vessel.model, &self.parameters, self.initial, &exogenous, &self.noise);
        let f = information.map(|sums| sums.information).unwrap_or_default();
        let n = vessel.model.layout().with_intercepts().parameters();
        let size = |i: usize| f.get(i * n + i).copied().unwrap_or(0.0).max(0.0).sqrt();
        let nothing = (0..n).find(|i| size(*i) == 0.0);
        let strongest = || -> Option<usize> {
            let correlation: Vec<f64> = (0..n * n).map(|e| f[e] / (size(e / n) * size(e % n))).collect();
            let direction = numerics::weakest(n, &correlation)?.direction;
            (0..n).max_by(|i, j| direction[*i].abs().total_cmp(&direction[*j].abs()))
        };
        nothing.or_else(strongest).map_or_else(String::new, |i| rows(&vessel.model)[i].clone())
    }
}

/// The simulated states, (N+1) × 3.
fn states(
    vessel: &Vessel,
    parameters: &[f64],
    initial: [f64; 3],
    inputs: &[f64],
) -> Result<Vec<f64>, campaign::Refusal> {
    let states = simulate_one(&vessel.model, parameters, initial, &vessel.model.undisturbed(inputs));
    match check_diverged(states.iter().copied()) {
        Some(at) => {
            Err(campaign::Refusal::Vessel(at.invalid("the design's experiment", vessel.sample_rate_hz)))
        }
        None => Ok(states),
    }
}

/// What a step may be larger than its limit by rounding, as a part of it.
const ROUNDING: f64 = 1e-9;

/// `inputs`, N × steps, each following its own signal by at most its step from sample to sample, and which of them had to.
fn slowed(inputs: &[f64], steps: &[f64]) -> (Vec<f64>, Vec<usize>) {
    let width = steps.len();
    let mut out = inputs.to_vec();
    let mut is_slowed = vec![false; width];
    for e in width..out.len() {
        let (before, step) = (out[e - width], steps[e % width]);
        if (out[e] - before).abs() > step * (1.0 + ROUNDING) {
            out[e] = out[e].clamp(before - step, before + step);
            is_slowed[e % width] = true;
        }
    }
    (out, (0..width).filter(|i| is_slowed[*i]).collect())
}

/// 1/θ².
fn weights(vessel: &Vessel, parameters: &[f64]) -> Result<Vec<f64>, campaign::Refusal> {
    let known: BTreeMap<&str, f64> = vessel.model.parameter_names().zip(parameters.iter().copied()).collect();
    match known.iter().find(|(_, theta)| **theta == 0.0) {
        None => Ok(parameters.iter().map(|theta| 1.0 / (theta * theta)).collect()),
        Some((name, _)) => Err(campaign::Refusal::Vessel(Invalid::new(
            format!("parameter `{name}`"),
            "0",
            "a value other than 0 that its error can be relative to",
            "give it another value, or leave the term out",
        ))),
    }
}
