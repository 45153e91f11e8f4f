//! The criterion of a whole experiment, with the state carried over from maneuver to maneuver.

use std::collections::BTreeMap;

use design::Candidates;
use engine::{check_diverged, simulate_one};
use identification::output_information;
use numerics::LANES;
use numerics::lanes::interleave;
use regression::{Batch, MeanRemoval, Noise, middle, moments};

use super::{Arranging, generated_limits};
use crate::moments::{Estimated, Expected, ForcesPrediction, OutputErrorMoments, leading};

/// Penalty in the criterion's value for exceeding a limit by 100 %.
const PENALTY: f64 = 20.0;

impl Arranging<'_> {
    /// Values of up to [`LANES`] runs of equal length.
    pub(super) fn group(&self, runs: &[([f64; 3], Vec<f64>)]) -> Vec<f64> {
        let model = &self.vessel.model;
        let exogenous: Vec<Vec<f64>> = runs.iter().map(|(_, inputs)| model.undisturbed(inputs)).collect();
        let penalty = |i: usize| {
            let Some(limits) = generated_limits(self.generator) else { return 0.0 };
            let states = simulate_one(model, self.generator.parameters(), runs[i].0, &exogenous[i]);
            let exceeded = limits.exceeded(model, &states, &runs[i].1, self.vessel.sample_rate_hz);
            exceeded.map_or(0.0, |e| PENALTY * (e.found / e.allowed - 1.0))
        };
        let values = match self.estimated {
            Estimated::Iv(removal) => self.instrumental(runs, &exogenous, removal),
            Estimated::OutputError { current } => {
                (0..runs.len()).map(|i| self.output_error(runs[i].0, &exogenous[i], current)).collect()
            }
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

    fn output_error(&self, initial: [f64; 3], exogenous: &[f64], current: bool) -> Option<f64> {
        let noise = self.noise()?;
        let theta = self.ordered(&self.moments.output_error.as_ref()?.parameters)?;
        let noise = if current { noise } else { Noise { current: 0.0, ..noise } };
        if self.vessel.model.forces.is_some() {
            return self.physical(theta, initial, exogenous, noise);
        }
        let found = output_information(&self.vessel.model, &theta, initial, exogenous, &noise)?;
        self.judge(vec![found.information.len().isqrt()], &found.information, Some(&found.middle()))
    }

    /// Of a ship with forces, whose priors count once for the experiment.
    fn physical(&self, theta: Vec<f64>, initial: [f64; 3], exogenous: &[f64], noise: Noise) -> Option<f64> {
        let own = ForcesPrediction::with(self.vessel, theta, noise).ok()?;
        let samples = exogenous.len() / self.vessel.model.exogenous().max(1);
        let OutputErrorMoments { f: mut information, p, .. } = own.of_experiment(initial, exogenous)?;
        let known = own.prior_information();
        let n = known.len();
        (0..n).for_each(|i| information[i * n + i] += known[i] / samples.max(1) as f64);
        let current = p.unwrap_or_else(|| vec![0.0; n * n]);
        let middle: Vec<f64> = information.iter().zip(&current).map(|(own, more)| own + more).collect();
        self.judge(vec![n], &information, Some(&middle))
    }

    fn instrumental(
        &self,
        runs: &[([f64; 3], Vec<f64>)],
        exogenous: &[Vec<f64>],
        removal: MeanRemoval,
    ) -> Vec<Option<f64>> {
        let model = &self.vessel.model;
        let theta = match &self.moments.disturbances {
            Some(expected) => self.ordered(&expected.parameters),
            None => Some(self.generator.parameters().to_vec()),
        };
        let Some(theta) = theta else { return vec![None; runs.len()] };
        let simulated = |theta: &[f64]| -> Vec<Vec<f64>> {
            let run = |i: usize| simulate_one(model, theta, runs[i].0, &exogenous[i]);
            (0..runs.len()).map(run).collect()
        };
        let (own, nominal) = (simulated(&theta), simulated(&self.vessel.nominal));
        let lanes = |rows: &[Vec<f64>]| interleave(&rows.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let (measured, instrument_states, inputs) = (lanes(&own), lanes(&nominal), lanes(exogenous));
        let batch = Batch {
            model,
            measured: &measured,
            instrument_states: &instrument_states,
            exogenous: &inputs,
            instrument_exogenous: &inputs,
            segments: [&[0]; LANES],
        };
        let found = moments(&batch);
        let middles = self.noise().map(|noise| middle(&batch, &theta, &noise));
        let sizes: Vec<usize> = model.degrees.iter().map(|d| d.terms.len() + 1).collect();
        let kept: Vec<usize> =
            sizes.iter().map(|n| if removal == MeanRemoval::Complete { *n } else { n - 1 }).collect();
        let of = |i: usize| {
            let finite = |states: &[f64]| check_diverged(states.iter().copied()).is_none();
            if !(finite(&own[i]) && finite(&nominal[i])) {
                return None;
            }
            let cut = |matrices: &[Vec<f64>]| -> Vec<f64> {
                let all = matrices.iter().zip(&sizes).zip(&kept);
                all.flat_map(|((matrix, n), kept)| leading(matrix, *n, *kept)).collect()
            };
            let middle = middles.as_ref().map(|m| cut(&m[i]));
            self.judge(kept.clone(), &cut(&found[i].matrices), middle.as_deref())
        };
        (0..runs.len()).map(of).collect()
    }

    /// The criterion of one experiment.
    fn judge(&self, dimensions: Vec<usize>, information: &[f64], middle: Option<&[f64]>) -> Option<f64> {
        let one = |entries: &[f64]| {
            let mut candidates = Candidates::new(dimensions.clone());
            candidates.push(entries).ok().map(|()| candidates)
        };
        let (information, middle) = (one(information)?, middle.and_then(one));
        self.criterion.of_experiment(self.dictionary, &information, middle.as_ref())
    }
}
