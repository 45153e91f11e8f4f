//! Choices that the other crates define, as values of flags.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Parses one of `all` by its name; `help` is its line in `--help`.
pub fn choice<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
    help: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let values = all.iter().map(|one| PossibleValue::new(name(*one)).help(help(*one)));
    PossibleValuesParser::new(values.collect::<Vec<_>>()).try_map(move |given| {
        let known = all.iter().copied().find(|one| name(*one) == given);
        known.ok_or_else(|| format!("unknown value {given}"))
    })
}
