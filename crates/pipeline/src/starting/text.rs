//! Texts in hand-written files.

use toml::Value;

/// What is at the end of a line that was guessed.
pub(super) const MARK: &str = "  # guessed";

/// `text` in quotes as TOML has them.
pub(super) fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}
