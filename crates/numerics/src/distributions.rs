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
