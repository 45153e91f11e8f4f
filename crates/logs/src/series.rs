use std::ops::Range;
use std::sync::Arc;

use numerics::statistics::median;

use crate::unwrap;

/// Times that differ by less are the same \[s\]: what remains of a time since 1970 in 64 bits.
const SAME_TIME_S: f64 = 1e-6;

/// One channel on its own clock. Times increase; values are finite.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Times \[s\]: channels of one file share them.
    pub t: Arc<Vec<f64>>,
    /// Values, one per time.
    pub values: Vec<f64>,
    /// Between samples further apart than this the channel is unknown \[s\].
    pub max_gap_s: f64,
}

impl Series {
    /// Leaves out the values that are missing (not finite). `t` increases.
    pub fn new(t: &[f64], values: &[f64], max_gap_s: f64) -> Self {
        let (t, values): (Vec<f64>, _) = t.iter().zip(values).filter(|(_, v)| v.is_finite()).unzip();
        Self { t: Arc::new(t), values, max_gap_s }
    }

    /// [`Series::new`] of times that other channels may have too.
    pub fn shared(t: &Arc<Vec<f64>>, values: Vec<f64>, max_gap_s: f64) -> Self {
        match values.iter().all(|value| value.is_finite()) {
            true => Self { t: Arc::clone(t), values, max_gap_s },
            false => Self::new(t, &values, max_gap_s),
        }
    }

    /// The same clock with other values; missing ones (not finite) are left out.
    pub fn with(&self, values: Vec<f64>) -> Self {
        Self::shared(&self.t, values, self.max_gap_s)
    }

    /// Every value through `f`.
    pub fn map(mut self, f: impl Fn(f64) -> f64) -> Self {
        self.values.iter_mut().for_each(|value| *value = f(*value));
        self
    }

    /// Without jumps of more than half a turn \[rad\].
    pub fn unwrapped(mut self) -> Self {
        unwrap(&mut self.values);
        self
    }

    /// Samples per second: the inverse of the median step. None for fewer than two samples.
    pub fn rate_hz(&self) -> Option<f64> {
        median(self.t.windows(2).map(|pair| pair[1] - pair[0]).collect()).map(|step| 1.0 / step)
    }

    /// The stretches of samples without a gap between neighbours.
    pub fn pieces(&self) -> Vec<Range<usize>> {
        let mut pieces: Vec<Range<usize>> = Vec::new();
        for i in 0..self.t.len() {
            match pieces.last_mut() {
                Some(piece) if !self.is_gap(i - 1) => piece.end = i + 1,
                _ => pieces.push(i..i + 1),
            }
        }
        pieces
    }

    /// Number of gaps.
    pub fn gaps(&self) -> usize {
        self.pieces().len().saturating_sub(1)
    }

    /// Whether there is a gap after sample `i`.
    fn is_gap(&self, i: usize) -> bool {
        self.t[i + 1] - self.t[i] > self.max_gap_s + SAME_TIME_S
    }

    /// Values at `times`, which increase, by linear interpolation; NaN before the first sample, after the last and in gaps.
    pub fn at(&self, times: &[f64]) -> Vec<f64> {
        let mut next = 0;
        times
            .iter()
            .map(|&time| {
                while next < self.t.len() && self.t[next] < time - SAME_TIME_S {
                    next += 1;
                }
                self.between(next, time)
            })
            .collect()
    }

    /// The value at `time`, where `next` is the first sample that is not before it.
    fn between(&self, next: usize, time: f64) -> f64 {
        let Some(&after) = self.t.get(next) else { return f64::NAN };
        if after - time <= SAME_TIME_S {
            return self.values[next];
        }
        if next == 0 || self.is_gap(next - 1) {
            return f64::NAN;
        }
        let (before, from, to) = (self.t[next - 1], self.values[next - 1], self.values[next]);
        from + (to - from) * ((time - before) / (after - before))
    }

    /// Centred moving average over `width_s`: the mean of the samples no further away than half of it. Towards the ends of
    /// a piece the width shrinks to what is there on both sides, so that nothing is delayed.
    pub fn averaged(&self, width_s: f64) -> Self {
        let mut values = Vec::with_capacity(self.values.len());
        for piece in self.pieces() {
            let (first, last) = (self.t[piece.start], self.t[piece.end - 1]);
            let (mut low, mut high) = (piece.start, piece.start);
            for i in piece.clone() {
                let time = self.t[i];
                let half = (0.5 * width_s).min(time - first).min(last - time) + SAME_TIME_S;
                // Half widths shrink again towards the end, so the lower edge may only be searched onwards from here.
                while self.t[low] < time - half {
                    low += 1;
                }
                while high < piece.end && self.t[high] <= time + half {
                    high += 1;
                }
                values.push(self.values[low..high].iter().sum::<f64>() / (high - low) as f64);
            }
        }
        Self { t: Arc::clone(&self.t), values, max_gap_s: self.max_gap_s }
    }
}
