//! Columns of recordings, thinned, and what relations between them are computed from: increments and integrals.

use std::ops::Range;

use numerics::{dot, solve};

/// Most rows of a recording that are looked at.
pub const ROWS: usize = 1200;
/// Most recordings that are looked at: the longest.
pub const RECORDINGS: usize = 8;
/// Rows over which values are compared.
pub(super) const STEPS: [usize; 4] = [4, 12, 36, 100];

/// Columns of some recordings, each thinned to few rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoggedTable {
    /// The columns, recording after recording.
    pub columns: Vec<Vec<f64>>,
    /// The rows of each recording.
    pub recordings: Vec<Range<usize>>,
    /// Of how many rows of each recording one is looked at.
    pub(super) every: Vec<usize>,
}

impl LoggedTable {
    /// The table of `recordings`, each one of so many rows of a list of columns; absent values are NaN, and the one before counts.
    pub fn of(mut recordings: Vec<(usize, Vec<Vec<f64>>)>) -> Self {
        let rows = |recording: &[Vec<f64>]| recording.first().map_or(0, Vec::len);
        recordings.sort_by_key(|(every, recording)| usize::MAX - every * rows(recording));
        recordings.truncate(RECORDINGS);
        let mut table = Self::default();
        for (thinned, recording) in recordings.iter().filter(|(_, recording)| rows(recording) > 1) {
            let (count, every) = (rows(recording), rows(recording).div_ceil(ROWS));
            let start = table.recordings.last().map_or(0, |rows| rows.end);
            table.columns.resize(recording.len().max(table.columns.len()), vec![f64::NAN; start]);
            for (all, values) in table.columns.iter_mut().zip(recording) {
                let mut last = values.iter().copied().find(|value| value.is_finite()).unwrap_or(f64::NAN);
                for (row, value) in values.iter().enumerate() {
                    last = if value.is_finite() { *value } else { last };
                    if row % every == 0 {
                        all.push(last);
                    }
                }
            }
            table.recordings.push(start..start + count.div_ceil(every));
            table.every.push(thinned * every);
        }
        table
    }

    /// Rows in all.
    pub(super) fn rows(&self) -> usize {
        self.recordings.last().map_or(0, |rows| rows.end)
    }

    /// Whether the column at `at` has a number in every row and does not stand still.
    pub(super) fn moves(&self, at: usize) -> bool {
        let values = &self.columns[at];
        let [least, most] = extent(values);
        values.iter().all(|value| value.is_finite()) && most - least > 1e-9 * most.abs().max(least.abs())
    }

    /// The integral of `values` over `time`, anew in each recording.
    pub(super) fn integral(&self, values: impl Fn(usize) -> f64, time: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.rows()];
        for rows in &self.recordings {
            let mut before = values(rows.start);
            for row in rows.start + 1..rows.end {
                let value = values(row);
                out[row] = out[row - 1] + 0.5 * (before + value) * (time[row] - time[row - 1]);
                before = value;
            }
        }
        out
    }

    /// The rows before and after `step` rows, every half of that.
    pub(super) fn spans(&self, step: usize) -> Vec<[usize; 2]> {
        let ends = self.recordings.iter().flat_map(|rows| {
            (rows.start..rows.end.saturating_sub(step)).step_by(step / 2).map(move |row| [row, row + step])
        });
        ends.collect()
    }
}

/// Least and greatest.
pub(super) fn extent(values: &[f64]) -> [f64; 2] {
    values
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(*value), high.max(*value)])
}

pub(super) fn increments(values: &[f64], spans: &[[usize; 2]]) -> Vec<f64> {
    spans.iter().map(|[from, to]| values[*to] - values[*from]).collect()
}

/// Σ (y − mean)².
pub(super) fn scatter(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|value| (value - mean) * (value - mean)).sum()
}

pub(super) fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let count = a.len().max(1) as f64;
    let [mean_a, mean_b] = [a, b].map(|all| all.iter().sum::<f64>() / count);
    let product: f64 = a.iter().zip(b).map(|(a, b)| (a - mean_a) * (b - mean_b)).sum();
    let scale = (scatter(a) * scatter(b)).sqrt();
    if scale > 0.0 { product / scale } else { 0.0 }
}

/// Sums of products of regressors with each other and with what they explain.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sums {
    /// Number of regressors.
    n: usize,
    /// Products among regressors and, last, the target.
    products: Vec<f64>,
}

impl Sums {
    pub(super) fn of(regressors: &[&[f64]], target: &[f64]) -> Self {
        let all: Vec<&[f64]> = regressors.iter().copied().chain([target]).collect();
        let products = all.iter().flat_map(|a| all.iter().map(|b| dot(a, b))).collect();
        Self { n: regressors.len(), products }
    }

    pub(super) fn plus(&self, other: &Self, sign: f64) -> Self {
        let products = self.products.iter().zip(&other.products).map(|(a, b)| a + sign * b).collect();
        Self { n: self.n, products }
    }

    /// The sums of some of the regressors.
    pub(super) fn some(&self, which: &[usize]) -> Self {
        let width = self.n + 1;
        let all: Vec<usize> = which.iter().copied().chain([self.n]).collect();
        let products =
            all.iter().flat_map(|a| all.iter().map(move |b| self.products[a * width + b])).collect();
        Self { n: which.len(), products }
    }

    /// Coefficients by least squares; `None` where the regressors depend on each other.
    pub(super) fn solution(&self) -> Option<Vec<f64>> {
        let (n, width) = (self.n, self.n + 1);
        let scale: Vec<f64> = (0..n).map(|i| self.products[i * width + i].sqrt()).collect();
        let mut a = vec![0.0; n * n];
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            // A trace of a ridge: dependent regressors share.
            let ridge = if i == j { 1.0 + 1e-9 } else { 1.0 };
            a[i * n + j] = ridge * self.products[i * width + j] / (scale[i] * scale[j]);
        }
        let mut b: Vec<f64> = (0..n).map(|i| self.products[i * width + n] / scale[i]).collect();
        solve(n, &mut a, &mut b)?;
        b.iter().all(|b| b.is_finite()).then(|| b.iter().zip(&scale).map(|(b, scale)| b / scale).collect())
    }

    /// Σ residual² with these coefficients.
    pub(super) fn residual(&self, coefficients: &[f64]) -> f64 {
        let width = self.n + 1;
        let all: Vec<f64> = coefficients.iter().map(|c| -c).chain([1.0]).collect();
        let pairs = (0..width).flat_map(|i| (0..width).map(move |j| (i, j)));
        pairs.map(|(i, j)| all[i] * all[j] * self.products[i * width + j]).sum::<f64>().max(0.0)
    }

    /// Σ target².
    pub(super) fn square(&self) -> f64 {
        self.products[self.products.len() - 1]
    }
}
