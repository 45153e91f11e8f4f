//! Tails of distributions.

use numerics::statistics::{chi_square_tail, log_chi_square_tail, normal_tails};

#[test]
fn law_tails_are_one_at_zero_and_none_at_infinity() {
    approx::assert_relative_eq!(normal_tails(-1.959963984540054), 0.05, max_relative = 1e-10);
    assert_eq!((chi_square_tail(0.0, 4.0), chi_square_tail(f64::INFINITY, 4.0)), (1.0, 0.0));
    assert_eq!(chi_square_tail(1.0, 0.0), 1.0);
}

#[test]
fn law_the_logarithm_of_a_tail_goes_on_where_numbers_end() {
    // With two degrees of freedom the tail is exp(−x/2).
    for x in [3.0, 1300.0, 1400.0] {
        let found = log_chi_square_tail(x, 2);
        assert!((found + 0.5 * x).abs() < 1e-9, "{found}");
    }
}

/// As printed in tables of Student's t.
#[test]
fn oracle_half_widths_of_intervals_are_those_of_tables() {
    let few = [(1.0, 12.706_205), (2.0, 4.302_653), (3.0, 3.182_446), (8.0, 2.306_004)];
    let many = [(9.0, 2.262_157), (13.0, 2.160_369), (30.0, 2.042_272), (1e7, 1.959_964)];
    for (freedom, printed) in few.into_iter().chain(many) {
        let found = numerics::statistics::student_half_width(freedom);
        assert!((found - printed).abs() < 2e-4 * printed, "{freedom}: {found}");
    }
}
