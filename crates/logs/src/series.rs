use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

use numerics::statistics::streamed_median;

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
        streamed_median(|| steps(self.t.iter())).map(|step| 1.0 / step)
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

/// Removes jumps of more than half a turn between neighbours \[rad\].
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwrapping {
    last: Option<f64>,
    turns: f64,
}

impl Unwrapping {
    /// The next angle, without a jump from the previous one.
    pub fn next(&mut self, angle: f64) -> f64 {
        if let Some(last) = self.last {
            let step = angle + self.turns - last;
            self.turns -= TAU * (step / TAU).round();
        }
        // The first angle is passed on bit for bit.
        let unwrapped = if self.last.is_some() { angle + self.turns } else { angle };
        self.last = Some(unwrapped);
        unwrapped
    }
}

/// Number of samples, odd and at least 3, that span about `window_s` at `rate_hz`.
pub fn window_samples(window_s: f64, rate_hz: f64) -> usize {
    2 * ((0.5 * window_s * rate_hz).round() as usize).max(1) + 1
}

/// Fits a parabola by least squares to the `window` samples around each sample of a section; passes the fit's value and
/// slope there to `each`, in order (in the unit of `values` and per second). At the ends the first and the last whole window
/// is evaluated off its centre. With equal steps this is the filter of Savitzky & Golay (Analytical Chemistry 36, 1964).
///
/// `t` increases \[s\]. Nothing is passed for fewer than three samples, or a shorter window.
pub fn local_quadratic(
    t: &Samples,
    values: &Samples,
    section: Range<usize>,
    window: usize,
    mut each: impl FnMut(f64, f64),
) {
    let window = window.min(section.len());
    if window < 3 {
        return;
    }
    let (mut times, mut seen) = (View::new(t), View::new(values));
    let mut at = |i: usize, each: &mut dyn FnMut(f64, f64)| {
        let first = (section.start + i.saturating_sub(window / 2)).min(section.end - window);
        let places = first..first + window;
        let time = times.at(section.start + i);
        let (value, slope) = fit_at(times.slice(places.clone()), seen.slice(places), time);
        each(value, slope);
    };
    let Some(step) = equal_step(t, &section) else {
        return (0..section.len()).for_each(|i| at(i, &mut each));
    };
    (0..window / 2).for_each(|i| at(i, &mut each));
    filter(values, &section, &weights(window, step), &mut each);
    (section.len() - (window - 1) / 2..section.len()).for_each(|i| at(i, &mut each));
}

/// Steps that differ by less than this share of a step are equal.
const EQUAL: f64 = 1e-4;

/// The step of a section whose steps are all equal.
fn equal_step(t: &Samples, section: &Range<usize>) -> Option<f64> {
    let [first, last] = [section.start, section.end - 1].map(|end| t.range(end..end + 1).next());
    let step = (last? - first?) / (section.len() - 1) as f64;
    steps(t.range(section.clone())).all(|length| (length - step).abs() < EQUAL * step).then_some(step)
}

/// Weights that give value and slope at the centre of a window, from fits to its unit vectors.
fn weights(window: usize, step: f64) -> (Vec<f64>, Vec<f64>) {
    let place = |j: usize| (j as f64 - (window / 2) as f64) * step;
    let places: Vec<f64> = (0..window).map(place).collect();
    let mut single = vec![0.0; window];
    let weight = |j| {
        single.fill(0.0);
        single[j] = 1.0;
        fit_at(&places, &single, 0.0)
    };
    (0..window).map(weight).unzip()
}

/// Passes value and slope at the centre of every whole window of a section to `each`: with equal steps the
/// weights are the same everywhere.
fn filter(
    values: &Samples,
    section: &Range<usize>,
    weights: &(Vec<f64>, Vec<f64>),
    each: &mut dyn FnMut(f64, f64),
) {
    const AT_A_TIME: usize = 1 << 14;
    let (mut seen, more) = (View::new(values), weights.0.len() - 1);
    // Large offsets would cost digits: the first value is subtracted and, for the values, added back.
    let offset = seen.at(section.start);
    let (mut moved, mut smooth, mut slope) = (Vec::new(), Vec::new(), Vec::new());
    for first in (section.start..section.end - more).step_by(AT_A_TIME) {
        let end = (first + AT_A_TIME).min(section.end - more);
        moved.clear();
        moved.extend(seen.slice(first..end + more).iter().map(|value| value - offset));
        smooth.clear();
        slope.clear();
        append_weighted(&moved, &weights.0, &mut smooth, offset);
        append_weighted(&moved, &weights.1, &mut slope, 0.0);
        smooth.iter().zip(&slope).for_each(|(value, slope)| each(*value, *slope));
    }
}

/// Appends offset + Σ_j weights\[j\] values\[i + j\] for every i for which they are there.
fn append_weighted(values: &[f64], weights: &[f64], out: &mut Vec<f64>, offset: f64) {
    const BLOCK: usize = 1024;
    let (before, count) = (out.len(), values.len() + 1 - weights.len());
    out.resize(before + count, offset);
    for (block, first) in out[before..].chunks_mut(BLOCK).zip((0..).step_by(BLOCK)) {
        for (weight, shifted) in weights.iter().zip(values[first..].windows(block.len())) {
            block.iter_mut().zip(shifted).for_each(|(sum, value)| *sum += weight * value);
        }
    }
}

/// Value and slope at `time` of the parabola through `values` at `t`. Times are centred and scaled, so that the normal
/// equations are well conditioned; by discrete orthogonal polynomials, hence no matrix.
fn fit_at(t: &[f64], values: &[f64], time: f64) -> (f64, f64) {
    let n = t.len() as f64;
    let scale = 0.5 * (t[t.len() - 1] - t[0]);
    let centre = t.iter().sum::<f64>() / n;
    let z = |t: f64| (t - centre) / scale;
    let (mut s2, mut s3, mut mean) = (0.0, 0.0, 0.0);
    for (t, y) in t.iter().zip(values) {
        let z = z(*t);
        s2 += z * z;
        s3 += z * z * z;
        mean += y / n;
    }
    // p1 = z, p2 = z² − (s3/s2) z − s2/n, orthogonal on the samples because Σ z = 0.
    let (a, b) = (s3 / s2, s2 / n);
    let p2 = |z: f64| z * z - a * z - b;
    let (mut c1, mut c2, mut norm) = (0.0, 0.0, 0.0);
    for (t, y) in t.iter().zip(values) {
        let (z, y) = (z(*t), y - mean);
        c1 += z * y;
        c2 += p2(z) * y;
        norm += p2(z) * p2(z);
    }
    let (c1, c2) = (c1 / s2, c2 / norm);
    let z = z(time);
    (mean + c1 * z + c2 * p2(z), (c1 + c2 * (2.0 * z - a)) / scale)
}

impl Series {
    /// [`local_quadratic`] over `window_s` in every section without gaps: values and slopes. Sections of
    /// fewer than three samples are left out.
    pub fn smoothed(&self, window_s: f64) -> (Self, Self) {
        let window = window_samples(window_s, self.rate_hz().unwrap_or(0.0));
        let mut sections = self.sections();
        sections.retain(|section| section.len() >= 3);
        // A channel without gaps is one section and keeps its clock.
        let whole = sections.iter().map(Range::len).sum::<usize>() == self.t.len();
        let of_sections = || self.t.made(sections.iter().flat_map(|section| self.t.range(section.clone())));
        let times = if whole { Arc::clone(&self.t) } else { Arc::new(of_sections()) };
        let [mut smooth, mut slope] = [self.values.none(), self.values.none()];
        for section in sections {
            local_quadratic(&self.t, &self.values, section, window, |value, rate| {
                smooth.push(value);
                slope.push(rate);
            });
        }
        let series = |values| Self { t: Arc::clone(&times), values, max_gap_s: self.max_gap_s };
        (series(smooth), series(slope))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_equal_steps_and_others_are_fitted_alike() {
        for (n, window) in [(3000, 11), (3000, 101), (30, 101), (7, 4), (3, 3)] {
            let t: Vec<f64> = (0..n).map(|i| 5.0 + 0.01 * f64::from(i)).collect();
            let y: Vec<f64> =
                t.iter().map(|t| 6e5 + libm::sin(3.0 * t) + 0.1 * libm::cos(170.0 * t)).collect();
            let whole = window.min(t.len());
            let (mut values, mut slopes) = (Vec::new(), Vec::new());
            let [times, seen] = [&t, &y].map(|of| Samples::from(of.as_slice()));
            local_quadratic(&times, &seen, 0..t.len(), window, |value, slope| {
                values.push(value);
                slopes.push(slope);
            });
            assert_eq!((values.len(), slopes.len()), (t.len(), t.len()));
            for i in 0..t.len() {
                let first = i.saturating_sub(whole / 2).min(t.len() - whole);
                let (value, slope) = fit_at(&t[first..first + whole], &y[first..first + whole], t[i]);
                approx::assert_relative_eq!(values[i], value, max_relative = 1e-14);
                approx::assert_abs_diff_eq!(slopes[i], slope, epsilon = 1e-6);
            }
        }
    }
}
