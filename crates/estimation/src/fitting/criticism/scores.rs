//! Scores of candidates, from which fitted numbers and starts of windows are projected out.

use numerics::scaled_inverse;
use rayon::prelude::*;

use super::columns::{Block, Column};
use crate::fitting::bounded::held;
use crate::fitting::normal::Reduced;
use crate::fitting::pass::Pass;
use crate::fitting::sums::Sums;
use crate::fitting::{Fit, Unfit};

/// A candidate whose derivatives the fitted numbers explain but for this share cannot be told from them.
const LEFT: f64 = 1e-6;
/// Share of the weight of priors that is kept, so that what nothing determines stays. Priors weigh more than noise does:
/// where they are kept, candidates would make up for them.
const KEPT: f64 = 1e-4;
/// Windows are the independent units where there are so many for each number that they determine; else pieces are.
const ENOUGH: f64 = 4.0;

/// The score of a candidate.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Score {
    /// g: half the derivative of the cost by its number.
    pub gradient: f64,
    /// H: half its second derivative.
    pub curvature: f64,
    /// Its part in each independent unit.
    pub units: Vec<f64>,
}

/// The scores of all candidates.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scores {
    /// In order; none where the fitted numbers explain a candidate.
    pub all: Vec<Option<Score>>,
    /// Number of independent units.
    pub units: usize,
    /// Whether these are whole windows; else pieces of them.
    pub whole: bool,
}

impl Score {
    /// z: the gradient in its standard deviations.
    pub fn standardised(&self) -> f64 {
        self.gradient / self.variance().sqrt().max(f64::MIN_POSITIVE)
    }

    /// V.
    pub fn variance(&self) -> f64 {
        self.units.iter().map(|own| own * own).sum()
    }

    /// By how much the cost would fall if it were added.
    pub fn gain(&self) -> f64 {
        self.gradient * self.gradient / self.curvature
    }

    /// Its number if it were added, and the standard error of that.
    pub fn value(&self) -> (f64, f64) {
        (-self.gradient / self.curvature, self.variance().sqrt() / self.curvature)
    }
}

/// The inverse second derivatives of half the cost by the free numbers, and what is left of its first ones.
struct Fitted {
    free: Vec<usize>,
    inverse: Vec<f64>,
    gradient: Vec<f64>,
    /// Numbers that the recordings determine.
    used: f64,
}

/// Sums over all windows for one candidate.
struct Total {
    across: Vec<f64>,
    square: f64,
    gradient: f64,
}

impl Pass<'_> {
    /// The scores of the candidates of `blocks` after `fit`.
    ///
    /// # Errors
    /// A start of a window or a number that nothing determines.
    pub(crate) fn scores(&self, fit: &Fit, blocks: &[Block]) -> Result<Scores, Unfit> {
        let groups: Vec<_> = self.groups.iter().zip(&fit.starts).collect();
        let found: Result<Vec<_>, Unfit> = groups
            .par_iter()
            .map(|(group, starts)| self.columns(group, (&fit.theta, starts), blocks))
            .collect();
        let (sums, columns): (Vec<Vec<Sums>>, Vec<Vec<Vec<Column>>>) = found?.into_iter().unzip();
        let reduced = self.determined(&sums)?;
        let fitted = self.fitted(fit, &sums, &reduced)?;
        let windows: Vec<(&Sums, &Reduced, &Vec<Column>)> = sums
            .iter()
            .zip(&reduced)
            .zip(&columns)
            .flat_map(|((sums, reduced), columns)| sums.iter().zip(reduced).zip(columns))
            .map(|((sums, reduced), columns)| (sums, reduced, columns))
            .collect();
        let whole = windows.len() as f64 >= ENOUGH * fitted.used;
        let count = blocks.iter().map(Block::count).sum();
        let of = |j: usize| self.score(&fitted, &windows, j, whole);
        let all: Vec<Option<Score>> = (0..count).into_par_iter().map(of).collect();
        let units = match whole {
            true => windows.len(),
            false => windows.iter().map(|(sums, _, _)| sums.pieces.len()).sum(),
        };
        Ok(Scores { all, units, whole })
    }

    fn fitted(&self, fit: &Fit, sums: &[Vec<Sums>], reduced: &[Vec<Reduced>]) -> Result<Fitted, Unfit> {
        let n = fit.theta.len();
        let (data, mut gradient) = self.information(n, sums, reduced);
        let pulls = self.pulls(&fit.theta);
        let whole: Vec<f64> = gradient.iter().zip(&pulls).map(|(own, [_, pull])| own + pull).collect();
        let held = held(self.forces, &fit.theta, &whole);
        gradient.iter_mut().zip(&pulls).for_each(|(sum, [_, own])| *sum += KEPT * own);
        let free: Vec<usize> = (0..n).filter(|i| !held[*i]).collect();
        let m = free.len();
        let mut bread: Vec<f64> = (0..m * m).map(|k| data[free[k / m] * n + free[k % m]]).collect();
        (0..m).for_each(|i| bread[i * m + i] += KEPT * pulls[free[i]][0]);
        let inverse = scaled_inverse(m, &bread).ok_or_else(|| self.undetermined(&free, &bread))?;
        let used = m as f64 - (0..m).map(|i| KEPT * inverse[i * m + i] * pulls[free[i]][0]).sum::<f64>();
        let gradient = free.iter().map(|i| gradient[*i]).collect();
        Ok(Fitted { free, inverse, gradient, used })
    }

    fn total(&self, n: usize, windows: &[(&Sums, &Reduced, &Vec<Column>)], j: usize) -> Total {
        let mut total = Total { across: vec![0.0; n], square: 0.0, gradient: 0.0 };
        for (sums, _, columns) in windows {
            let (weight, own) = (self.weight(&sums.errors), &columns[j]);
            total.across.iter_mut().zip(&own.across).for_each(|(sum, own)| *sum += weight * own);
            total.square += weight * own.square;
            total.gradient += weight * own.scores.iter().sum::<f64>();
        }
        total
    }

    fn score(
        &self,
        fitted: &Fitted,
        windows: &[(&Sums, &Reduced, &Vec<Column>)],
        j: usize,
        whole: bool,
    ) -> Option<Score> {
        let n = self.forces.parameters().len();
        let total = self.total(n, windows, j);
        let across: Vec<f64> = fitted.free.iter().map(|i| total.across[*i]).collect();
        let m = across.len();
        // How the fitted numbers would follow the candidate.
        let follows: Vec<f64> =
            (0..m).map(|i| numerics::dot(&fitted.inverse[i * m..(i + 1) * m], &across)).collect();
        let curvature = total.square - numerics::dot(&follows, &across);
        if !(curvature > LEFT * total.square && curvature.is_finite()) {
            return None;
        }
        let gradient = total.gradient - numerics::dot(&follows, &fitted.gradient);
        let mut units = Vec::new();
        for (sums, reduced, columns) in windows {
            let weight = self.weight(&sums.errors);
            let pieces = sums.scores(reduced, n).into_iter().zip(&columns[j].scores).map(|(known, own)| {
                let known: f64 = fitted.free.iter().zip(&follows).map(|(i, own)| own * known[*i]).sum();
                weight * (own - known)
            });
            match whole {
                true => units.push(pieces.sum()),
                false => units.extend(pieces),
            }
        }
        // Numbers that the recordings determine use up units.
        let count = units.len() as f64;
        let correction = (count / (count - fitted.used).max(1.0)).sqrt();
        units.iter_mut().for_each(|unit| *unit *= correction);
        Some(Score { gradient, curvature, units })
    }
}
