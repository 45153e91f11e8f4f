//! Times of sentences: those that sentences of one kind tell, or stamps before them.

use jiff::civil::Date;
use jiff::tz::TimeZone;
use refusal::Invalid;

use super::sentence::Sentence;
use crate::columns::cell_of;
use crate::{LogError, Stamps};

/// Where times come from.
pub(super) struct Clock<'a> {
    from: Told<'a>,
    /// The last time of day \[s\], and whole days before it, where no date is told.
    last: f64,
    days: f64,
}

enum Told<'a> {
    /// Sentences of this kind, perhaps of one talker.
    Sentence(String),
    /// What stands before a sentence: a time as text or a number.
    Prefix(Option<&'a Stamps>),
}

/// Sentences that tell a time, the field that it stands in, and where the date stands.
const TELLING: [(&str, usize, Dated); 5] = [
    ("RMC", 0, Dated::Joined(8)),
    ("ZDA", 0, Dated::Apart(1)),
    ("GGA", 0, Dated::Never),
    ("GNS", 0, Dated::Never),
    ("GLL", 4, Dated::Never),
];

#[derive(Clone, Copy)]
enum Dated {
    /// `ddmmyy`.
    Joined(usize),
    /// Day, month and year in three fields.
    Apart(usize),
    /// Times of day alone.
    Never,
}

const DAY: f64 = 86_400.0;

impl<'a> Clock<'a> {
    /// No times at all.
    pub(super) fn none() -> Self {
        Self { from: Told::Prefix(None), last: f64::NAN, days: 0.0 }
    }

    /// The clock called `column`.
    pub(super) fn new(column: &str, stamps: &'a Stamps, is_text: bool) -> Result<Self, Invalid> {
        let from = match column {
            "prefix" => Told::Prefix(is_text.then_some(stamps)),
            kind if TELLING.iter().any(|(known, ..)| kind.ends_with(known)) => {
                Told::Sentence(kind.to_owned())
            }
            _ => {
                let found = format!("`{column}`");
                let expected = "RMC, ZDA, GGA, GNS or GLL, which tell a time, or `prefix`";
                return Err(Invalid::new(
                    "time of sentences",
                    found,
                    expected,
                    "correct the time's `column`",
                ));
            }
        };
        Ok(Self { from, ..Self::none() })
    }

    /// The time that a line tells \[s\]: none where it goes on with the last.
    pub(super) fn time(
        &mut self,
        prefix: &str,
        sentence: &Sentence,
        line: usize,
        written_in: &str,
    ) -> Result<Option<f64>, LogError> {
        match &self.from {
            Told::Prefix(stamps) => {
                let text = prefix.trim_matches([' ', '\t', ',', ';', '[', ']', '"']);
                match stamps {
                    Some(stamps) => match stamps.seconds(text) {
                        Ok(seconds) => Ok(Some(seconds)),
                        Err(why) => {
                            Err(LogError::Invalid(stamps.refused(line, "prefix", text, why, written_in)))
                        }
                    },
                    None if text.is_empty() => Ok(Some(f64::NAN)),
                    None => {
                        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
                        let remedy = "correct the line, or state the `format` of the stamps";
                        let refused =
                            || Invalid::new(cell_of(line, "prefix"), format!("`{text}`"), "a number", remedy);
                        Ok(Some(number.ok_or_else(refused)?))
                    }
                }
            }
            Told::Sentence(kind) if sentence.address.ends_with(kind.as_str()) => self.told(sentence, line),
            Told::Sentence(_) => Ok(None),
        }
    }

    /// The time that a sentence of the clock's kind tells; NaN where it knows none yet.
    fn told(&mut self, sentence: &Sentence, line: usize) -> Result<Option<f64>, LogError> {
        let Some((_, place, dated)) = TELLING.iter().find(|(kind, ..)| sentence.address.ends_with(kind))
        else {
            return Ok(None);
        };
        let text = sentence.field(*place);
        if text.is_empty() {
            return Ok(Some(f64::NAN));
        }
        let refused = |text: &str, expected: &str| {
            let column = format!("{}.time", sentence.address);
            Invalid::new(
                cell_of(line, &column),
                format!("`{text}`"),
                expected,
                "correct or leave out the line",
            )
        };
        let since = of_day(text).ok_or_else(|| refused(text, "a time such as 123519.00"))?;
        let date = match *dated {
            Dated::Never => {
                self.days += if since < self.last - 0.5 * DAY { DAY } else { 0.0 };
                self.last = since;
                return Ok(Some(self.days + since));
            }
            Dated::Joined(place) => joined(sentence.field(place)),
            Dated::Apart(place) => date([0, 1, 2].map(|i| sentence.field(place + i))),
        };
        let days = date.ok_or_else(|| refused(text, "a date beside the time"))?;
        Ok(Some(days + since))
    }

    /// What lacks where none of `addresses` tells the time.
    pub(super) fn lacks<'b>(&self, mut addresses: impl Iterator<Item = &'b String>) -> Option<&str> {
        match &self.from {
            Told::Sentence(kind) => {
                (!addresses.any(|address| address.ends_with(kind.as_str()))).then_some(kind)
            }
            Told::Prefix(_) => None,
        }
    }
}

/// Seconds since midnight of `hhmmss.ss`.
fn of_day(text: &str) -> Option<f64> {
    let part = |from: usize, to: usize| text.get(from..to)?.parse::<u8>().ok().map(f64::from);
    let (hours, minutes) = (part(0, 2)?, part(2, 4)?);
    let seconds: f64 = text.get(4..)?.parse().ok()?;
    let fits = hours < 24.0 && minutes < 60.0 && (0.0..61.0).contains(&seconds);
    fits.then_some(3600.0 * hours + 60.0 * minutes + seconds)
}

/// Seconds from 1970 to the day `ddmmyy`, in this century.
fn joined(text: &str) -> Option<f64> {
    let year = format!("20{}", text.get(4..6)?);
    date([text.get(0..2)?, text.get(2..4)?, &year])
}

fn date([day, month, year]: [&str; 3]) -> Option<f64> {
    let date = Date::new(year.parse().ok()?, month.parse().ok()?, day.parse().ok()?).ok()?;
    let midnight = date.to_zoned(TimeZone::UTC).ok()?.timestamp();
    Some(midnight.as_duration().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_and_times_are_read_as_the_standard_writes_them() {
        assert_eq!(of_day("123519.25"), Some(45_319.25));
        assert_eq!([of_day("246000"), of_day("1235"), of_day("")], [None; 3]);
        assert_eq!(joined("310720"), Some(1_596_153_600.0));
        assert_eq!(date(["31", "07", "2020"]), Some(1_596_153_600.0));
        assert_eq!([joined("310220"), joined("3107")], [None; 2]);
    }
}
