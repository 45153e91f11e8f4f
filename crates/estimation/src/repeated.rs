//! Estimates of the same parameters from many runs of one design.

use numerics::statistics::{mean, quantile, sorted, spread};

/// Standard errors are trusted if their relative difference from the spread that they predict is at most this.
pub const TRUSTED: f64 = 0.15;

/// One parameter over the runs that have an estimate. Relative figures are over the modulus of the truth, and absent
/// if it is unknown or 0.
#[derive(Clone, Debug, PartialEq)]
pub struct RepeatedEstimates {
    /// Mean estimate.
    pub mean: Option<f64>,
    /// Standard deviation of the estimates; none below two runs.
    pub spread: Option<f64>,
    /// Median of the standard errors that the runs report.
    pub predicted_se: Option<f64>,
    /// (mean − truth)/|truth|.
    pub relative_bias: Option<f64>,
    /// spread/|truth|.
    pub relative_spread: Option<f64>,
}

impl RepeatedEstimates {
    /// From the estimates and the standard errors of all runs.
    pub fn new(estimates: &[f64], standard_errors: &[f64], truth: Option<f64>) -> Self {
        let (mean, spread) = (mean(estimates), spread(estimates));
        let known = truth.filter(|truth| *truth != 0.0);
        Self {
            mean,
            spread,
            predicted_se: quantile(
                &sorted(standard_errors.iter().copied().filter(|error| !error.is_nan()).map(Some)),
                0.5,
            ),
            relative_bias: mean.zip(known).map(|(mean, truth)| (mean - truth) / truth.abs()),
            relative_spread: spread.zip(known).map(|(spread, truth)| spread / truth.abs()),
        }
    }

    /// Predicted standard error over the spread: near 1 if standard errors can be trusted.
    pub fn se_ratio(&self) -> Option<f64> {
        let spread = self.spread.filter(|spread| *spread > 0.0)?;
        Some(self.predicted_se? / spread)
    }

    /// Whether the standard errors are within [`TRUSTED`] of the spread.
    pub fn se_trusted(&self) -> bool {
        self.se_ratio().is_some_and(|ratio| (ratio - 1.0).abs() <= TRUSTED)
    }
}

/// 2-norms of relative bias, of relative spread, and of both, over the parameters that have both; `None` where none has.
pub fn relative_norms(parameters: &[RepeatedEstimates]) -> Option<[f64; 3]> {
    let both: Vec<[f64; 2]> =
        parameters.iter().filter_map(|p| Some([p.relative_bias?, p.relative_spread?])).collect();
    let norm = |i: usize| both.iter().map(|x| x[i] * x[i]).sum::<f64>().sqrt();
    let [bias, spread] = [norm(0), norm(1)];
    (!both.is_empty()).then(|| [bias, spread, libm::hypot(bias, spread)])
}
