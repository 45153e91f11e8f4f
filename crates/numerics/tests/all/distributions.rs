//! Tails of distributions.

use numerics::distributions::{chi_square_tail, normal_tails};

#[test]
fn law_tails_are_one_at_zero_and_none_at_infinity() {
    approx::assert_relative_eq!(normal_tails(-1.959963984540054), 0.05, max_relative = 1e-10);
    assert_eq!((chi_square_tail(0.0, 4.0), chi_square_tail(f64::INFINITY, 4.0)), (1.0, 0.0));
    assert_eq!(chi_square_tail(1.0, 0.0), 1.0);
}
