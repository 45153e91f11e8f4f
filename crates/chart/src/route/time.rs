//! Calendar times of routes: UTC, whole milliseconds.

use jiff::{SignedDuration, Timestamp};

use crate::Invalid;

/// A moment in UTC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Instant(Timestamp);

impl Instant {
    /// Reads `YYYY-MM-DDThh:mm:ssZ`, and no other of ISO 8601's many forms.
    pub(crate) fn parse(text: &str) -> Result<Self, Invalid> {
        let instant =
            text.parse().ok().map(Self).filter(|instant| text.len() == 20 && instant.after(0.0) == text);
        instant.ok_or_else(|| {
            Invalid::new(
                "departure",
                format!("`{text}`"),
                "a time such as 2026-05-20T06:00:00Z",
                "correct it",
            )
        })
    }

    /// The time `seconds` later, as `YYYY-MM-DDThh:mm:ss.sssZ`, without the fraction where it is zero. Times beyond the year
    /// 9999 stay at its end.
    pub(crate) fn after(self, seconds: f64) -> String {
        let millis = (seconds * 1000.0).round() as i64;
        let later = self.0.saturating_add(SignedDuration::from_millis(millis)).unwrap_or(Timestamp::MAX);
        let whole = later.subsec_nanosecond() == 0;
        later.strftime(if whole { "%Y-%m-%dT%H:%M:%SZ" } else { "%Y-%m-%dT%H:%M:%S.%3fZ" }).to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EPOCH: Instant = Instant(Timestamp::UNIX_EPOCH);

    #[test]
    fn oracle_times_known_from_the_unix_epoch() {
        let cases = [
            ("1970-01-01T00:00:00Z", 0),
            ("2000-02-29T12:00:00Z", 951_825_600),
            ("2026-11-21T11:31:27Z", 1_795_260_687),
            ("2100-03-01T00:00:00Z", 4_107_542_400),
        ];
        for (text, seconds) in cases {
            let expected = Instant(Timestamp::from_second(seconds).unwrap());
            assert_eq!(Instant::parse(text).unwrap(), expected, "{text}");
            assert_eq!(EPOCH.after(seconds as f64), text);
        }
        assert_eq!(EPOCH.after(86_399.999_6), "1970-01-02T00:00:00Z");
        assert_eq!(EPOCH.after(1.25), "1970-01-01T00:00:01.250Z");
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
