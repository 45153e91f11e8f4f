//! The information of a segment of a trajectory about the parameters: sums of lifted moments per degree of
//! freedom.

use engine::simulate_one;
use model::Vessel;
use numerics::{LANES, Lane};
use regression::{Batch, moments};

use crate::Piece;

/// Σ φ̃ ζ̃ᵀ per degree of freedom, row-major. The sums of two segments add up to those of both.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct MomentSums {
    degrees: Vec<Vec<f64>>,
}

impl MomentSums {
    /// For N samples: `inputs` N × inputs, `states` (N+1) × 3. The instruments come from the nominal model
    /// with the same inputs and initial state.
    pub(super) fn of(vessel: &Vessel, inputs: &[f64], states: &[f64]) -> Self {
        let exogenous = vessel.model.undisturbed(inputs);
        let initial = [states[0], states[1], states[2]];
        let instruments = simulate_one(&vessel.model, &vessel.nominal, initial, &exogenous);
        let lanes = |values: &[f64]| values.iter().map(|v| Lane::splat(*v)).collect::<Vec<_>>();
        let (measured, instruments, exogenous) = (lanes(states), lanes(&instruments), lanes(&exogenous));
        let batch = Batch {
            model: &vessel.model,
            measured: &measured,
            instrument_states: &instruments,
            exogenous: &exogenous,
            instrument_exogenous: &exogenous,
            segments: [&[0]; LANES],
        };
        let found = moments(&batch).swap_remove(0);
        let scale = found.samples as f64;
        let degrees =
            found.matrices.into_iter().map(|m| m.into_iter().map(|x| x * scale).collect()).collect();
        Self { degrees }
    }

    /// For a piece of a maneuver run by the nominal model in still water.
    pub(super) fn of_piece(vessel: &Vessel, piece: &Piece) -> Self {
        let exogenous = vessel.model.undisturbed(&piece.inputs);
        let initial = [piece.speed_m_s, 0.0, 0.0];
        let states = simulate_one(&vessel.model, &vessel.nominal, initial, &exogenous);
        Self::of(vessel, &piece.inputs, &states)
    }

    /// Adds `times` of another.
    pub(super) fn add(&mut self, other: &Self, times: f64) {
        if self.degrees.is_empty() {
            self.degrees = other.degrees.iter().map(|m| vec![0.0; m.len()]).collect();
        }
        for (own, other) in self.degrees.iter_mut().zip(&other.degrees) {
            own.iter_mut().zip(other).for_each(|(a, b)| *a += times * b);
        }
    }

    /// Σ over degrees of freedom of log|det|; −∞ where a direction is not excited.
    pub(super) fn log_det(&self) -> f64 {
        let one = |m: &Vec<f64>| {
            let n = m.len().isqrt();
            // Rows and columns are scaled first: forces and speeds differ by many powers of ten.
            let size: Vec<f64> = (0..n).map(|i| m[i * n + i].abs().sqrt()).collect();
            let mut scaled: Vec<f64> = (0..n * n).map(|k| m[k] / (size[k / n] * size[k % n])).collect();
            let shift: f64 = size.iter().map(|s| 2.0 * libm::log(*s)).sum();
            match numerics::log_det(n, &mut scaled) {
                Some(det) if det.log_abs.is_finite() && det.log_abs > -60.0 => det.log_abs + shift,
                _ => f64::NEG_INFINITY,
            }
        };
        if self.degrees.is_empty() { f64::NEG_INFINITY } else { self.degrees.iter().map(one).sum() }
    }

    /// tr(M⁻¹ M_other)/p over all degrees of freedom: the share of `other` in this sum, if it is part of it. `None` where a
    /// direction is not excited.
    pub(super) fn share_of(&self, other: &Self) -> Option<f64> {
        if !self.log_det().is_finite() {
            return None;
        }
        let traces = self.degrees.iter().zip(&other.degrees).map(|(own, other)| {
            let n = own.len().isqrt();
            // Scaled as for the determinant: that leaves the trace as it is.
            let size: Vec<f64> = (0..n).map(|i| own[i * n + i].abs().sqrt()).collect();
            let scaled =
                |m: &[f64]| -> Vec<f64> { (0..n * n).map(|k| m[k] / (size[k / n] * size[k % n])).collect() };
            let (mut a, mut solved) = (scaled(own), scaled(other));
            numerics::solve(n, &mut a, &mut solved)?;
            Some(solved.iter().step_by(n + 1).sum::<f64>())
        });
        Some(traces.sum::<Option<f64>>()? / self.dimension() as f64)
    }

    /// Number of rows of all degrees of freedom.
    pub(super) fn dimension(&self) -> usize {
        self.degrees.iter().map(|m| m.len().isqrt()).sum()
    }
}
