//! Tail probabilities.

use statrs::distribution::{ChiSquared, ContinuousCDF};
use statrs::function::erf::erfc;

/// P(χ² ≥ x) for `freedom` degrees of freedom; 1 without any.
pub fn chi_square_tail(x: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(1.0, |distribution| distribution.sf(x))
}

/// P(|Z| ≥ |z|) for a standard normal Z, to 1e-10 of it.
pub fn normal_tails(z: f64) -> f64 {
    erfc(z.abs() / std::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_tails_are_one_at_zero_and_none_at_infinity() {
        approx::assert_relative_eq!(normal_tails(-1.959963984540054), 0.05, max_relative = 1e-10);
        assert_eq!((chi_square_tail(0.0, 4.0), chi_square_tail(f64::INFINITY, 4.0)), (1.0, 0.0));
        assert_eq!(chi_square_tail(1.0, 0.0), 1.0);
    }
}
