//! Minimisation within bounds.

use numerics::Watch;
use numerics::bounded::{Objective, minimise};

struct Rosenbrock;

impl Objective for Rosenbrock {
    type Point = [f64; 2];
    fn value(&mut self, x: &[f64]) -> Option<(f64, [f64; 2])> {
        Some(((1.0 - x[0]).powi(2) + 100.0 * (x[1] - x[0] * x[0]).powi(2), [x[0], x[1]]))
    }
    fn gradient(&self, x: &[f64; 2]) -> Vec<f64> {
        let inner = x[1] - x[0] * x[0];
        vec![-2.0 * (1.0 - x[0]) - 400.0 * x[0] * inner, 200.0 * inner]
    }
    fn keep(&mut self, x: &[f64], _: &[f64; 2]) {
        assert!(x[0] <= 0.5);
    }
}

#[test]
fn law_the_bound_that_binds_is_reached_and_the_rest_is_minimal() {
    let mut x = vec![-1.2, 1.0];
    minimise(&mut Rosenbrock, &mut x, [&[-2.0, -2.0], &[0.5, 2.0]], 200, &Watch::default());
    // At x = 1/2 the best y is 1/4.
    assert!((x[0] - 0.5).abs() < 1e-8 && (x[1] - 0.25).abs() < 1e-6, "{x:?}");
}
