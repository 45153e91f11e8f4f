//! Small blocks against determinants by their definition.

use approx::assert_relative_eq;
use numerics::{condition, inverse, inverse_and_log_det, log_det, solve};
use proptest::prelude::*;

/// The determinant of A (n × n, n small) by its definition, and the sum of the sizes of the products in it, both by set of
/// columns for the first rows.
fn by_definition(n: usize, a: &[f64]) -> [f64; 2] {
    let mut sums = vec![[1.0, 1.0]; 1 << n];
    for set in 1..1_usize << n {
        let row = set.count_ones() as usize - 1;
        let columns = (0..n).filter(|j| set >> j & 1 == 1);
        sums[set] = columns.fold([0.0, 0.0], |[sum, size], j| {
            let sign = if (set >> (j + 1)).count_ones().is_multiple_of(2) { 1.0 } else { -1.0 };
            let (entry, [det, sizes]) = (a[row * n + j], sums[set ^ 1 << j]);
            [sum + sign * entry * det, size + entry.abs() * sizes]
        });
    }
    sums[(1 << n) - 1]
}

proptest! {
    /// Cramer's rule: what a solution differs by is small beside the products that a determinant is the sum of.
    #[test]
    fn oracle_solutions_and_determinants_are_those_of_the_definition(n in 1usize..9, entries in prop::collection::vec(-1.0f64..1.0, 64), rhs in prop::collection::vec(-1.0f64..1.0, 8)) {
        let a = &entries[..n * n];
        let [expected, size] = by_definition(n, a);
        prop_assume!(expected.abs() > 1e-9 * size);
        let (mut x, mut inverted) = (rhs[..n].to_vec(), vec![0.0; n * n]);
        solve(n, &mut a.to_vec(), &mut x).unwrap();
        let det = inverse_and_log_det(n, &mut a.to_vec(), &mut inverted).unwrap();
        let close = |found: f64, expected: f64, size: f64| {
            assert!((found - expected).abs() < 1e-12 * size, "{found} {expected} of {size}");
        };
        close(det.sign * det.log_abs.exp(), expected, size);
        for i in 0..n {
            let replaced: Vec<f64> = (0..n * n).map(|k| if k % n == i { rhs[k / n] } else { a[k] }).collect();
            let [numerator, own] = by_definition(n, &replaced);
            close(x[i] * expected, numerator, own + x[i].abs() * size);
            let solved: f64 = (0..n).map(|j| inverted[i * n + j] * rhs[j]).sum();
            close(solved * expected, numerator, own + (0..n).map(|j| inverted[i * n + j].abs()).sum::<f64>() * size);
        }
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
