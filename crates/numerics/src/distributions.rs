//! Tail probabilities.

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};
use statrs::function::erf::erfc;

/// P(χ² ≥ x) for `freedom` degrees of freedom; 1 without any.
pub fn chi_square_tail(x: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(1.0, |distribution| distribution.sf(x))
}

/// P(|Z| ≥ |z|) for a standard normal Z, to 1e-10 of it.
pub fn normal_tails(z: f64) -> f64 {
    erfc(z.abs() / std::f64::consts::SQRT_2)
}

/// Half the width of an interval of 95 % by Student's t of so many degrees of freedom, in standard errors.
pub fn student_half_width(freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |t| t.inverse_cdf(0.975))
}
