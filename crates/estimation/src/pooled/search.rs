//! Pooled estimates by search: by simulations and by predictions.

use regression::pooled::{AnyParts, DegreeFit, Drawn, Part, PooledSums, Status, Unread, Windowed};
use regression::{DegreeSums, MeanRemoval};
use ship::engine::RunView;

use super::searched::least_errors_any;
use super::{Estimated, Follow, Pool, Scales, Searched, Unfound};
use crate::Estimator;
use crate::criticism::{ENOUGH, Kinds, calibrated};
use crate::estimator::Intercepts;
use crate::predictor::{InitialState, Unknown};
use crate::validate::Score;

/// Starts are estimated if noise has at least this share of the squared errors.
const NOISY: f64 = 0.25;

/// What a search ends with: none without a minimum.
type Reached = Result<Option<Searched>, Unread>;

impl Pool<'_> {
    /// Continues to the least errors of free simulations, then of predictions if requested; without success there is no
    /// estimate. A model without an estimate of a degree of freedom is left unchanged.
    pub(super) fn searched(&self, parts: &AnyParts, by: Estimator, to: &mut Estimated) -> Result<(), Unread> {
        let Some((theta, intercepts)) = to.theta() else { return Ok(()) };
        let intercepts = if self.additional.intercepts == Intercepts::None { [0.0; 3] } else { intercepts };
        let start = self.model.layout().woven(&theta, intercepts);
        let mut deviations = to.means().deviations();
        parts.each(&mut |part| deviations.add(part.run.measured))?;
        let std = deviations.std();
        let sizes = self.sizes(to.least_squares_sums(), std);
        let mut scales = Scales { std, sizes, follow: Follow::Simulated(self.unknown()) };
        let simulated = self.continued(parts, &start, &scales)?;
        let best = if by == Estimator::PredictionError {
            // A filter can follow motion that a simulation cannot.
            let from = simulated.as_ref().map_or(&start, |searched| &searched.parameters);
            let predicted = self.predicted(parts, from, &scales)?;
            predicted.map(|(follow, best, noises)| {
                (scales.follow, to.noises) = (follow, noises);
                best
            })
        } else {
            match simulated {
                Some(searched) if self.mostly_noise(parts, &searched, std)? => {
                    let unknown = Unknown { initial: InitialState::Estimated, ..self.unknown() };
                    scales.follow = Follow::Simulated(unknown);
                    self.least_errors(parts, &searched.parameters, &scales)?
                }
                searched => searched,
            }
        };
        let Some(best) = best else {
            let recordings = self.diverging(parts, &start)?;
            to.unfound = Some(Unfound { estimator: by, recordings });
            let none = || DegreeFit { status: Status::Unfound, solution: None };
            to.degrees = [none(), none(), none()];
            return Ok(());
        };
        for (d, (theta, intercept)) in self.split(&best.parameters).into_iter().enumerate() {
            let model = &self.vessel.model.degrees[d];
            if theta.iter().enumerate().all(|(i, value)| model.at_bound(i, *value)) {
                to.degrees[d] = DegreeFit { status: Status::Bounded, solution: None };
            }
            if let Some(solution) = &mut to.degrees[d].solution {
                (solution.theta, solution.intercept) = (theta, intercept);
            }
            to.used[d] = by;
        }
        to.searched = Some((best, scales));
        Ok(())
    }

    /// Whether sensor noise, by third differences, is a large share of the errors: then the first sample of a part is as
    /// noisy as others, and its start is a further unknown.
    fn mostly_noise(&self, parts: &AnyParts, simulated: &Searched, std: [f64; 3]) -> Result<bool, Unread> {
        let (mut noise, mut counted, mut samples) = (0.0, 0_u64, 0);
        parts.each(&mut |part| {
            let rows = part.run.measured.as_chunks::<3>().0;
            for four in rows.windows(4) {
                let third = |d: usize| four[3][d] - 3.0 * (four[2][d] - four[1][d]) - four[0][d];
                let weighed = (0..3).filter(|d| std[*d] > 0.0).map(|d| (third(d) / std[d]).powi(2));
                // The variance of a third difference of white noise is 1 + 9 + 9 + 1 times its own.
                noise += weighed.sum::<f64>() / 20.0;
                counted += 1;
            }
            samples += part.run.samples();
        })?;
        Ok(noise * samples as f64 > NOISY * simulated.squares * counted as f64)
    }

    /// Minimises the errors of predictions by filters for the likeliest noise of the first parts.
    fn predicted(
        &self,
        parts: &AnyParts,
        from: &[f64],
        scales: &Scales,
    ) -> Result<Option<(Follow, Searched, Kinds)>, Unread> {
        let (mut samples, mut first) = (0, Vec::new());
        let enough = |i: &usize| {
            let before = samples;
            samples += parts.samples(*i);
            before < ENOUGH
        };
        let places: Vec<usize> = (0..parts.count()).take_while(enough).collect();
        parts.at(&places, &mut |part| first.push(Part::new("", "", part.run)))?;
        let views: Vec<RunView> = first.iter().map(Part::view).collect();
        let start = [from.to_vec()];
        let Some(noise) = calibrated(&self.model, &views, self.vessel.sample_rate_hz, false, &start) else {
            return Ok(None);
        };
        let follow = Follow::Predicted(noise.levels, noise.parameters.clone());
        let scales = Scales { follow, std: scales.std, sizes: scales.sizes.clone() };
        let searched = self.least_errors(parts, &noise.parameters, &scales)?;
        Ok(searched.map(|best| (scales.follow, best, noise.kinds)))
    }

    /// The estimate of a search from the parts at `drawn`, started at that from all: θ̂ of surge, sway and yaw.
    pub(super) fn searched_again(
        &self,
        parts: &AnyParts,
        drawn: &[usize],
        estimated: &Estimated,
    ) -> Result<Option<[Vec<f64>; 3]>, Unread> {
        let Some((all, scales)) = &estimated.searched else { return Ok(None) };
        let best = self.least_errors(&Drawn { parts, places: drawn }, &all.parameters, scales)?;
        Ok(best.map(|best| self.split(&best.parameters).map(|(theta, _)| theta)))
    }

    /// θ and intercept of surge, sway and yaw from parameters of the model with intercepts.
    fn split(&self, parameters: &[f64]) -> [(Vec<f64>, f64); 3] {
        let layout = self.model.layout();
        let intercepts = layout.intercepts(parameters);
        [0, 1, 2].map(|d| (parameters[layout.terms(d)].to_vec(), intercepts[d]))
    }

    /// The value of each parameter with which its term alone would equal the state's deviation; 0 where it is fixed.
    fn sizes(&self, sums: &PooledSums, std: [f64; 3]) -> Vec<f64> {
        let whole = sums.total();
        let n = whole.samples.max(1) as f64;
        let size = |square: f64, std: f64| if square > 0.0 { std / (square / n).sqrt() } else { 0.0 };
        let none = self.removal == MeanRemoval::None || self.additional.intercepts == Intercepts::None;
        let intercept = |std: f64| if none { 0.0 } else { std };
        let degree = |(degree, std): (&DegreeSums, f64)| -> Vec<f64> {
            let terms = degree.regressor_squares.iter().map(|square| size(*square, std));
            terms.chain((!degree.known.constant).then(|| intercept(std))).collect()
        };
        whole.degrees.iter().zip(std).flat_map(degree).collect()
    }
}

/// Samples of the first windows of a search if whole parts diverge; their length doubles with each step.
const SHORTEST: usize = 8;
/// Factors on the start's parameters, tried in turn: with zero nothing moves, and nothing diverges.
const DAMPED: [f64; 4] = [1.0, 0.5, 0.1, 0.0];

impl Pool<'_> {
    /// Minimises the errors of free simulations of `parts`. If these diverge, it fits short windows first, then longer
    /// ones; if need be from smaller multiples of `start`.
    pub(super) fn continued(&self, parts: &AnyParts, start: &[f64], scales: &Scales) -> Reached {
        if let Some(searched) = self.least_errors(parts, start, scales)? {
            return Ok(Some(searched));
        }
        for share in DAMPED {
            let damped = |(value, size): (&f64, &f64)| if *size > 0.0 { share * value } else { *value };
            let from: Vec<f64> = start.iter().zip(&scales.sizes).map(damped).collect();
            let searched = self.through_windows(parts, from, scales)?;
            if searched.as_ref().is_some_and(|searched| searched.converged) {
                return Ok(searched);
            }
        }
        Ok(None)
    }

    fn through_windows(&self, parts: &AnyParts, mut at: Vec<f64>, scales: &Scales) -> Reached {
        let longest = (0..parts.count()).map(|i| parts.samples(i)).max().unwrap_or(0);
        let lengths = std::iter::successors(Some(SHORTEST), |length| Some(2 * length));
        for length in lengths.take_while(|length| *length < longest) {
            let windows = Windowed::new(parts, length);
            if let Some(searched) = self.least_errors(&windows, &at, scales)? {
                at = searched.parameters;
            }
        }
        self.least_errors(parts, &at, scales)
    }

    pub(super) fn least_errors(&self, parts: &AnyParts, start: &[f64], scales: &Scales) -> Reached {
        let Scales { std, sizes, follow } = scales;
        least_errors_any(&self.model, parts, start, *std, sizes, follow)
    }

    pub(super) fn diverging(&self, parts: &AnyParts, parameters: &[f64]) -> Result<Vec<String>, Unread> {
        let mut named: Vec<String> = Vec::new();
        parts.each(&mut |part| {
            let score = Score::of(&self.model, parameters, std::iter::once(part.run));
            if score.diverged > 0 && !named.iter().any(|name| name == part.source) {
                named.push(part.source.to_owned());
            }
        })?;
        Ok(named)
    }
}
