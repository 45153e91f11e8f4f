use std::fmt::{self, Display};
use std::ops::RangeInclusive;

use crate::words::{fitted, short};
use crate::{foreign, one_line, suggestion};

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

/// Most characters of a name: it stands in figures and routes.
const LONGEST: usize = 200;

/// Refuses a name that figures, routes and pages cannot hold: an empty one, one of more than 200 characters,
/// or one with line breaks, invisible marks, or characters that XML does not allow.
///
/// # Errors
/// Names `thing`, the owner of the name.
pub fn check_name(thing: impl Into<String>, name: &str) -> Result<(), Invalid> {
    let count = name.chars().count();
    let refuse = |found: String| {
        let expected = format!("1 to {LONGEST} visible characters in one line");
        Err(Invalid::new(thing, found, expected, "rename it"))
    };
    let unheld = |c: &char| matches!(c, '\u{fffe}' | '\u{ffff}') || one_line(&c.to_string()) != c.to_string();
    match name.chars().find(unheld) {
        Some(c) => refuse(format!("`{}` with the character U+{:04X}", foreign(name), u32::from(c))),
        None if name.trim().is_empty() => refuse("no name".to_owned()),
        None if count > LONGEST => refuse(format!("`{}`, {count} characters", foreign(name))),
        None => Ok(()),
    }
}

/// Refuses the first of `numbers`, each with its key, that is not finite or not valid: it should be `expected`.
///
/// # Errors
/// Names the key.
pub fn check_numbers<K: Display>(
    numbers: impl IntoIterator<Item = (K, f64)>,
    expected: &str,
    fits: impl Fn(f64) -> bool,
) -> Result<(), Invalid> {
    match numbers.into_iter().find(|(_, value)| !(value.is_finite() && fits(*value))) {
        Some((key, value)) => Err(invalid(key, value, expected)),
        None => Ok(()),
    }
}

/// Refuses the first of `numbers`, each with its key, range and unit, that is out of range: derived sizes,
/// such as a number of samples, would be unbounded.
///
/// # Errors
/// Names the key and the range.
pub fn check_ranges<K: Display>(
    numbers: impl IntoIterator<Item = (K, f64, RangeInclusive<f64>, &'static str)>,
) -> Result<(), Invalid> {
    match numbers.into_iter().find(|(_, value, range, _)| !range.contains(value)) {
        Some((key, value, range, unit)) => {
            let expected = format!("{} to {} {unit}", short(*range.start()), short(*range.end()));
            Err(invalid(key, value, expected.trim_end()))
        }
        None => Ok(()),
    }
}

fn invalid(key: impl Display, value: f64, expected: &str) -> Invalid {
    Invalid::new(format!("`{key}`"), short(value), expected, "correct it")
}
