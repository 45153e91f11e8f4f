/// Superscript digits 0 to 9.
const SUPERSCRIPTS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

/// `value` as a tick of an axis whose ticks are `step` apart: as many decimals as the step needs, a true minus sign,
/// a power of ten for very large or small values. Empty for a value that is not finite.
///
/// ```
/// assert_eq!(report::figures::tick_number(-0.25, 0.05), "−0.25");
/// assert_eq!(report::figures::tick_number(4000.0, 2000.0), "4000");
/// assert_eq!(report::figures::tick_number(2e6, 1e6), "2·10⁶");
/// ```
#[must_use]
pub fn number(value: f64, step: f64) -> String {
    if !value.is_finite() {
        return String::new();
    }
    if value.abs() < step.abs() * 1e-9 {
        return "0".to_owned();
    }
    let magnitude = libm::log10(value.abs()).floor();
    if (-4.0..5.0).contains(&magnitude) { plain(value, step) } else { scientific(value, magnitude) }
}

fn plain(value: f64, step: f64) -> String {
    let needed = if step > 0.0 { (-libm::log10(step).floor()).max(0.0) } else { 2.0 };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 9")]
    let decimals = needed.min(9.0) as usize;
    signed(&format!("{value:.decimals$}"))
}

fn scientific(value: f64, magnitude: f64) -> String {
    let mantissa = format!("{:.1}", value / libm::pow(10f64, magnitude));
    let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
    #[expect(clippy::cast_possible_truncation, reason = "an exponent of a finite number")]
    let exponent = magnitude as i32;
    format!("{}·10{}", signed(mantissa), superscript(exponent))
}

/// A whole number as an exponent is written.
pub(crate) fn superscript(exponent: i32) -> String {
    let sign = if exponent < 0 { "⁻" } else { "" };
    let digits = exponent.unsigned_abs().to_string();
    let raised = digits.bytes().map(|digit| SUPERSCRIPTS[usize::from(digit - b'0')]);
    sign.chars().chain(raised).collect()
}

/// With a true minus sign.
pub(crate) fn signed(digits: &str) -> String {
    digits.replace('-', "−")
}

/// `share` (0 to 1) in percent with one decimal.
pub(crate) fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// `text`, or its beginning and an ellipsis if it has more than `most` characters.
pub(crate) fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(1)).chain(['…']).collect()
}

/// The approximate width of `text` at font size `size`, both in pixels.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    0.56 * size * text.chars().count() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_labels_are_cut() {
        assert_eq!(shortened("zig-zag", 7), "zig-zag");
        assert_eq!(shortened("zig-zags", 7), "zig-za…");
    }
}
