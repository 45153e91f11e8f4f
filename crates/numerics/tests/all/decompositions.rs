//! Singular values, eigenvalues and large systems against their definitions.

use numerics::{dot, inverse, product, solve, symmetric, times, weakest};
use proptest::prelude::*;

#[test]
fn law_the_weakest_direction_of_a_scaled_identity_is_its_smallest_axis() {
    let found = weakest(3, &[3.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 2.0]).unwrap();
    assert!((found.ratio - 0.5 / 3.0).abs() < 1e-15);
    assert!((found.direction[1] - 1.0).abs() < 1e-12 && found.dominant(3) == 1);
    assert_eq!(weakest(2, &[0.0; 4]), None);
    assert_eq!(weakest(2, &[f64::NAN, 0.0, 0.0, 1.0]), None);
    assert_eq!(symmetric(1, &[f64::INFINITY]), None);
}

fn length(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

proptest! {
    /// A moves its weakest direction by least of all, by the largest singular value times the ratio.
    #[test]
    fn law_no_direction_is_weaker_than_the_weakest(
        entries in prop::collection::vec(-1.0f64..1.0, 81),
        sizes in prop::collection::vec(-4.0f64..4.0, 9),
        other in prop::collection::vec(-1.0f64..1.0, 9),
        n in 1usize..10,
    ) {
        let a: Vec<f64> = (0..n * n).map(|k| 10f64.powf(sizes[k % n]) * entries[k]).collect();
        let found = weakest(n, &a).unwrap();
        // The largest singular value is the root of the largest eigenvalue of AᵀA.
        let squared = product(n, &numerics::transposed(n, &a), &a);
        let largest = symmetric(n, &squared).unwrap().0[n - 1].sqrt();
        prop_assert!((length(&found.direction) - 1.0).abs() < 1e-13);
        prop_assert!((length(&times(&a, &found.direction)) - found.ratio * largest).abs() < 1e-12 * largest);
        let other = &other[..n];
        prop_assert!(length(&times(&a, other)) >= (found.ratio - 1e-12) * largest * length(other));
    }

    #[test]
    fn law_the_vectors_are_orthogonal_and_rebuild_the_matrix(entries in prop::collection::vec(-1.0f64..1.0, 25), n in 1usize..6) {
        let a: Vec<f64> = (0..n * n).map(|k| entries[(k / n).min(k % n) * 5 + (k / n).max(k % n)]).collect();
        let (values, q) = symmetric(n, &a).unwrap();
        prop_assert!(values.is_sorted());
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

/// Below and above the size where the method changes.
#[test]
fn law_solutions_and_inverses_of_any_size_are_what_they_are_defined_by() {
    let mut state = 1u64;
    let mut draw = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    for n in [5, 47, 48, 49, 185] {
        let a: Vec<f64> = (0..n * n).map(|k| draw() + if k / n == k % n { 2.0 } else { 0.0 }).collect();
        let b: Vec<f64> = (0..3 * n).map(|_| draw()).collect();
        let (mut x, mut inverted) = (b.clone(), vec![0.0; n * n]);
        solve(n, &mut a.clone(), &mut x).unwrap();
        inverse(n, &mut a.clone(), &mut inverted).unwrap();
        let unit = product(n, &a, &inverted);
        for i in 0..n {
            for c in 0..3 {
                let found: f64 = (0..n).map(|j| a[i * n + j] * x[3 * j + c]).sum();
                assert!((found - b[3 * i + c]).abs() < 1e-11, "{n}");
            }
            for j in 0..n {
                assert!((unit[i * n + j] - f64::from(u8::from(i == j))).abs() < 1e-11, "{n}");
            }
        }
        let mut singular = a.clone();
        singular[n..2 * n].fill(0.0);
        assert!(solve(n, &mut singular, &mut b.clone()).is_none(), "{n}");
    }
}
