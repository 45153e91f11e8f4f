use std::ops::Range;

/// The common clock of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Time of row 0 on the recording's clock \[s\].
    pub start_s: f64,
    /// Rows per second.
    pub rate_hz: f64,
    /// Number of rows.
    pub rows: usize,
}

impl Grid {
    /// Slack in units of a step for times that should fall on a row.
    const SLACK: f64 = 1e-4;

    /// Rows from `start_s` to no later than `end_s`.
    pub fn new(start_s: f64, end_s: f64, rate_hz: f64) -> Self {
        let steps = ((end_s - start_s) * rate_hz + Self::SLACK).floor();
        Self { start_s, rate_hz, rows: if steps >= 0.0 { steps as usize + 1 } else { 0 } }
    }

    /// Times of all rows \[s\].
    pub fn times(&self) -> Vec<f64> {
        (0..self.rows).map(|k| self.start_s + k as f64 / self.rate_hz).collect()
    }

    /// The rows from `from_s` to `to_s`, both included, as first row and one past the last.
    pub fn rows_within(&self, from_s: f64, to_s: f64) -> Range<usize> {
        let place = |time: f64| (time - self.start_s) * self.rate_hz;
        let first = (place(from_s) - Self::SLACK).ceil().max(0.0) as usize;
        let end = ((place(to_s) + Self::SLACK).floor() + 1.0).max(0.0) as usize;
        first..end.min(self.rows).max(first)
    }
}

/// Rows that can be one run: N samples with inputs, and the state after the last of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stretch {
    /// First row.
    pub start: usize,
    /// Number of samples N; rows `start..=start + samples`.
    pub samples: usize,
}

/// The longest stretches of at least one sample in which every state (`measured`) and every input (`exogenous`) is known;
/// after the last sample the states alone. Channels have equally many rows, NaN where unknown.
pub fn stretches(measured: &[Vec<f64>; 3], exogenous: &[Vec<f64>]) -> Vec<Stretch> {
    let rows = measured[0].len();
    let known = |channels: &[Vec<f64>], row: usize| channels.iter().all(|c| c[row].is_finite());
    let mut out = Vec::new();
    let mut start = 0;
    while start < rows {
        let whole = |row: &usize| known(measured, *row) && known(exogenous, *row);
        if !whole(&start) {
            start += 1;
            continue;
        }
        let end = (start..rows).find(|row| !whole(row)).unwrap_or(rows);
        let last = if end < rows && known(measured, end) { end } else { end - 1 };
        if last > start {
            out.push(Stretch { start, samples: last - start });
        }
        start = end;
    }
    out
}
