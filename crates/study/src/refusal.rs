use std::path::Path;

use files::Error;
use refusal::Invalid;

/// A refusal of what is invalid in `file`.
pub fn invalid(file: &Path, invalid: &Invalid) -> Error {
    Error::invalid(file, invalid.clone())
}

/// A refusal of `file`.
pub fn refuse(file: &Path, thing: &str, found: &str, expected: &str, remedy: &str) -> Error {
    Error::refuse(file, thing, found, expected, remedy)
}
