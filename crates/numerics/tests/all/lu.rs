//! Small blocks against faer.

use approx::assert_relative_eq;
use faer::linalg::solvers::Solve;
use numerics::{condition, inverse, inverse_and_log_det, log_det, solve};
use proptest::prelude::*;

proptest! {
    #[test]
    fn oracle_solutions_and_determinants_agree_with_faer(n in 1usize..9, entries in prop::collection::vec(-1.0f64..1.0, 81), rhs in prop::collection::vec(-1.0f64..1.0, 9)) {
        let a = faer::Mat::from_fn(n, n, |i, j| entries[i * 9 + j] + if i == j { 0.01 } else { 0.0 });
        let condition = a.svd().map(|s| s.S().column_vector()[0] / s.S().column_vector()[n - 1]).unwrap_or(f64::INFINITY);
        prop_assume!(condition < 1e6);
        let mut block: Vec<f64> = (0..n * n).map(|k| a[(k / n, k % n)]).collect();
        let mut x = rhs[..n].to_vec();
        let (mut whole, mut inverted) = (block.clone(), vec![0.0; n * n]);
        solve(n, &mut block, &mut x).unwrap();
        let det = inverse_and_log_det(n, &mut whole, &mut inverted).unwrap();
        let expected = a.partial_piv_lu().solve(faer::Mat::from_fn(n, 1, |i, _| rhs[i]));
        for i in 0..n {
            assert_relative_eq!(x[i], expected[(i, 0)], max_relative = 1e-8, epsilon = 1e-9);
        }
        assert_relative_eq!(det.sign * det.log_abs.exp(), a.determinant(), max_relative = 1e-9, epsilon = 1e-300);
    }
}

#[test]
fn law_an_inverse_inverts_and_a_singular_block_is_none() {
    let a = [4.0, 1.0, 0.5, 1.0, 3.0, -0.2, 0.1, 0.7, 2.0];
    let mut out = [0.0; 9];
    inverse(3, &mut a.clone(), &mut out).unwrap();
    for i in 0..3 {
        for j in 0..3 {
            let entry: f64 = (0..3).map(|k| a[3 * i + k] * out[3 * k + j]).sum();
            assert_relative_eq!(entry, if i == j { 1.0 } else { 0.0 }, epsilon = 1e-14);
        }
    }
    assert_relative_eq!(condition(2, &[2.0, 0.0, 0.0, -0.5]), 4.0);
    assert_eq!(condition(2, &[1.0, 2.0, 0.0, 0.0]), f64::INFINITY);
    assert_eq!(log_det(2, &mut [1.0, 2.0, 0.0, 0.0]), None);
    assert_eq!(log_det(2, &mut [f64::NAN, 2.0, 0.0, 1.0]), None);
}

#[test]
fn law_rows_taken_in_order_invert_too_where_pivots_are_large() {
    for n in 1..6 {
        let entry = |k: usize| if k.is_multiple_of(n + 1) { 1.0 } else { 0.3 * ((7 * k + 3) as f64).sin() };
        let a: Vec<f64> = (0..n * n).map(entry).collect();
        let (mut exchanged, mut in_order) = (vec![0.0; n * n], vec![0.0; n * n]);
        numerics::inverse(n, &mut a.clone(), &mut exchanged).unwrap();
        let mut pivots = a.clone();
        numerics::inverse_in_order(n, &mut pivots, &mut in_order);
        assert!(
            exchanged.iter().zip(&in_order).all(|(a, b)| (a - b).abs() < 1e-13),
            "{exchanged:?} {in_order:?}"
        );
        assert!(pivots.iter().step_by(n + 1).all(|pivot| pivot.abs() > 0.1));
        let product = numerics::product(n, &a, &in_order);
        let off = |k: usize| product[k] - if k.is_multiple_of(n + 1) { 1.0 } else { 0.0 };
        assert!((0..n * n).all(|k| off(k).abs() < 1e-13));
    }
}
