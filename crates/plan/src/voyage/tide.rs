//! Level and stream of the tide during a trial.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A row of a tide table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TideRow {
    /// Seconds since 1970, UTC.
    pub at_s: f64,
    /// Height of the water over the chart's datum \[m\].
    pub level_m: f64,
    /// North and east components of the stream \[m/s\].
    pub stream_m_s: [f64; 2],
}

/// What the tide is at worst from the departure until the trial has to be over.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tide {
    /// When the trial has to be over, after its departure \[s\].
    pub slot_s: f64,
    /// Least height of the water over the chart's datum \[m\]: charted depths count with it.
    pub level_m: f64,
    /// Middle of the stream, north and east \[m/s\]: it joins the known current.
    pub stream_m_s: [f64; 2],
    /// Farthest that the stream is from its middle \[m/s\]: it joins the unknown current.
    pub spread_m_s: f64,
}

/// North and east of a current of `speed_m_s` towards a compass direction \[m/s\].
pub fn current_m_s(speed_m_s: f64, towards_deg: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(towards_deg.to_radians());
    [speed_m_s * cos, speed_m_s * sin]
}

impl Tide {
    /// The worst case of a table of ascending times, interpolated linearly, over `slot_s` from `departure_s`.
    /// `None` where the table does not cover it.
    pub fn worst(table: &[TideRow], departure_s: f64, slot_s: f64) -> Option<Self> {
        let ends = [departure_s, departure_s + slot_s];
        let within = table.iter().filter(|row| ends[0] < row.at_s && row.at_s < ends[1]).copied();
        let rows: Vec<TideRow> =
            [at(table, ends[0])?, at(table, ends[1])?].into_iter().chain(within).collect();
        let level_m = rows.iter().map(|row| row.level_m).fold(f64::INFINITY, f64::min);
        let stream_m_s = [0, 1].map(|c: usize| {
            let of = rows.iter().map(|row| row.stream_m_s[c]);
            0.5 * (of.clone().fold(f64::INFINITY, f64::min) + of.fold(f64::NEG_INFINITY, f64::max))
        });
        let off =
            |row: &TideRow| libm::hypot(row.stream_m_s[0] - stream_m_s[0], row.stream_m_s[1] - stream_m_s[1]);
        Some(Self { slot_s, level_m, stream_m_s, spread_m_s: rows.iter().map(off).fold(0.0, f64::max) })
    }
}

/// The table interpolated at a time within it.
fn at(table: &[TideRow], at_s: f64) -> Option<TideRow> {
    let later = table.iter().position(|row| row.at_s >= at_s)?;
    let after = table[later];
    if after.at_s == at_s {
        return Some(after);
    }
    let before = table[later.checked_sub(1)?];
    let part = (at_s - before.at_s) / (after.at_s - before.at_s);
    let between = |a: f64, b: f64| a + part * (b - a);
    Some(TideRow {
        at_s,
        level_m: between(before.level_m, after.level_m),
        stream_m_s: [0, 1].map(|c: usize| between(before.stream_m_s[c], after.stream_m_s[c])),
    })
}
