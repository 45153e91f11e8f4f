//! Estimates the memory of a parsed JSON text: a few of its bytes can represent a hundred times as many.

use std::path::Path;

use crate::budget::{Work, budget};
use crate::error::Result;
use crate::ordinary::REMEDY;

/// Memory of a map of one key, of a list of one value, and of a value with its key \[bytes\].
const MAP: usize = 640;
const LIST: usize = 160;
const VALUE: usize = 96;

/// Refuses a text, read from `path`, whose contents do not fit in memory.
///
/// # Errors
/// States the need and the bound.
pub(crate) fn check(path: &Path, text: &str) -> Result<()> {
    // Most texts are so short that they need not be counted.
    if (text.len() * MAP) as f64 <= budget().bytes() {
        return Ok(());
    }
    let found = format!("{} bytes", text.len());
    let work = Work { file: path, thing: "contents", found: &found, remedy: REMEDY };
    budget().memory(work, bytes(text.as_bytes()) as f64)
}

/// Approximate memory of the text and its contents \[bytes\].
fn bytes(text: &[u8]) -> usize {
    let (mut taken, mut quoted, mut escaped) = (2 * text.len() + VALUE, false, false);
    for byte in text {
        match byte {
            _ if escaped => escaped = false,
            b'\\' => escaped = quoted,
            b'"' => quoted = !quoted,
            b'{' if !quoted => taken += MAP,
            b'[' if !quoted => taken += LIST,
            b',' if !quoted => taken += VALUE,
            _ => {}
        }
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_in_texts_takes_no_more_than_they_have() {
        let text = br#"{"a,[\"{": "\\", "b": [1, 2]}"#;
        assert_eq!(bytes(text), 2 * text.len() + VALUE + MAP + LIST + 2 * VALUE);
    }
}
