/// Eigenvalues of a symmetric matrix (n × n, row-major) and its eigenvectors, one per column, by Jacobi's rotations: for
/// the small blocks of a covariance.
pub(crate) fn symmetric(n: usize, matrix: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let mut a = matrix.to_vec();
    let mut vectors: Vec<f64> = (0..n * n).map(|k| f64::from(u8::from(k / n == k % n))).collect();
    for _ in 0..60 {
        let diagonal: f64 = (0..n).map(|i| a[i * n + i] * a[i * n + i]).sum();
        let off: f64 = (0..n).map(|i| (0..i).map(|j| a[i * n + j] * a[i * n + j]).sum::<f64>()).sum();
        if off <= 1e-34 * diagonal || !off.is_finite() {
            break;
        }
        for i in 0..n {
            for j in i + 1..n {
                rotate(n, &mut a, &mut vectors, i, j);
            }
        }
    }
    ((0..n).map(|i| a[i * n + i]).collect(), vectors)
}

/// Makes the entries (i, j) and (j, i) zero.
fn rotate(n: usize, a: &mut [f64], vectors: &mut [f64], i: usize, j: usize) {
    let entry = a[i * n + j];
    if entry == 0.0 {
        return;
    }
    let theta = (a[j * n + j] - a[i * n + i]) / (2.0 * entry);
    let tangent = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;
    let turn = |values: &mut [f64], p: usize, q: usize| {
        let (x, y) = (values[p], values[q]);
        values[p] = cosine * x - sine * y;
        values[q] = sine * x + cosine * y;
    };
    (0..n).for_each(|k| turn(a, k * n + i, k * n + j));
    (0..n).for_each(|k| turn(a, i * n + k, j * n + k));
    (0..n).for_each(|k| turn(vectors, k * n + i, k * n + j));
    a[i * n + j] = 0.0;
    a[j * n + i] = 0.0;
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn law_the_vectors_are_orthogonal_and_rebuild_the_matrix(entries in prop::collection::vec(-1.0f64..1.0, 25), n in 1usize..6) {
            let a: Vec<f64> = (0..n * n).map(|k| entries[(k / n).min(k % n) * 5 + (k / n).max(k % n)]).collect();
            let (values, q) = symmetric(n, &a);
            for i in 0..n {
                for j in 0..n {
                    let rebuilt: f64 = (0..n).map(|k| q[i * n + k] * values[k] * q[j * n + k]).sum();
                    let product: f64 = (0..n).map(|k| q[k * n + i] * q[k * n + j]).sum();
                    prop_assert!((rebuilt - a[i * n + j]).abs() < 1e-13);
                    prop_assert!((product - f64::from(u8::from(i == j))).abs() < 1e-13);
                }
            }
        }
    }
}
