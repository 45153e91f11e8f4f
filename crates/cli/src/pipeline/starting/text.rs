//! Texts in hand-written files.

use logs::guess::Placed;
use toml::Value;

/// What is at the end of a line that was guessed.
pub(super) const MARK: &str = "  # guessed";

/// `text` in quotes as TOML has them.
pub(super) fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}

/// A channel as an item of a list.
pub(super) fn channel(placed: &Placed) -> String {
    let [column, channel, unit] = [&placed.column, &placed.channel, &placed.unit].map(|text| quoted(text));
    let optional = if placed.is_optional { ", optional = true" } else { "" };
    format!("{{ column = {column}, channel = {channel}, unit = {unit}{optional} }}")
}
