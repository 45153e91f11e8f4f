//! Quadratic forms of singular matrices.

use numerics::quadratic_of_inverse;

#[test]
fn law_directions_without_variance_count_for_nothing() {
    // The third variable is the sum of the first two, the fourth has no variance.
    let v = [[4.0, 1.0, 5.0, 0.0], [1.0, 2.0, 3.0, 0.0], [5.0, 3.0, 8.0, 0.0], [0.0; 4]].concat();
    let (statistic, rank) = quadratic_of_inverse(v, vec![1.0, -1.0, 0.0, 0.0], &[4.0, 2.0, 8.0, 0.0], 1e-6);
    // (1, −1) [[4, 1], [1, 2]]⁻¹ (1, −1)ᵀ.
    assert!((statistic - 8.0 / 7.0).abs() < 1e-12 && rank == 2, "{statistic} {rank}");
}
