use crate::Candidates;

/// Whether the criterion is concave on the simplex: every matrix is symmetric positive semidefinite, possibly after
/// multiplying its rows by positive numbers that are the same for all candidates (which changes log|det| by a
/// constant). Then a small Kiefer–Wolfowitz gap bounds the distance to the global optimum.
pub fn is_concave(candidates: &Candidates) -> bool {
    candidates.blocks().all(|(n, range)| {
        let matrices = || (0..candidates.len()).map(|q| &candidates.candidate(q)[range.clone()]);
        match row_scaling(n, matrices()) {
            Some(scaling) => matrices().all(|m| is_semidefinite(n, m, &scaling)),
            None => false,
        }
    })
}

/// Positive factors d with d_i m_ij = d_j m_ji for the sum of moduli, found along the strongest couplings from row 0.
pub(crate) fn row_scaling<'a>(n: usize, matrices: impl Iterator<Item = &'a [f64]>) -> Option<Vec<f64>> {
    let mut ratios = vec![(0.0, 0.0); n * n];
    for m in matrices {
        for i in 0..n {
            for j in 0..n {
                ratios[i * n + j].0 += m[i * n + j] * m[i * n + j];
                ratios[i * n + j].1 += m[i * n + j] * m[j * n + i];
            }
        }
    }
    let mut scaling = vec![1.0; n];
    let mut known = vec![false; n];
    for start in 0..n {
        if known[start] {
            continue;
        }
        known[start] = true;
        let mut queue = vec![start];
        while let Some(i) = queue.pop() {
            for j in 0..n {
                let (own, cross) = ratios[j * n + i];
                if !known[j] && own > 0.0 {
                    scaling[j] = scaling[i] * cross / own;
                    if scaling[j] <= 0.0 {
                        return None;
                    }
                    known[j] = true;
                    queue.push(j);
                }
            }
        }
    }
    Some(scaling)
}

/// Symmetric to 1e-9 and without an eigenvalue below −1e-9 of the largest diagonal entry, by Cholesky elimination.
pub(crate) fn is_semidefinite(n: usize, m: &[f64], scaling: &[f64]) -> bool {
    let mut a: Vec<f64> = (0..n * n).map(|k| scaling[k / n] * m[k]).collect();
    let size = (0..n).map(|i| a[i * n + i].abs()).fold(0.0, f64::max);
    let off = |i: usize, j: usize| (a[i * n + j] - a[j * n + i]).abs();
    if (0..n).any(|i| (0..i).any(|j| off(i, j) > 1e-9 * size)) {
        return false;
    }
    for k in 0..n {
        let pivot = a[k * n + k];
        if pivot < -1e-9 * size {
            return false;
        }
        if pivot <= 1e-9 * size {
            if (k + 1..n).any(|j| a[k * n + j].abs() > 1e-4 * size) {
                return false;
            }
            continue;
        }
        for i in k + 1..n {
            let factor = a[i * n + k] / pivot;
            for j in k + 1..n {
                a[i * n + j] -= factor * a[k * n + j];
            }
        }
    }
    true
}
