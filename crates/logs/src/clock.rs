use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;
use serde::Deserialize;

/// What a time column counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TimeUnit {
    /// Seconds, from any origin.
    S,
    /// Milliseconds.
    Ms,
    /// Microseconds.
    Us,
    /// Nanoseconds.
    Ns,
    /// Date and time as text, `2020-07-31T13:04:24.5+09:00`; without a zone UTC is meant.
    Iso8601,
}

impl TimeUnit {
    /// Seconds in one unit; none where time is text.
    pub fn seconds(self) -> Option<f64> {
        match self {
            Self::S => Some(1.0),
            Self::Ms => Some(1e-3),
            Self::Us => Some(1e-6),
            Self::Ns => Some(1e-9),
            Self::Iso8601 => None,
        }
    }

    /// Seconds since 1970-01-01 UTC of a date and time in ISO 8601; UTC where it names no zone.
    pub fn of_text(text: &str) -> Option<f64> {
        let text = text.trim();
        let in_utc =
            || text.parse::<DateTime>().ok()?.to_zoned(TimeZone::UTC).ok().map(|time| time.timestamp());
        let has_time = text.get(10..).is_some_and(|rest| rest.starts_with(['T', 't', ' ']));
        let time = has_time.then(|| text.parse::<Timestamp>().ok().or_else(in_utc))??;
        Some(time.as_duration().as_secs_f64())
    }
}

/// What to do with rows whose time is before that of an earlier row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NonMonotonic {
    /// Refuse the file.
    #[default]
    Refuse,
    /// Put the rows in the order of time.
    Sort,
    /// Leave them out.
    Drop,
}

/// The rows of a file in the order of time, each time once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Order {
    /// Rows that stay, in order.
    pub rows: Vec<usize>,
    /// Rows left out because an earlier row has the same time.
    pub repeated: usize,
    /// Rows that stood after a later time.
    pub backwards: usize,
}

/// Time goes backwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Backwards {
    /// The row whose time is too early.
    pub row: usize,
    /// Its time \[s\].
    pub time: f64,
    /// The latest time before it \[s\].
    pub latest: f64,
}

/// Orders rows by their `times` (finite, \[s\]).
///
/// # Errors
/// The first row that is earlier than a row before it, where `policy` refuses that.
pub fn order(times: &[f64], policy: NonMonotonic) -> Result<Order, Backwards> {
    let mut out = Order { rows: Vec::with_capacity(times.len()), repeated: 0, backwards: 0 };
    let mut latest = f64::NEG_INFINITY;
    for (row, &time) in times.iter().enumerate() {
        if time < latest {
            if policy == NonMonotonic::Refuse {
                return Err(Backwards { row, time, latest });
            }
            out.backwards += 1;
        }
        if time > latest || policy == NonMonotonic::Sort {
            out.rows.push(row);
        } else if time == latest {
            out.repeated += 1;
        }
        latest = latest.max(time);
    }
    if policy == NonMonotonic::Sort {
        out.rows.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
        let before = out.rows.len();
        out.rows.dedup_by(|later, earlier| times[*later] == times[*earlier]);
        out.repeated = before - out.rows.len();
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_read_as_the_calendar_says() {
        for (text, expected) in [
            ("1970-01-01T00:00:00Z", 0.0),
            ("2020-07-31T13:04:24.5Z", 1_596_200_664.5),
            ("2020-07-31 13:04:24,5", 1_596_200_664.5),
            ("2020-07-31T22:04:24.5+09:00", 1_596_200_664.5),
            ("2020-07-31T09:34:24.5-0330", 1_596_200_664.5),
            ("2000-02-29T12:00", 951_825_600.0),
            ("1969-12-31T23:59:59Z", -1.0),
        ] {
            assert_eq!(TimeUnit::of_text(text), Some(expected), "{text}");
        }
        for text in
            ["", "2020-07-31", "2021-02-29T00:00Z", "2020-13-01T00:00Z", "31.07.2020 13:04", "12.5", "é"]
        {
            assert_eq!(TimeUnit::of_text(text), None, "{text}");
        }
    }

    #[test]
    fn repeated_and_early_rows_are_counted() {
        let times = [0.0, 1.0, 1.0, 3.0, 2.0, 3.0, 4.0];
        let error = order(&times, NonMonotonic::Refuse).unwrap_err();
        assert_eq!(error, Backwards { row: 4, time: 2.0, latest: 3.0 });
        let dropped = order(&times, NonMonotonic::Drop).unwrap();
        assert_eq!(dropped, Order { rows: vec![0, 1, 3, 6], repeated: 2, backwards: 1 });
        let sorted = order(&times, NonMonotonic::Sort).unwrap();
        assert_eq!(sorted, Order { rows: vec![0, 1, 4, 3, 6], repeated: 2, backwards: 1 });
    }
}
