//! Times in sentences.

use jiff::civil::Date;
use jiff::tz::TimeZone;

use super::sentence::Sentence;

/// A time that a sentence reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reported {
    /// Since midnight \[s\]; from 86,400 in a leap second.
    pub(super) of_day: f64,
    /// From 1970 to that midnight, if the date is reported \[s\].
    pub(super) midnight: Option<f64>,
    /// Whether it lies in a leap second.
    pub(super) is_sixty: bool,
    /// Whether the receiver has a fix.
    pub(super) is_fix: bool,
}

/// Sentences with a time, and the field of the time.
const TIMED: [(&str, usize); 5] = [("RMC", 0), ("ZDA", 0), ("GGA", 0), ("GNS", 0), ("GLL", 4)];

/// Whether sentences whose addresses end with `kind` have a time.
pub(super) fn has_time(kind: &str) -> bool {
    TIMED.iter().any(|(known, _)| kind.ends_with(known)) && !kind.starts_with('P') && kind.len() <= 5
}

/// Whether they have a date.
pub(super) fn is_dated(kind: &str) -> bool {
    kind.ends_with("RMC") || kind.ends_with("ZDA")
}

/// The time in `sentence`: `None` where it is of another kind or has none.
///
/// # Errors
/// The field that is not a time, and what was expected.
pub(super) fn reported_time<'a>(
    sentence: &Sentence<'a>,
) -> Result<Option<Reported>, (&'a str, &'static str)> {
    let Some((kind, place)) = TIMED.iter().find(|(kind, _)| sentence.is_a(kind)) else { return Ok(None) };
    let text = sentence.field(*place);
    if text.is_empty() {
        return Ok(None);
    }
    let is_fix = is_fix(kind, sentence);
    let (date, midnight) = match *kind {
        "RMC" => (sentence.field(8), joined(sentence.field(8))),
        "ZDA" => (sentence.field(3), apart([1, 2, 3].map(|place| sentence.field(place)))),
        _ => ("", None),
    };
    // A receiver without a date writes nothing, or zeros.
    let dateless = date.bytes().all(|byte| byte == b'0');
    match of_day(text) {
        Some((of_day, is_sixty)) if midnight.is_some() || dateless || !is_fix => {
            // A receiver that does not know the date yet begins with the first day of its week count.
            let is_fix = is_fix && !(*kind == "ZDA" && midnight.is_some_and(is_first_day));
            Ok(Some(Reported { of_day, midnight, is_sixty, is_fix }))
        }
        Some(_) => Err((date, "a valid date")),
        None if is_fix => Err((text, "a time such as 123519.00")),
        None => Ok(None),
    }
}

fn is_fix(kind: &str, sentence: &Sentence) -> bool {
    match kind {
        "RMC" => sentence.field(1) == "A",
        "GLL" => sentence.field(5) == "A",
        "GGA" => !["", "0"].contains(&sentence.field(5)),
        "GNS" => sentence.field(5).chars().any(|mode| mode != 'N'),
        _ => true,
    }
}

/// Period of the receivers' week count \[s\].
pub(super) const WEEKS: f64 = 1024.0 * 7.0 * DAY;

pub(super) const DAY: f64 = 86_400.0;

/// From 1970 to their first week \[s\].
const FIRST: f64 = 315_964_800.0;

/// Whether a day is within two days of the start of a week count.
fn is_first_day(midnight: f64) -> bool {
    (midnight - FIRST).rem_euclid(WEEKS) < 2.0 * DAY
}

/// Seconds since midnight of `hhmmss.ss`, and whether it is a second 60.
fn of_day(text: &str) -> Option<(f64, bool)> {
    let whole = text.get(..6)?.bytes().all(|byte| byte.is_ascii_digit());
    let part = |from: usize, to: usize| text.get(from..to)?.parse::<u8>().ok().map(f64::from);
    let (hours, minutes) = (part(0, 2)?, part(2, 4)?);
    let seconds: f64 = text.get(4..)?.parse().ok()?;
    let fits = whole && hours < 24.0 && minutes < 60.0 && (0.0..61.0).contains(&seconds);
    fits.then_some((3600.0 * hours + 60.0 * minutes + seconds, seconds >= 60.0))
}

/// Seconds from 1970 to the day `ddmmyy`, in the years from 1980 on.
fn joined(text: &str) -> Option<f64> {
    let year = text.get(4..6)?;
    let century = if year >= "80" { "19" } else { "20" };
    apart([text.get(0..2)?, text.get(2..4)?, &format!("{century}{year}")])
}

fn apart([day, month, year]: [&str; 3]) -> Option<f64> {
    let date = Date::new(year.parse().ok()?, month.parse().ok()?, day.parse().ok()?).ok()?;
    let midnight = date.to_zoned(TimeZone::UTC).ok()?.timestamp();
    Some(midnight.as_duration().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_and_times_are_read_as_the_standard_writes_them() {
        assert_eq!(of_day("123519.25"), Some((45_319.25, false)));
        assert_eq!(of_day("235960"), Some((86_400.0, true)));
        assert_eq!([of_day("246000"), of_day("1235"), of_day("")], [None; 3]);
        assert_eq!(joined("310720"), Some(1_596_153_600.0));
        assert_eq!(apart(["31", "07", "2020"]), Some(1_596_153_600.0));
        assert_eq!([joined("310220"), joined("3107")], [None; 2]);
    }

    #[test]
    fn years_from_1980_on_are_those_of_the_receivers() {
        let first = joined("060180").unwrap();
        assert_eq!(first, FIRST);
        assert!([first, joined("220899").unwrap(), joined("070419").unwrap()].into_iter().all(is_first_day));
        assert!(!is_first_day(joined("110425").unwrap()));
    }
}
