use std::ops::Range;

use crate::samples::{Samples, Values};

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
    pub fn times(&self) -> impl Iterator<Item = f64> + use<> {
        let Self { start_s, rate_hz, rows } = *self;
        (0..rows).map(move |k| start_s + k as f64 / rate_hz)
    }

    /// The rows from `from_s` to `to_s`, both included, as first row and one past the last.
    pub fn rows_within(&self, from_s: f64, to_s: f64) -> Range<usize> {
        let place = |time: f64| (time - self.start_s) * self.rate_hz;
        let first = (place(from_s) - Self::SLACK).ceil().max(0.0) as usize;
        let end = ((place(to_s) + Self::SLACK).floor() + 1.0).max(0.0) as usize;
        first..end.min(self.rows).max(first)
    }
}

/// A gap-free section of rows that can be one run: N samples with inputs, and the state after the last of
/// them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// First row.
    pub start: usize,
    /// Number of samples N; rows `start..=start + samples`.
    pub samples: usize,
}

/// The longest sections of at least one sample in which every state (`measured`) and every input
/// (`exogenous`) is known; after the last sample only the states. Channels have equally many rows, NaN where
/// unknown.
pub fn sections(measured: &[Samples; 3], exogenous: &[Samples]) -> Vec<Section> {
    let (mut states, mut inputs) = (all(measured), all(exogenous));
    let (mut out, mut start) = (Vec::new(), None);
    for row in 0..=measured[0].len() {
        let known = [&mut states, &mut inputs].map(|channels| next_known(channels));
        let inside = row < measured[0].len();
        match start {
            None if inside && known == [true; 2] => start = Some(row),
            Some(first) if !inside || known != [true; 2] => {
                let last = if inside && known[0] { row } else { row - 1 };
                if last > first {
                    out.push(Section { start: first, samples: last - first });
                }
                start = None;
            }
            _ => {}
        }
    }
    out
}

/// Rows up to the last at which all `channels` are known.
pub(crate) fn known_rows(channels: &[Samples; 3]) -> usize {
    let mut values = all(channels);
    (0..channels[0].len()).filter(|_| next_known(&mut values)).last().map_or(0, |row| row + 1)
}

fn all(channels: &[Samples]) -> Vec<Values<'_>> {
    channels.iter().map(Samples::iter).collect()
}

/// Whether the next values of all `channels` are known. Every iterator advances.
fn next_known(channels: &mut [Values]) -> bool {
    channels.iter_mut().fold(true, |known, values| known & values.next().is_some_and(f64::is_finite))
}
