//! Logs as they are read, whether they are packed or not.

use std::io::{BufRead, BufReader};
use std::path::Path;

use files::{Error, open};
use flate2::read::MultiGzDecoder;
use logs::LogError;
use study::invalid;

/// The bytes of the log at `path`, unpacked where its name ends with `.gz`.
///
/// # Errors
/// A file that cannot be opened.
pub(super) fn reader(path: &Path) -> Result<Box<dyn BufRead>, Error> {
    let file = open(path)?;
    let is_packed = path.extension().is_some_and(|end| end == "gz");
    Ok(match is_packed {
        true => Box::new(BufReader::new(MultiGzDecoder::new(file))),
        false => Box::new(BufReader::new(file)),
    })
}

/// What is wrong with the log at `path`.
pub(super) fn wrong(path: &Path, error: LogError) -> Error {
    match error {
        LogError::Unreadable(error) => Error::io(path, "read", error),
        LogError::Invalid(wrong) => invalid(path, &wrong),
    }
}
