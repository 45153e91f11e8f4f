use numerics::distributions::log_chi_square_tail;
use numerics::{inverse, times};

use crate::predictor::{Linear, scaled_inverse};

/// A signal cannot be distinguished from the estimated unknowns if less than this share of it is left after
/// projection.
const LEFT: f64 = 1e-7;

/// A candidate for what the model lacks: unknowns that are zero in the model, each a sum of columns.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Group {
    /// Per unknown the columns that act together.
    pub unknowns: Vec<Vec<usize>>,
}

/// The score test of a group.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Score {
    /// T = sᵀV⁻¹s over the errors' variance.
    pub statistic: f64,
    /// Degrees of freedom.
    pub freedom: usize,
    /// log P(χ² ≥ T).
    pub log_p: f64,
    /// What each unknown would be if the group were added.
    pub values: Vec<f64>,
    /// Standard errors of these.
    pub standard_errors: Vec<f64>,
}

/// Whitened errors and sensitivities of all runs, projected onto the complement of the estimated unknowns.
#[derive(Clone, Debug)]
pub(super) struct Projected {
    columns: usize,
    /// s = W⊥ᵀ w⊥ of every column.
    scores: Vec<f64>,
    /// V = W⊥ᵀ W⊥, columns × columns.
    covariance: Vec<f64>,
    /// The diagonal of WᵀW before projection.
    whole: Vec<f64>,
    /// Σ w⊥², and its degrees of freedom.
    pub squares: f64,
    pub freedom: f64,
}

impl Projected {
    /// From white `sums`, whose first `estimated` columns are estimated unknowns. `None` if these are singular.
    pub fn new(sums: &Linear, estimated: usize) -> Option<Self> {
        let (normal, gradient) = sums.weighted([1.0; 3]);
        let (all, p) = (gradient.len(), estimated);
        let known: Vec<f64> = (0..p * p).map(|k| normal[k / p * all + k % p]).collect();
        let inverted = scaled_inverse(&known, p).ok()?;
        let row = |i: usize| &normal[i * all..i * all + p];
        let solved: Vec<Vec<f64>> = (p..all).map(|i| times(&inverted, row(i))).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let columns = all - p;
        let covariance = (0..columns * columns).map(|k| {
            let (i, j) = (k / columns, k % columns);
            normal[(p + i) * all + p + j] - dot(&solved[i], row(p + j))
        });
        let explained = dot(&gradient[..p], &times(&inverted, &gradient[..p]));
        Some(Self {
            columns,
            scores: (0..columns).map(|i| gradient[p + i] - dot(&solved[i], &gradient[..p])).collect(),
            covariance: covariance.collect(),
            whole: (p..all).map(|i| normal[i * all + i]).collect(),
            squares: sums.squares.iter().sum::<f64>() - explained,
            freedom: (3.0 * sums.samples - p as f64).max(1.0),
        })
    }

    /// Variance of the white errors, 1 if the stated noise is right.
    pub fn variance(&self) -> f64 {
        self.squares / self.freedom
    }

    /// Correlation of the scores of unknowns, given by their columns.
    pub fn correlation(&self, unknowns: &[&[usize]]) -> Vec<f64> {
        let entry = |rows: &[usize], columns: &[usize]| -> f64 {
            let row = |a: &usize| columns.iter().map(|b| self.covariance[a * self.columns + b]).sum::<f64>();
            rows.iter().map(row).sum()
        };
        let size: Vec<f64> = unknowns.iter().map(|unknown| entry(unknown, unknown).max(0.0).sqrt()).collect();
        let all = || unknowns.iter().zip(&size);
        all().flat_map(|(a, s)| all().map(move |(b, t)| entry(a, b) / (s * t))).collect()
    }

    /// The test of `group`; `None` if it cannot be distinguished from the estimated unknowns.
    pub fn score(&self, group: &Group) -> Option<Score> {
        let q = group.unknowns.len();
        let sum = |of: &dyn Fn(usize) -> f64, columns: &[usize]| columns.iter().map(|c| of(*c)).sum::<f64>();
        let s: Vec<f64> = group.unknowns.iter().map(|columns| sum(&|c| self.scores[c], columns)).collect();
        let entry = |i: usize, j: usize| {
            let (rows, columns) = (&group.unknowns[i], &group.unknowns[j]);
            sum(&|a| sum(&|b| self.covariance[a * self.columns + b], columns), rows)
        };
        let v: Vec<f64> = (0..q * q).map(|k| entry(k / q, k % q)).collect();
        let whole = |i: usize| sum(&|c| self.whole[c], &group.unknowns[i]);
        if (0..q).any(|i| v[i * q + i].is_nan() || v[i * q + i] <= LEFT * whole(i)) {
            return None;
        }
        let (mut destroyed, mut inverted) = (v, vec![0.0; q * q]);
        inverse(q, &mut destroyed, &mut inverted)?;
        let values = times(&inverted, &s);
        let statistic = values.iter().zip(&s).map(|(x, s)| x * s).sum::<f64>() / self.variance();
        let error = |i: usize| (self.variance() * inverted[i * q + i]).max(0.0).sqrt();
        Some(Score {
            statistic,
            freedom: q,
            log_p: log_chi_square_tail(statistic, q),
            standard_errors: (0..q).map(error).collect(),
            values,
        })
    }
}
