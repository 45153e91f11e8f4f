use engine::Diverged;
use model::DegreeOfFreedom;
use refusal::Invalid;
use thiserror::Error;

/// The nominal model's simulation over a run left every bound, so that there are no instruments.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("the nominal model diverges over design {design}, run {run}, at sample {} in {}", .at.sample, DegreeOfFreedom::ALL[.at.state].name())]
pub struct NominalDiverged {
    /// The run's design.
    pub design: String,
    /// The run's number.
    pub run: i32,
    /// Where it diverged.
    pub at: Diverged,
}

impl NominalDiverged {
    /// What is invalid of the vessel.
    pub fn invalid(&self) -> Invalid {
        self.at.invalid(format!("nominal model (`nominal`) over design {}, run {}", self.design, self.run))
    }

    /// Over a run of `design`.
    pub fn over(design: &str, run: i32, at: Diverged) -> Self {
        Self { design: design.to_owned(), run, at }
    }
}

/// Why runs cannot be estimated at all.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum RunError {
    /// There are no instruments.
    #[error(transparent)]
    Diverged(#[from] NominalDiverged),
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
    /// What is invalid: of the vessel where its nominal model diverges, else of the runs.
    pub fn invalid(&self) -> Invalid {
        match self {
            Self::Diverged(diverged) => diverged.invalid(),
            Self::TooShort { design, run, samples } => Invalid::new(
                format!("design {design}, run {run}"),
                format!("{samples} samples"),
                "more samples than unknowns (parameters and intercepts of a degree of freedom)",
                "lengthen the run, or remove the mean over the whole run",
            ),
        }
    }
}
