//! A logged position of a ship, and lists of them in the order of time.

use std::collections::BTreeMap;

use refusal::Invalid;

use crate::LogError;

/// Most positions of a file: ten a second for a day.
const MOST: usize = 864_000;

/// A ship is elsewhere so long after her last position \[s\].
const STALE_S: f64 = 10.0;

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
    /// Inputs that were logged, by name: times, counted as those of positions, and values in the units of the vessel.
    pub inputs: BTreeMap<String, Vec<[f64; 2]>>,
    /// How many positions without a fix, or at 0 N 0 E, were left out.
    pub left_out: usize,
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

/// Positions without those at 0 N 0 E, of a log that ends at a time and has so many positions without a fix. Refuses one without
/// positions, and one that goes on without them; `expected` is what it should hold.
pub(crate) fn checked(
    since: Since,
    mut rows: Vec<LoggedPosition>,
    (ends_s, unfixed): (f64, usize),
    expected: &str,
) -> Result<LoggedPositions, LogError> {
    let (all, ends_s) = (rows.len(), rows.last().map_or(ends_s, |last| last.at_s.max(ends_s)));
    rows.retain(|own| [own.longitude_deg, own.latitude_deg] != [0.0; 2]);
    let Some(last) = rows.last() else {
        let remedy = "export the positions since the departure";
        let found = if all == 0 { "none" } else { "none but 0 N 0 E, which stands for no fix" };
        return Err(Invalid::new("positions", found, expected, remedy).into());
    };
    let stale_s = ends_s - last.at_s;
    if stale_s > STALE_S {
        let found = format!("the last fix, {stale_s:.0} s before the end of the log");
        let expected = format!("one in its last {STALE_S} s: she is elsewhere now");
        let remedy =
            "give a log that ends with a fix, or say where she is with `plan resume --done STEPS --from`";
        return Err(Invalid::new(format!("line {}", last.line), found, expected, remedy).into());
    }
    let left_out = all - rows.len() + unfixed;
    Ok(LoggedPositions { since, rows, inputs: BTreeMap::new(), left_out })
}
