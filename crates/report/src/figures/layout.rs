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

    /// Pixel of the middle of row `index`.
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
