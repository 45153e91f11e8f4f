use std::fmt;

use crate::nearest;

/// A value that is refused. It knows no file: whoever read one adds its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Invalid {
    /// What the value is: a key, a column, a row.
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

    /// A name that is none of the `known` ones, the nearest of which may be meant.
    pub fn unknown<'a>(
        thing: impl Into<String>,
        name: &str,
        known: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let known: Vec<&str> = known.into_iter().collect();
        let remedy = match nearest(name, known.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "remove it".into(),
        };
        Self::new(thing, format!("`{name}`"), known.join(", "), remedy)
    }
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { thing, found, expected, remedy } = self;
        f.write_str(&one_line(&format!("{thing}: found {found}, expected {expected}; {remedy}")))
    }
}

impl std::error::Error for Invalid {}

/// `text` with every run of line breaks and other control characters replaced by one space.
pub fn one_line(text: &str) -> String {
    let parts = text.split(|c: char| c.is_control() || c == '\u{2028}' || c == '\u{2029}');
    parts.filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_one_line_whatever_its_parts_hold() {
        let invalid = Invalid::new("`a`", "x\r\n\u{2028}y", "z", "correct it");
        assert_eq!(invalid.to_string(), "`a`: found x y, expected z; correct it");
    }
}
