//! The moving average of order one that makes a sequence most likely.
//!
//! r(k) = e(k) + θ e(k−1) with white e of variance σ² has γ₀ = σ² (1 + θ²) and γ₁ = σ² θ. Where θ is near −1, as of
//! increments of noise, γ₀ + 2 γ₁ = σ² (1 + θ)² is a small difference of large numbers. Autocovariances of the sample
//! leave it uncertain by several times itself, the likelihood by a fraction.

use std::f64::consts::{FRAC_PI_2, PI};

use numerics::{LANES, Lane, Number};

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
            for own in self.0 {
                e = less.fused(e, *own);
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

    /// The vertex of the parabola through `middle` and the points `distance` beside it; `middle` where it has none
    /// between these.
    fn vertex(&self, middle: Lane, distance: f64) -> Lane {
        let [below, at, above] = [-distance, 0.0, distance].map(|away| self.cost(middle + Lane::splat(away)));
        let (slope, curvature) = (above - below, above + below - at - at);
        middle.each(slope / curvature, |middle, ratio| {
            let away = -0.5 * distance * ratio;
            if away.abs() <= distance { middle + away } else { middle }
        })
    }
}
