//! Failures of a stage that writes nothing: one line and an exit code.

use std::convert::Infallible;
use std::path::Path;

use estimation::pooled::PoolError;
use estimation::runs::RunError;
use refusal::Invalid;
use regression::pooled::LostInstruments;
use thiserror::Error;

/// Why nothing was written. The message is one line.
#[derive(Debug, Error)]
pub enum Failure {
    /// Input, output or numerics failed.
    #[error("{0}")]
    Failed(String),
    /// The command line is invalid.
    #[error("{0}")]
    Usage(String),
    /// An input file was refused.
    #[error("{0}")]
    Refused(String),
    /// There is no result: not identifiable, did not converge.
    #[error("{0}")]
    NoAnswer(String),
}

impl Failure {
    /// 1 failed, 2 usage, 3 input refused, 4 no answer.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Failed(_) => 1,
            Self::Usage(_) => 2,
            Self::Refused(_) => 3,
            Self::NoAnswer(_) => 4,
        }
    }

    /// A refusal of `file`.
    pub fn refuse(file: &Path, thing: &str, found: &str, expected: &str, remedy: &str) -> Self {
        files::Error::refuse(file, thing, found, expected, remedy).into()
    }

    /// A run of `file` cannot be estimated.
    pub fn of_run(error: &RunError, vessel_file: &Path, file: &Path) -> Self {
        let diverged = matches!(error, RunError::Diverged(_) | RunError::Forces(_));
        Self::invalid(if diverged { vessel_file } else { file }, &error.invalid())
    }

    /// There are no instruments for runs of `file`.
    pub fn lost(file: &Path, lost: &LostInstruments) -> Self {
        Self::NoAnswer(format!(
            "{}: {lost}: found no instruments, expected a nominal model that follows the data; cut shorter parts with \
             --part-s, name another --nominal, or use --estimator ls",
            file.display()
        ))
    }

    /// The runs of `file` give no pooled estimate.
    pub fn of_pool<E>(error: PoolError<E>, file: &Path) -> Self
    where
        Self: From<E>,
    {
        match error {
            PoolError::Unread(error) => error.into(),
            PoolError::Lost(instruments) => Self::lost(file, &instruments),
            PoolError::Bounded(reasons) => Self::NoAnswer(format!(
                "{}: pooled estimate: found no room for an estimate ({}), expected a parameter that the data determine; widen \
                 the `bounds`, or fix some of these parameters",
                file.display(),
                reasons.join("; ")
            )),
            PoolError::Unfound(unfound) if unfound.recordings.is_empty() => Self::NoAnswer(format!(
                "{}: pooled estimate: found that {unfound}, expected one; leave out terms that these runs do not move",
                file.display()
            )),
            PoolError::Unfound(unfound) => Self::NoAnswer(format!(
                "{}: pooled estimate: found that {unfound}, expected a model that follows all; name recordings that belong to \
                 another ship or load with --leave-out, cut shorter parts with --part-s, or correct the structure",
                file.display()
            )),
            PoolError::Incomplete(reasons) => Self::NoAnswer(format!(
                "{}: pooled estimate: found degrees of freedom that are not identifiable ({}), without which no search can \
                 simulate, expected all three; add runs that vary these terms, fix them, or use --estimator auto",
                file.display(),
                reasons.join("; ")
            )),
            PoolError::NotIdentifiable(reasons) => Self::NoAnswer(format!(
                "{}: pooled estimate: found no degree of freedom that is identifiable ({}), expected one; add runs that vary \
                 these terms, or name a --prior for `ls`, `iv` or `auto`",
                file.display(),
                reasons.join("; ")
            )),
        }
    }

    /// Something in `file` is invalid.
    pub fn invalid(file: &Path, invalid: &Invalid) -> Self {
        files::Error::invalid(file, invalid.clone()).into()
    }
}

impl From<files::Error> for Failure {
    fn from(error: files::Error) -> Self {
        match error {
            files::Error::Refused { .. } => Self::Refused(error.to_string()),
            files::Error::Io { .. } => Self::Failed(error.to_string()),
        }
    }
}

impl From<Infallible> for Failure {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}
