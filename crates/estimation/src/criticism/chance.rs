use numerics::distributions::log_chi_square_tail;
use ship::engine::Streams;

use super::score::{Group, Projected, Score};

/// Number of draws of the scores under the model.
const DRAWS: usize = 2000;
/// A score is a mixture of others if less than this share of its pivot is left.
const LEFT: f64 = 1e-9;
/// The draws are the same in every criticism.
const SEED: u64 = 1;

/// Normal random numbers for draws of scores.
pub(super) struct Draws {
    width: usize,
    normals: Vec<f64>,
}

impl Draws {
    /// For up to `width` unknowns.
    pub fn new(width: usize) -> Self {
        let mut normals = vec![0.0; (width * DRAWS).next_multiple_of(2)];
        Streams::new(SEED, "criticism").normals(0, 0, &mut normals);
        Self { width, normals }
    }

    /// Per group, the probability under the model that any group has a score as improbable as its own. Tests overlap,
    /// so a Bonferroni factor would be too large: scores are drawn with their joint covariance. Probabilities beyond
    /// all draws use that factor.
    pub fn adjusted(&self, projected: &Projected, groups: &[(&Group, &Score)]) -> Vec<f64> {
        let least = self.least(projected, groups);
        let among = |score: &Score| {
            let fewer = least.partition_point(|log_p| *log_p <= score.log_p);
            let product = groups.len() as f64 * libm::exp(score.log_p);
            ((fewer + 1) as f64 / (DRAWS + 1) as f64).min(product).min(1.0)
        };
        groups.iter().map(|(_, score)| among(score)).collect()
    }

    /// The least logarithm of a probability of every draw, in ascending order.
    fn least(&self, projected: &Projected, groups: &[(&Group, &Score)]) -> Vec<f64> {
        let unknowns = groups.iter().flat_map(|(group, _)| group.unknowns.iter().map(Vec::as_slice));
        let unknowns: Vec<&[usize]> = unknowns.collect();
        let n = unknowns.len();
        let correlation = projected.correlation(&unknowns);
        let (factor, forms) = (lower(n, &correlation), forms(n, &correlation, groups));
        let freedom = groups.iter().map(|(_, score)| score.freedom).max().unwrap_or(0);
        let least = |z: &[f64]| {
            let x: Vec<f64> = (0..n).map(|i| numerics::dot(&factor[i * n..=i * n + i], &z[..=i])).collect();
            let mut most = vec![0.0_f64; freedom + 1];
            for (first, inverse, q) in &forms {
                let statistic = numerics::quadratic(&x[*first..first + q], inverse);
                most[*q] = most[*q].max(statistic);
            }
            let tail =
                |(q, most): (usize, &f64)| if *most > 0.0 { log_chi_square_tail(*most, q) } else { 0.0 };
            most.iter().enumerate().map(tail).fold(0.0, f64::min)
        };
        let mut all: Vec<f64> = self.normals.chunks_exact(self.width.max(1)).take(DRAWS).map(least).collect();
        all.sort_by(f64::total_cmp);
        all
    }
}

/// Per group its first unknown, the inverse correlation of its unknowns, and their number.
fn forms(n: usize, correlation: &[f64], groups: &[(&Group, &Score)]) -> Vec<(usize, Vec<f64>, usize)> {
    let mut first = 0;
    let form = |(group, _): &(&Group, &Score)| {
        let (from, q) = (first, group.unknowns.len());
        first += q;
        let mut own: Vec<f64> = (0..q * q).map(|k| correlation[(from + k / q) * n + from + k % q]).collect();
        let mut inverted = vec![0.0; q * q];
        numerics::inverse(q, &mut own, &mut inverted)?;
        Some((from, inverted, q))
    };
    groups.iter().filter_map(form).collect()
}

/// L with L Lᵀ = `a`, n × n, which may be singular.
fn lower(n: usize, a: &[f64]) -> Vec<f64> {
    let mut l = vec![0.0; n * n];
    for j in 0..n {
        let left = a[j * n + j] - (0..j).map(|k| l[j * n + k] * l[j * n + k]).sum::<f64>();
        if left <= LEFT {
            continue;
        }
        l[j * n + j] = left.sqrt();
        for i in j + 1..n {
            let rest = a[i * n + j] - (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum::<f64>();
            l[i * n + j] = rest / l[j * n + j];
        }
    }
    l
}
