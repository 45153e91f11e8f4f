use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Samples;

/// What a time column counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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
    /// Date and time as text, `2020-07-31T13:04:24.5+09:00`; without an offset in the time's `zone`.
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

    /// Whether a text in ISO 8601 has a time of day, and not only a date.
    pub(crate) fn has_time(text: &str) -> bool {
        text.get(10..).is_some_and(|rest| rest.starts_with(['T', 't', ' ']))
    }
}

/// What to do with rows whose time is before that of an earlier row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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

/// What to do with rows that have the time of the row before, such as rows at 20 Hz with whole seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Repeated {
    /// Leave them out where they are few; refuse the file where they are more than a fifth.
    #[default]
    Refuse,
    /// Leave them out: the first row of each time stays.
    Drop,
    /// Spread the rows of each time evenly until the next.
    Spread,
}

/// The rows of a file in order of time, each time once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Order {
    /// The remaining rows, in order.
    pub rows: Vec<u32>,
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

/// Orders rows by their `times` (\[s\]) and leaves out rows without a time (not finite). Sorting holds all
/// times in memory.
///
/// # Errors
/// The first row that is earlier than a row before it, where `policy` refuses that.
pub fn order(times: &Samples, policy: NonMonotonic) -> Result<Order, Backwards> {
    let mut out = Order { rows: Vec::new(), repeated: 0, backwards: 0 };
    let mut latest = f64::NEG_INFINITY;
    for (row, time) in times.iter().enumerate().filter(|(_, time)| time.is_finite()) {
        if time < latest {
            if policy == NonMonotonic::Refuse {
                return Err(Backwards { row, time, latest });
            }
            out.backwards += 1;
        }
        if time > latest || policy == NonMonotonic::Sort {
            out.rows.push(row as u32);
        } else if time == latest {
            out.repeated += 1;
        }
        latest = latest.max(time);
    }
    if policy == NonMonotonic::Sort {
        let times = times.to_vec();
        let time = |row: u32| times[row as usize];
        out.rows.sort_by(|a, b| time(*a).total_cmp(&time(*b)));
        let before = out.rows.len();
        out.rows.dedup_by(|later, earlier| time(*later) == time(*earlier));
        out.repeated = before - out.rows.len();
    }
    Ok(out)
}
