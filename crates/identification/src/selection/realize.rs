use vessel::lanes::interleave;

use super::draw::Draw;
use super::prepared::Prepared;
use crate::pooled::{Errors, Options, Pool, Score, Solution, Windows, fit};
use crate::{Estimator, ScoreStatus, Sums};

/// One realization: what was picked, and what its model is worth.
#[derive(Clone, Debug, PartialEq)]
pub struct Realization {
    /// Its number.
    pub number: u32,
    /// Places of the parts, ascending.
    pub picked: Vec<usize>,
    /// What became of its model over all parts.
    pub status: ScoreStatus,
    /// Free simulation over all parts; `None` without a model and where one diverged.
    pub overlapping: Option<Errors>,
    /// Over those that were not picked.
    pub left_out: Option<Errors>,
}

/// Makes realizations from sums per part.
pub(super) struct Realizer<'a> {
    /// What all have in common.
    pub pool: &'a Pool<'a>,
    /// The estimator.
    pub estimator: Estimator,
    /// Sums per part.
    pub prepared: &'a Prepared,
    /// All parts, to simulate over.
    pub windows: &'a Windows,
    /// Standard deviations of u, v, r over them.
    pub std: [f64; 3],
}

impl Realizer<'_> {
    /// Up to [`vessel::LANES`] realizations, from `first` on.
    pub(super) fn chunk(&self, draw: &Draw, first: u32, count: usize) -> Vec<Realization> {
        let picked: Vec<Vec<usize>> = (0..count as u32).map(|i| draw.realization(first + i)).collect();
        let models: Vec<Option<Vec<f64>>> = picked.iter().map(|own| self.model(own)).collect();
        let scores = self.scores(&picked, &models);
        let each = picked.into_iter().zip(&models).zip(scores).zip(first..);
        each.map(|(((picked, model), [all, rest]), number)| {
            let errors = |score: &Score| model.as_ref().and_then(|_| Errors::of(score, self.std));
            let overlapping = errors(&all);
            let status = match (model, overlapping) {
                (None, _) => ScoreStatus::NotIdentifiable,
                (Some(_), None) => ScoreStatus::Diverged,
                (Some(_), Some(_)) => ScoreStatus::Scored,
            };
            Realization { number, picked, status, overlapping, left_out: errors(&rest) }
        })
        .collect()
    }

    /// Scores over all parts and over those not `picked`, the models side by side.
    fn scores(&self, picked: &[Vec<usize>], models: &[Option<Vec<f64>>]) -> Vec<[Score; 2]> {
        let zero = vec![0.0; self.pool.model.parameters()];
        let lanes = interleave(&models.iter().map(|m| m.as_deref().unwrap_or(&zero)).collect::<Vec<_>>());
        let mut scores = vec![[Score::default(); 2]; picked.len()];
        for part in 0..self.windows.len() {
            let found = self.windows.run(&lanes, part);
            for (lane, own) in picked.iter().enumerate() {
                scores[lane][0].add(found[lane], self.windows.samples(part));
                if own.binary_search(&part).is_err() {
                    scores[lane][1].add(found[lane], self.windows.samples(part));
                }
            }
        }
        scores
    }

    /// The parameters of the model from parts `picked`, intercepts among them.
    fn model(&self, picked: &[usize]) -> Option<Vec<f64>> {
        let solutions = self.solutions(picked);
        let intercepts = solutions.each_ref().map(|s| s.as_ref().map_or(0.0, |s| s.intercept));
        let theta: Option<Vec<Vec<f64>>> =
            solutions.into_iter().map(|solution| solution.map(|s| s.theta)).collect();
        Some(self.pool.model.layout().woven(&theta?.concat(), intercepts))
    }

    /// Collinear picks are answered (by `auto` with least squares): what comes of them is what the study shows.
    fn solutions(&self, picked: &[usize]) -> [Option<Solution>; 3] {
        let Prepared { ls, iv, nominal, .. } = self.prepared;
        let fitted = |sums: &[Sums], options: Options| {
            let own: Vec<&Sums> = picked.iter().map(|i| &sums[*i]).collect();
            fit(&own, &options).map(|degree| degree.solution)
        };
        let options = |used: Estimator| self.pool.options(nominal.as_deref(), used);
        match (self.estimator, iv) {
            (Estimator::Ls, _) | (_, None) => fitted(ls, options(Estimator::Ls)),
            (Estimator::Auto, Some(iv)) => {
                let mut own = fitted(iv, options(Estimator::Iv));
                if own.iter().any(Option::is_none) {
                    for (own, least) in own.iter_mut().zip(fitted(ls, options(Estimator::Ls))) {
                        *own = own.take().or(least);
                    }
                }
                own
            }
            (_, Some(iv)) => fitted(iv, Options { most: f64::INFINITY, ..options(Estimator::Iv) }),
        }
    }
}
