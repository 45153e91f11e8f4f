//! Quadratic forms of singular matrices, dependent columns.

use numerics::{dependent_columns, dot, quadratic_of_inverse};

#[test]
fn law_directions_without_variance_count_for_nothing() {
    // The third variable is the sum of the first two, the fourth has no variance.
    let v = [[4.0, 1.0, 5.0, 0.0], [1.0, 2.0, 3.0, 0.0], [5.0, 3.0, 8.0, 0.0], [0.0; 4]].concat();
    let (statistic, rank) = quadratic_of_inverse(v, vec![1.0, -1.0, 0.0, 0.0], &[4.0, 2.0, 8.0, 0.0], 1e-6);
    // (1, −1) [[4, 1], [1, 2]]⁻¹ (1, −1)ᵀ.
    assert!((statistic - 8.0 / 7.0).abs() < 1e-12 && rank == 2, "{statistic} {rank}");
}

#[test]
fn law_a_column_that_follows_from_those_before_it_is_told_and_no_other() {
    // In rows: 1, 2, their sum, something else, zero, twice the first.
    let columns =
        [[1.0, 2.0, 4.0], [0.5, -1.0, 3.0], [1.5, 1.0, 7.0], [0.0, 0.3, 0.0], [0.0; 3], [2.0, 4.0, 8.0]];
    let sums: Vec<f64> = columns.iter().flat_map(|a| columns.iter().map(move |b| dot(a, b))).collect();
    assert_eq!(dependent_columns(6, &sums, 1e-10), [2, 4, 5]);
    assert_eq!(dependent_columns(2, &[1.0, 0.999, 0.999, 1.0], 1e-10), [0; 0]);
}
