//! The times of a table's rows.

use refusal::Invalid;
use ship::engine::refuse_endless;

/// Tolerance, as a fraction of a step, for differences between steps and between stamps and samples: stamps
/// are rounded.
const ROUNDED: f64 = 0.1;

/// The time of every row of a table, evenly spaced.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stamps {
    /// From the first row on \[s\].
    seconds: Vec<f64>,
    /// Their lines in the file.
    lines: Vec<u64>,
}

impl Stamps {
    /// Stamps with their lines.
    ///
    /// # Errors
    /// Stamps that repeat, go back or are not evenly spaced: names the first of them.
    pub(super) fn new(stamps: &[(u64, f64)]) -> Result<Self, Invalid> {
        let steps = || stamps.windows(2).map(|pair| (pair[1].0, pair[1].1 - pair[0].1));
        let mut sorted: Vec<f64> = steps().map(|(_, step)| step).collect();
        sorted.sort_by(f64::total_cmp);
        let usual = sorted.get(sorted.len() / 2).copied().unwrap_or(1.0);
        for (line, step) in steps() {
            if step <= 0.0 {
                let found = if step == 0.0 { "the time of the row before".to_owned() } else { back(step) };
                return Err(refused(line, found, "later times row by row", "correct or remove the row"));
            }
            if (step - usual).abs() > ROUNDED * usual {
                let (found, expected) =
                    (format!("{step} s after the row before"), format!("{usual} s, as mostly"));
                return Err(refused(
                    line,
                    found,
                    &expected,
                    "add the rows that are missing, or correct the times",
                ));
            }
        }
        let first = stamps.first().map_or(0.0, |(_, t)| *t);
        Ok(Self {
            seconds: stamps.iter().map(|(_, t)| t - first).collect(),
            lines: stamps.iter().map(|(line, _)| *line).collect(),
        })
    }

    /// Rows per second; `None` for a single row.
    pub(super) fn rate_hz(&self) -> Option<f64> {
        let last = self.seconds.last().filter(|last| **last > 0.0)?;
        Some((self.seconds.len() - 1) as f64 / last)
    }

    /// Refuses rows that are not the samples of `rate_hz`.
    pub(super) fn check_rate(&self, rate_hz: f64) -> Result<(), Invalid> {
        let off = |(k, t): &(usize, &f64)| (*t * rate_hz - *k as f64).abs() > ROUNDED;
        let Some((k, t)) = self.seconds.iter().enumerate().find(off) else { return Ok(()) };
        let expected = format!("{} s, a row per sample of the vessel's {rate_hz} Hz", k as f64 / rate_hz);
        let found = format!("{t} s after the first row");
        Err(refused(
            self.lines[k],
            found,
            &expected,
            "add `resample = true` to the maneuver, or correct the times",
        ))
    }

    /// `rows` (N × `width`) linearly interpolated at samples of `rate_hz` from the first time to the last.
    ///
    /// # Errors
    /// An unbounded number of samples.
    pub(super) fn resampled(&self, rows: &[f64], width: usize, rate_hz: f64) -> Result<Vec<f64>, Invalid> {
        let last = self.seconds.last().copied().unwrap_or(0.0);
        // The number of samples may be slightly below an integer in binary fractions.
        let samples = (last * rate_hz + 1e-6).floor() as usize + 1;
        refuse_endless("column `t`", samples)?;
        let mut after = 0;
        let sample = |k: usize| {
            let t = (k as f64 / rate_hz).min(last);
            while after + 1 < self.seconds.len() && self.seconds[after] < t {
                after += 1;
            }
            let before = after.saturating_sub(1);
            let step = self.seconds[after] - self.seconds[before];
            let share = if step > 0.0 { (t - self.seconds[before]) / step } else { 1.0 };
            let [from, to] = [before, after].map(|row| &rows[row * width..(row + 1) * width]);
            from.iter()
                .zip(to)
                .map(|(a, b)| if share == 1.0 { *b } else { a + share * (b - a) })
                .collect::<Vec<_>>()
        };
        Ok((0..samples).flat_map(sample).collect())
    }
}

fn back(step: f64) -> String {
    format!("{} s before the row before", -step)
}

fn refused(line: u64, found: String, expected: &str, remedy: &str) -> Invalid {
    Invalid::new(format!("line {line}, column `t`"), found, expected, remedy)
}
