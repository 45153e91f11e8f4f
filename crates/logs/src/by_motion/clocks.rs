//! Which columns may be the clock, and what it counts.

use super::table::{LoggedTable, correlation};
use crate::TimeUnit;

/// Share of steps that may go back.
const BACK: f64 = 0.002;
/// How far the progress of a clock may be off that of the rows, as a part of the whole.
const UNEVEN: f64 = 0.02;
/// Time between rows, and of all of a recording \[s\].
const STEP_S: [f64; 2] = [0.004, 12.0];
const LENGTH_S: [f64; 2] = [5.0, 3e5];
/// What correlates so with the rows is a time, a distance or a counter.
const WITH_TIME: f64 = 0.97;

/// A column that may be the clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockChoice {
    /// The column.
    pub column: usize,
    /// What it may count.
    pub unit: TimeUnit,
    /// Whether it may only count rows.
    pub is_counter: bool,
}

/// The columns that progress as the rows do, in each unit in which they may be a time, the most even first, those that count
/// rows last.
pub fn clocks(table: &LoggedTable) -> Vec<ClockChoice> {
    let mut all = Vec::new();
    for column in (0..table.columns.len()).filter(|at| table.moves(*at)) {
        let Some(unevenness) = unevenness(table, column) else { continue };
        for unit in [TimeUnit::S, TimeUnit::Ms, TimeUnit::Us, TimeUnit::Ns] {
            if let Some(is_counter) = counts(table, column, unit) {
                all.push((unevenness, ClockChoice { column, unit, is_counter }));
            }
        }
    }
    all.sort_by(|(a, entry), (b, other)| entry.is_counter.cmp(&other.is_counter).then(a.total_cmp(b)));
    all.into_iter().map(|(_, clock)| clock).collect()
}

/// How far the progress of a column is off that of the rows; `None` where it does not rise as they do.
fn unevenness(table: &LoggedTable, at: usize) -> Option<f64> {
    let of = |rows: &std::ops::Range<usize>| {
        let entry = &table.columns[at][rows.clone()];
        let back = entry.windows(2).filter(|pair| pair[1] < pair[0]).count() as f64;
        let (first, whole, last) = (entry[0], entry[entry.len() - 1] - entry[0], (entry.len() - 1) as f64);
        let off = |(row, value): (usize, &f64)| ((value - first) / whole - row as f64 / last).abs();
        let most = entry.iter().enumerate().map(off).fold(0.0, f64::max);
        (whole > 0.0 && back <= BACK * last && most < UNEVEN).then_some(most)
    };
    table.recordings.iter().map(of).try_fold(0.0, |most: f64, entry| Some(most.max(entry?)))
}

/// Whether times are possible ones in `unit`, and then whether they are as the numbers of rows.
fn counts(table: &LoggedTable, at: usize, unit: TimeUnit) -> Option<bool> {
    let (values, size) = (&table.columns[at], unit.seconds()?);
    let mut is_counter = unit == TimeUnit::S;
    for (rows, every) in table.recordings.iter().zip(&table.every) {
        let entry = &values[rows.clone()];
        let whole = size * (entry[entry.len() - 1] - entry[0]);
        let step = whole / ((entry.len() - 1) * every) as f64;
        let is_within = |value: f64, [low, high]: [f64; 2]| (low..=high).contains(&value);
        if !is_within(step, STEP_S) || !is_within(whole, LENGTH_S) {
            return None;
        }
        is_counter &= entry.windows(2).all(|pair| pair[1] - pair[0] == *every as f64);
    }
    Some(is_counter)
}

/// Whether a column is a time, a distance or a counter.
pub(super) fn goes_with_time(table: &LoggedTable, at: usize) -> bool {
    let rows: Vec<f64> =
        table.recordings.iter().flat_map(|rows| (0..rows.len()).map(|row| row as f64)).collect();
    let alone = |entry: &std::ops::Range<usize>| {
        correlation(&table.columns[at][entry.clone()], &rows[entry.clone()]).abs() > WITH_TIME
    };
    correlation(&table.columns[at], &rows).abs() > WITH_TIME || table.recordings.iter().all(alone)
}
