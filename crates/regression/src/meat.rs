//! The meat of the sandwich covariance of an instrumental-variable estimate, predicted from stated disturbances.
//!
//! To first order about the undisturbed motion x̄ the residual is ε_d(k) = e_d(k+1) − e_d(k) − Σ_i J_di(k) (e_i(k) + c_i(k)),
//! J_di = θ_dᵀ ∂φ_d/∂x_i at x̄(k): the measurement error e enters the increment and the regressors, the current c (none in r) the
//! motion. The vessel's own drift under the current cancels. Σ_k ζ̃ ε is therefore a sum over independent draws: of e_d(k) times
//! ζ̃(k−1) − (1 + J_dd(k)) ζ̃(k), and of every other draw times J_di(k) ζ̃(k).

use std::f64::consts::{FRAC_PI_2, PI};

use numerics::lanes::lane_of;
use numerics::{LANES, Lane, Number};
use ship::engine::Compiled;

use crate::Batch;

/// Standard deviations of the disturbances of a run, white per sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Of the measured u, v \[m/s\] and r \[rad/s\].
    pub measurement: [f64; 3],
    /// Of each of the current's components in body axes \[m/s\].
    pub current: f64,
}

impl Noise {
    /// Per state the variance that enters degree of freedom `d` through its slope: errors of the other states, and the current.
    #[inline(always)]
    pub(crate) fn others(&self, d: usize) -> [f64; 3] {
        let measurement = |i: usize| if i == d { 0.0 } else { self.measurement[i].powi(2) };
        let current = |i: usize| if i < 2 { self.current.powi(2) } else { 0.0 };
        [0, 1, 2].map(|i| measurement(i) + current(i))
    }
}

/// B = (1/N) Σ over draws of variance × ggᵀ, g the factor of the draw in Σ ζ̃ ε: per lane and degree of freedom p̃ ×
/// p̃, row-major, symmetric, rows and columns by instrument. `theta`: parameters of the motion; the motion is the
/// batch's measured states, which must be undisturbed. The draws before the first and after the last regressor belong
/// to the batch: B of a whole run is exact, sums over maneuvers ignore that neighbours share a draw.
pub fn meat(batch: &Batch, theta: &[f64], noise: &Noise) -> Vec<Vec<Vec<f64>>> {
    let theta: Vec<Lane> = theta.iter().copied().map(Lane::splat).collect();
    let mut compiled = Compiled::new(batch.model, &theta);
    let degrees = numerics::vectorized!(draws(batch, &mut compiled.clone(), &mut compiled, noise));
    let of = |lane: usize| degrees.iter().map(|d| lane_of(&d.sum, lane)).collect();
    (0..LANES).map(of).collect()
}

/// The draws of one degree of freedom.
struct DegreeDraws {
    /// B: p̃ × p̃.
    sum: Vec<Lane>,
    /// ζ̃ at this sample and the one before, zero before the run.
    zeta: [Vec<Lane>; 2],
}

/// The draws of all samples.
#[inline(always)]
fn draws(
    batch: &Batch,
    nominal: &mut Compiled<Lane>,
    measured_model: &mut Compiled<Lane>,
    noise: &Noise,
) -> [DegreeDraws; 3] {
    let Batch { model, measured, instrument_states, exogenous, instrument_exogenous, .. } = *batch;
    let (width, samples) = (model.exogenous(), batch.samples());
    let zeros = |count: usize| vec![Lane::ZERO; count];
    let sizes = model.degrees.each_ref().map(|degree| degree.terms.len() + 1);
    let mut degrees = sizes.map(|n| DegreeDraws { sum: zeros(n * n), zeta: [zeros(n), zeros(n)] });
    for k in 0..samples {
        let row = width * k..width * (k + 1);
        measured_model.look(measured.as_chunks().0[k], &exogenous[row.clone()], None);
        nominal.look(instrument_states.as_chunks().0[k], &instrument_exogenous[row], None);
        let slopes = measured_model.slopes();
        let mut first = 0;
        for (d, DegreeDraws { sum, zeta: [before, zeta] }) in degrees.iter_mut().enumerate() {
            let p = zeta.len() - 1;
            for (i, z) in zeta[..p].iter_mut().enumerate() {
                *z = nominal.term(first + i);
            }
            zeta[p] = Lane::ONE;
            first += p;
            let pole = Lane::ONE + slopes[d][d];
            for (b, z) in before.iter_mut().zip(&*zeta) {
                *b = *b - pole * *z;
            }
            add_outer(sum, Lane::splat(noise.measurement[d].powi(2)), before);
            add_outer(sum, others(d, &slopes[d], noise), zeta);
            std::mem::swap(before, zeta);
        }
    }
    let share = Lane::splat(1.0 / samples.max(1) as f64);
    for (d, DegreeDraws { sum, zeta: [before, _] }) in degrees.iter_mut().enumerate() {
        // The last error ends an increment and is in no regressor.
        add_outer(sum, Lane::splat(noise.measurement[d].powi(2)), before);
        sum.iter_mut().for_each(|entry| *entry = *entry * share);
    }
    degrees
}

/// Variance of the draws that multiply ζ̃(k) alone: errors of the other states and the current.
#[inline(always)]
fn others(d: usize, slopes: &[Lane; 3], noise: &Noise) -> Lane {
    let mut sum = Lane::ZERO;
    for (slope, variance) in slopes.iter().zip(noise.others(d)) {
        sum += *slope * *slope * Lane::splat(variance);
    }
    sum
}

/// Adds variance × ggᵀ.
#[inline(always)]
fn add_outer(sum: &mut [Lane], variance: Lane, g: &[Lane]) {
    for (row, a) in sum.chunks_exact_mut(g.len()).zip(g) {
        let scaled = variance * *a;
        for (entry, b) in row.iter_mut().zip(g) {
            *entry += scaled * *b;
        }
    }
}

// The moving average of order one that makes a sequence most likely.
//
// r(k) = e(k) + θ e(k−1) with white e of variance σ² has γ₀ = σ² (1 + θ²) and γ₁ = σ² θ. Where θ is near −1, as of
// increments of noise, γ₀ + 2 γ₁ = σ² (1 + θ)² is a small difference of large numbers. Autocovariances of the sample
// leave it uncertain by several times itself, the likelihood by a fraction.

/// 1/golden ratio.
const RATIO: f64 = 0.618_033_988_749_894_8;

/// Golden sections of the angles of θ = sin(angle). They leave 0.026, over which the likelihood is nearly a parabola.
const SECTIONS: usize = 10;

/// Distance of the points of the last parabola.
const NEAR: f64 = 1e-3;

/// γ₀ and γ₁ of the likeliest moving average of `sequence`, lane by lane.
pub(crate) fn autocovariances(sequence: &[Lane]) -> [Lane; 2] {
    let likelihood = Likelihood(sequence);
    let theta = sines(likelihood.maximum());
    let [squares, _] = likelihood.squares(theta);
    let variance = squares / Lane::splat(sequence.len() as f64);
    [variance * (Lane::ONE + theta * theta), variance * theta]
}

fn sines(angle: Lane) -> Lane {
    angle.each(Lane::ZERO, |angle, _| libm::sin(angle))
}

/// The exact Gaussian likelihood, concentrated with respect to σ², of a sequence.
struct Likelihood<'a>(&'a [Lane]);

impl Likelihood<'_> {
    /// Σ e² over all samples and the one before them, at its most likely value, and the determinant of the covariance
    /// over σ²ᴺ (Box & Jenkins, *Time Series Analysis*, 1976, appendix A7.4).
    fn squares(&self, theta: Lane) -> [Lane; 2] {
        let less = Lane::ZERO - theta;
        numerics::vectorized!({
            // e with e(−1) = 0, and de/de(−1).
            let (mut e, mut response) = (Lane::ZERO, Lane::ONE);
            let [mut squares, mut product, mut responses] = [Lane::ZERO, Lane::ZERO, Lane::ONE];
            for value in self.0 {
                e = less.fused(e, *value);
                response = less * response;
                squares = e.fused(e, squares);
                product = e.fused(response, product);
                responses = response.fused(response, responses);
            }
            [squares - product * product / responses, responses]
        })
    }

    /// −2 log likelihood over N, and a constant, at θ = sin(`angle`).
    fn cost(&self, angle: Lane) -> Lane {
        let [squares, determinant] = self.squares(sines(angle));
        let samples = self.0.len() as f64;
        squares
            .each(determinant, |squares, determinant| libm::log(squares) + libm::log(determinant) / samples)
    }

    /// The angle of the likeliest θ. The likelihood is even about ± π/2: nothing lies beyond.
    fn maximum(&self) -> Lane {
        let (mut low, mut width) = (Lane::splat(-FRAC_PI_2), PI);
        let inner = |low: Lane, share: f64, width: f64| low + Lane::splat(share * width);
        let [mut left, mut right] = [1.0 - RATIO, RATIO].map(|share| self.cost(inner(low, share, width)));
        for _ in 0..SECTIONS {
            let is_left: [bool; LANES] = std::array::from_fn(|lane| left[lane] < right[lane]);
            let mut next = Lane::ZERO;
            for lane in 0..LANES {
                if !is_left[lane] {
                    low[lane] += (1.0 - RATIO) * width;
                }
                next[lane] = low[lane] + if is_left[lane] { 1.0 - RATIO } else { RATIO } * RATIO * width;
            }
            width *= RATIO;
            let cost = self.cost(next);
            for lane in 0..LANES {
                [left[lane], right[lane]] =
                    if is_left[lane] { [cost[lane], left[lane]] } else { [right[lane], cost[lane]] };
            }
        }
        let middle = inner(low, 0.5, width);
        self.vertex(self.vertex(middle, 0.5 * width), NEAR)
    }

    /// The vertex of the parabola through `middle` and the points `distance` beside it; `middle` where it has none between these.
    fn vertex(&self, middle: Lane, distance: f64) -> Lane {
        let [below, at, above] = [-distance, 0.0, distance].map(|away| self.cost(middle + Lane::splat(away)));
        let (slope, curvature) = (above - below, above + below - at - at);
        middle.each(slope / curvature, |middle, ratio| {
            let away = -0.5 * distance * ratio;
            if away.abs() <= distance { middle + away } else { middle }
        })
    }
}
