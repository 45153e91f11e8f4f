refusal::choices! {
    /// How parameters are estimated.
    pub enum Estimator {
        /// Least squares (biased by measurement noise).
        Ls = "ls",
        /// Instrumental variables: instruments from the nominal model over the same inputs.
        Iv = "iv",
        /// Least errors of free simulations, with intercepts.
        OutputError = "output-error",
        /// Least errors of one-sample predictions by an extended Kalman filter of the disturbances that --campaign states, or that the run tells.
        PredictionError = "prediction-error",
        /// Of pooled sub-experiments: instrumental variables where they identify a degree of freedom, least squares elsewhere.
        Auto = "auto",
    }
}

impl Estimator {
    /// Estimators of a single run, in the order of a comparison.
    pub const OF_RUNS: [Self; 4] = [Self::Ls, Self::Iv, Self::OutputError, Self::PredictionError];
    /// Estimators from pooled sub-experiments.
    pub const POOLED: [Self; 5] = [Self::Ls, Self::Iv, Self::Auto, Self::OutputError, Self::PredictionError];
    /// Those of them that are fast enough for a comparison by default.
    pub const COMPARED: [Self; 4] = [Self::Ls, Self::Iv, Self::Auto, Self::OutputError];
    /// Estimators whose accuracy a design predicts.
    pub const PREDICTED: [Self; 2] = [Self::Iv, Self::OutputError];

    /// Whether it uses simulated instruments, so that it has no estimate if they are collinear.
    pub fn by_instruments(self) -> bool {
        self == Self::Iv
    }

    /// Seconds per row of a run and thread, order of magnitude: the paper's campaign of 800,000 rows on a server of
    /// 2024.
    pub fn seconds_per_row(self) -> f64 {
        match self {
            Self::Ls | Self::Iv | Self::Auto => 2e-7,
            Self::OutputError => 2e-6,
            Self::PredictionError => 4e-6,
        }
    }

    /// Whether it searches for a minimum, which may not converge.
    pub fn searches(self) -> bool {
        matches!(self, Self::OutputError | Self::PredictionError)
    }
}
