use std::io;

use refusal::Invalid;

/// Why bytes are not a bag.
#[derive(Debug)]
pub enum BagError {
    /// They cannot be read.
    Unreadable(io::Error),
    /// They can be read, but are not a bag, or not one with what is wanted.
    Invalid(Invalid),
}

impl From<io::Error> for BagError {
    fn from(error: io::Error) -> Self {
        Self::Unreadable(error)
    }
}

impl From<Invalid> for BagError {
    fn from(invalid: Invalid) -> Self {
        Self::Invalid(invalid)
    }
}
