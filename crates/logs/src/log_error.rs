use std::io;

use refusal::Invalid;

/// Why bytes are not a log.
#[derive(Debug)]
pub enum LogError {
    /// They cannot be read.
    Unreadable(io::Error),
    /// They can be read, but are not a log.
    Invalid(Invalid),
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
