//! The experiment that refinement begins with.

use std::collections::BTreeMap;

use estimation::output_information;
use estimation::refine::TraceCriterion;
use maneuver::Generator;
use refusal::Invalid;
use regression::Noise;
use ship::engine::{check_diverged, simulate_one};
use ship::model::{Source, Vessel};

use crate::campaign::{Parts, Refusal};
use crate::moments::rows;

/// Inputs, initial state and the data to evaluate them.
#[derive(Clone, Debug)]
pub struct Start {
    /// N × inputs.
    pub inputs: Vec<f64>,
    /// u, v \[m/s\], r \[rad/s\].
    pub initial: [f64; 3],
    /// Simulated states, (N+1) × 3.
    pub states: Vec<f64>,
    /// Which parameters it is simulated with, and errors are relative to: the true ones if the vessel has
    /// them.
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

impl Start {
    /// The experiment of `plan`: maneuvers of `generator` and their samples.
    ///
    /// # Errors
    /// A maneuver that the model cannot hold; parameters of zero; a simulation that diverges.
    pub fn new(
        vessel: &Vessel,
        generator: &Generator,
        plan: &[(usize, usize)],
        noise: Noise,
    ) -> Result<Self, Refusal> {
        let mut parts = Parts::default();
        parts.make(generator, plan).map_err(Refusal::Dictionary)?;
        let (initial, inputs) = parts.joined(plan);
        let source = vessel.best_known();
        let parameters = vessel.parameters(source).map_err(Refusal::Vessel)?;
        let weights = weights(vessel, &parameters)?;
        let states = states(vessel, &parameters, initial, &inputs)?;
        Ok(Self { inputs, initial, states, source, parameters, weights, noise, slowed: Vec::new() })
    }

    /// The experiment with inputs that change by no more than `steps` from sample to sample, by input: over the whole of it, as
    /// inputs jump where one maneuver ends and the next begins.
    ///
    /// # Errors
    /// A simulation that diverges.
    pub fn within_rates(self, vessel: &Vessel, steps: &[f64]) -> Result<Self, Refusal> {
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
        TraceCriterion {
            model: &vessel.model,
            parameters: &self.parameters,
            weights: &self.weights,
            noise: self.noise,
            initial: self.initial,
        }
    }

    /// The parameter with the least information in the experiment.
    pub(super) fn weakest(&self, vessel: &Vessel) -> String {
        let exogenous = vessel.model.undisturbed(&self.inputs);
        let found =
            output_information(&vessel.model, &self.parameters, self.initial, &exogenous, &self.noise);
        let f = found.map(|found| found.information).unwrap_or_default();
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
///
/// # Errors
/// A simulation that diverges.
fn states(
    vessel: &Vessel,
    parameters: &[f64],
    initial: [f64; 3],
    inputs: &[f64],
) -> Result<Vec<f64>, Refusal> {
    let states = simulate_one(&vessel.model, parameters, initial, &vessel.model.undisturbed(inputs));
    match check_diverged(states.iter().copied()) {
        Some(at) => Err(Refusal::Vessel(at.invalid("the design's experiment", vessel.sample_rate_hz))),
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
fn weights(vessel: &Vessel, parameters: &[f64]) -> Result<Vec<f64>, Refusal> {
    let by_name: BTreeMap<&str, f64> =
        vessel.model.parameter_names().zip(parameters.iter().copied()).collect();
    match by_name.iter().find(|(_, theta)| **theta == 0.0) {
        None => Ok(parameters.iter().map(|theta| 1.0 / (theta * theta)).collect()),
        Some((name, _)) => Err(Refusal::Vessel(Invalid::new(
            format!("parameter `{name}`"),
            "0",
            "a value other than 0 that its error can be relative to",
            "give it another value, or leave the term out",
        ))),
    }
}
