use estimation::pooled::{Pool, Score};
use estimation::{Estimator, ScoreStatus, free_runs};
use numerics::lanes::interleave;
use regression::Sums;
use regression::pooled::{Options, Solution, fit, joined};
use ship::engine::RunView;

use super::draw::Draw;
use super::prepared::Prepared;

/// One realization: the picked parts, and the score of its model.
#[derive(Clone, Debug, PartialEq)]
pub struct Realization {
    /// `optimized` or `random`.
    pub design: String,
    /// Its number.
    pub number: i32,
    /// Indices of the parts, ascending: `3 17 40`.
    pub picked: String,
    /// The status of its model over all parts.
    pub status: ScoreStatus,
    /// Free simulation over all parts: RMSE of u, v, r; absent without a model and if it diverged.
    pub rmse: Option<[f64; 3]>,
    /// Norm of RMSE/std.
    pub error_norm: Option<f64>,
    /// RMSE over the parts that were not picked.
    pub left_out_rmse: Option<[f64; 3]>,
    /// Norm of RMSE/std over them.
    pub left_out_norm: Option<f64>,
}

/// Makes realizations from sums per part.
pub(super) struct Realizer<'a> {
    /// The options of all estimates.
    pub pool: &'a Pool<'a>,
    /// The estimator.
    pub estimator: Estimator,
    /// Sums per part.
    pub prepared: &'a Prepared,
    /// All parts, to simulate over.
    pub parts: &'a [RunView<'a>],
    /// Standard deviations of u, v, r over them.
    pub std: [f64; 3],
}

impl Realizer<'_> {
    /// Up to [`numerics::LANES`] realizations, from `first` on.
    pub(super) fn chunk(&self, draw: &Draw, first: u32, count: usize) -> Vec<Realization> {
        let picked: Vec<Vec<usize>> = (0..count as u32).map(|i| draw.realization(first + i)).collect();
        let models: Vec<Option<Vec<f64>>> = picked.iter().map(|own| self.model(own)).collect();
        let scores = self.scores(&picked, &models);
        let realization = |i: usize| {
            let score = |which: usize| models[i].as_ref().map(|_| &scores[i][which]);
            let [rmse, left_out_rmse] = [0, 1].map(|which| score(which).and_then(Score::rmse));
            let [error_norm, left_out_norm] =
                [0, 1].map(|which| score(which).and_then(|score| score.norm(self.std)));
            Realization {
                design: draw.design.to_owned(),
                number: (first as usize + i) as i32,
                picked: picked[i].iter().map(usize::to_string).collect::<Vec<_>>().join(" "),
                status: match (&models[i], rmse) {
                    (None, _) => ScoreStatus::NotIdentifiable,
                    (Some(_), None) => ScoreStatus::Diverged,
                    (Some(_), Some(_)) => ScoreStatus::Scored,
                },
                rmse,
                error_norm,
                left_out_rmse,
                left_out_norm,
            }
        };
        (0..count).map(realization).collect()
    }

    /// Scores of the models, in lanes, over all parts and over those not `picked`.
    fn scores(&self, picked: &[Vec<usize>], models: &[Option<Vec<f64>>]) -> Vec<[Score; 2]> {
        let zero = vec![0.0; self.pool.model.parameters()];
        let lanes = interleave(&models.iter().map(|m| m.as_deref().unwrap_or(&zero)).collect::<Vec<_>>());
        let mut scores = vec![[Score::default(); 2]; picked.len()];
        for (place, part) in self.parts.iter().enumerate() {
            let found = free_runs(&self.pool.model, &lanes, part.exogenous, part.measured);
            for (lane, own) in picked.iter().enumerate() {
                scores[lane][0].add(found[lane], part.samples());
                if own.binary_search(&place).is_err() {
                    scores[lane][1].add(found[lane], part.samples());
                }
            }
        }
        scores
    }

    /// The parameters of the model from parts `picked`, intercepts among them.
    fn model(&self, picked: &[usize]) -> Option<Vec<f64>> {
        let (theta, intercepts) = joined(self.solutions(picked).each_ref().map(Option::as_ref))?;
        Some(self.pool.model.layout().woven(&theta, intercepts))
    }

    /// Collinear picks are estimated too (by `auto` with least squares): the study shows the errors.
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
