//! Matrices that may be singular: quadratic forms, dependent columns.

use crate::dot;

/// sᵀV⁺s and the rank of V, a positive semidefinite matrix n × n, with `s` in its range. V is what is left of a matrix with
/// the diagonal `whole`: a pivot counts if it is more than the share `least` of that.
pub fn quadratic_of_inverse(mut v: Vec<f64>, mut s: Vec<f64>, whole: &[f64], least: f64) -> (f64, usize) {
    let p = s.len();
    let (mut statistic, mut rank) = (0.0, 0);
    loop {
        let share = |i: &usize| if whole[*i] > 0.0 { v[i * p + i] / whole[*i] } else { 0.0 };
        let Some(best) = (0..p).max_by(|a, b| share(a).total_cmp(&share(b))) else { break };
        if share(&best) <= least {
            break;
        }
        let pivot = v[best * p + best];
        let row: Vec<f64> = v[best * p..(best + 1) * p].to_vec();
        let score = s[best];
        statistic += score * score / pivot;
        rank += 1;
        for i in 0..p {
            s[i] -= row[i] * score / pivot;
            for j in 0..p {
                v[i * p + j] -= row[i] * row[j] / pivot;
            }
        }
        v[best * p + best] = 0.0;
    }
    (statistic, rank)
}

/// The columns that depend linearly on those before them, from their n × n sums of products `a`, by Cholesky's method: those
/// before them leave at most the share `least` of their squares.
pub fn dependent_columns(n: usize, a: &[f64], least: f64) -> Vec<usize> {
    let (mut rows, mut found): (Vec<(usize, Vec<f64>)>, Vec<usize>) = (Vec::new(), Vec::new());
    for i in 0..n {
        let mut own: Vec<f64> = Vec::with_capacity(rows.len() + 1);
        for (j, before) in &rows {
            let rest = a[i * n + j] - dot(&own, &before[..own.len()]);
            own.push(rest / before[own.len()]);
        }
        let rest = a[i * n + i] - dot(&own, &own);
        if rest <= least * a[i * n + i] {
            found.push(i);
        } else {
            own.push(rest.sqrt());
            rows.push((i, own));
        }
    }
    found
}
