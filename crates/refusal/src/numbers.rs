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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_beyond_their_range_are_refused_with_it() {
        let check = |value| check_ranges([("window_s", value, 1e-6..=1e7, "s")]).map_err(|e| e.to_string());
        assert_eq!(check(3.0), Ok(()));
        let message = check(1.8446744073709552e19).unwrap_err();
        assert_eq!(message, "`window_s`: found 1.8446744073709552e19, expected 1e-6 to 1e7 s; correct it");
        assert!(check(f64::NAN).unwrap_err().contains("found NaN"));
        assert!(check(-1.0).unwrap_err().contains("found -1,"));
    }
}
