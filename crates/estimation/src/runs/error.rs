use refusal::Invalid;
use regression::runs::NominalDiverged;
use thiserror::Error;

/// Why runs cannot be estimated at all.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RunError {
    /// There are no instruments.
    #[error(transparent)]
    Diverged(#[from] NominalDiverged),
    /// Estimates of a ship with forces that cannot be.
    #[error("{0}")]
    Forces(Invalid),
    /// A degree of freedom has no fewer unknowns (parameters and intercepts) than the run has samples.
    #[error("design {design}, run {run} has {samples} samples, no more than unknowns")]
    TooShort {
        /// The run's design.
        design: String,
        /// The run's number.
        run: i32,
        /// Its samples.
        samples: usize,
    },
}

impl RunError {
    /// The invalid part: of the vessel if its nominal model diverges, else of the runs.
    pub fn invalid(&self) -> Invalid {
        match self {
            Self::Diverged(diverged) => diverged.invalid(),
            Self::Forces(invalid) => invalid.clone(),
            Self::TooShort { design, run, samples } => Invalid::new(
                format!("design {design}, run {run}"),
                format!("{samples} samples"),
                "more samples than unknowns (parameters and intercepts of a degree of freedom)",
                "lengthen the run, or remove the mean over the whole run",
            ),
        }
    }
}
