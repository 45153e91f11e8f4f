use thiserror::Error;

/// A value that a file may not have. Whoever read the file adds its name.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{thing}: found {found}, expected {expected}; {remedy}")]
pub struct Invalid {
    /// What the value is.
    pub thing: String,
    /// The value as found.
    pub found: String,
    /// What would be valid.
    pub expected: String,
    /// What to do about it.
    pub remedy: String,
}

impl Invalid {
    /// All four parts of the message.
    pub fn new(
        thing: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self { thing: thing.into(), found: found.into(), expected: expected.into(), remedy: remedy.into() }
    }
}

/// The known name that looks most like `found`.
pub fn nearest<'a>(found: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known
        .into_iter()
        .map(|name| (strsim::jaro_winkler(found, name), name))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}
