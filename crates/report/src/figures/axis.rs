use crate::figures::svg::{Anchor, Lettering, Paint, Sheet};
use crate::figures::text;

/// A map from values to pixels along one direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    pub(crate) low: f64,
    pub(crate) high: f64,
    from: f64,
    to: f64,
    /// Half-width of the linear part of a symmetric logarithmic axis; absent on a linear one.
    linear_within: Option<f64>,
}

/// A value to mark on an axis, with its label.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tick {
    pub(crate) value: f64,
    pub(crate) label: String,
}

impl Axis {
    /// Maps `low` to pixel `from` and `high` to pixel `to`. An empty or infinite range is replaced by one that
    /// contains it.
    pub(crate) fn linear(low: f64, high: f64, from: f64, to: f64) -> Self {
        let (low, high) = usable(low, high);
        Self { low, high, from, to, linear_within: None }
    }

    /// Symmetric about zero from −`most` to `most`: linear within ±`linear`, logarithmic beyond.
    pub(crate) fn symmetric(most: f64, linear: f64, from: f64, to: f64) -> Self {
        let (low, high) = usable(-most.abs(), most.abs());
        Self { low, high, from, to, linear_within: Some(linear) }
    }

    /// Pixel of `value`.
    pub(crate) fn at(&self, value: f64) -> f64 {
        let (low, high) = (self.bent(self.low), self.bent(self.high));
        self.from + (self.bent(value) - low) / (high - low) * (self.to - self.from)
    }

    /// Pixel of `value`, kept inside the axis.
    pub(crate) fn inside(&self, value: f64) -> f64 {
        self.at(value.clamp(self.low, self.high))
    }

    /// Pixels of both ends.
    pub(crate) fn ends(&self) -> (f64, f64) {
        (self.from, self.to)
    }

    /// At least `wanted` round values inside the range, as few as steps of 1, 2 or 5 times a power of ten allow.
    pub(crate) fn ticks(&self, wanted: usize) -> Vec<Tick> {
        let finest = round_step((self.high - self.low) / (2 * wanted.max(1)) as f64);
        let steps = [4.0, 2.0, 1.0].map(|factor| round_step(factor * finest * 0.9));
        let choices = steps.map(|step| self.multiples(step));
        let enough = choices.iter().find(|ticks| ticks.len() >= wanted);
        enough.unwrap_or(&choices[2]).clone()
    }

    /// The multiples of `step` inside the range.
    fn multiples(&self, step: f64) -> Vec<Tick> {
        let first = (self.low / step - 1e-9).ceil();
        let count = ((self.high / step + 1e-9).floor() - first).max(0.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a handful")]
        let count = count.min(100.0) as usize;
        let values = (0..=count).map(|i| (first + i as f64) * step);
        values.filter(|value| *value <= self.high + 1e-9 * step).map(|value| tick(value, step)).collect()
    }

    fn bent(&self, value: f64) -> f64 {
        match self.linear_within {
            None => value,
            Some(linear) if value.abs() <= linear => value / linear,
            Some(linear) => value.signum() * (1.0 + libm::log10(value.abs() / linear)),
        }
    }
}

fn tick(value: f64, step: f64) -> Tick {
    Tick { value, label: text::number(value, step) }
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `least`.
pub(crate) fn round_step(least: f64) -> f64 {
    if !(least.is_finite() && least > 0.0) {
        return 1.0;
    }
    let power = libm::pow(10f64, libm::log10(least).floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * power >= least * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

/// Least and greatest finite value, if there is one.
pub(crate) fn extent(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    let finite = values.into_iter().filter(|v| v.is_finite());
    finite.fold(None, |range, v| match range {
        None => Some((v, v)),
        Some((low, high)) => Some((v.min(low), v.max(high))),
    })
}

fn usable(low: f64, high: f64) -> (f64, f64) {
    if !(low.is_finite() && high.is_finite()) {
        return (0.0, 1.0);
    }
    let least = 1e-12 * low.abs().max(high.abs()).max(1e-6);
    if high - low > least { (low, high) } else { (low - 0.5, low + 0.5) }
}

/// Width of a figure that stands alone on a phone and two abreast on a desk [px].
pub(crate) const COLUMN: f64 = 460.0;
/// Size of labels and titles of axes [px].
pub(crate) const LABEL: f64 = 13.0;
/// Size of ticks and notes [px].
pub(crate) const NOTE: f64 = 12.0;

pub(crate) const GRID: Paint = Paint::ink(0.13);
pub(crate) const BASE: Paint = Paint::ink(0.5);

/// Text of ticks and notes.
pub(crate) const fn note(anchor: Anchor) -> Lettering {
    Lettering::new(NOTE, anchor).painted(Paint::ink(0.7))
}

/// Left and right end of a plot of one column, and its top [px].
pub(crate) const PLOT: (f64, f64) = (62.0, COLUMN - 16.0);
pub(crate) const PLOT_TOP: f64 = 16.0;
/// Space below such a plot [px].
pub(crate) const PLOT_FOOT: f64 = 48.0;

/// Grid, ticks, axes and titles of a plot: the axis across, then the one upwards.
pub(crate) fn frame(sheet: &mut Sheet, across: (&Axis, &[Tick], &str), up: (&Axis, &[Tick], &str)) {
    let ((left, right), (bottom, top)) = (across.0.ends(), up.0.ends());
    for tick in across.1 {
        let x = across.0.at(tick.value);
        sheet.line((x, top), (x, bottom), (GRID, 1.0));
        sheet.text(&tick.label, (x, bottom + 13.0), note(Anchor::Middle));
    }
    for tick in up.1 {
        let y = up.0.at(tick.value);
        sheet.line((left, y), (right, y), (GRID, 1.0));
        sheet.text(&tick.label, (left - 8.0, y), note(Anchor::End));
    }
    sheet.line((left, bottom), (right, bottom), (BASE, 1.0));
    sheet.line((left, top), (left, bottom), (BASE, 1.0));
    let title = Lettering::new(LABEL, Anchor::Middle);
    sheet.text(across.2, ((left + right) / 2.0, bottom + 36.0), title);
    sheet.text(up.2, (14.0, (top + bottom) / 2.0), title.upwards());
}

/// Rows one below the other with names at the left and a common horizontal axis below.
pub(crate) struct NamedRows {
    names: Vec<String>,
    left: f64,
    right: f64,
    row: f64,
}

/// Pixel of the upper end of the first row.
pub(crate) const TOP: f64 = 26.0;
const FOOT: f64 = 46.0;
const LONGEST_NAME: usize = 26;

impl NamedRows {
    /// Rows `row` pixels high, of which the last `margin` pixels at the right stay free for notes.
    pub(crate) fn new<'a>(names: impl Iterator<Item = &'a str>, row: f64, margin: f64) -> Self {
        let names: Vec<String> = names.map(|name| text::shortened(name, LONGEST_NAME)).collect();
        let widest = names.iter().map(|name| text::width(name, LABEL)).fold(40.0, f64::max);
        Self { names, left: widest + 14.0, right: COLUMN - margin, row }
    }

    pub(crate) fn height(&self) -> f64 {
        self.bottom() + FOOT
    }

    /// Pixel of the centre of row `index`.
    pub(crate) fn middle(&self, index: usize) -> f64 {
        TOP + (index as f64 + 0.5) * self.row
    }

    pub(crate) fn bottom(&self) -> f64 {
        TOP + self.names.len() as f64 * self.row
    }

    /// Left and right pixel of the axis.
    pub(crate) fn span(&self) -> (f64, f64) {
        (self.left, self.right)
    }

    /// Names, grid and axis.
    pub(crate) fn draw(&self, sheet: &mut Sheet, axis: &Axis, ticks: &[Tick], title: &str) {
        for tick in ticks {
            let x = axis.at(tick.value);
            sheet.line((x, TOP), (x, self.bottom()), (GRID, 1.0));
            sheet.text(&tick.label, (x, self.bottom() + 12.0), note(Anchor::Middle));
        }
        for (index, name) in self.names.iter().enumerate() {
            let at = (self.left - 10.0, self.middle(index));
            sheet.text(name, at, Lettering::new(LABEL, Anchor::End));
        }
        let middle = (self.left + self.right) / 2.0;
        sheet.text(title, (middle, self.bottom() + 34.0), Lettering::new(LABEL, Anchor::Middle));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_the_ends_of_an_axis_map_to_its_pixels() {
        let axis = Axis::linear(-2.0, 3.0, 10.0, 110.0);
        assert!((axis.at(-2.0) - 10.0).abs() < 1e-12);
        assert!((axis.at(3.0) - 110.0).abs() < 1e-12);
        assert!((axis.inside(1e9) - 110.0).abs() < 1e-12);
    }

    #[test]
    fn a_symmetric_axis_is_continuous_and_odd() {
        let axis = Axis::symmetric(10.0, 0.1, 0.0, 100.0);
        assert!((axis.at(0.0) - 50.0).abs() < 1e-12);
        assert!((axis.at(0.1) - axis.at(0.1 + 1e-12)).abs() < 1e-6);
        assert!((axis.at(3.0) + axis.at(-3.0) - 100.0).abs() < 1e-9);
        assert!(axis.at(1.0) > axis.at(0.5));
    }

    #[test]
    fn ticks_are_round_and_inside() {
        let labels = |low, high, wanted| -> Vec<_> {
            Axis::linear(low, high, 0.0, 1.0).ticks(wanted).into_iter().map(|t| t.label).collect()
        };
        assert_eq!(labels(0.0, 26.0, 5), ["0", "5", "10", "15", "20", "25"]);
        assert_eq!(labels(-0.41, 0.41, 4), ["−0.4", "−0.2", "0", "0.2", "0.4"]);
        assert_eq!(labels(-0.38, 0.38, 2), ["−0.2", "0", "0.2"]);
    }

    #[test]
    fn an_empty_or_endless_range_is_replaced() {
        assert!(Axis::linear(2.0, 2.0, 0.0, 1.0).at(2.0).is_finite());
        assert!(Axis::linear(f64::NAN, 2.0, 0.0, 1.0).at(0.5).is_finite());
        assert!(Axis::symmetric(0.0, 0.1, 0.0, 1.0).at(0.0).is_finite());
    }
}
