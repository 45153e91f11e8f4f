use std::fmt;

use crate::bounded::fitted;
use crate::{one_line, suggestion};

/// Most characters of the four parts of a message together: with a file's name they stay below 500.
const MOST: usize = 360;

/// A refused value. It knows no file: the reader of a file adds its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Invalid {
    /// What the value is: a key, a column, a row.
    pub thing: String,
    /// The value as found.
    pub found: String,
    /// What would be valid.
    pub expected: String,
    /// How to correct it.
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

    /// A name that is not among the `known` ones, the nearest of which is suggested.
    pub fn unknown<'a>(
        thing: impl Into<String>,
        name: &str,
        known: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let known: Vec<&str> = known.into_iter().collect();
        let near = suggestion(name, known.iter().copied());
        let remedy = near.unwrap_or_else(|| "remove it".into());
        Self::new(thing, format!("`{name}`"), known.join(", "), remedy)
    }
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = [&self.thing, &self.found, &self.expected, &self.remedy].map(|part| one_line(part));
        let [thing, found, expected, remedy] = fitted(parts.each_ref().map(String::as_str), MOST);
        write!(f, "{thing}: found {found}, expected {expected}; {remedy}")
    }
}

impl std::error::Error for Invalid {}
