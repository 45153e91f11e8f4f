//! The middle matrix of the covariance of an instrumental-variable estimate, predicted from stated disturbances.
//!
//! To first order around the undisturbed motion x̄ the residual is
//! ε_d(k) = e_d(k+1) − e_d(k) − Σ_i J_di(k) (e_i(k) + c_i(k)), J_di = θ_dᵀ ∂φ_d/∂x_i at x̄(k): the measurement error e enters the
//! increment and the regressors, the current c (none in r) the motion. The vessel's own drift under the current cancels.
//! Σ_k ζ̃ ε is therefore a sum over independent draws: of e_d(k) times ζ̃(k−1) − (1 + J_dd(k)) ζ̃(k), and of every other
//! draw times J_di(k) ζ̃(k).

use vessel::{LANES, Lane, Model};

use crate::Batch;

/// Standard deviations of what disturbs a run, white per sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Of the measured u, v \[m/s\] and r \[rad/s\].
    pub measurement: [f64; 3],
    /// Of each of the current's components in body axes \[m/s\].
    pub current: f64,
}

/// B = (1/N) Σ over draws of variance × ggᵀ, g what multiplies the draw in Σ ζ̃ ε: per lane and degree of freedom p̃ × p̃,
/// row-major, symmetric, rows and columns by instrument. `theta`: parameters of the motion; the motion is the batch's
/// measured states, which must be undisturbed. The draws before the first and after the last regressor belong to the
/// batch: B of a whole run is exact, sums over maneuvers leave out that neighbours share a draw.
pub fn middle(batch: &Batch, theta: &[f64], noise: &Noise) -> Vec<Vec<Vec<f64>>> {
    (0..LANES).map(|lane| of_lane(batch, theta, noise, lane)).collect()
}

fn of_lane(batch: &Batch, theta: &[f64], noise: &Noise, lane: usize) -> Vec<Vec<f64>> {
    let sizes: Vec<usize> = batch.model.degrees.iter().map(|d| d.terms.len() + 1).collect();
    let mut sums: Vec<Vec<f64>> = sizes.iter().map(|n| vec![0.0; n * n]).collect();
    // ζ̃(k−1), zero before the run.
    let mut before: Vec<Vec<f64>> = sizes.iter().map(|n| vec![0.0; *n]).collect();
    let mut own = vec![0.0; batch.model.variables.len()];
    let mut nominal = own.clone();
    for k in 0..batch.samples() {
        variables(batch.model, batch.measured, batch.exogenous, k, lane, &mut own);
        variables(batch.model, batch.instrument_states, batch.exogenous, k, lane, &mut nominal);
        let mut first = 0;
        for (d, degree) in batch.model.degrees.iter().enumerate() {
            let theta = &theta[first..first + degree.terms.len()];
            let slope = |i: usize| -> f64 {
                degree.terms.iter().zip(theta).map(|(term, t)| t * term.derivative(&own, i)).sum()
            };
            let slopes = [slope(0), slope(1), slope(2)];
            let zeta: Vec<f64> =
                degree.terms.iter().map(|term| term.evaluate(&nominal)).chain([1.0]).collect();
            let difference: Vec<f64> =
                before[d].iter().zip(&zeta).map(|(b, z)| b - (1.0 + slopes[d]) * z).collect();
            add_outer(&mut sums[d], noise.measurement[d].powi(2), &difference);
            add_outer(&mut sums[d], others(d, &slopes, noise), &zeta);
            before[d] = zeta;
            first += degree.terms.len();
        }
    }
    let share = 1.0 / batch.samples().max(1) as f64;
    for (d, sum) in sums.iter_mut().enumerate() {
        // The last error ends an increment and is in no regressor.
        add_outer(sum, noise.measurement[d].powi(2), &before[d]);
        sum.iter_mut().for_each(|entry| *entry *= share);
    }
    sums
}

/// Variance of what multiplies ζ̃(k) alone: errors of the other states and the current.
fn others(d: usize, slopes: &[f64; 3], noise: &Noise) -> f64 {
    let measurement = |i: usize| if i == d { 0.0 } else { noise.measurement[i] };
    let current = |i: usize| if i < 2 { noise.current } else { 0.0 };
    (0..3).map(|i| slopes[i].powi(2) * (measurement(i).powi(2) + current(i).powi(2))).sum()
}

/// Values of all variables of one lane at sample `k`.
fn variables(model: &Model, states: &[Lane], exogenous: &[Lane], k: usize, lane: usize, out: &mut [f64]) {
    let width = model.exogenous();
    let all = states[3 * k..3 * k + 3].iter().chain(&exogenous[width * k..width * (k + 1)]);
    out.iter_mut().zip(all).for_each(|(o, value)| *o = value[lane]);
}

fn add_outer(sum: &mut [f64], variance: f64, g: &[f64]) {
    if variance == 0.0 {
        return;
    }
    for (row, a) in sum.chunks_exact_mut(g.len()).zip(g) {
        row.iter_mut().zip(g).for_each(|(entry, b)| *entry += variance * a * b);
    }
}
