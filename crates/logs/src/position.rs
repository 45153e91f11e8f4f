//! A logged position of a ship, and lists of them in the order of time.

use refusal::Invalid;

use crate::LogError;

/// Most positions of a file: ten a second for a day.
const MOST: usize = 864_000;

/// A position of the ship.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoggedPosition {
    /// The line that it stands on, from 1.
    pub line: usize,
    /// When she was there, since [`LoggedPositions::since`] \[s\].
    pub at_s: f64,
    /// Longitude, from −180 to 180 \[deg\].
    pub longitude_deg: f64,
    /// Latitude \[deg\].
    pub latitude_deg: f64,
    /// True heading, where it was logged \[deg\].
    pub heading_deg: Option<f64>,
    /// Speed over the ground, where it was logged \[m/s\].
    pub speed_m_s: Option<f64>,
}

/// What times count from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Since {
    /// 1970, UTC.
    Epoch,
    /// The departure of the trial.
    Departure,
}

/// The positions of a file, whose times ascend.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedPositions {
    /// What their times count from.
    pub since: Since,
    /// In the order of time, at least one.
    pub rows: Vec<LoggedPosition>,
}

/// Appends a position to `rows`.
///
/// # Errors
/// One that is not later than the last; too many.
pub(crate) fn push(rows: &mut Vec<LoggedPosition>, next: LoggedPosition) -> Result<(), Invalid> {
    let line = format!("line {}", next.line);
    if rows.len() == MOST {
        let remedy = "thin them out: one a second is enough";
        return Err(Invalid::new(line, "one more position", format!("at most {MOST}"), remedy));
    }
    if let Some(last) = rows.last().filter(|last| next.at_s <= last.at_s) {
        let back_s = last.at_s - next.at_s;
        let found = match back_s {
            0.0 => format!("the time of line {}", last.line),
            _ => format!("a time {back_s:.3} s before that of line {}", last.line),
        };
        let remedy = "sort the positions, and keep one of each time";
        return Err(Invalid::new(format!("{line}, `time`"), found, "a later time", remedy));
    }
    rows.push(next);
    Ok(())
}

/// Refuses a file without positions; `expected` is what it should hold.
pub(crate) fn checked(
    since: Since,
    rows: Vec<LoggedPosition>,
    expected: &str,
) -> Result<LoggedPositions, LogError> {
    if rows.is_empty() {
        let remedy = "export the positions since the departure";
        return Err(Invalid::new("positions", "none", expected, remedy).into());
    }
    Ok(LoggedPositions { since, rows })
}
