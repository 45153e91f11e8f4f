use refusal::Invalid;
use ship::engine::Diverged;
use ship::model::DegreeOfFreedom;
use thiserror::Error;

/// The nominal model's simulation over a run left every bound, so that there are no instruments.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("the nominal model diverges over design {design}, run {run}, at sample {} in {}", .at.sample, DegreeOfFreedom::ALL[.at.state].name())]
pub struct NominalDiverged {
    /// The run's design.
    pub design: String,
    /// The run's number.
    pub run: i32,
    /// Where it diverged.
    pub at: Diverged,
    /// Samples per second \[Hz\].
    pub rate_hz: f64,
}

impl NominalDiverged {
    /// The part of the vessel that is invalid.
    pub fn invalid(&self) -> Invalid {
        let what = format!("nominal model (`nominal`) over design {}, run {}", self.design, self.run);
        self.at.invalid(what, self.rate_hz)
    }

    /// The divergence over a run of `design`.
    pub fn over(design: &str, run: i32, at: Diverged, rate_hz: f64) -> Self {
        Self { design: design.to_owned(), run, at, rate_hz }
    }
}
