use crate::figures::axis::{Axis, BASE, GRID, LABEL, NOTE, note, round_step};
use crate::figures::palette::BLUE;
use crate::figures::svg::{Anchor, Lettering, Look, Paint, Sheet};
use crate::figures::text;

/// One row of correlations.
#[derive(Clone, Debug)]
pub struct CorrelationRow<'a> {
    /// The name of the row.
    pub name: &'a str,
    /// Half-width of the band of correlations by chance.
    pub bound: f64,
    /// One cell per column.
    pub cells: Vec<CorrelationCell<'a>>,
}

/// Correlations at consecutive lags.
#[derive(Clone, Copy, Debug)]
pub struct CorrelationCell<'a> {
    /// The first lag \[samples\].
    pub first: i32,
    /// From −1 to 1.
    pub values: &'a [f64],
}

const WIDTH: f64 = 960.0;
/// Space for ticks, left of the first column and of the second.
const MARGIN: f64 = 42.0;
const GAP: f64 = 24.0;
const HEAD: f64 = 26.0;
const ROW: f64 = 112.0;
const CELL: f64 = 84.0;
const FOOT: f64 = 40.0;
const LETTER: f64 = 8.0;

/// Correlations over lags: a row per error, a column per signal it is correlated with, over the band of correlations
/// by chance. The first column, of the error with itself, goes from −1 to 1; the others share another axis.
pub fn correlations(columns: &[&str], rows: &[CorrelationRow<'_>]) -> String {
    let height = HEAD + rows.len() as f64 * ROW + FOOT;
    let grid = CorrelationGrid::new(columns.len(), rows);
    Sheet::figure(WIDTH, height, "Correlations of errors over lags", |sheet| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a handful")]
        let letters = (grid.width / LETTER) as usize;
        for (i, title) in columns.iter().enumerate() {
            let title = text::shortened(title, letters);
            sheet.text(&title, (grid.left(i), 12.0), Lettering::new(LABEL, Anchor::Start).bold());
        }
        for (i, row) in rows.iter().enumerate() {
            grid.row(sheet, HEAD + i as f64 * ROW, row);
        }
        for (i, cell) in rows.last().iter().flat_map(|row| &row.cells).enumerate() {
            foot(sheet, &grid.across(i, cell), HEAD + rows.len() as f64 * ROW);
        }
    })
}

/// The positions of the columns, and the vertical range of those after the first.
struct CorrelationGrid {
    width: f64,
    most: f64,
}

impl CorrelationGrid {
    fn new(columns: usize, rows: &[CorrelationRow<'_>]) -> Self {
        let beyond = rows.iter().flat_map(|row| row.cells.iter().skip(1).flat_map(|cell| cell.values));
        let bounds = rows.iter().map(|row| 2.0 * row.bound);
        let largest = beyond.map(|x| x.abs()).chain(bounds).filter(|x| x.is_finite()).fold(0.0, f64::max);
        let columns = columns.max(1) as f64;
        let width = (WIDTH - 2.0 * MARGIN - 10.0 - (columns - 1.0) * GAP) / columns;
        Self { width, most: round_step(largest).clamp(0.02, 1.0) }
    }

    fn left(&self, column: usize) -> f64 {
        let further = if column > 0 { MARGIN } else { 0.0 };
        MARGIN + further + column as f64 * (self.width + GAP)
    }

    fn across(&self, column: usize, cell: &CorrelationCell<'_>) -> Axis {
        let (left, first) = (self.left(column), f64::from(cell.first));
        let last = first + cell.values.len() as f64;
        Axis::linear(first.min(0.0) - 0.5, last - 0.5, left, left + self.width)
    }

    fn row(&self, sheet: &mut Sheet, top: f64, row: &CorrelationRow<'_>) {
        let up = |most: f64| Axis::linear(-most, most, top + 20.0 + CELL, top + 20.0);
        sheet.text(row.name, (2.0, top + 8.0), Lettering::new(LABEL, Anchor::Start).bold());
        for (column, cell) in row.cells.iter().enumerate() {
            let up = up(if column > 0 { self.most } else { 1.0 });
            if column < 2 {
                for tick in up.ticks(2) {
                    let at = (self.left(column) - 6.0, up.at(tick.value));
                    sheet.text(&tick.label, at, note(Anchor::End));
                }
            }
            cell.draw(sheet, &self.across(column, cell), &up, row.bound);
        }
    }
}

fn foot(sheet: &mut Sheet, across: &Axis, top: f64) {
    for tick in across.ticks(2) {
        sheet.text(&tick.label, (across.at(tick.value), top + 6.0), note(Anchor::Middle));
    }
    let (left, right) = across.ends();
    sheet.text("lag [samples]", ((left + right) / 2.0, top + 26.0), Lettering::new(NOTE, Anchor::Middle));
}

impl CorrelationCell<'_> {
    fn draw(&self, sheet: &mut Sheet, across: &Axis, up: &Axis, bound: f64) {
        let (left, right) = across.ends();
        let corner = (left, up.inside(bound));
        sheet.bar(corner, (right, up.inside(-bound)), Look::filled(Paint::ink(0.16)));
        for (value, paint) in [(up.low, GRID), (0.0, BASE), (up.high, GRID)] {
            sheet.line((left, up.at(value)), (right, up.at(value)), (paint, 1.0));
        }
        let stem = (0.8 * (across.at(1.0) - across.at(0.0))).clamp(0.8, 3.0);
        for (k, value) in self.values.iter().enumerate() {
            let x = across.at(f64::from(self.first) + k as f64);
            sheet.line((x, up.at(0.0)), (x, up.inside(*value)), (Paint::solid(BLUE), stem));
        }
    }
}
