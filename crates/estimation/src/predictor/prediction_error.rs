use std::convert::Infallible;

use numerics::lanes::by_lane;
use numerics::least_squares::{
    Ended, Expansion, Linearization, Minimum, Residuals, minimize, scaled_inverse,
};
use numerics::{LANES, Lane, Watch, times};
use regression::jackknife;
use ship::engine::{RunView, SideBySide};
use ship::model::Model;

use super::linear::{ENDING, InitialState, Linear, Weighting, blocks, inverse, linearize};
use super::output_error::{better, side_by_side};
use super::{EstimateErrors, RunFit, fit};
use crate::sensitivity::{Gain, NoiseModel, Recordings, filter, groups, with_states};

/// Maximum number of computations of the filter's gains, the first at the start.
const ROUNDS: usize = 3;
/// A round with a smaller rise of twice the log-likelihood is the last.
const SETTLED: f64 = 0.01;

/// Estimates by the errors of one-sample predictions: an extended Kalman filter whose states are the vessel's and
/// those of the stated disturbances. Its gains are computed along the filter at the last estimate and fixed while
/// whitened innovations are minimised over the parameters: three rounds, of which those after the first are used if
/// they increase the filter's likelihood. Without that guard, gains that trust the measurements more and more lead to
/// least squares. Standard errors are those of white innovations, scaled by their own variance. `starts` as for
/// [`super::output_error`].
pub fn prediction_error(
    model: &Model,
    runs: &[RunView],
    starts: &[Vec<Vec<f64>>],
    initial: InitialState,
    levels: &NoiseModel,
) -> Vec<RunFit> {
    let mut fits = vec![RunFit::NotConverged(0); runs.len()];
    for (group, runs) in groups(runs, 0..runs.len()) {
        let recordings = &Recordings::of(model, &runs);
        let attempts = group.iter().map(|run| starts[*run].len()).max().unwrap_or(0);
        let at =
            |run: usize, i: usize| starts[run].get(i).or(starts[run].last()).cloned().unwrap_or_default();
        let starts: Vec<_> = (0..attempts).map(|i| by_lane(group.len(), |run| at(group[run], i))).collect();
        let of_group = with_states!(levels.states(), rounds(recordings, &starts, initial, levels));
        group.iter().zip(of_group).for_each(|(run, fit)| fits[*run] = fit);
    }
    fits
}

/// Innovations of the extended Kalman filter for `levels` at these unknowns (see [`Recordings::unknowns`]), (N+1) × 3.
pub fn innovations(runs: &Recordings, at: &[Lane], levels: &NoiseModel, initial: InitialState) -> Vec<Lane> {
    let known = initial == InitialState::Known;
    with_states!(levels.states(), filter(runs, at, levels, known).1)
}

/// The covariance of all parameters of a run by leaving out each of ten blocks of samples: for any kind of errors.
pub(crate) fn errors_by_blocks(
    model: &Model,
    run: RunView,
    theta: &[f64],
    initial: InitialState,
    levels: &NoiseModel,
) -> Option<Vec<f64>> {
    let alike = SideBySide::of(&[run]);
    let recordings = &Recordings::of(model, &alike);
    let unknowns: Vec<Lane> = theta.iter().copied().chain([0.0; 3]).map(Lane::splat).collect();
    let known = initial == InitialState::Known;
    let all_blocks = with_states!(levels.states(), of_blocks(recordings, &unknowns, levels, known));
    let blocks: Vec<&Linear> = all_blocks.iter().filter_map(|block| block.first()).collect();
    let mut whole = (*blocks.first()?).clone();
    blocks[1..].iter().for_each(|block| whole.add(block));
    let (whole, _) = whole.weighted([1.0; 3]);
    let without = |block: &Linear| {
        let (part, gradient) = block.weighted([1.0; 3]);
        let others: Vec<f64> = whole.iter().zip(part).map(|(whole, entry)| whole - entry).collect();
        let inverse =
            scaled_inverse(&others, gradient.len()).or_else(|_| scaled_inverse(&whole, gradient.len()));
        Some(times(&inverse.ok()?, &gradient))
    };
    jackknife(blocks.iter().copied(), without)
}

fn of_blocks<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    levels: &NoiseModel,
    known: bool,
) -> Vec<Vec<Linear>> {
    let free: Vec<usize> = (0..recordings.model.parameters()).collect();
    let (gains, _) = filter::<N>(recordings, unknowns, levels, known);
    blocks(recordings, unknowns, &free, Some(levels), &gains, false)
}

const WHITE: Weighting = Weighting::Fixed([1.0; 3]);

struct Predictions<'a, const N: usize> {
    recordings: &'a Recordings<'a>,
    levels: &'a NoiseModel,
    free: Vec<usize>,
    gains: Vec<Gain<Lane, N>>,
}

impl<const N: usize> Residuals<Linear> for Predictions<'_, N> {
    fn linearize(&mut self, asked: &[Linearization]) -> Result<Vec<(Expansion, Linear)>, Infallible> {
        // A problem's gains are in its lane, so it cannot move to another.
        Ok(WHITE.by_lane(asked, |points| {
            let unknowns = side_by_side(points, &self.free, self.recordings.unknowns());
            linearize(self.recordings, &unknowns, &self.free, Some(self.levels), &self.gains, true)
        }))
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        self.recordings.model.bounds().unwrap_or_default()
    }
}

fn rounds<const N: usize>(
    recordings: &Recordings,
    starts: &[[Vec<f64>; LANES]],
    initial: InitialState,
    levels: &NoiseModel,
) -> Vec<RunFit> {
    let free: Vec<usize> = (0..recordings.unknowns() - 3).collect();
    let known = initial == InitialState::Known;
    let mut best: Vec<Minimum<Linear>> = Vec::new();
    for starts in starts {
        if best.is_empty() || best.iter().any(|b| b.status != Ended::Converged) {
            let point = |lane: usize| match best.get(lane).filter(|b| b.status == Ended::Converged) {
                Some(converged) => converged.point.clone(),
                None => starts[lane].clone(),
            };
            let minima = round::<N>(recordings, std::array::from_fn(point), &free, levels, known);
            best = match best.is_empty() {
                true => minima,
                false => best.into_iter().zip(minima).map(|(a, b)| better(a, b)).collect(),
            };
        }
    }
    if best.is_empty() {
        return vec![RunFit::NotConverged(0); LANES];
    }
    let mut likelihood = likelihoods::<N>(recordings, &best, levels, known);
    let mut open = [true; LANES];
    for _ in 1..ROUNDS {
        if !open.contains(&true) {
            break;
        }
        let again = std::array::from_fn(|lane| best[lane].point.clone());
        let next = round::<N>(recordings, again, &free, levels, known);
        let next_likelihood = likelihoods::<N>(recordings, &next, levels, known);
        for (lane, next) in next.into_iter().enumerate() {
            if !open[lane] {
                continue;
            }
            best[lane].steps += next.steps;
            let more = next_likelihood[lane] - likelihood[lane];
            open[lane] = next.status == Ended::Converged && more > SETTLED;
            if next.status == Ended::Converged && more > 0.0 {
                best[lane] = Minimum { steps: best[lane].steps, ..next };
                likelihood[lane] = next_likelihood[lane];
            }
        }
    }
    let fit = |m: &Minimum<Linear>| fit(recordings, m, errors(m, free.len()), InitialState::Known.into());
    best.iter().map(fit).collect()
}

/// Gains along the filter at `points`, and the minima of the innovations with them.
fn round<const N: usize>(
    recordings: &Recordings,
    points: [Vec<f64>; LANES],
    free: &[usize],
    levels: &NoiseModel,
    known: bool,
) -> Vec<Minimum<Linear>> {
    let unknowns = side_by_side(&points, free, recordings.unknowns());
    let (gains, _) = filter::<N>(recordings, &unknowns, levels, known);
    let mut problem = Predictions { recordings, levels, free: free.to_vec(), gains };
    let points = points.map(|mut point| {
        point.resize(free.len(), 0.0);
        point
    });
    let Ok(minima) = minimize(&mut problem, points.to_vec(), ENDING, &Watch::default());
    minima
}

/// Twice the log-likelihood of every lane's innovations, up to a constant.
fn likelihoods<const N: usize>(
    recordings: &Recordings,
    minima: &[Minimum<Linear>],
    levels: &NoiseModel,
    known: bool,
) -> Vec<f64> {
    let points: Vec<Vec<f64>> = minima.iter().map(|m| m.point.clone()).collect();
    let free: Vec<usize> = (0..recordings.unknowns()).collect();
    let unknowns = side_by_side(&points, &free, recordings.unknowns());
    let (gains, innovations) = filter::<N>(recordings, &unknowns, levels, known);
    let mut likelihood = vec![0.0; LANES];
    for (gain, error) in gains.iter().zip(innovations.as_chunks().0) {
        let white = gain.white(error);
        let [a, b, c] = gain.scales();
        for (lane, likelihood) in likelihood.iter_mut().enumerate() {
            *likelihood += 2.0 * libm::log(a[lane] * b[lane] * c[lane]);
            *likelihood -= white.iter().map(|w| w[lane] * w[lane]).sum::<f64>();
        }
    }
    likelihood
}

/// From σ̂² H⁻¹, σ̂² being the whitened innovations' variance, near 1 if the levels are right.
fn errors(minimum: &Minimum<Linear>, p: usize) -> Option<EstimateErrors> {
    let mut inverse = inverse(minimum, [1.0; 3]).ok()?;
    let freedom = (3.0 * minimum.sums.samples - p as f64).max(1.0);
    let variance = minimum.sums.squares.iter().sum::<f64>() / freedom;
    let each: Vec<f64> = (0..p).map(|i| (variance * inverse[i * p + i]).max(0.0).sqrt()).collect();
    inverse.iter_mut().for_each(|entry| *entry *= variance);
    let covariance = Some(inverse);
    each.iter().all(|e| e.is_finite()).then_some(EstimateErrors { each, covariance, approximate: false })
}
