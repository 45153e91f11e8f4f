use crate::figures::axis::{Axis, BASE, GRID, LABEL, note};
use crate::figures::palette::series;
use crate::figures::svg::{Anchor, Lettering, Paint, Sheet};
use crate::figures::text;

/// Counts of values in equal bins from 0 to a limit, with everything else accounted for.
///
/// `counts`, `beyond` and `missing` sum to the number of runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Histogram {
    /// Values per bin; bin i holds i·limit/bins ≤ value < (i+1)·limit/bins. Negative values are in the first.
    pub counts: Vec<usize>,
    /// Values at or above the limit.
    pub beyond: usize,
    /// Runs without a finite value.
    pub missing: usize,
}

impl Histogram {
    /// Counts `values` in `bins` bins from 0 to `limit` (in the values' unit).
    #[must_use]
    pub fn new(values: &[Option<f64>], limit: f64, bins: usize) -> Self {
        let mut histogram = Self { counts: vec![0; bins.max(1)], beyond: 0, missing: 0 };
        for value in values {
            histogram.add(*value, limit);
        }
        histogram
    }

    /// Number of runs.
    #[must_use]
    pub fn runs(&self) -> usize {
        self.counts.iter().sum::<usize>() + self.beyond + self.missing
    }

    pub(crate) fn tallest(&self) -> usize {
        self.counts.iter().copied().max().unwrap_or(0)
    }

    fn add(&mut self, value: Option<f64>, limit: f64) {
        match value.filter(|v| v.is_finite()) {
            None => self.missing += 1,
            Some(value) if value >= limit => self.beyond += 1,
            Some(value) => {
                let last = self.counts.len() - 1;
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates")]
                let bin = (value / limit * self.counts.len() as f64) as usize;
                self.counts[bin.min(last)] += 1;
            }
        }
    }
}

/// The horizontal axis that all panels share.
#[derive(Clone, Copy, Debug)]
pub struct HistogramAxis<'a> {
    /// Quantity and unit: `parameter error [1]`.
    pub title: &'a str,
    /// Values at or above it go to the last bar (in the values' unit).
    pub limit: f64,
    /// Number of bins below the limit.
    pub bins: usize,
    /// Drawn as a line: below it a run counts as good.
    pub bound: Option<f64>,
    /// Width of the figure \[px\], at least 240: its letters are 12 to 13 pixels high at this width.
    pub width: f64,
}

/// One panel: the runs of one design, in the colour of its index among the panels.
#[derive(Clone, Debug)]
pub struct HistogramPanel<'a> {
    /// Name of the design.
    pub label: &'a str,
    /// One value per run; `None` for a run without one.
    pub values: Vec<Option<f64>>,
    /// Next to the bound: `98.6 % below 5`.
    pub note: Option<String>,
}

const LEFT: f64 = 54.0;
/// Pixels from the right edge: end of the axis, beginning and end of the last bar.
const ENDS: [f64; 3] = [64.0, 50.0, 18.0];
const HEAD: f64 = 28.0;
const PLOT: f64 = 128.0;
const PANEL: f64 = HEAD + PLOT + 12.0;
const FOOT: f64 = 44.0;

/// Histograms one above the other with the same bins and the same two axes. Values at or above the limit are in a
/// separate bar at the right, paler and outlined; a bar that would dwarf the others is broken and labelled with its
/// count.
pub fn histogram_pair(axis: &HistogramAxis<'_>, panels: &[HistogramPanel<'_>]) -> String {
    let counted: Vec<Histogram> =
        panels.iter().map(|p| Histogram::new(&p.values, axis.limit, axis.bins)).collect();
    let top = ceiling(&counted);
    let label = format!("Histograms of {}", axis.title);
    Sheet::figure(axis.width.max(240.0), panels.len() as f64 * PANEL + FOOT, &label, |sheet| {
        for (index, (panel, histogram)) in panels.iter().zip(&counted).enumerate() {
            let floor = index as f64 * PANEL + HEAD + PLOT;
            Plot::new(axis, top, floor).draw(sheet, panel, histogram, Paint::solid(series(index)));
        }
        Plot::new(axis, top, 0.0).foot(sheet, panels.len() as f64 * PANEL);
    })
}

/// Upper end of the vertical axis: the tallest bin, and the last bar up to half as much again.
fn ceiling(counted: &[Histogram]) -> f64 {
    let tallest = counted.iter().map(Histogram::tallest).max().unwrap_or(0) as f64;
    let beyond = counted.iter().map(|h| h.beyond).max().unwrap_or(0) as f64;
    let wanted = if tallest > 0.0 { tallest.max(beyond.min(1.5 * tallest)) } else { beyond };
    (1.06 * wanted).max(1.0)
}

struct Plot<'a> {
    axis: &'a HistogramAxis<'a>,
    across: Axis,
    up: Axis,
    floor: f64,
    right: f64,
    overflow: (f64, f64),
}

impl<'a> Plot<'a> {
    fn new(axis: &'a HistogramAxis<'a>, top: f64, floor: f64) -> Self {
        let [right, from, to] = ENDS.map(|end| axis.width.max(240.0) - end);
        let across = Axis::linear(0.0, axis.limit, LEFT, right);
        let up = Axis::linear(0.0, top, floor, floor - PLOT);
        Self { axis, across, up, floor, right, overflow: (from, to) }
    }

    fn draw(&self, sheet: &mut Sheet, panel: &HistogramPanel<'_>, counted: &Histogram, paint: Paint) {
        self.grid(sheet);
        self.bins(sheet, counted, paint);
        self.overflow(sheet, counted.beyond, paint);
        sheet.line((LEFT, self.floor), (self.right, self.floor), (BASE, 1.0));
        let y = self.floor - PLOT - 14.0;
        sheet.bar((LEFT, y - 5.0), (LEFT + 10.0, y + 5.0), paint);
        sheet.text(panel.label, (LEFT + 16.0, y), Lettering::new(LABEL, Anchor::Start).bold());
        if let Some(bound) = self.axis.bound.filter(|bound| *bound < self.axis.limit) {
            self.bound(sheet, bound, panel.note.as_deref());
        }
    }

    fn grid(&self, sheet: &mut Sheet) {
        for tick in self.up.ticks(3).iter().filter(|tick| tick.value.fract() == 0.0) {
            let y = self.up.at(tick.value);
            sheet.line((LEFT, y), (self.right, y), (GRID, 1.0));
            sheet.text(&tick.label, (LEFT - 7.0, y), note(Anchor::End));
        }
        let middle = self.floor - 0.5 * PLOT;
        sheet.text("runs", (11.0, middle), Lettering::new(LABEL, Anchor::Middle).upwards());
    }

    fn bins(&self, sheet: &mut Sheet, counted: &Histogram, paint: Paint) {
        let width = self.axis.limit / counted.counts.len() as f64;
        for (bin, &count) in counted.counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let from = self.across.at(bin as f64 * width) + 0.4;
            let to = self.across.at((bin + 1) as f64 * width) - 0.4;
            sheet.bar((from, self.floor), (to, self.up.at(count as f64)), paint);
        }
    }

    fn overflow(&self, sheet: &mut Sheet, beyond: usize, paint: Paint) {
        let (from, to) = self.overflow;
        let top = self.up.inside(beyond as f64);
        sheet.line((from - 3.0, self.floor), (to + 3.0, self.floor), (BASE, 1.0));
        if beyond > 0 {
            sheet.bar((from, self.floor), (to, top), paint.faded(0.3));
            sheet.bar((from, self.floor), (to, top), (paint, 1.4));
        }
        if beyond as f64 > self.up.high {
            // Two slanted strokes: it continues beyond the axis.
            for drop in [14.0, 20.0] {
                let y = self.floor - PLOT + drop;
                sheet.line((from - 5.0, y + 4.0), (to + 5.0, y - 4.0), (Paint::ink(0.8), 1.6));
            }
        }
        sheet.text(&beyond.to_string(), ((from + to) / 2.0, top - 9.0), note(Anchor::Middle));
    }

    fn bound(&self, sheet: &mut Sheet, bound: f64, text: Option<&str>) {
        let x = self.across.at(bound);
        sheet.line((x, self.floor), (x, self.floor - PLOT - 3.0), (Paint::ink(0.85), 1.4));
        if let Some(text) = text {
            let at = (x + 7.0, self.floor - PLOT + 7.0);
            sheet.text(text, at, Lettering::new(LABEL, Anchor::Start));
        }
    }

    /// Ticks and title below the last panel. The limit is named below the last bar only.
    fn foot(&self, sheet: &mut Sheet, top: f64) {
        for tick in self.across.ticks(4) {
            let x = self.across.at(tick.value);
            sheet.line((x, top - 12.0), (x, top - 8.0), (BASE, 1.0));
            if x < self.right - 16.0 {
                sheet.text(&tick.label, (x, top), note(Anchor::Middle));
            }
        }
        let (from, to) = self.overflow;
        let limit = format!("≥ {}", text::number(self.axis.limit, finest(self.axis.limit)));
        sheet.text(&limit, ((from + to) / 2.0, top), note(Anchor::Middle));
        let middle = (LEFT + self.right) / 2.0;
        sheet.text(self.axis.title, (middle, top + 24.0), Lettering::new(LABEL, Anchor::Middle));
    }
}

/// The value of the last digit that `limit` needs, down to thousandths.
fn finest(limit: f64) -> f64 {
    let exact = |step: &f64| ((limit / step).round() * step - limit).abs() < 1e-9 * limit.abs();
    [1.0, 0.1, 0.01].into_iter().find(exact).unwrap_or(0.001)
}
