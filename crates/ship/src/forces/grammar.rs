//! How terms are written, with forces or per sample: names, moduli and powers.

/// Most factors of a term, and of a formula.
pub const MOST_FACTORS: usize = 32;

/// Whether a modulus is at the start of `text`, the name there, and the rest; the name is empty where none begins.
///
/// # Errors
/// What is wrong: an unclosed modulus.
pub fn parse_name(text: &str) -> Result<(bool, &str, &str), String> {
    let (modulus, start) = match text.strip_prefix('|') {
        Some(inner) => (true, inner.trim_start()),
        None => (false, text),
    };
    let end = start.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(start.len());
    let (name, mut after) = start.split_at(end);
    if modulus {
        after = after.trim_start().strip_prefix('|').ok_or("an unclosed `|`")?;
    }
    Ok((modulus, name, after))
}

/// The power at the start of `text`, 1 if there is none, and the rest.
///
/// # Errors
/// What is wrong: a power that is none.
pub fn parse_power(text: &str) -> Result<(u8, &str), String> {
    let Some(exponent) = text.trim_start().strip_prefix('^') else { return Ok((1, text)) };
    let exponent = exponent.trim_start();
    let end = exponent.find(|c: char| !c.is_ascii_digit()).unwrap_or(exponent.len());
    match exponent[..end].parse() {
        Ok(power @ 1..=9) => Ok((power, &exponent[end..])),
        _ => Err("a power that is no whole number from 1 to 9".to_owned()),
    }
}
