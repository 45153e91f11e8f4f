//! The weakest direction of a block.

use numerics::weakest;

#[test]
fn law_the_weakest_direction_of_a_scaled_identity_is_its_smallest_axis() {
    let found = weakest(3, &[3.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 2.0]).unwrap();
    assert!((found.ratio - 0.5 / 3.0).abs() < 1e-15);
    assert!((found.direction[1].abs() - 1.0).abs() < 1e-12);
    assert_eq!(weakest(2, &[0.0; 4]), None);
    assert_eq!(weakest(2, &[f64::NAN, 0.0, 0.0, 1.0]), None);
}

/// faer's decomposition of random blocks, columns of which differ by up to eight orders of magnitude.
#[test]
fn oracle_the_weakest_direction_is_that_of_faers_singular_values() {
    let mut state = 1u64;
    let mut draw = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    for case in 0..400 {
        let n = 1 + case % 9;
        let sizes: Vec<f64> = (0..n).map(|_| 10f64.powf(8.0 * draw())).collect();
        let a: Vec<f64> = (0..n * n).map(|k| sizes[k % n] * draw()).collect();
        let found = weakest(n, &a).unwrap();
        let svd = faer::MatRef::from_row_major_slice(&a, n, n).svd().unwrap();
        let values = svd.S().column_vector();
        let ratio = values[n - 1] / values[0];
        // Small singular values are known to rounding errors of the largest one only.
        assert!((found.ratio - ratio).abs() < 1e-14 + 1e-9 * ratio, "{case}: {} {ratio}", found.ratio);
        let gap = if n > 1 { (values[n - 2] - values[n - 1]) / values[0] } else { 1.0 };
        let along: f64 = (0..n).map(|i| svd.V()[(i, n - 1)] * found.direction[i]).sum();
        assert!(gap < 1e-10 || (along.abs() - 1.0).abs() < 1e-8, "{case}: {along}");
    }
}
