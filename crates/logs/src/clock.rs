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

    /// Seconds since 1970-01-01 UTC of a text in ISO 8601.
    pub fn of_text(text: &str) -> Option<f64> {
        let (date, rest) = text.trim().split_at_checked(10)?;
        let time = rest.strip_prefix(['T', 't', ' '])?;
        let (clock, zone_s) = split_zone(time)?;
        let date: Vec<&str> = date.split('-').collect();
        let [year, month, day] = date.as_slice() else { return None };
        let days = days_from_civil(digits(year)?, digits(month)?, digits(day)?)?;
        Some(days as f64 * 86_400.0 + clock_s(clock)? - zone_s)
    }
}

/// Splits `13:04:24.5+09:00` before the zone; the zone's offset \[s\].
fn split_zone(time: &str) -> Option<(&str, f64)> {
    if let Some(clock) = time.strip_suffix(['Z', 'z']) {
        return Some((clock, 0.0));
    }
    let Some(at) = time.rfind(['+', '-']) else { return Some((time, 0.0)) };
    let (clock, zone) = time.split_at(at);
    let number = zone[1..].replace(':', "");
    let (hours, minutes) = match number.len() {
        2 => (digits(&number)?, 0),
        4 => (digits(&number[..2])?, digits(&number[2..])?),
        _ => return None,
    };
    let offset = (hours * 3600 + minutes * 60) as f64;
    Some((clock, if zone.starts_with('-') { -offset } else { offset }))
}

fn clock_s(clock: &str) -> Option<f64> {
    let parts: Vec<&str> = clock.split(':').collect();
    let (hours, minutes, seconds) = match parts.as_slice() {
        [h, m] => (digits(h)?, digits(m)?, 0.0),
        [h, m, s] if s.starts_with(|c: char| c.is_ascii_digit()) => {
            (digits(h)?, digits(m)?, s.replace(',', ".").parse::<f64>().ok()?)
        }
        _ => return None,
    };
    let valid = (0..=24).contains(&hours) && (0..60).contains(&minutes) && (0.0..61.0).contains(&seconds);
    valid.then(|| (hours * 3600 + minutes * 60) as f64 + seconds)
}

fn digits(text: &str) -> Option<i64> {
    (text.len() <= 4 && text.bytes().all(|b| b.is_ascii_digit())).then(|| text.parse().ok())?
}

/// Days since 1970-01-01 in the proleptic Gregorian calendar.
fn days_from_civil(year: i64, month: i64, day: i64) -> Option<i64> {
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let february = if leap { 29 } else { 28 };
    let lengths = [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let month_index = usize::try_from(month - 1).ok()?;
    if !(1..=*lengths.get(month_index)?).contains(&day) || year < 1 {
        return None;
    }
    let before = year - 1;
    let to_year = before * 365 + before / 4 - before / 100 + before / 400;
    Some(to_year + lengths[..month_index].iter().sum::<i64>() + day - 1 - 719_162)
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
