use std::io;

use crate::bag::BagError;
use refusal::Invalid;

/// Why bytes are not a log.
#[derive(Debug)]
pub enum LogError {
    /// They cannot be read.
    Unreadable(io::Error),
    /// They can be read, but are not a log.
    Invalid(Invalid),
}

impl From<BagError> for LogError {
    fn from(error: BagError) -> Self {
        match error {
            BagError::Unreadable(error) => Self::Unreadable(error),
            BagError::Invalid(invalid) => Self::Invalid(invalid),
        }
    }
}

impl From<io::Error> for LogError {
    fn from(error: io::Error) -> Self {
        Self::Unreadable(error)
    }
}

impl From<Invalid> for LogError {
    fn from(invalid: Invalid) -> Self {
        Self::Invalid(invalid)
    }
}
