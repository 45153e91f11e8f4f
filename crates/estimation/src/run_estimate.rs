use crate::{EstimateStatus, Estimator};

/// The estimate of one run by one estimator.
#[derive(Clone, Debug, PartialEq)]
pub struct RunEstimate {
    /// The run's design.
    pub design: String,
    /// The run's number.
    pub run: i32,
    /// The estimator.
    pub estimator: Estimator,
    /// Whether there is an estimate, and if not, why.
    pub status: EstimateStatus,
    /// θ̂ (surge, sway, yaw) and its standard errors, if there is one.
    pub estimate: Option<(Vec<f64>, Vec<f64>)>,
    /// Condition number per degree of freedom; infinite if a direction is not excited.
    pub condition: [f64; 3],
    /// Name of the parameter that dominates the weakest direction, per degree of freedom.
    pub weakest: [String; 3],
}

/// The covariance of the parameters of an estimate, as many rows as parameters, row-major. `None` without an estimate, and
/// where standard errors are the largest under several kinds of noise. Between degrees of freedom it is 0 for
/// estimators that regress.
pub type EstimateCovariance = Option<Vec<f64>>;
