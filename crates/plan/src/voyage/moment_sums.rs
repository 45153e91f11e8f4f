//! The information of a segment of a trajectory about the parameters: sums of lifted moments per degree of
//! freedom, of a ship with forces that of her free numbers.

use std::collections::BTreeMap;

use estimation::{Simulated, summed_information};
use numerics::{LANES, Lane};
use refusal::Invalid;
use regression::{Batch, Noise, moments};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::simulate_one;
use ship::model::Vessel;
use trial::Piece;
use trial::moments::Prediction;

use super::error::VoyageError;
use super::task::Brief;

/// Σ φ̃ ζ̃ᵀ per degree of freedom, row-major; of a ship with forces one matrix Σ SᵀWS. The sums of two segments add up to
/// those of both.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct MomentSums {
    degrees: Vec<Vec<f64>>,
    /// 1/σ² of every free number of a ship with forces by its prior, which counts once for the whole trial; 0 without one.
    /// Empty of terms per sample.
    prior: Vec<f64>,
}

/// What the sums of a vessel are made with.
#[derive(Clone, Debug)]
pub(super) struct Summing<'a> {
    vessel: &'a Vessel,
    /// The noise that errors of whole segments are weighed by; none where sums are of instruments.
    noise: Option<Noise>,
}

impl Brief {
    /// How the information of its vessel is summed.
    pub(super) fn summing(&self) -> Result<Summing<'_>, Invalid> {
        let vessel = &self.vessel;
        let noise = match (vessel.model.has_regressors(), self.task.measurement) {
            (true, None) => None,
            (false, Some(assumed)) => {
                let noise = Noise { measurement: assumed.std(), current: 0.0 };
                Prediction::check(&vessel.model, &noise)?;
                Some(noise)
            }
            (false, None) => {
                let expected = "the noise of the logged u, v and r, by which a ship with forces is estimated";
                let remedy = "add `std_u_m_s`, `std_v_m_s` and `std_r_rad_s`, as campaign.toml has them";
                return Err(Invalid::new("[measurement]", "none", expected, remedy));
            }
            (true, Some(_)) => {
                let both = "noise of logs, and a vessel with terms per sample";
                let expected = "it of a ship with forces alone";
                return Err(Invalid::new("[measurement]", both, expected, "leave it out"));
            }
        };
        Ok(Summing { vessel, noise })
    }
}

impl Summing<'_> {
    /// Whether segments are simulated from a start that is known, each by itself.
    pub(super) fn is_of_segments(&self) -> bool {
        self.noise.is_some()
    }

    /// For N samples: `inputs` N × inputs, `states` (N+1) × 3 through the water. Instruments and derivatives come from the
    /// nominal model with the same inputs and initial state. A ship with forces whose simulation diverges tells nothing.
    pub(super) fn of(&self, inputs: &[f64], states: &[f64]) -> MomentSums {
        let exogenous = self.vessel.model.undisturbed(inputs);
        let initial = [states[0], states[1], states[2]];
        let Some(noise) = &self.noise else { return self.lifted(initial, states, &exogenous) };
        let (model, theta) = (&self.vessel.model, &self.vessel.nominal);
        let known = |deviation: Option<f64>| deviation.map_or(0.0, |sigma| 1.0 / (sigma * sigma));
        let prior: Vec<f64> = model.prior_deviations().into_iter().map(known).collect();
        let nothing = || vec![0.0; prior.len() * prior.len()];
        let run = Simulated { theta, initial, exogenous: &exogenous };
        let information = summed_information(model, &run, noise).unwrap_or_else(nothing);
        MomentSums { degrees: vec![information], prior }
    }

    fn lifted(&self, initial: [f64; 3], states: &[f64], exogenous: &[f64]) -> MomentSums {
        let vessel = self.vessel;
        let instruments = simulate_one(&vessel.model, &vessel.nominal, initial, exogenous);
        let lanes = |values: &[f64]| values.iter().map(|v| Lane::splat(*v)).collect::<Vec<_>>();
        let (measured, instruments, exogenous) = (lanes(states), lanes(&instruments), lanes(exogenous));
        let batch = Batch {
            model: &vessel.model,
            measured: &measured,
            instrument_states: &instruments,
            exogenous: &exogenous,
            instrument_exogenous: &exogenous,
            segments: [&[0]; LANES],
        };
        let sums = moments(&batch).swap_remove(0);
        let scale = sums.samples as f64;
        let degrees = sums.matrices.into_iter().map(|m| m.into_iter().map(|x| x * scale).collect()).collect();
        MomentSums { degrees, prior: Vec::new() }
    }

    /// For a piece of a maneuver run by the nominal model in still water.
    pub(super) fn of_piece(&self, piece: &Piece) -> MomentSums {
        let exogenous = self.vessel.model.undisturbed(&piece.inputs);
        let initial = [piece.speed_m_s, 0.0, 0.0];
        if self.is_of_segments() {
            return self.of(&piece.inputs, &initial);
        }
        let states = simulate_one(&self.vessel.model, &self.vessel.nominal, initial, &exogenous);
        self.of(&piece.inputs, &states)
    }
}

impl MomentSums {
    /// Adds `times` of another.
    pub(super) fn add(&mut self, other: &Self, times: f64) {
        if self.degrees.is_empty() {
            self.degrees = other.degrees.iter().map(|m| vec![0.0; m.len()]).collect();
            self.prior = other.prior.clone();
        }
        for (matrix, other) in self.degrees.iter_mut().zip(&other.degrees) {
            matrix.iter_mut().zip(other).for_each(|(a, b)| *a += times * b);
        }
    }

    /// The sums with what the priors know.
    fn with_prior(&self) -> Vec<Vec<f64>> {
        let mut all = self.degrees.clone();
        for matrix in &mut all {
            let n = matrix.len().isqrt();
            self.prior.iter().enumerate().for_each(|(i, known)| matrix[i * n + i] += known);
        }
        all
    }

    /// Σ over degrees of freedom of log|det|, with the priors; −∞ where a direction is not excited.
    pub(super) fn log_det(&self) -> f64 {
        // Many numbers that are hardly told apart have small determinants, and are determined all the same.
        let least = if self.prior.is_empty() { LEAST } else { LEAST_OF_FORCES * self.prior.len() as f64 };
        let one = |m: &Vec<f64>| {
            let n = m.len().isqrt();
            // Rows and columns are scaled first: forces and speeds differ by many powers of ten.
            let size: Vec<f64> = (0..n).map(|i| m[i * n + i].abs().sqrt()).collect();
            let mut scaled: Vec<f64> = (0..n * n).map(|k| m[k] / (size[k / n] * size[k % n])).collect();
            let shift: f64 = size.iter().map(|s| 2.0 * libm::log(*s)).sum();
            match numerics::log_det(n, &mut scaled) {
                Some(det) if det.log_abs.is_finite() && det.log_abs > least => det.log_abs + shift,
                _ => f64::NEG_INFINITY,
            }
        };
        if self.degrees.is_empty() { f64::NEG_INFINITY } else { self.with_prior().iter().map(one).sum() }
    }

    /// tr(M⁻¹ M_other)/p over all degrees of freedom: the share of `other` in this sum, if it is part of it. With priors M has
    /// them, and p is tr(M⁻¹ M_own) of what was sailed alone. `None` where a direction is not excited.
    fn share_of(&self, other: &Self) -> Option<f64> {
        if !self.log_det().is_finite() {
            return None;
        }
        let whole = if self.prior.is_empty() { self.dimension() as f64 } else { self.trace_with(self)? };
        Some(self.trace_with(other)? / whole)
    }

    /// tr(M⁻¹ M_other) with the priors in M.
    fn trace_with(&self, other: &Self) -> Option<f64> {
        let all = self.with_prior();
        let traces = all.iter().zip(&other.degrees).map(|(matrix, other)| {
            let n = matrix.len().isqrt();
            // Scaled as for the determinant: that leaves the trace as it is.
            let size: Vec<f64> = (0..n).map(|i| matrix[i * n + i].abs().sqrt()).collect();
            let scaled =
                |m: &[f64]| -> Vec<f64> { (0..n * n).map(|k| m[k] / (size[k / n] * size[k % n])).collect() };
            let (mut a, mut solved) = (scaled(matrix), scaled(other));
            numerics::solve(n, &mut a, &mut solved)?;
            Some(solved.iter().step_by(n + 1).sum::<f64>())
        });
        traces.sum()
    }

    /// Number of rows of all degrees of freedom.
    pub(super) fn dimension(&self) -> usize {
        self.degrees.iter().map(|m| m.len().isqrt()).sum()
    }
}

/// Least logarithm of the determinant of a matrix that is scaled to ones on its diagonal, of terms per sample; of a ship
/// with forces for each number.
const LEAST: f64 = -60.0;
const LEAST_OF_FORCES: f64 = -10.0;

/// The planned information of the maneuvers that are done, of that of all in the plan, by the D-criterion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gathered {
    /// Σ of the shares of what is done: 1 where all is, whatever priors know. Absent where the whole plan leaves a direction unexcited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
    /// exp((log|det| of what is done − that of the plan)/p): 0 until every direction is excited, 1 where all is done.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub efficiency: Option<f64>,
    /// p.
    pub dimension: u64,
    /// Every maneuver of the plan.
    pub maneuvers: Vec<GatheredManeuver>,
}

/// A maneuver of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GatheredManeuver {
    /// Its name.
    pub name: String,
    /// Its uses in the plan.
    pub planned: u64,
    /// Those that are done.
    pub done: u64,
    /// tr(M⁻¹ M_q)/p of all its uses in the plan, with the information M of all maneuvers: what the D-criterion grows by, to
    /// first order. With priors, which M then has, p is tr(M⁻¹ M_q) summed over the maneuvers. Absent as above.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
}

impl Brief {
    /// The planned information of `done` uses of maneuvers, of that of the `planned` ones: each use adds the moments of its
    /// piece, by the nominal model in still water.
    ///
    /// # Errors
    /// A planned maneuver that the task or the dictionary lacks.
    pub fn gathered(
        &self,
        planned: &BTreeMap<String, u64>,
        done: &BTreeMap<String, u64>,
    ) -> Result<Gathered, VoyageError> {
        let (wanted, summing) = (self.wanted()?, self.summing()?);
        let mut summed: Vec<(MomentSums, GatheredManeuver)> = Vec::new();
        for (name, count) in planned {
            let Some(super::Wanted { piece, .. }) = wanted.iter().find(|one| one.piece.maneuver == *name)
            else {
                let known = wanted.iter().map(|one| one.piece.maneuver.clone()).collect();
                return Err(VoyageError::UnknownManeuver { name: name.clone(), known });
            };
            let done = done.get(name).copied().unwrap_or(0);
            let maneuver = GatheredManeuver { name: name.clone(), planned: *count, done, share: None };
            summed.push((summing.of_piece(piece), maneuver));
        }
        Ok(of_pieces(summed))
    }
}

/// Of the moments of one use of each maneuver.
fn of_pieces(mut gathered: Vec<(MomentSums, GatheredManeuver)>) -> Gathered {
    let (mut all, mut so_far) = (MomentSums::default(), MomentSums::default());
    for (moments, maneuver) in &gathered {
        all.add(moments, maneuver.planned as f64);
        so_far.add(moments, maneuver.done as f64);
    }
    for (moments, maneuver) in &mut gathered {
        maneuver.share = all.share_of(moments).map(|share| share * maneuver.planned as f64);
    }
    let part = |one: &GatheredManeuver| Some(one.share? * one.done as f64 / one.planned.max(1) as f64);
    let efficiency = libm::exp((so_far.log_det() - all.log_det()) / all.dimension() as f64);
    Gathered {
        share: gathered.iter().map(|(_, maneuver)| part(maneuver)).sum(),
        efficiency: Some(efficiency).filter(|ratio| ratio.is_finite()),
        dimension: all.dimension() as u64,
        maneuvers: gathered.into_iter().map(|(_, maneuver)| maneuver).collect(),
    }
}
