//! The search for the minimum, by Levenberg's and Marquardt's method.

use numerics::least_squares::{Ended, Ending, Expansion, Linearization, Residuals, minimize};
use numerics::{Lane, Watch, congruence, scaled_inverse, symmetric};
use rayon::prelude::*;

use super::sums::{Reduced, WindowErrors, WindowSums, reduced};
use super::{Pass, Problem, Starts, Unfit, Window, add_priors, at_bound, block, distance, prior_gradient};

/// A step that is to lower the cost by less than the square of this share is the last.
const ENOUGH: f64 = 1e-3;
/// What no step need lower: errors of a millionth of a standard deviation.
const LEAST: f64 = 1e-12;
const DAMPING: f64 = 1e-3;

/// The minimum.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// θ, in the system that each was written in.
    pub theta: Vec<f64>,
    /// The mean of Huber's function of the windows' RMS errors, with what the priors add.
    pub cost: f64,
    /// RMS errors of u, v and r over all windows, in their standard deviations.
    pub rms: [f64; 3],
    /// Steps of the search.
    pub steps: usize,
    /// The start of each window.
    pub(crate) starts: Vec<Vec<[f64; 3]>>,
    /// As how many samples the first one of a window counts.
    pub(crate) first: Option<[f64; 3]>,
}

impl Fit {
    /// What share of the cost `gain` is; an exact fit counts as one that no step need lower.
    pub(crate) fn share(&self, gain: f64) -> f64 {
        gain / self.cost.max(LEAST)
    }
}

impl Problem<'_> {
    /// Fits the model, from its numbers before the fit.
    ///
    /// # Errors
    /// A simulation that diverges, a parameter that nothing determines, no end of the search.
    pub fn fit(&self) -> Result<Fit, Unfit> {
        self.fit_from(&self.forces.nominal())
    }

    /// Fits the model, from `theta`: with windows that start at their first measured sample, and from there with starts of
    /// their own, if these are unknown.
    ///
    /// # Errors
    /// As [`Self::fit`].
    pub fn fit_from(&self, theta: &[f64]) -> Result<Fit, Unfit> {
        let measured_fit = Pass::new(self, None).fit(theta)?;
        match self.settings.starts {
            Starts::Measured => Ok(measured_fit),
            Starts::Unknown => {
                let fit = Pass::new(self, Some(self.first(measured_fit.rms))).fit(&measured_fit.theta)?;
                Ok(Fit { steps: fit.steps + measured_fit.steps, ..fit })
            }
        }
    }

    /// The cost of θ with windows that start at their first measured sample; infinite where one diverges.
    pub fn cost(&self, theta: &[f64]) -> f64 {
        Pass::new(self, None).cost_from(theta)
    }

    /// The cost of θ with windows that start at their first measured sample, and its derivatives by θ.
    pub fn cost_and_slopes(&self, theta: &[f64]) -> (f64, Vec<f64>) {
        Pass::new(self, None).cost(theta)
    }

    /// Derivatives by θ of the errors of windows that start at their first measured sample. Each entry has a group of windows
    /// side by side: a row for each error, 0 after the end of a window.
    pub fn jacobian(&self, theta: &[f64]) -> Vec<Vec<Lane>> {
        let pass = Pass::new(self, None);
        let groups: Vec<_> = self.groups.iter().zip(pass.measured_starts()).collect();
        groups.par_iter().map(|(group, starts)| pass.derivatives(group, theta, starts).slopes).collect()
    }
}

impl Pass<'_> {
    fn fit(&self, theta: &[f64]) -> Result<Fit, Unfit> {
        match self.search(theta, self.settings.most_steps)? {
            (fit, true) => Ok(fit),
            (_, false) => Err(Unfit::Unfinished(self.settings.most_steps)),
        }
    }

    /// What at most `most` steps from `theta` lead to, and whether it is a minimum.
    pub(crate) fn search(&self, theta: &[f64], most: usize) -> Result<(Fit, bool), Unfit> {
        let bounds = self.forces.parameters().iter().map(|parameter| parameter.bounds);
        let theta: Vec<f64> = theta.iter().zip(bounds).map(|(x, [low, high])| x.clamp(low, high)).collect();
        let at = self.at(theta.clone(), self.measured_starts());
        if !at.cost.is_finite() {
            return Err(self.diverged(&at));
        }
        let mut search =
            WindowSearch { pass: self, next: at.clone(), at, sums: Vec::new(), reduced: Vec::new() };
        let ending = Ending { steps: most, enough: ENOUGH, damping: DAMPING };
        let minima = minimize(&mut search, vec![theta], ending, &Watch::default())?;
        let mut is_minimum = false;
        for minimum in minima {
            if let Ended::Singular(i) = minimum.status {
                return Err(Unfit::Undetermined(self.forces.parameters()[i].name.clone()));
            }
            search.reach(&minimum.point);
            search.at.steps = minimum.steps;
            // Where no step is lower, the cost has an edge.
            is_minimum = minimum.status != Ended::Stalled || minimum.steps < most;
        }
        Ok((search.at, is_minimum))
    }

    /// The cost of θ with windows that start at their first measured sample; infinite where one diverges.
    pub(crate) fn cost_from(&self, theta: &[f64]) -> f64 {
        let cost = self.at(theta.to_vec(), self.measured_starts()).cost;
        if cost.is_finite() { cost } else { f64::INFINITY }
    }

    fn cost(&self, theta: &[f64]) -> (f64, Vec<f64>) {
        let at = self.at(theta.to_vec(), self.measured_starts());
        let sums = self.all_sums(&at.theta, &at.starts);
        let mut slopes = vec![0.0; theta.len()];
        for window in sums.iter().flatten() {
            let weight = 2.0 * self.weight(&window.errors);
            for piece in &window.pieces {
                slopes.iter_mut().zip(piece).for_each(|(sum, slope)| *sum += weight * slope);
            }
        }
        slopes.iter_mut().zip(self.prior_gradient(theta)).for_each(|(sum, [_, slope])| *sum += 2.0 * slope);
        (at.cost, slopes)
    }

    fn measured_starts(&self) -> Vec<Vec<[f64; 3]>> {
        let start = |window: &Window| {
            let measured = self.recordings[window.recording].measured;
            [0, 1, 2].map(|d| measured[3 * window.first + d])
        };
        self.groups.iter().map(|group| group.windows.iter().map(start).collect()).collect()
    }

    pub(crate) fn all_sums(&self, theta: &[f64], starts: &[Vec<[f64; 3]>]) -> Vec<Vec<WindowSums>> {
        let groups: Vec<_> = self.groups.iter().zip(starts).collect();
        groups.par_iter().map(|(group, starts)| self.sums(group, theta, starts)).collect()
    }

    fn at(&self, theta: Vec<f64>, starts: Vec<Vec<[f64; 3]>>) -> Fit {
        let groups: Vec<_> = self.groups.iter().zip(&starts).collect();
        let all: Vec<Vec<WindowErrors>> =
            groups.par_iter().map(|(group, starts)| self.errors(group, &theta, starts)).collect();
        let knee = self.settings.knee;
        let (mut cost, mut squares) = (0.0, [0.0; 3]);
        for window in all.iter().flatten() {
            cost += self.share(window) * window.cost(knee);
            squares.iter_mut().zip(window.squares).for_each(|(sum, square)| *sum += square);
        }
        cost += self.prior_cost() * distance(&theta, &self.priors);
        let rms = squares.map(|square| (square / self.samples as f64).sqrt());
        Fit { theta, cost, rms, steps: 0, starts, first: self.first }
    }

    pub(crate) fn share(&self, window: &WindowErrors) -> f64 {
        window.samples as f64 / self.samples as f64
    }

    pub(crate) fn determined(&self, sums: &[Vec<WindowSums>]) -> Result<Vec<Vec<Reduced>>, Unfit> {
        let n = self.forces.parameters().len();
        let reduce = |(window, sums)| reduced(sums, n, 0.0).ok_or_else(|| self.without_start(window));
        let all = self.groups.iter().zip(sums);
        all.map(|(group, sums)| group.windows.iter().zip(sums).map(reduce).collect()).collect()
    }

    /// The second and first derivatives by θ, of `n` parameters, of half the recordings' part of the cost.
    pub(crate) fn information(
        &self,
        n: usize,
        sums: &[Vec<WindowSums>],
        windows: &[Vec<Reduced>],
    ) -> (Vec<f64>, Vec<f64>) {
        let (mut products, mut gradient) = (vec![0.0; n * n], vec![0.0; n]);
        for (window_sums, window) in sums.iter().flatten().zip(windows.iter().flatten()) {
            let weight = self.weight(&window_sums.errors);
            products.iter_mut().zip(&window.products).for_each(|(sum, entry)| *sum += weight * entry);
            gradient.iter_mut().zip(&window.gradient).for_each(|(sum, slope)| *sum += weight * slope);
        }
        (products, gradient)
    }

    /// What the prior of each of θ adds to the second and to the first derivative of half the cost.
    pub(crate) fn prior_gradient(&self, theta: &[f64]) -> Vec<[f64; 2]> {
        prior_gradient(theta, &self.priors, self.prior_cost())
    }

    pub(crate) fn weight(&self, window: &WindowErrors) -> f64 {
        self.share(window) * window.slope(self.settings.knee) / window.numbers()
    }

    fn diverged(&self, at: &Fit) -> Unfit {
        for (group, starts) in self.groups.iter().zip(&at.starts) {
            let errors = self.errors(group, &at.theta, starts);
            let pairs = group.windows.iter().zip(&errors);
            if let Some((window, _)) = pairs.into_iter().find(|(_, error)| !error.rms().is_finite()) {
                let recording = self.recordings[window.recording].name.to_owned();
                return Unfit::Diverged { recording, first_s: window.first as f64 * self.settings.sample_s };
            }
        }
        Unfit::Boundless
    }

    pub(crate) fn without_start(&self, window: &Window) -> Unfit {
        let recording = self.recordings[window.recording].name.to_owned();
        Unfit::Start { recording, first_s: window.first as f64 * self.settings.sample_s }
    }
}

/// A search for θ from which the starts of windows are eliminated: they follow it.
struct WindowSearch<'p> {
    pass: &'p Pass<'p>,
    at: Fit,
    /// Where the last step led.
    next: Fit,
    sums: Vec<Vec<WindowSums>>,
    reduced: Vec<Vec<Reduced>>,
}

impl WindowSearch<'_> {
    fn reach(&mut self, theta: &[f64]) {
        if self.next.theta == theta && self.next.cost < self.at.cost {
            self.at = self.next.clone();
        }
    }

    fn expansion(&self) -> Expansion {
        let n = self.at.theta.len();
        let (normal, mut gradient) = self.pass.information(n, &self.sums, &self.reduced);
        gradient.iter_mut().for_each(|slope| *slope = -*slope);
        let unit = self.at.cost + LEAST / (ENOUGH * ENOUGH);
        let mut expansion = Expansion { cost: 0.0, unit, normal, gradient };
        add_priors(&mut expansion, &self.at.theta, &self.pass.priors, self.pass.prior_cost());
        Expansion { cost: self.at.cost, ..expansion }
    }
}

impl Residuals<(), Unfit> for WindowSearch<'_> {
    fn linearize(&mut self, asked: &[Linearization]) -> Result<Vec<(Expansion, ())>, Unfit> {
        let expand = |request: &Linearization| {
            self.reach(&request.point);
            self.sums = self.pass.all_sums(&self.at.theta, &self.at.starts);
            self.reduced = self.pass.determined(&self.sums)?;
            Ok((self.expansion(), ()))
        };
        asked.iter().map(expand).collect()
    }

    fn has_costs(&self) -> bool {
        true
    }

    fn cost(&mut self, trial: &Linearization) -> f64 {
        let change: Vec<f64> = trial.point.iter().zip(&self.at.theta).map(|(new, old)| new - old).collect();
        let starts = self.at.starts.iter().zip(&self.reduced).map(|(starts, windows)| {
            starts.iter().zip(windows).map(|(start, window)| window.start(*start, &change)).collect()
        });
        self.next = self.pass.at(trial.point.clone(), starts.collect());
        self.next.cost
    }

    fn damped(&mut self, damping: f64) -> Option<Expansion> {
        let n = self.at.theta.len();
        let reduce = |group: &Vec<WindowSums>| group.iter().map(|sums| reduced(sums, n, damping)).collect();
        self.reduced = self.sums.iter().map(reduce).collect::<Option<_>>()?;
        Some(self.expansion())
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        self.pass.forces.parameters().iter().map(|parameter| parameter.bounds).collect()
    }
}

impl Reduced {
    fn start(&self, old: [f64; 3], change: &[f64]) -> [f64; 3] {
        let n = change.len();
        [0, 1, 2].map(|d: usize| {
            let followed: f64 = (0..n).map(|i| self.follows[d * n + i] * change[i]).sum();
            old[d] + self.stays[d] + followed
        })
    }
}

/// A free parameter after the fit, in the system that it was written in.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its estimate.
    pub value: f64,
    /// Its standard error; none at a bound.
    pub standard_error: Option<f64>,
    /// How much of the estimate is the prior's, from 0 to 1.
    pub prior_share: f64,
    /// By what the standard error grows because others are unknown; none where recordings leave a direction open.
    pub inflation: Option<f64>,
}

/// The errors of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimates {
    /// One per free parameter.
    pub parameters: Vec<Parameter>,
    /// Covariance of the estimates; rows and columns of those at bounds are 0.
    pub covariance: Vec<f64>,
    /// Square root of the largest over the smallest eigenvalue of the recordings' information, in correlations.
    pub condition: f64,
    /// Pieces of recordings that count as independent.
    pub pieces: usize,
}

/// Weakest eigenvalue of an information in correlations that still counts as one.
const OPEN: f64 = 1e-14;

impl Problem<'_> {
    /// The errors of `fit`, from pieces of the windows as clusters; what the priors do not know is added.
    ///
    /// # Errors
    /// A parameter that nothing determines.
    pub fn estimates(&self, fit: &Fit) -> Result<Estimates, Unfit> {
        Pass::new(self, fit.first).estimates(fit)
    }
}

impl Pass<'_> {
    fn estimates(&self, fit: &Fit) -> Result<Estimates, Unfit> {
        let n = fit.theta.len();
        let sums = self.all_sums(&fit.theta, &fit.starts);
        let windows = self.determined(&sums)?;
        let (data, gradient) = self.information(n, &sums, &windows);
        let (mut meat, mut pieces) = (vec![0.0; n * n], 0);
        for (window_sums, window) in sums.iter().flatten().zip(windows.iter().flatten()) {
            let weight = self.weight(&window_sums.errors);
            let scores = window_sums.scores(window, n).into_iter();
            for score in scores.filter(|score| score.iter().any(|entry| *entry != 0.0)) {
                let score: Vec<f64> = score.iter().map(|entry| weight * entry).collect();
                numerics::add_outer(&mut meat, &score, &score);
                pieces += 1;
            }
        }
        self.errors_of(fit, (data, meat), gradient, pieces)
    }

    /// The errors of `fit`, from the information and the scores' products of the recordings, and their gradient.
    fn errors_of(
        &self,
        fit: &Fit,
        (data, mut meat): (Vec<f64>, Vec<f64>),
        mut gradient: Vec<f64>,
        pieces: usize,
    ) -> Result<Estimates, Unfit> {
        let n = fit.theta.len();
        let pulls = self.prior_gradient(&fit.theta);
        gradient.iter_mut().zip(&pulls).for_each(|(sum, [_, slope])| *sum += slope);
        let pulls: Vec<f64> = pulls.iter().map(|[pull, _]| *pull).collect();
        let held = at_bound(self.forces, &fit.theta, &gradient);
        let free: Vec<usize> = (0..n).filter(|i| !held[*i]).collect();
        let m = free.len();
        let information = block(&data, n, &free);
        let mut bread = information.clone();
        (0..m).for_each(|i| bread[i * m + i] += pulls[free[i]]);
        let inverse = scaled_inverse(m, &bread).ok_or_else(|| self.undetermined(&free, &bread))?;
        let shares: Vec<f64> = (0..m).map(|i| inverse[i * m + i] * pulls[free[i]]).collect();
        // Parameters that the recordings determine use up pieces.
        let used = m as f64 - shares.iter().sum::<f64>();
        let correction = pieces as f64 / (pieces as f64 - used).max(1.0);
        meat.iter_mut().for_each(|entry| *entry *= correction);
        let mut meat = block(&meat, n, &free);
        (0..m).for_each(|i| {
            meat[i * m + i] +=
                self.priors[free[i]].map_or(0.0, |prior| (pulls[free[i]] * prior.deviation).powi(2));
        });
        let inner_covariance = congruence(m, &inverse, &meat);
        let mut covariance = vec![0.0; n * n];
        (0..m * m).for_each(|k| covariance[free[k / m] * n + free[k % m]] = inner_covariance[k]);
        let (condition, inflations) = conditioned(m, &information);
        let parameter = |i: usize| {
            let place = free.iter().position(|free_one| *free_one == i);
            Parameter {
                name: self.forces.parameters()[i].name.clone(),
                value: fit.theta[i],
                standard_error: place.map(|_| covariance[i * n + i].sqrt()),
                prior_share: place.map_or(0.0, |k| shares[k].clamp(0.0, 1.0)),
                inflation: place.and_then(|k| inflations.as_ref().map(|growth| growth[k])),
            }
        };
        let parameters = (0..n).map(parameter).collect();
        Ok(Estimates { parameters, covariance, condition, pieces })
    }

    pub(crate) fn undetermined(&self, free: &[usize], bread: &[f64]) -> Unfit {
        let m = free.len();
        let weakest = numerics::weakest(m, bread).map_or(0, |weakest| weakest.dominant(m));
        Unfit::Undetermined(self.forces.parameters()[free[weakest]].name.clone())
    }
}

/// The condition index of an information, and by what each standard error grows because of the others.
pub(crate) fn conditioned(n: usize, information: &[f64]) -> (f64, Option<Vec<f64>>) {
    let scale: Vec<f64> = (0..n).map(|i| information[i * n + i].sqrt()).collect();
    let scaled: Vec<f64> = (0..n * n).map(|k| information[k] / (scale[k / n] * scale[k % n])).collect();
    let Some((values, vectors)) = symmetric(n, &scaled) else { return (f64::INFINITY, None) };
    let (low, high) = (values.first().copied().unwrap_or(1.0), values.last().copied().unwrap_or(1.0));
    if low <= OPEN * high {
        return (f64::INFINITY, None);
    }
    let inflation = |i: usize| (0..n).map(|k| vectors[i * n + k].powi(2) / values[k]).sum::<f64>().sqrt();
    ((high / low).sqrt(), Some((0..n).map(inflation).collect()))
}
