use vessel::{LANES, Lane};

use super::adjoint::disturbed_scores;
use super::levels::Levels;
use super::levenberg_marquardt::{Ended, Minimum, Residuals, Weighting, minimize, scaled_inverse};
use super::recordings::Recordings;
use super::scores::{Kept, correlated_scores};
use super::sums::{Linear, linearize};
use crate::Direction;

/// Where a simulation starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InitialState {
    /// At the recording's own start, which is known.
    Known,
    /// Near it: its offset is estimated, and the first measurement counts.
    Estimated,
}

/// What standard errors are made of.
#[derive(Clone, Copy, Debug)]
pub enum Spread<'a> {
    /// Errors correlated in time, by their own scores over overlapping windows.
    Residuals,
    /// Stated disturbances, followed through the model to first order.
    Stated(&'a Levels),
}

/// What became of one run.
#[derive(Clone, Debug, PartialEq)]
pub enum Fit {
    /// An estimate.
    Converged(Fitted),
    /// No minimum after this many steps, or none at all from a start that diverges.
    NotConverged(usize),
    /// A direction of the parameters leaves the prediction as it is.
    NotIdentifiable(Direction),
}

/// An estimate of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// θ̂: surge, sway, yaw.
    pub parameters: Vec<f64>,
    /// Standard error of each.
    pub standard_errors: Vec<f64>,
    /// One per degree of freedom.
    pub intercepts: [f64; 3],
    /// Estimated minus given initial state.
    pub offset: [f64; 3],
    /// Root mean square errors of the prediction in u, v \[m/s\], r \[rad/s\].
    pub rmse: [f64; 3],
    /// Steps of the search.
    pub steps: usize,
}

/// Variances of output errors are not taken below this share of the measured state's mean square: data without noise.
const EXACT: f64 = 1e-12;

/// Estimates by the errors of free simulations: minimises Σ_d N log Σ e_d², the likelihood of white errors with a variance
/// of their own in u, v and r, over parameters, intercepts and, if so wanted, the initial state. Per run `starts` holds
/// parameters to begin at; where the first ones diverge or lead to no minimum, the next are taken.
pub fn output_error(
    recordings: &Recordings,
    starts: &[[Vec<f64>; LANES]],
    initial: InitialState,
    spread: Spread,
) -> Vec<Fit> {
    let problem = Simulations { recordings, free: free(recordings, initial), initial };
    let sizes = mean_squares(recordings);
    let weighting: Vec<Weighting> =
        sizes.iter().map(|s| Weighting::Likelihood(s.map(|square| EXACT * square))).collect();
    let mut found = best_of(&problem, &weighting, starts, problem.free.len());
    if found.iter().any(|m| m.status != Ended::Converged) {
        // Where one state is predicted far better than another its weight bars the way: begin with weights that stay.
        let fixed: Vec<Weighting> =
            sizes.iter().map(|s| Weighting::Fixed(s.map(|square| square.recip()))).collect();
        let first = best_of(&problem, &fixed, starts, problem.free.len());
        let again = [std::array::from_fn(|lane| first[lane].point.clone())];
        let then = best_of(&problem, &weighting, &again, problem.free.len());
        found = found.into_iter().zip(then).map(|(a, b)| better(a, b)).collect();
    }
    let errors = problem.standard_errors(&found, &weighting, spread);
    found.iter().zip(errors).map(|(minimum, errors)| fit(recordings, minimum, errors)).collect()
}

/// The unknowns that are estimated.
fn free(recordings: &Recordings, initial: InitialState) -> Vec<usize> {
    let held = if initial == InitialState::Known { 3 } else { 0 };
    (0..recordings.unknowns() - held).collect()
}

/// Of the measured states.
fn mean_squares(recordings: &Recordings) -> Vec<[f64; 3]> {
    let mean_square = |lane: usize, d: usize| {
        let own = recordings.measured.iter().skip(d).step_by(3).take(recordings.samples[lane] + 1);
        let sum: f64 = own.map(|y| y[lane] * y[lane]).sum();
        (sum / (recordings.samples[lane] + 1) as f64).max(1e-12)
    };
    (0..LANES).map(|lane| [0, 1, 2].map(|d| mean_square(lane, d))).collect()
}

/// Minimises from the first starts, then from the next those that found nothing. What a start lacks is zero.
pub(super) fn best_of(
    problem: &impl Residuals,
    weighting: &[Weighting],
    starts: &[[Vec<f64>; LANES]],
    unknowns: usize,
) -> Vec<Minimum> {
    let mut best: Vec<Minimum> = Vec::new();
    for starts in starts {
        if best.iter().all(|b| b.status == Ended::Converged) && !best.is_empty() {
            break;
        }
        let start = |lane: usize| -> Vec<f64> {
            match best.get(lane).filter(|b| b.status == Ended::Converged) {
                Some(found) => found.point.clone(),
                None => {
                    let mut point = starts[lane].clone();
                    point.resize(unknowns, 0.0);
                    point
                }
            }
        };
        let points: Vec<Vec<f64>> = (0..LANES).map(start).collect();
        let Some(found) = minimize(problem, weighting.to_vec(), points) else { continue };
        best = match best.is_empty() {
            true => found,
            false => best.into_iter().zip(found).map(|(a, b)| better(a, b)).collect(),
        };
    }
    best
}

/// Whichever is a minimum; of two that are none, the first that got anywhere.
pub(super) fn better(a: Minimum, b: Minimum) -> Minimum {
    let rank = |m: &Minimum| match m.status {
        Ended::Converged => 3,
        Ended::Stalled => 2,
        Ended::Singular(_) => 1,
        Ended::Diverged => 0,
    };
    if rank(&b) > rank(&a) { b } else { a }
}

/// One lane per unknown; the lanes' points hold the free ones.
pub(super) fn side_by_side(points: &[Vec<f64>], all: usize) -> Vec<Lane> {
    let of = |i: usize| Lane(std::array::from_fn(|lane| points[lane].get(i).copied().unwrap_or(0.0)));
    (0..all).map(of).collect()
}

pub(super) fn fit(recordings: &Recordings, minimum: &Minimum, errors: Option<Vec<f64>>) -> Fit {
    let theta = recordings.model.parameters();
    let at = |i: usize| minimum.point.get(i).copied().unwrap_or(0.0);
    match (minimum.status, errors) {
        (Ended::Singular(unknown), _) if unknown < theta => {
            let mut parameter = unknown;
            let sizes = recordings.model.degrees.each_ref().map(|d| d.terms.len());
            let mut degree = 0;
            while parameter >= sizes[degree] {
                parameter -= sizes[degree];
                degree += 1;
            }
            Fit::NotIdentifiable(Direction { degree, parameter })
        }
        (Ended::Converged, Some(errors)) => Fit::Converged(Fitted {
            parameters: minimum.point[..theta].to_vec(),
            standard_errors: errors[..theta].to_vec(),
            intercepts: [0, 1, 2].map(|d| at(theta + d)),
            offset: [0, 1, 2].map(|d| at(theta + 3 + d)),
            rmse: minimum.linear.squares.map(|s| (s / minimum.linear.samples).sqrt()),
            steps: minimum.steps,
        }),
        _ => Fit::NotConverged(minimum.steps),
    }
}

struct Simulations<'a> {
    recordings: &'a Recordings<'a>,
    free: Vec<usize>,
    initial: InitialState,
}

impl Residuals for Simulations<'_> {
    fn linearize(&self, points: &[Vec<f64>]) -> Vec<Linear> {
        let unknowns = side_by_side(points, self.recordings.unknowns());
        let from_start = self.initial == InitialState::Estimated;
        linearize::<3>(self.recordings, &unknowns, &self.free, None, &[], from_start)
    }
}

impl Simulations<'_> {
    /// √diag(H⁻¹ B H⁻¹), H = Σ sᵀWs, B the covariance of the scores Σ sᵀWe.
    fn standard_errors(
        &self,
        found: &[Minimum],
        weighting: &[Weighting],
        spread: Spread,
    ) -> Vec<Option<Vec<f64>>> {
        let points: Vec<Vec<f64>> = found.iter().map(|m| m.point.clone()).collect();
        let unknowns = side_by_side(&points, self.recordings.unknowns());
        let weights: Vec<[f64; 3]> = found.iter().zip(weighting).map(|(m, w)| w.weights(&m.linear)).collect();
        let weights = [0, 1, 2].map(|d| Lane(std::array::from_fn(|lane| weights[lane][d])));
        let from_start = self.initial == InitialState::Estimated;
        let kept = Kept::of(self.recordings, &unknowns, &self.free, from_start);
        let middles = match spread {
            Spread::Residuals => correlated_scores(self.recordings, &kept, weights),
            Spread::Stated(levels) => disturbed_scores(self.recordings, &unknowns, &kept, weights, levels),
        };
        let p = self.free.len();
        let errors = |(lane, minimum): (usize, &Minimum)| {
            let own = [0, 1, 2].map(|d: usize| weights[d][lane]);
            let (normal, _) = minimum.linear.weighted(own);
            let inverse = scaled_inverse(&normal, p).ok()?;
            let middle: Vec<f64> = middles.iter().map(|m| m[lane]).collect();
            let variance = |i: usize| {
                let row = &inverse[i * p..(i + 1) * p];
                (0..p * p).map(|k| row[k / p] * middle[k] * row[k % p]).sum::<f64>()
            };
            let errors: Vec<f64> = (0..p).map(|i| variance(i).max(0.0).sqrt()).collect();
            errors.iter().all(|e| e.is_finite()).then_some(errors)
        };
        found.iter().enumerate().map(errors).collect()
    }
}
