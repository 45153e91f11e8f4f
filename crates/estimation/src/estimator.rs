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

/// Unknowns that estimates by simulation and prediction include in addition to the parameters of the vessel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdditionalUnknowns {
    /// Constant forces.
    pub intercepts: Intercepts,
    /// A current, for output error only.
    pub current: UnknownCurrent,
}

refusal::choices! {
    /// Constant forces that no term describes.
    pub enum Intercepts {
        /// One for each degree of freedom.
        Each = "each",
        /// None: where disturbances are known to average out, or a current is the unknown, estimates are closer.
        None = "none",
    }
}

refusal::choices! {
    /// An unknown current.
    pub enum UnknownCurrent {
        /// None: still water.
        None = "none",
        /// It stays, and keeps its direction over ground.
        Earth = "earth",
    }
}

impl Default for AdditionalUnknowns {
    fn default() -> Self {
        Self { intercepts: Intercepts::Each, current: UnknownCurrent::None }
    }
}

refusal::choices! {
    /// What became of the estimate of a run, or of a degree of freedom.
    pub enum EstimateStatus {
        /// There is an estimate, and the run does not reject the model where it was asked.
        Identified = "identified",
        /// There is an estimate, but the run rejects the model: something is missing beyond chance.
        Rejected = "identified, model rejected",
        /// There is an estimate, but a free simulation of what it was estimated from diverges.
        Diverges = "estimated, simulation diverges",
        /// There is an estimate, whose errors follow no noise that is known here: its standard errors are approximate.
        Approximate = "identified, errors approximate",
        /// There is an estimate without standard errors: waves move the ship.
        Waves = "identified, waves: no errors",
        /// There is an estimate by instruments of the run's own model of least output error: the nominal one diverges.
        OwnInstruments = "identified, instruments by output error",
        /// A direction of the parameters is not excited.
        NotIdentifiable = "not identifiable",
        /// The search for an estimate did not converge.
        NotConverged = "not converged",
    }
}

impl EstimateStatus {
    /// Whether there is an estimate.
    pub fn estimated(self) -> bool {
        !matches!(self, Self::NotIdentifiable | Self::NotConverged)
    }
}

refusal::choices! {
    /// What became of a model that was to be simulated over validation data.
    pub enum ScoreStatus {
        /// It was simulated.
        Scored = "scored",
        /// Its simulation diverged.
        Diverged = "diverged",
        /// There is no model: a direction of the parameters is not excited.
        NotIdentifiable = "not identifiable",
        /// There is no model: the search for one did not converge.
        NotConverged = "not converged",
    }
}

impl ScoreStatus {
    /// Whether there is an estimate.
    pub fn estimated(self) -> bool {
        matches!(self, Self::Scored | Self::Diverged)
    }
}

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
