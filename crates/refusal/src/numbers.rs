use std::fmt::Display;

use crate::Invalid;

/// Refuses the first of `numbers`, each with its key, that is not finite or does not fit: it should be `expected`.
///
/// # Errors
/// Names the key.
pub fn check_numbers<K: Display>(
    numbers: impl IntoIterator<Item = (K, f64)>,
    expected: &str,
    fits: impl Fn(f64) -> bool,
) -> Result<(), Invalid> {
    match numbers.into_iter().find(|(_, value)| !(value.is_finite() && fits(*value))) {
        Some((key, value)) => {
            Err(Invalid::new(format!("`{key}`"), value.to_string(), expected, "correct it"))
        }
        None => Ok(()),
    }
}
