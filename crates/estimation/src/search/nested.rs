use std::collections::BTreeMap;
use std::convert::Infallible;

use numerics::Watch;
use numerics::least_squares::{Ended, Ending, Expansion, Linearization, Residuals, minimize};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::Model;

use super::problem::WindowProblem;
use super::{Laid, Recording, limit, mean_fit, scores, standard_error, together};
use crate::pooled::Score;

/// These begin near a minimum.
const ALONG: Ending = Ending { steps: 2, enough: 0.03, damping: 1e-6 };
const BASE: Ending = Ending { steps: 20, enough: 3e-3, ..ALONG };
/// No smaller ridge is tried after this many candidates worse than the best: with few recordings a large ridge may be
/// better than its neighbours without being the best of all.
const WORSE: usize = 3;

/// Differences in mean fit \[%\] below this count as ties. On the Esso Osaka, with five ways to deal its recordings,
/// and on the KVLCC2 the fits with 0.05 and 0 were better than with 0.2, by 0.1 to 0.3.
const TIE: f64 = 0.05;

pub(crate) type Folds<'r> = [Vec<&'r Recording>];

pub(crate) struct Study<'a> {
    /// Both with intercepts; the base's terms come first in each degree of freedom of the library.
    pub base: &'a Model,
    pub library: &'a Model,
    pub recordings: &'a [Recording],
    pub folds: &'a [usize],
    pub ridges: &'a [f64],
    pub rate_hz: f64,
    /// Of u, v, r over consecutive windows, over those that overlap, and over those that choose the ridge.
    pub std: [f64; 3],
    pub overlapping_std: [f64; 3],
    pub choosing_std: [f64; 3],
    pub whole_runs: bool,
}

const DELIVERED: Ending = Ending { steps: 20, enough: 1e-3, ..ALONG };

/// Fits without some folds, from the largest ridge on, each from the cheapest of the one before and two others.
pub(crate) struct RidgePath<'a> {
    problem: WindowProblem<'a>,
    pub limit: [f64; 3],
    pub base: Option<Vec<f64>>,
    /// Starts in scaled parameters of the library: that, the library's least squares, and zero.
    starts: Vec<Vec<f64>>,
    last: Option<Vec<f64>>,
    pub thetas: Vec<Option<Vec<f64>>>,
}

/// One ridge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Candidate {
    /// Λ.
    pub ridge: f64,
    /// Mean fit of u, v, r over windows of the recordings when they were left out \[%\]; none where a fold was rejected.
    pub score: Option<f64>,
    /// Its standard error.
    pub standard_error: Option<f64>,
    /// Folds whose fit diverged, or whose model left every bound on what was left out, over windows or over what is scored.
    pub rejected: u64,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Choice {
    pub candidates: Vec<Candidate>,
    ended: bool,
}

impl Choice {
    /// The index of the best; among ties, the one with the largest ridge.
    pub fn best(&self) -> Option<usize> {
        let (_, highest) = self.highest()?;
        let as_good = |c: &Candidate| c.score.is_some_and(|score| score >= highest - TIE);
        self.candidates.iter().position(as_good)
    }

    fn highest(&self) -> Option<(usize, f64)> {
        let scores = self.candidates.iter().enumerate().filter_map(|(i, c)| Some((i, c.score?)));
        scores.reduce(|best, candidate| if candidate.1 > best.1 { candidate } else { best })
    }

    fn add(&mut self, candidate: Candidate) {
        self.candidates.push(candidate);
        self.ended = self.highest().is_some_and(|(best, _)| self.candidates.len() > best + WORSE);
    }
}

pub(crate) struct Fitted {
    pub model: Model,
    pub theta: Vec<f64>,
}

pub(crate) struct Nested<'a> {
    pub all: Choice,
    pub without: Vec<Choice>,
    pub paths: BTreeMap<Vec<usize>, RidgePath<'a>>,
}

impl<'a> Study<'a> {
    /// Indices of the folds.
    pub fn all_folds(&self) -> std::ops::Range<usize> {
        0..self.folds.iter().max().map_or(0, |last| last + 1)
    }

    /// The recordings of `fold`.
    pub fn within(&self, fold: usize) -> Vec<&'a Recording> {
        self.picked(|other| other == fold)
    }

    /// The folds except the one at `without`.
    pub fn others(&self, without: Option<usize>) -> Vec<Vec<&'a Recording>> {
        self.all_folds().filter(|fold| Some(*fold) != without).map(|fold| self.within(fold)).collect()
    }

    /// The recordings of the folds that `keep` picks.
    pub fn picked(&self, keep: impl Fn(usize) -> bool) -> Vec<&'a Recording> {
        self.recordings.iter().zip(self.folds).filter(|(_, fold)| keep(**fold)).map(|(r, _)| r).collect()
    }

    /// The path without some folds, before its first ridge: the base by least squares, then by output errors.
    pub fn path(&self, without: &[usize]) -> RidgePath<'a> {
        let recordings = self.picked(|fold| !without.contains(&fold));
        let base = started(self.base, &recordings, self.rate_hz, BASE);
        let problem = WindowProblem::new(self.library, &recordings, self.rate_hz);
        let simple = least_squares(self.library, &recordings, self.rate_hz).map(|beta| problem.theta(&beta));
        let wide = base.as_ref().map(|base| widened(self.base, self.library, base));
        let problem = match &wide {
            Some(wide) => problem.by_effect(wide, &self.known()),
            None => problem,
        };
        let [wide, simple] = [wide, simple].map(|theta| theta.map(|theta| problem.beta(&theta)));
        // From zero no simulation diverges.
        let none = vec![0.0; self.library.parameters()];
        let starts = wide.into_iter().chain(simple).chain([none]).collect();
        RidgePath { problem, limit: limit(&recordings), base, starts, last: None, thetas: Vec::new() }
    }

    /// The ridge that was chosen without the fold at `without`, and the base structure fitted to the others.
    pub fn given(&self, nested: &Nested, chosen: usize, without: Option<usize>) -> Option<(f64, Vec<f64>)> {
        let Some(fold) = without else {
            return Some((self.ridges[chosen], self.base_of_all()?));
        };
        let choice = &nested.without[fold];
        let ridge = choice.best().map(|best| choice.candidates[best].ridge)?;
        Some((ridge, nested.paths[&vec![fold]].base.clone()?))
    }

    /// The base structure, fitted to all.
    pub fn base_of_all(&self) -> Option<Vec<f64>> {
        started(self.base, &self.picked(|_| true), self.rate_hz, BASE)
    }

    /// Indices in the library of the base structure's parameters.
    pub fn base_places(&self) -> Vec<usize> {
        let (base_layout, all) = (self.base.layout(), self.library.layout());
        let intercept = |d: usize| all.terms(d).end..all.degree(d).end;
        let places = |d: usize| (all.degree(d).start..).take(base_layout.terms(d).len()).chain(intercept(d));
        (0..3).flat_map(places).collect()
    }

    /// Which parameters of the library are the base structure's.
    pub fn known(&self) -> Vec<bool> {
        let places = self.base_places();
        (0..self.library.parameters()).map(|i| places.contains(&i)).collect()
    }

    /// Chooses the ridge by recordings that are left out.
    pub fn choice(&self) -> Choice {
        let sets: Vec<Vec<usize>> = self.all_folds().map(|fold| vec![fold]).collect();
        let paths: Vec<RidgePath> = sets.par_iter().map(|set| self.path(set)).collect();
        let mut paths: BTreeMap<Vec<usize>, RidgePath> = sets.into_iter().zip(paths).collect();
        let mut choice = Choice::default();
        for ridge in self.ridges {
            if choice.ended {
                break;
            }
            let all: Vec<&mut RidgePath> = paths.values_mut().collect();
            all.into_par_iter().for_each(|path| path.fit_next(*ridge));
            choice.add(self.candidate(&paths, *ridge, &[]));
        }
        choice
    }

    /// Chooses the ridge by left-out recordings; again without each fold. A fit without two folds serves both.
    pub fn nested(&self, done: &(dyn Fn(usize) + Sync)) -> Nested<'a> {
        let count = self.all_folds().end;
        let sets: Vec<Vec<usize>> = (0..count)
            .flat_map(|i| std::iter::once(vec![i]).chain((i + 1..count).map(move |j| vec![i, j])))
            .collect();
        let paths: Vec<RidgePath> = sets.par_iter().map(|set| self.path(set)).collect();
        let paths = sets.into_iter().zip(paths).collect();
        let mut nested = Nested { all: Choice::default(), without: vec![Choice::default(); count], paths };
        for ridge in self.ridges {
            let open: Vec<bool> = nested.without.iter().map(|choice| !choice.ended).collect();
            let all = !nested.all.ended;
            if !all && !open.contains(&true) {
                break;
            }
            let wanted = |set: &[usize]| (all && set.len() == 1) || set.iter().any(|i| open[*i]);
            let moving: Vec<(&Vec<usize>, &mut RidgePath)> =
                nested.paths.iter_mut().filter(|(set, _)| wanted(set)).collect();
            moving.into_par_iter().for_each(|(_, path)| {
                path.fit_next(*ridge);
                done(1);
            });
            if all {
                let candidate = self.candidate(&nested.paths, *ridge, &[]);
                nested.all.add(candidate);
            }
            for i in (0..count).filter(|i| open[*i]) {
                let candidate = self.candidate(&nested.paths, *ridge, &[i]);
                nested.without[i].add(candidate);
            }
        }
        nested
    }

    /// Scores the last fits of `paths` on the folds except those `without`, each left out in turn.
    fn candidate(&self, paths: &BTreeMap<Vec<usize>, RidgePath>, ridge: f64, without: &[usize]) -> Candidate {
        let (mut all, mut rejected) = (Vec::new(), 0_u64);
        for fold in self.all_folds().filter(|fold| !without.contains(fold)) {
            let mut set = [without, &[fold]].concat();
            set.sort_unstable();
            match self.followed(&paths[&set], fold) {
                Some(followed) => all.extend(followed),
                None => rejected += 1,
            }
        }
        let whole = rejected == 0;
        Candidate {
            ridge,
            score: mean_fit(&together(all.iter()), self.choosing_std).filter(|_| whole),
            standard_error: standard_error(&all, self.choosing_std).filter(|_| whole),
            rejected,
        }
    }

    /// Scores the last fit on windows of the recordings of `fold`; `None` if it diverges over what is scored.
    fn followed(&self, path: &RidgePath, fold: usize) -> Option<Vec<Score>> {
        let (theta, recordings) = (path.last_theta()?, self.within(fold));
        let over = |laid| {
            let followed = scores(self.library, theta, &recordings, laid, path.limit);
            Some(followed).filter(|scores| scores.iter().all(|score| score.diverged == 0))
        };
        if self.whole_runs {
            over(Laid::SideBySide)?;
        }
        over(Laid::Choosing)
    }
}

impl RidgePath<'_> {
    /// Fits at the next ridge.
    pub fn fit_next(&mut self, ridge: f64) {
        let starts = self.starts.iter().chain(&self.last);
        self.last = minimum_from(&self.problem, starts, ridge, ALONG);
        self.thetas.push(self.last.as_ref().map(|beta| self.problem.theta(beta)));
    }

    /// The last fit, run to convergence.
    pub fn delivered(&self, ridge: f64) -> Option<Fitted> {
        let beta = minimum(&self.problem, self.last.clone()?, ridge, DELIVERED)?;
        Some(Fitted { model: self.problem.model.clone(), theta: self.problem.theta(&beta) })
    }

    pub fn last_theta(&self) -> Option<&[f64]> {
        self.thetas.last()?.as_deref()
    }
}

/// θ of `base` as θ of `library`, whose other terms are 0.
pub(crate) fn widened(base: &Model, library: &Model, theta: &[f64]) -> Vec<f64> {
    let (base_layout, all) = (base.layout(), library.layout());
    let (mut out, intercepts) = (vec![0.0; all.parameters()], base_layout.intercepts(theta));
    for d in 0..3 {
        let terms = &theta[base_layout.terms(d)];
        out[all.terms(d)][..terms.len()].copy_from_slice(terms);
        out[all.terms(d).end..all.degree(d).end].fill(intercepts[d]);
    }
    out
}

/// loss(β) + ridge |β|².
struct Penalised<'a> {
    problem: &'a WindowProblem<'a>,
    ridge: f64,
    /// The loss where a step led, and the weights of the windows.
    looked: Option<(f64, Vec<f64>)>,
}

impl Residuals for Penalised<'_> {
    fn linearize(&mut self, asked: &[Linearization]) -> Result<Vec<(Expansion, ())>, Infallible> {
        let expand = |Linearization { point, .. }: &Linearization| {
            let looked = self.looked.take().or_else(|| self.problem.look(point));
            let slopes = looked.and_then(|(loss, weights)| self.problem.slopes(point, (loss, &weights)));
            let mut all = slopes.unwrap_or_else(|| Expansion { cost: f64::NAN, ..Expansion::default() });
            for i in 0..all.gradient.len() {
                all.add_prior(i, point[i], self.ridge);
                let pivot = &mut all.normal[i * point.len() + i];
                // A term without effect stays.
                *pivot = if *pivot > 0.0 { *pivot } else { 1.0 };
            }
            (Expansion { unit: all.cost, ..all }, ())
        };
        Ok(asked.iter().map(expand).collect())
    }

    fn has_costs(&self) -> bool {
        true
    }

    fn cost(&mut self, trial: &Linearization) -> f64 {
        self.looked = self.problem.look(&trial.point);
        self.looked.as_ref().map_or(f64::NAN, |(loss, _)| cost(&trial.point, *loss, self.ridge))
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        self.problem.scaled_bounds()
    }

    fn condition(&self) -> f64 {
        // The ridge keeps collinear terms apart.
        f64::INFINITY
    }
}

/// Minimises loss(β) + ridge |β|² within bounds; `None` from beyond limits.
pub(crate) fn minimum(
    problem: &WindowProblem,
    start: Vec<f64>,
    ridge: f64,
    ending: Ending,
) -> Option<Vec<f64>> {
    let mut penalised = Penalised { problem, ridge, looked: None };
    let Ok(minima) = minimize(&mut penalised, vec![start], ending, &Watch::default());
    let minimum = minima.into_iter().next()?;
    (minimum.steps > 0 || minimum.status != Ended::Diverged).then_some(minimum.point)
}

fn cost(beta: &[f64], loss: f64, ridge: f64) -> f64 {
    loss + ridge * beta.iter().map(|b| b * b).sum::<f64>()
}

/// The minimum from the one of `starts` that costs least, so that a path recovers from a bad fit.
fn minimum_from<'s>(
    problem: &WindowProblem,
    starts: impl Iterator<Item = &'s Vec<f64>>,
    ridge: f64,
    ending: Ending,
) -> Option<Vec<f64>> {
    let costs = starts.filter_map(|beta| Some((cost(beta, problem.look(beta)?.0, ridge), beta)));
    let (_, start) = costs.min_by(|a, b| a.0.total_cmp(&b.0))?;
    minimum(problem, start.clone(), ridge, ending)
}

/// Weight of the penalty that keeps collinear terms of the base structure in place.
const NEARLY_NONE: f64 = 1e-8;

/// θ by output errors, nearly without a penalty, from least squares or, if that diverges, from zero.
fn started(model: &Model, recordings: &[&Recording], rate_hz: f64, ending: Ending) -> Option<Vec<f64>> {
    let none = vec![0.0; model.parameters()];
    let least = least_squares(model, recordings, rate_hz)?;
    let problem = WindowProblem::new(model, recordings, rate_hz);
    let from = |start| minimum(&problem, start, NEARLY_NONE, ending);
    from(least).or_else(|| from(none)).map(|beta| problem.theta(&beta))
}

fn least_squares(model: &Model, recordings: &[&Recording], rate_hz: f64) -> Option<Vec<f64>> {
    let simple = WindowProblem::increments(model, recordings, rate_hz);
    let none = vec![0.0; model.parameters()];
    minimum(&simple, none, NEARLY_NONE, Ending { steps: 1, enough: 0.0, ..ALONG })
}
