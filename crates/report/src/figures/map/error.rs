use std::fmt;

/// A map that cannot be drawn truly.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MapError {
    /// What the value is.
    pub thing: String,
    /// The value as found.
    pub found: String,
    /// What would be valid.
    pub expected: String,
    /// What to do about it.
    pub remedy: String,
}

impl MapError {
    pub(crate) fn new(
        thing: impl Into<String>,
        found: impl fmt::Display,
        expected: &str,
        remedy: &str,
    ) -> Self {
        let found = found.to_string().replace('\n', " ");
        Self { thing: thing.into(), found, expected: expected.to_owned(), remedy: remedy.to_owned() }
    }
}

impl fmt::Display for MapError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { thing, found, expected, remedy } = self;
        write!(f, "map: {thing}: found {found}, expected {expected}; {remedy}")
    }
}

impl std::error::Error for MapError {}
