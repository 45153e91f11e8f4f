use std::fmt::Display;
use std::ops::RangeInclusive;

use crate::Invalid;

/// Refuses the first of `numbers`, each with its key, that is not finite or not valid: it should be
/// `expected`.
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

/// A number without long runs of zeros.
fn short(number: f64) -> String {
    let plain = number == 0.0 || !number.is_finite() || (1e-3..1e7).contains(&number.abs());
    if plain { number.to_string() } else { format!("{number:e}") }
}
