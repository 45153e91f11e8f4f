use crate::figures::axis::{Axis, Tick};
use crate::figures::svg::{Anchor, Lettering, Paint, Sheet};
use crate::figures::text;

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
pub(crate) struct Rows {
    names: Vec<String>,
    left: f64,
    right: f64,
    row: f64,
}

const TOP: f64 = 26.0;
const FOOT: f64 = 46.0;
const LONGEST_NAME: usize = 26;

impl Rows {
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

    pub(crate) fn top(&self) -> f64 {
        TOP
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
