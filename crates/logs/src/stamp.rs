//! Dates and times as text: in ISO 8601 or in a given format, in a time zone or with an offset.

use jiff::civil::DateTime;
use jiff::fmt::strtime::BrokenDownTime;
use jiff::tz::{AmbiguousOffset, Offset, TimeZone, TimeZoneDatabase};
use jiff::{Timestamp, Zoned};
use refusal::{Invalid, foreign, nearest};

use crate::columns::{cell_of, is_nothing};
use crate::{TimeSpec, TimeUnit};

/// How times in text are read in one kind of files.
#[derive(Clone, Debug)]
pub struct Stamps {
    /// `None` for ISO 8601.
    format: Option<String>,
    /// Whether the format has a day, and not only a time of day.
    dated: bool,
    /// The clock's time zone and its name in messages; UTC by default.
    zone: TimeZone,
    called: String,
}

/// Why a text is no time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoStamp {
    /// It does not parse.
    Unread,
    /// Clocks were set back and showed it twice.
    Twice,
    /// Clocks were set forward and never showed it.
    Never,
}

/// A time since 1970 \[s\] as a date.
pub(crate) fn moment(time: f64) -> String {
    Timestamp::from_second(time as i64).map_or_else(|_| format!("{time} s"), |time| time.to_string())
}

impl Stamps {
    /// Reads times as `spec` says.
    ///
    /// # Errors
    /// A format that has no time of day or cannot be read back, an unknown zone.
    pub fn new(spec: &TimeSpec) -> Result<Self, Invalid> {
        let (zone, called) = match &spec.zone {
            Some(name) => (zone(name)?, name.clone()),
            None => (TimeZone::UTC, "UTC".to_owned()),
        };
        let dated = spec.format.as_deref().map_or(Ok(true), has_day)?;
        Ok(Self { format: spec.format.clone(), dated, zone, called })
    }

    /// Seconds since 1970-01-01 UTC of a text, or since midnight where the format has no day; NaN where there is none.
    ///
    /// # Errors
    /// See [`NoStamp`].
    pub fn seconds(&self, text: &str) -> Result<f64, NoStamp> {
        let text = text.trim();
        if is_nothing(text) {
            return Ok(f64::NAN);
        }
        let Some(format) = &self.format else { return self.iso(text) };
        let parsed = BrokenDownTime::parse(format, text).map_err(|_| NoStamp::Unread)?;
        if !self.dated {
            let since = parsed.to_time().map_err(|_| NoStamp::Unread)?.duration_since(jiff::civil::Time::MIN);
            return Ok(since.as_secs_f64());
        }
        if parsed.timestamp().is_some() || parsed.offset().is_some() {
            return parsed.to_timestamp().map(since_1970).map_err(|_| NoStamp::Unread);
        }
        self.local(parsed.to_datetime().map_err(|_| NoStamp::Unread)?)
    }

    fn iso(&self, text: &str) -> Result<f64, NoStamp> {
        if !TimeUnit::has_time(text) {
            return Err(NoStamp::Unread);
        }
        match text.parse::<Timestamp>() {
            Ok(time) => Ok(since_1970(time)),
            Err(_) => self.local(text.parse().map_err(|_| NoStamp::Unread)?),
        }
    }

    /// A local time in the zone.
    fn local(&self, shown: DateTime) -> Result<f64, NoStamp> {
        let moment = self.zone.to_ambiguous_zoned(shown);
        match moment.offset() {
            AmbiguousOffset::Gap { .. } => Err(NoStamp::Never),
            AmbiguousOffset::Fold { .. } => Err(NoStamp::Twice),
            AmbiguousOffset::Unambiguous { offset } => {
                offset.to_timestamp(shown).map(since_1970).map_err(|_| NoStamp::Unread)
            }
        }
    }

    /// Whether a text, which was read as `time`, has a second 60, which is read as 59.
    fn is_leap(&self, text: &str, time: f64) -> bool {
        let is_last = time.rem_euclid(60.0) >= 59.0;
        if !is_last {
            return false;
        }
        let with = |at: usize, second: &str| format!("{}{second}{}", &text[..at], &text[at + 2..]);
        let is_second = |at: usize| {
            let before = self.seconds(&with(at, "58"));
            before.is_ok_and(|before| (time - before - 1.0).abs() < 1e-3)
        };
        text.match_indices("60").any(|(at, _)| is_second(at))
    }

    /// Seconds since 1970-01-01 UTC of the local time `shown` in the zone, which is in seconds as if it were UTC.
    ///
    /// # Errors
    /// See [`NoStamp`].
    pub fn shown(&self, shown: f64) -> Result<f64, NoStamp> {
        if self.zone == TimeZone::UTC || !shown.is_finite() {
            return Ok(shown);
        }
        let whole = shown.floor();
        let second = Timestamp::from_second(whole as i64).map_err(|_| NoStamp::Unread)?;
        Ok(self.local(TimeZone::UTC.to_datetime(second))? + (shown - whole))
    }

    /// Whether times are those of a day without a date.
    pub(crate) fn of_day(&self) -> bool {
        self.format.is_some() && !self.dated
    }

    /// The refusal of a cell that is not a time.
    pub fn refused(&self, line: usize, column: &str, text: &str, why: NoStamp, written_in: &str) -> Invalid {
        let shown = |how: &str| format!("`{}`, which clocks in {} {how}", foreign(text), self.called);
        let problem = match why {
            NoStamp::Unread => format!("`{}`", foreign(text)),
            NoStamp::Twice => shown("showed twice: they were set back"),
            NoStamp::Never => shown("never showed: they were set forward"),
        };
        let expected = match (why, &self.format) {
            (NoStamp::Unread, Some(format)) => format!("a time that fits `{format}` as a whole"),
            (NoStamp::Unread, None) => "a date and time such as 2020-07-31T13:04:24.5Z".to_owned(),
            _ => "an unambiguous time".to_owned(),
        };
        let remedy = match (why, &self.format) {
            (NoStamp::Unread, Some(_)) => format!("correct the cell, or the time's `format` in {written_in}"),
            (NoStamp::Unread, None) => format!("correct the cell, or the time's `unit` in {written_in}"),
            _ => format!(
                "write times with their offset (`%:z` in the `format`), or as UTC: {written_in} may say \
                 `zone = \"+03:00\"` for such files"
            ),
        };
        Invalid::new(cell_of(line, column), problem, expected, remedy)
    }
}

/// Reads the times of consecutive rows. A leap second is a second of its own: all later times are a second later.
pub struct Moments<'a> {
    pub(crate) stamps: &'a Stamps,
    /// When it began \[s\].
    leap_s: Option<f64>,
}

impl<'a> Moments<'a> {
    /// Reads times with `stamps`.
    pub fn new(stamps: &'a Stamps) -> Self {
        Self { stamps, leap_s: None }
    }

    /// See [`Stamps::seconds`].
    ///
    /// # Errors
    /// See [`NoStamp`].
    pub fn next(&mut self, text: &str) -> Result<f64, NoStamp> {
        let time = self.stamps.seconds(text)?;
        if self.stamps.is_leap(text, time) {
            self.leap_s.get_or_insert(time.floor() + 1.0);
            return Ok(time + 1.0);
        }
        Ok(if self.leap_s.is_some_and(|leap_s| time >= leap_s) { time + 1.0 } else { time })
    }

    /// The moment of the leap second, if there was one.
    pub fn leap_s(&self) -> Option<f64> {
        self.leap_s
    }
}

fn since_1970(time: Timestamp) -> f64 {
    time.as_duration().as_secs_f64()
}

/// A zone by its name in the bundled tz database, or by its offset.
fn zone(name: &str) -> Result<TimeZone, Invalid> {
    if name.starts_with(['+', '-']) {
        let offset = BrokenDownTime::parse("%:z", name).ok().and_then(|parsed| parsed.offset());
        return offset.map(Offset::to_time_zone).ok_or_else(|| unknown(name, None));
    }
    let known = TimeZoneDatabase::bundled();
    known.get(name).map_err(|_| {
        let names: Vec<String> = known.available().map(|name| name.to_string()).collect();
        unknown(name, nearest(name, names.iter().map(String::as_str)))
    })
}

fn unknown(name: &str, near: Option<&str>) -> Invalid {
    let remedy = near.map_or("correct it".to_owned(), |near| format!("did you mean `{near}`?"));
    let expected = "a zone such as Europe/Helsinki, or an offset such as +03:00";
    Invalid::new("`zone`", format!("`{name}`"), expected, remedy)
}

/// Whether a `format` has a day, found by writing a time and reading it back.
fn has_day(format: &str) -> Result<bool, Invalid> {
    let refused = |text: String| {
        let expected = "a format such as `%Y/%m/%d %H:%M:%S%.f`, with hours at least";
        Invalid::new("`format`", text, expected, "correct it")
    };
    let moment: Zoned = Timestamp::UNIX_EPOCH.to_zoned(TimeZone::UTC);
    let written = jiff::fmt::strtime::format(format, &moment)
        .map_err(|_| refused(format!("`{format}`, which has no meaning")))?;
    let read = BrokenDownTime::parse(format, &written)
        .map_err(|_| refused(format!("`{format}`, which cannot be read")))?;
    let dated = read.timestamp().is_some() || read.to_date().is_ok();
    if read.hour().is_none() && read.timestamp().is_none() {
        return Err(refused(format!("`{format}`, which has no time of day")));
    }
    Ok(dated)
}
