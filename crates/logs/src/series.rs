use std::ops::Range;
use std::sync::Arc;

use numerics::statistics::streamed_median as median_again;

use crate::Unwrapping;
use crate::samples::{Samples, View, steps};

/// Times that differ by less are the same \[s\]: the resolution of a time since 1970 in 64 bits.
const SAME_TIME_S: f64 = 1e-6;

/// One channel on its own clock. Times increase; values are finite.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Times \[s\]: channels of one file share them.
    pub t: Arc<Samples>,
    /// Values, one per time.
    pub values: Samples,
    /// Between samples that are further apart the channel is unknown \[s\].
    pub max_gap_s: f64,
}

impl Series {
    /// Leaves out the values that are missing (not finite). `t` increases.
    pub fn new(t: &[f64], values: &[f64], max_gap_s: f64) -> Self {
        Self::shared(&Arc::new(t.into()), values.into(), max_gap_s)
    }

    /// [`Series::new`] of times that other channels may have too.
    pub fn shared(t: &Arc<Samples>, values: Samples, max_gap_s: f64) -> Self {
        if values.iter().all(f64::is_finite) {
            return Self { t: Arc::clone(t), values, max_gap_s };
        }
        let known = || t.iter().zip(values.iter()).filter(|(_, value)| value.is_finite());
        let times = values.made(known().map(|(time, _)| time));
        let values = values.made(known().map(|(_, value)| value));
        Self { t: Arc::new(times), values, max_gap_s }
    }

    /// The same clock with other values; missing ones (not finite) are left out.
    pub fn with(&self, values: Samples) -> Self {
        Self::shared(&self.t, values, self.max_gap_s)
    }

    /// Applies `f` to every value.
    pub fn map(mut self, f: impl FnMut(f64) -> f64) -> Self {
        self.values = self.values.made(self.values.iter().map(f));
        self
    }

    /// Without jumps of more than half a turn \[rad\].
    pub fn unwrapped(self) -> Self {
        let mut unwrapping = Unwrapping::default();
        self.map(|angle| unwrapping.next(angle))
    }

    /// Samples per second: the inverse of the median step. None for fewer than two samples.
    pub fn rate_hz(&self) -> Option<f64> {
        median_again(|| steps(self.t.iter())).map(|step| 1.0 / step)
    }

    /// The sections of samples without a gap between neighbours.
    pub fn sections(&self) -> Vec<Range<usize>> {
        let mut sections: Vec<Range<usize>> = Vec::new();
        let mut before = f64::NAN;
        for (i, time) in self.t.iter().enumerate() {
            match sections.last_mut() {
                Some(section) if !self.is_gap(before, time) => section.end = i + 1,
                _ => sections.push(i..i + 1),
            }
            before = time;
        }
        sections
    }

    /// Number of gaps.
    pub fn gaps(&self) -> usize {
        steps(self.t.iter()).filter(|step| self.is_long(*step)).count()
    }

    /// Whether there is a gap between two neighbouring times.
    fn is_gap(&self, before: f64, after: f64) -> bool {
        self.is_long(after - before)
    }

    fn is_long(&self, step: f64) -> bool {
        step > self.max_gap_s + SAME_TIME_S
    }

    /// Values at `times`, which increase, by linear interpolation; NaN before the first sample, after the last and in gaps.
    pub fn at(&self, times: impl IntoIterator<Item = f64>) -> impl Iterator<Item = f64> {
        let mut sampler = Sampler::new(self);
        times.into_iter().map(move |time| sampler.at(time))
    }

    /// Centred moving average over `width_s`: the mean of the samples no further away than half of it.
    /// Towards the ends of a section the width shrinks to what both sides have, so that nothing is delayed.
    pub fn averaged(&self, width_s: f64) -> Self {
        let mut averages = self.values.none();
        let (mut t, mut values) = (View::new(&self.t), View::new(&self.values));
        for section in self.sections() {
            let ends = [section.start, section.end - 1].map(|end| self.t.range(end..end + 1).next());
            let [Some(first), Some(last)] = ends else { continue };
            let (mut low, mut high) = (section.start, section.start);
            for time in self.t.range(section.clone()) {
                let half = (0.5 * width_s).min(time - first).min(last - time) + SAME_TIME_S;
                // Half widths shrink again towards the end, so the lower edge only moves forward from here.
                while t.at(low) < time - half {
                    low += 1;
                }
                while high < section.end && t.at(high) <= time + half {
                    high += 1;
                }
                averages.push(values.slice(low..high).iter().sum::<f64>() / (high - low) as f64);
            }
        }
        Self { t: Arc::clone(&self.t), values: averages, max_gap_s: self.max_gap_s }
    }
}

/// Finds values of a series at times that increase.
pub(crate) struct Sampler<'a> {
    series: &'a Series,
    t: View<'a>,
    values: View<'a>,
    /// The first sample that is not before the last time.
    next: usize,
    len: usize,
}

impl<'a> Sampler<'a> {
    pub(crate) fn new(series: &'a Series) -> Self {
        let (t, values) = (View::new(&series.t), View::new(&series.values));
        Self { series, t, values, next: 0, len: series.t.len() }
    }

    /// The value at `time`; see [`Series::at`].
    pub(crate) fn at(&mut self, time: f64) -> f64 {
        while self.next < self.len && self.t.at(self.next) < time - SAME_TIME_S {
            self.next += 1;
        }
        if self.next == self.len {
            return f64::NAN;
        }
        let after = self.t.at(self.next);
        if after - time <= SAME_TIME_S {
            return self.values.at(self.next);
        }
        if self.next == 0 {
            return f64::NAN;
        }
        let before = self.t.at(self.next - 1);
        if self.series.is_gap(before, after) {
            return f64::NAN;
        }
        let &[from, to] = self.values.slice(self.next - 1..self.next + 1) else { return f64::NAN };
        from + (to - from) * ((time - before) / (after - before))
    }
}
