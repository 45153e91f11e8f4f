//! What errors the estimate of an experiment foretells, from the information of the whole sequence.

use std::collections::BTreeMap;

use design::Candidates;
use estimation::pooled::{Covariance, Uncertain};
use estimation::{OutputInformation, Simulated, output_informations, parameter_error};
use numerics::lanes::interleave;
use numerics::statistics::median;
use numerics::{LANES, congruence, dot, scaled_inverse, times};
use regression::{Batch, MeanRemoval, Noise, meat, moments};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{Streams, check_diverged, simulate_one};
use ship::model::Source;

use super::{Arranging, TrialKind, generated_limits};
use crate::moments::{Estimated, Expected, leading};

/// Errors that estimates of many trials of the same experiment have: medians over estimates drawn from their predicted
/// distribution, to first order in their errors. Where the true parameters are known, priors pull every estimate the same way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Foretold {
    /// Median parameter error, as validations define it.
    pub parameter_error: f64,
    /// Median simulation error over the validation maneuvers; null without some.
    pub simulation_error: Option<f64>,
    /// How many estimates were drawn.
    pub draws: u32,
}

/// What a trial promises.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Promised {
    /// Which trial.
    pub trial: TrialKind,
    /// Its errors; null where it does not tell every parameter.
    pub errors: Option<Foretold>,
}

impl Promised {
    /// By what trials are compared: the product of both errors, infinite without any.
    pub(super) fn product(&self) -> f64 {
        let product = |errors: Foretold| errors.parameter_error * errors.simulation_error.unwrap_or(1.0);
        self.errors.map_or(f64::INFINITY, product)
    }
}

/// Estimates that are drawn, and the seed of their random numbers.
const DRAWS: (u32, u64) = (4000, 1);

impl Arranging<'_> {
    /// Of an output-error estimate of the experiment `run`; `None` of other estimates, or where its information is singular.
    pub(super) fn foretold(&self, run: PlannedRun) -> Option<Foretold> {
        (self.estimated == Estimated::OutputError).then_some(())?;
        // Not of what is left out of the information.
        self.moments.disturbances.as_ref().filter(|expected| !expected.lasting_current_left_out)?;
        let model = self.moments.output_error.as_ref()?;
        let (g, rows, n) = (model.g.as_deref().unwrap_or_default(), &model.rows, model.rows.len());
        let samples = run.1.len() / self.vessel.model.exogenous().max(1);
        let theta = self.ordered(&model.parameters)?;
        let place = |name: &String| self.vessel.model.parameter_names().position(|other| other == name);
        let places: Vec<Option<usize>> = rows.iter().map(place).collect();
        let Information { information, mut meat } = self.informed(&[run])?.pop()??;
        let inverse = scaled_inverse(n, &information)?;
        let mut center = theta.clone();
        if let Some(prior) = self.moments.prior.as_ref().filter(|_| model.simulated_with == Source::Value) {
            // The ship is known: what priors say of her is off by as much as it is, in every trial.
            let mut known = vec![0.0; n * n];
            prior.add_to(&mut known, rows, samples as f64);
            meat.iter_mut().zip(&known).for_each(|(entry, known)| *entry -= known);
            let off = |place: &Option<usize>| place.map_or(0.0, |i| self.vessel.nominal[i] - theta[i]);
            let pulled = times(&inverse, &times(&known, &places.iter().map(off).collect::<Vec<_>>()));
            places
                .iter()
                .zip(pulled)
                .filter_map(|(place, pull)| Some(((*place)?, pull)))
                .for_each(|(i, pull)| center[i] += pull);
        }
        let entries = congruence(n, &inverse, &meat);
        let entries = entries.into_iter().map(|entry| entry / samples as f64).collect();
        let covariance = Covariance { joint: true, names: rows.clone(), entries, parts: None };
        let estimates = Uncertain::new(self.vessel, center, &covariance)?;
        let streams = Streams::new(DRAWS.1, "foretold");
        let errors = (0..DRAWS.0).map(|draw| {
            let drawn = estimates.drawn(&streams, draw);
            let off: Vec<f64> = places.iter().map(|at| at.map_or(0.0, |i| drawn[i] - theta[i])).collect();
            let square: f64 = times(g, &off).iter().zip(&off).map(|(slope, off)| slope * off).sum();
            (parameter_error(&drawn, &theta), square.max(0.0).sqrt())
        });
        let (parameters, simulations): (Vec<f64>, Vec<f64>) = errors.unzip();
        Some(Foretold {
            parameter_error: median(parameters)?,
            simulation_error: model.g.as_ref().and(median(simulations)),
            draws: DRAWS.0,
        })
    }
}

/// Where a run begins, and its rows.
type PlannedRun = ([f64; 3], Vec<f64>);

/// F and the meat of an estimate's covariance, n × n, per sample, with what is known before.
pub(super) struct Information {
    pub information: Vec<f64>,
    pub meat: Vec<f64>,
}

/// Penalty in the criterion's value for exceeding a limit by 100 %.
const PENALTY: f64 = 20.0;

impl Arranging<'_> {
    /// Values of up to [`LANES`] runs of equal length.
    pub(super) fn group(&self, runs: &[PlannedRun]) -> Vec<f64> {
        let model = &self.vessel.model;
        let undisturbed: Vec<PlannedRun> =
            runs.iter().map(|run| (run.0, model.undisturbed(&run.1))).collect();
        let penalty = |i: usize| {
            let Some(limits) = generated_limits(self.generator) else { return 0.0 };
            let states = simulate_one(model, self.generator.parameters(), runs[i].0, &undisturbed[i].1);
            let exceeded = limits.exceeded(model, &states, &runs[i].1, self.vessel.sample_rate_hz);
            exceeded.map_or(0.0, |e| PENALTY * (e.found / e.allowed - 1.0))
        };
        let values = match self.estimated {
            Estimated::Iv(removal) => self.instrumental(&undisturbed, removal),
            Estimated::OutputError => self.output_error(&undisturbed),
        };
        let judged = |(i, value): (usize, Option<f64>)| value.map_or(f64::NEG_INFINITY, |v| v - penalty(i));
        values.into_iter().enumerate().map(judged).collect()
    }

    fn noise(&self) -> Option<Noise> {
        self.moments.disturbances.as_ref().map(Expected::noise)
    }

    /// θ in the model's order.
    fn ordered(&self, by_name: &BTreeMap<String, f64>) -> Option<Vec<f64>> {
        self.vessel.model.parameter_names().map(|name| by_name.get(name).copied()).collect()
    }

    fn output_error(&self, runs: &[PlannedRun]) -> Vec<Option<f64>> {
        let Some(known) = self.informed(runs) else { return vec![None; runs.len()] };
        known.into_iter().map(|known| self.both_errors(&known?)).collect()
    }

    fn judged(&self, Information { information: f, meat }: &Information) -> Option<f64> {
        self.judge(vec![f.len().isqrt()], f, Some(meat))
    }

    /// The criterion, joined by the error of free runs where both count, each in time that it is worth.
    fn both_errors(&self, known: &Information) -> Option<f64> {
        let value = self.judged(known)?;
        let Some(g) = self.weights().filter(|_| self.is_joint()) else { return Some(value) };
        let n = known.information.len().isqrt();
        let covariance = congruence(n, &scaled_inverse(n, &known.information)?, &known.meat);
        let error = dot(g, &covariance);
        (error > 0.0).then(|| value / self.criterion.degree() - libm::log(error))
    }

    /// What the values of sequences are divided by for the time that they are worth.
    pub(super) fn degree(&self) -> f64 {
        if self.is_joint() { 2.0 } else { self.criterion.degree() }
    }

    /// G of the validation maneuvers.
    fn weights(&self) -> Option<&[f64]> {
        self.moments.output_error.as_ref()?.g.as_deref()
    }

    /// Whether sequences are judged by the errors of parameters and of predictions.
    pub(super) fn is_joint(&self) -> bool {
        self.estimated == Estimated::OutputError && self.weights().is_some()
    }

    /// The criterion's own value of a run.
    pub(super) fn criterion_of(&self, run: &PlannedRun) -> Option<f64> {
        if !self.is_joint() {
            return None;
        }
        self.judged(&self.informed(std::slice::from_ref(run))?.pop()??)
    }

    /// What output-error estimates of experiments of equal length know, per sample.
    fn informed(&self, runs: &[PlannedRun]) -> Option<Vec<Option<Information>>> {
        let (noise, expected) = (self.noise()?, self.moments.output_error.as_ref()?);
        let (model, theta) = (&self.vessel.model, self.ordered(&expected.parameters)?);
        let all = runs.iter().map(|run| Simulated { theta: &theta, initial: run.0, exogenous: &run.1 });
        let predicted = output_informations(model, &all.collect::<Vec<_>>(), &noise);
        let of = |p: OutputInformation| Information { meat: p.middle(), information: p.information };
        let mut all: Vec<Option<Information>> =
            predicted.into_iter().map(|predicted| predicted.map(of)).collect();
        if let (Some(prior), Some(run)) = (&self.moments.prior, runs.first()) {
            // Priors count once for the experiment.
            let samples = (run.1.len() / model.exogenous().max(1)) as f64;
            for sums in all.iter_mut().flatten() {
                prior.add_to(&mut sums.information, &expected.rows, samples);
                prior.add_to(&mut sums.meat, &expected.rows, samples);
            }
        }
        Some(all)
    }

    fn instrumental(&self, runs: &[PlannedRun], removal: MeanRemoval) -> Vec<Option<f64>> {
        let model = &self.vessel.model;
        let theta = match &self.moments.disturbances {
            Some(expected) => self.ordered(&expected.parameters),
            None => Some(self.generator.parameters().to_vec()),
        };
        let Some(theta) = theta else { return vec![None; runs.len()] };
        let simulated = |theta: &[f64]| -> Vec<Vec<f64>> {
            runs.iter().map(|(initial, rows)| simulate_one(model, theta, *initial, rows)).collect()
        };
        let (truth, nominal) = (simulated(&theta), simulated(&self.vessel.nominal));
        let lanes = |all: &[Vec<f64>]| interleave(&all.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let rows: Vec<&[f64]> = runs.iter().map(|run| &run.1[..]).collect();
        let (measured, instrument_states, inputs) = (lanes(&truth), lanes(&nominal), interleave(&rows));
        let batch = Batch {
            model,
            measured: &measured,
            instrument_states: &instrument_states,
            exogenous: &inputs,
            instrument_exogenous: &inputs,
            segments: [&[0]; LANES],
        };
        let information = moments(&batch);
        let middles = self.noise().map(|noise| meat(&batch, &theta, &noise));
        let sizes: Vec<usize> = model.degrees.iter().map(|d| d.terms.len() + 1).collect();
        let kept: Vec<usize> =
            sizes.iter().map(|n| if removal == MeanRemoval::Complete { *n } else { n - 1 }).collect();
        let of = |i: usize| {
            let finite = |states: &[f64]| check_diverged(states.iter().copied()).is_none();
            if !(finite(&truth[i]) && finite(&nominal[i])) {
                return None;
            }
            let cut = |matrices: &[Vec<f64>]| -> Vec<f64> {
                let all = matrices.iter().zip(&sizes).zip(&kept);
                all.flat_map(|((matrix, n), kept)| leading(matrix, *n, *kept)).collect()
            };
            let meat = middles.as_ref().map(|m| cut(&m[i]));
            self.judge(kept.clone(), &cut(&information[i].matrices), meat.as_deref())
        };
        (0..runs.len()).map(of).collect()
    }

    /// The criterion of one experiment.
    fn judge(&self, dimensions: Vec<usize>, information: &[f64], meat: Option<&[f64]>) -> Option<f64> {
        let one = |entries: &[f64]| {
            let mut candidates = Candidates::new(dimensions.clone());
            candidates.push(entries).ok().map(|()| candidates)
        };
        let (information, meat) = (one(information)?, meat.and_then(one));
        self.criterion.of_experiment(self.dictionary, &information, meat.as_ref())
    }
}
