use numerics::Lane;

/// Per degree of freedom Σ ε(k)² and Σ ε(k−1) ε(k) of residuals ε.
pub(crate) struct Lags {
    pub lag0: [Lane; 3],
    pub lag1: [Lane; 3],
}

impl Lags {
    /// Sums over no samples.
    pub(crate) const ZERO: Self = Self { lag0: [Lane::ZERO; 3], lag1: [Lane::ZERO; 3] };
}
