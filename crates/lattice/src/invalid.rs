use std::fmt;

/// A value that a problem may not have. Whoever read the file adds its name.
#[derive(Clone, Debug, PartialEq)]
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

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: found {}, expected {}; {}", self.thing, self.found, self.expected, self.remedy)
    }
}

impl std::error::Error for Invalid {}
