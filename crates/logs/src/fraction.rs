//! Times whose decimals are a whole number of nano- or microseconds, printed without leading zeros: `12.5`
//! for 12 s and 5 µs.

use numerics::statistics::streamed_median as median_again;

use crate::Samples;
use crate::samples::steps;

/// How many decimals the times of a file have, as long as they may be such numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fractions {
    /// One per row.
    digits: Vec<u8>,
    /// A time was seen that cannot be such a number.
    is_plain: bool,
    /// Some end in zero, as numbers in shortest form do not.
    has_zeros: bool,
}

/// How much more even steps must become before times are read the other way.
const MORE_EVEN: f64 = 4.0;

impl Fractions {
    /// Takes the time of the next row, whose decimals follow `decimal`.
    pub fn see(&mut self, text: &str, decimal: char) {
        if self.is_plain {
            return;
        }
        match digits_of(text, decimal) {
            Some(digits) if digits.len() == 1 || !digits.starts_with('0') => {
                self.has_zeros |= digits.len() > 1 && digits.ends_with('0');
                self.digits.push(digits.len().min(9) as u8);
            }
            // A row without a time.
            None if !text.contains(|c: char| c.is_ascii_digit()) => self.digits.push(0),
            _ => (self.is_plain, self.digits) = (true, Vec::new()),
        }
    }

    /// Appends the decimals of the following rows.
    pub(crate) fn append(&mut self, others: Self) {
        self.is_plain |= others.is_plain;
        self.has_zeros |= others.has_zeros;
        self.digits.extend(others.digits);
        if self.is_plain {
            self.digits = Vec::new();
        }
    }

    /// `times` \[s\] as they are meant, and how many rows that changes.
    pub(crate) fn padded(&self, times: Samples) -> (Samples, usize) {
        let lengths = || self.digits.iter().copied().filter(|digits| *digits > 0);
        let (Some(least), Some(most)) = (lengths().min(), lengths().max()) else { return (times, 0) };
        if self.is_plain || self.digits.len() != times.len() {
            return (times, 0);
        }
        let unit = if most > 6 {
            9
        } else if most > 3 {
            6
        } else {
            3
        };
        let rows = times.iter().zip(&self.digits);
        let meant = times.made(rows.map(|(time, digits)| {
            let whole = time.floor();
            let number = ((time - whole) * 10_f64.powi(i32::from(*digits))).round();
            whole + number * 10_f64.powi(-unit)
        }));
        // If all rows have equally many digits, they were printed so, with zeros at the end.
        match least < most && self.has_zeros || is_more_even(&meant, &times) {
            true => (meant, lengths().filter(|digits| i32::from(*digits) < unit).count()),
            false => (times, 0),
        }
    }
}

/// Whether the steps of `times` go back less often than those of `others`, or are far more even.
fn is_more_even(times: &Samples, others: &Samples) -> bool {
    let [own, other] = [times, others].map(|times| {
        let steps = || steps(times.iter().filter(|time| time.is_finite()));
        let back = steps().filter(|step| *step < 0.0).count();
        let usual = median_again(steps).unwrap_or(0.0);
        (back, steps().map(|step| (step - usual).abs()).sum::<f64>())
    });
    other.0 > MORE_EVEN as usize * own.0 || other.0 == own.0 && other.1 > MORE_EVEN * own.1
}

/// The decimals at the end of a time, or before its zone.
fn digits_of(text: &str, decimal: char) -> Option<&str> {
    let (before, after) = text.trim().rsplit_once(decimal)?;
    let end = after.find(|c: char| !c.is_ascii_digit()).unwrap_or(after.len());
    let (digits, rest) = after.split_at(end);
    let is_zone = || rest.starts_with(['Z', 'z', '+', '-']);
    let is_apart =
        || rest.strip_prefix(' ').is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_digit()));
    let ends = rest.is_empty() || is_zone() || is_apart();
    (!digits.is_empty() && before.ends_with(|c: char| c.is_ascii_digit()) && ends).then_some(digits)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn padded(texts: &[String]) -> (Vec<f64>, usize) {
        let mut fractions = Fractions::default();
        texts.iter().for_each(|text| fractions.see(text, '.'));
        let times: Vec<f64> = texts.iter().map(|text| text.parse().unwrap()).collect();
        let (times, moved) = fractions.padded(times.into());
        (times.to_vec(), moved)
    }

    #[test]
    fn law_numbers_without_leading_zeros_are_times_again() {
        for (unit, digits) in [(1_000_000_000_u64, 9), (1_000_000, 6), (1000, 3)] {
            for step_ms in [20, 100, 250, 1000] {
                let stamp =
                    |k: u64| (170_000_000 * unit) + k * step_ms * unit / 1000 + (7 * k * k) % 13 * unit / 500;
                let texts: Vec<String> =
                    (0..200).map(|k| format!("{}.{}", stamp(k) / unit, stamp(k) % unit)).collect();
                let (found, _) = padded(&texts);
                for (k, time) in found.iter().enumerate() {
                    let truth = (stamp(k as u64) as f64) / unit as f64;
                    assert!(
                        (time - truth).abs() < 1e-6,
                        "{digits} digits, {step_ms} ms: {time}, not {truth}"
                    );
                }
            }
        }
    }

    /// Four digits in every row: 2.0 to 8.6 ms after each second.
    #[test]
    fn numbers_of_as_many_digits_are_recognized_by_how_even_their_steps_are() {
        let micros = |k: usize| 2000 + (k * 7 % 13) * 550;
        let texts: Vec<String> = (0..61).map(|k| format!("{}.{}", 50_000 + k, micros(k))).collect();
        let (found, moved) = padded(&texts);
        assert_eq!(moved, 61);
        for (k, time) in found.iter().enumerate() {
            assert!((time - (50_000 + k) as f64 - micros(k) as f64 * 1e-6).abs() < 1e-9, "{time}");
        }
    }

    #[test]
    fn decimals_that_are_written_short_or_with_all_digits_stay() {
        for step in [0.01, 0.05, 0.1, 0.25, 0.5, 1.0] {
            let short: Vec<String> = (0..200).map(|k| format!("{}", 10.0 + step * f64::from(k))).collect();
            let one: Vec<String> = (0..200).map(|k| format!("{:?}", 10.0 + step * f64::from(k))).collect();
            let long: Vec<String> = (0..200).map(|k| format!("{:.3}", 10.0 + step * f64::from(k))).collect();
            for texts in [short, one, long] {
                assert_eq!(padded(&texts).1, 0, "{step}: {:?}", &texts[..9]);
            }
        }
        assert_eq!(digits_of("2020-07-31T13:04:24.25+09:00", '.'), Some("25"));
        assert_eq!(digits_of("11.04.2025 12:08:20", '.'), None);
        assert_eq!(digits_of("12:08:20.5", '.'), Some("5"));
    }
}
