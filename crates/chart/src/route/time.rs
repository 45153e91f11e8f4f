//! Calendar times without a clock: UTC, proleptic Gregorian, whole milliseconds.

use crate::Invalid;

/// Seconds since 1970-01-01T00:00:00Z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Instant(i64);

impl Instant {
    /// Reads `YYYY-MM-DDThh:mm:ssZ`.
    pub(crate) fn parse(text: &str) -> Result<Self, Invalid> {
        let refuse = || {
            Invalid::new(
                "departure",
                format!("`{text}`"),
                "a time such as 2026-05-20T06:00:00Z",
                "correct it",
            )
        };
        let number = |from: usize, to: usize| -> Option<i64> {
            let digits = text.get(from..to)?;
            digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok())?
        };
        let parts = [(0, 4), (5, 7), (8, 10), (11, 13), (14, 16), (17, 19)].map(|(a, b)| number(a, b));
        let marks = text.len() == 20
            && [(4, b'-'), (7, b'-'), (10, b'T'), (13, b':'), (16, b':'), (19, b'Z')]
                .iter()
                .all(|(i, c)| text.as_bytes().get(*i) == Some(c));
        let [Some(y), Some(m), Some(d), Some(h), Some(min), Some(s)] = parts else { return Err(refuse()) };
        let instant = Self(days(y, m, d) * 86_400 + h * 3600 + min * 60 + s);
        // A day that the month does not have comes back as another one.
        let same = marks && h < 24 && min < 60 && s < 60 && instant.after(0.0).get(..19) == text.get(..19);
        if same { Ok(instant) } else { Err(refuse()) }
    }

    /// The time `seconds` later, as `YYYY-MM-DDThh:mm:ss.sssZ`, without the fraction where it is zero.
    pub(crate) fn after(self, seconds: f64) -> String {
        let millis = (seconds * 1000.0).round() as i64;
        let total = self.0 + millis.div_euclid(1000);
        let (day, second) = (total.div_euclid(86_400), total.rem_euclid(86_400));
        let (y, m, d) = date(day);
        let (h, min, s) = (second / 3600, second / 60 % 60, second % 60);
        let fraction = match millis.rem_euclid(1000) {
            0 => String::new(),
            ms => format!(".{ms:03}"),
        };
        format!("{y:04}-{m:02}-{d:02}T{h:02}:{min:02}:{s:02}{fraction}Z")
    }
}

/// Days from 1970-01-01 to a date; years begin in March so that the leap day comes last.
fn days(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let leap = year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    year * 365 + leap + of_year - 719_468
}

/// The date that many days after 1970-01-01.
fn date(day: i64) -> (i64, i64, i64) {
    let day = day + 719_468;
    let era = day.div_euclid(146_097);
    let of_era = day.rem_euclid(146_097);
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let (d, m) = (of_year - (153 * month + 2) / 5 + 1, (month + 2) % 12 + 1);
    (year + era * 400 + i64::from(m <= 2), m, d)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oracle_times_known_from_the_unix_epoch() {
        let cases = [
            ("1970-01-01T00:00:00Z", 0),
            ("2000-02-29T12:00:00Z", 951_825_600),
            ("2026-11-21T11:31:27Z", 1_795_260_687),
            ("2100-03-01T00:00:00Z", 4_107_542_400),
        ];
        for (text, seconds) in cases {
            assert_eq!(Instant::parse(text).unwrap(), Instant(seconds), "{text}");
            assert_eq!(Instant(0).after(seconds as f64), text);
        }
        assert_eq!(Instant(0).after(86_399.999_6), "1970-01-02T00:00:00Z");
        assert_eq!(Instant(0).after(1.25), "1970-01-01T00:00:01.250Z");
    }

    #[test]
    fn times_that_do_not_exist_are_refused() {
        for text in
            ["2025-02-29T00:00:00Z", "2025-01-01T24:00:00Z", "2025-01-01 00:00:00Z", "2025-1-1", "æøå"]
        {
            assert!(Instant::parse(text).is_err(), "{text}");
        }
    }
}
