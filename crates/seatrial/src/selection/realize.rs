use identification::Sums;
use identification::pooled::{Score, Windows, fit};
use vessel::{LANES, Lane};

use super::Draw;
use crate::pooled::{Method, Pool, Used};

/// One realization: what was picked, and what its model is worth.
#[derive(Clone, Debug, PartialEq)]
pub struct Realization {
    /// The parts.
    pub picked: Vec<usize>,
    /// Free simulation over all parts; `None` without a model.
    pub overlapping: Option<Score>,
    /// Over those that were not picked.
    pub left_out: Option<Score>,
}

/// Makes realizations from sums per part.
pub struct Realizer<'a> {
    /// What all have in common.
    pub pool: &'a Pool<'a>,
    /// The estimator.
    pub method: Method,
    /// Nominal parameters that a prior pulls to.
    pub nominal: Option<&'a [f64]>,
    /// Sums per part with the regressors as instruments.
    pub ls: &'a [Sums],
    /// Sums per part with simulated instruments.
    pub iv: Option<&'a [Sums]>,
    /// All parts, to simulate over.
    pub windows: &'a Windows,
    /// Whether estimated intercepts are simulated too.
    pub intercepts: bool,
}

impl Realizer<'_> {
    /// Up to [`LANES`] realizations, from `first` on.
    pub fn chunk(&self, draw: &Draw, first: u32, count: usize) -> Vec<Realization> {
        let picked: Vec<Vec<usize>> = (0..count as u32).map(|i| draw.realization(first + i)).collect();
        let models: Vec<Option<Vec<f64>>> = picked.iter().map(|own| self.model(own)).collect();
        let zero = vec![0.0; self.pool.lifted.parameters()];
        let model = |lane: usize| models.get(lane).and_then(Option::as_deref).unwrap_or(&zero);
        let lanes: Vec<Lane> = (0..zero.len())
            .map(|i| Lane(std::array::from_fn::<f64, LANES, _>(|lane| model(lane)[i])))
            .collect();
        let mut scores = vec![[Score::default(); 2]; count];
        for part in 0..self.windows.len() {
            let found = self.windows.run(&lanes, part);
            for (lane, own) in picked.iter().enumerate() {
                scores[lane][0].add(found[lane], self.windows.samples(part));
                if own.binary_search(&part).is_err() {
                    scores[lane][1].add(found[lane], self.windows.samples(part));
                }
            }
        }
        let mut out = Vec::with_capacity(count);
        for ((picked, model), [all, rest]) in picked.into_iter().zip(&models).zip(scores) {
            let of_model = |score| model.as_ref().map(|_| score);
            out.push(Realization { picked, overlapping: of_model(all), left_out: of_model(rest) });
        }
        out
    }

    /// The lifted parameters of the model from parts `picked`. Collinear picks are answered: what comes of them is what
    /// the study shows.
    fn model(&self, picked: &[usize]) -> Option<Vec<f64>> {
        let fitted = |sums: &[Sums], used: Used, most: Option<f64>| {
            let own: Vec<&Sums> = picked.iter().map(|i| &sums[*i]).collect();
            let options = self.pool.options(self.nominal, used);
            let most = most.unwrap_or(options.most);
            fit(&own, &identification::pooled::Options { most, ..options }).map(|degree| degree.solution)
        };
        let solutions = match (self.method, self.iv) {
            (Method::Ls, _) | (_, None) => fitted(self.ls, Used::Ls, None),
            (Method::Auto, Some(iv)) => {
                let mut own = fitted(iv, Used::Iv, None);
                if own.iter().any(Option::is_none) {
                    for (own, least) in own.iter_mut().zip(fitted(self.ls, Used::Ls, None)) {
                        *own = own.take().or(least);
                    }
                }
                own
            }
            (_, Some(iv)) => fitted(iv, Used::Iv, Some(f64::INFINITY)),
        };
        let intercepts = [0, 1, 2]
            .map(|d: usize| solutions[d].as_ref().filter(|_| self.intercepts).map_or(0.0, |s| s.intercept));
        let theta: Option<Vec<Vec<f64>>> =
            solutions.into_iter().map(|solution| solution.map(|s| s.theta)).collect();
        Some(self.pool.lifted.layout().woven(&theta?.concat(), intercepts))
    }
}
