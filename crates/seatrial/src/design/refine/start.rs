//! The experiment that refinement begins with.

use std::collections::BTreeMap;
use std::path::Path;

use identification::refine::TraceCriterion;
use identification::{Noise, output_information};
use vessel::{Generator, Realized, Source, Vessel, check_diverged, simulate_one};

use super::Refine;
use crate::design::noise::lasting;
use crate::design::output_error::{SimulateWith, rows};
use crate::failure::Failure;
use crate::simulate::campaign::{CampaignFiles, optimized_plan};
use crate::simulate::{diverged, exogenous, refuse_endless};
use study::campaign_file::CampaignFile;
use study::documents::DesignDocument;

/// Inputs, initial state and what they are judged by.
pub struct Start {
    /// N × inputs.
    pub inputs: Vec<f64>,
    /// u, v \[m/s\], r \[rad/s\].
    pub initial: [f64; 3],
    /// Of the simulation, (N+1) × 3.
    pub states: Vec<f64>,
    /// The parameters that it is simulated with, and their name.
    pub parameters: Vec<f64>,
    pub with: SimulateWith,
    /// Weight of every parameter's variance, and the name of the parameters that errors are relative to.
    pub weights: Vec<f64>,
    pub relative_to: SimulateWith,
    noise: Noise,
}

impl Start {
    /// The experiment that a campaign would make of the design.
    ///
    /// # Errors
    /// A design of other maneuvers; parameters that are missing or zero; disturbances that no covariance is predicted for; a
    /// simulation that diverges.
    pub fn new(
        a: &Refine,
        vessel: &Vessel,
        generator: &Generator,
        config: &CampaignFile,
        design: &DesignDocument,
    ) -> Result<Self, Failure> {
        let samples = vessel.samples(config.duration_s);
        refuse_endless(&a.campaign, "`duration_s`", samples)?;
        let files = CampaignFiles {
            vessel: &a.vessel,
            dictionary: &a.dictionary,
            campaign: &a.campaign,
            design: &a.design,
        };
        let names: Vec<String> = generator.maneuvers().iter().map(|m| m.name.clone()).collect();
        let plan = optimized_plan(&files, &names, design, samples)?;
        let realize = |(q, n): &(usize, usize)| generator.realize(*q, *n);
        let parts: Vec<Realized> = plan
            .iter()
            .map(realize)
            .collect::<Result<_, _>>()
            .map_err(|e| Failure::invalid(&a.dictionary, &e))?;
        let initial = parts.first().map_or([0.0; 3], |part| part.initial);
        let inputs: Vec<f64> = parts.into_iter().flat_map(|part| part.inputs).collect();
        let known = vessel.value.iter().all(Option::is_some);
        let with = a.simulate_with.unwrap_or(if known { SimulateWith::Value } else { SimulateWith::Nominal });
        let parameters = named(&a.vessel, vessel, with)?;
        let relative_to = a.relative_to.unwrap_or(with);
        let weights = weights(&a.vessel, vessel, relative_to)?;
        let states = simulate_one(&vessel.model, &parameters, initial, &exogenous(&vessel.model, &inputs));
        if let Some(at) = check_diverged(states.iter().copied()) {
            return Err(diverged(&a.vessel, "the design's experiment", at));
        }
        let noise = noise(&a.campaign, config)?;
        Ok(Self { inputs, initial, states, parameters, with, weights, relative_to, noise })
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

    /// Says which parameter the start tells least about.
    pub fn not_identifiable(&self, a: &Refine, vessel: &Vessel) -> Failure {
        let exogenous = exogenous(&vessel.model, &self.inputs);
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
        let name = nothing.or_else(strongest).map_or_else(String::new, |i| rows(&vessel.model)[i].clone());
        Failure::NoAnswer(format!(
            "{}: the design's experiment: found one that does not tell `{name}` from the other parameters, expected a start that \
             excites all; begin with another design",
            a.design.display()
        ))
    }
}

fn named(file: &Path, vessel: &Vessel, which: SimulateWith) -> Result<Vec<f64>, Failure> {
    let source = if which == SimulateWith::Value { Source::Value } else { Source::Nominal };
    vessel.parameters(source).map_err(|e| Failure::invalid(file, &e))
}

/// 1/θ².
fn weights(file: &Path, vessel: &Vessel, relative_to: SimulateWith) -> Result<Vec<f64>, Failure> {
    let parameters = named(file, vessel, relative_to)?;
    let by_name: BTreeMap<&str, f64> =
        vessel.model.parameter_names().zip(parameters.iter().copied()).collect();
    match by_name.iter().find(|(_, theta)| **theta == 0.0) {
        None => Ok(parameters.iter().map(|theta| 1.0 / (theta * theta)).collect()),
        Some((name, _)) => Err(Failure::refuse(
            file,
            &format!("parameter `{name}`"),
            "0",
            "a value other than 0 that its error can be relative to",
            match relative_to {
                SimulateWith::Nominal => "take --relative-to value, or give it a nominal value",
                SimulateWith::Value => "take --relative-to nominal, or leave the term out",
            },
        )),
    }
}

fn noise(file: &Path, config: &CampaignFile) -> Result<Noise, Failure> {
    let noise = config.noise().ok_or_else(|| lasting(file, "name a campaign with one of these"))?;
    if noise.current == 0.0 && noise.measurement == [0.0; 3] {
        let expected = "errors of measurement or a current, without which every experiment is as good";
        return Err(Failure::refuse(file, "`measurement`", "no disturbance at all", expected, "state them"));
    }
    Ok(noise)
}
