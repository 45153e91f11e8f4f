use super::axis::{BASE, GRID, LABEL, NOTE, note};
use crate::figures::axis::{Axis, extent};
use crate::figures::palette::{INK, Rgb};
use crate::figures::svg::{Anchor, Lettering, Paint, Point, Sheet};

/// One column of the small multiples: a quantity whose vertical axis all rows share.
#[derive(Clone, Debug)]
pub struct TraceColumn<'a> {
    /// Quantity and unit: `surge u [m/s]`.
    pub title: &'a str,
    /// The names of its curves, in order; empty for a single black curve.
    pub legend: Vec<(String, Rgb)>,
}

/// One curve of a cell.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// One value per time of the row; values that are not finite are omitted.
    pub values: Vec<f64>,
    /// Its colour; `None` for ink.
    pub colour: Option<Rgb>,
    /// Half-widths of its band; empty for none.
    pub band: Vec<f64>,
    /// Whether it is drawn thin.
    pub is_thin: bool,
}

/// One row of the small multiples.
#[derive(Clone, Debug)]
pub struct TraceRow<'a> {
    /// Name of the maneuver.
    pub name: &'a str,
    /// Shown next to the name, above the second column.
    pub note: Option<String>,
    /// Times \[s\].
    pub t: &'a [f64],
    /// One cell per column.
    pub cells: Vec<Vec<Curve>>,
}

/// Width of the figure \[px\]: it needs a desk, or a container that scrolls.
const WIDTH: f64 = 960.0;
const MARGIN: f64 = 46.0;
const GAP: f64 = 44.0;
const ROW: f64 = 84.0;
const CELL: f64 = 54.0;
const FOOT: f64 = 42.0;
const MOST_POINTS: usize = 600;
const TITLE: f64 = 26.0;
const LINE: f64 = 17.0;

/// Small multiples over time: a row per maneuver, a column per quantity, the same axes everywhere in a column.
pub fn traces(columns: &[TraceColumn<'_>], rows: &[TraceRow<'_>]) -> String {
    let head = head(columns);
    let height = head + rows.len() as f64 * ROW + FOOT;
    Sheet::figure(WIDTH, height, "Inputs and states over time per maneuver", |sheet| {
        let grid = Grid::new(columns, rows, head);
        for (index, column) in columns.iter().enumerate() {
            legend(sheet, column, grid.across[index].ends().0);
        }
        for (index, row) in rows.iter().enumerate() {
            grid.draw_row(sheet, index, row);
        }
        grid.foot(sheet, rows.len());
    })
}

/// Height of the titles and legends above the first row \[px\].
fn head(columns: &[TraceColumn<'_>]) -> f64 {
    let lines = columns.iter().map(|column| column.legend.len()).max().unwrap_or(0);
    TITLE + LINE * lines as f64 + 6.0
}

/// Title and legend of one column whose cells begin at pixel `left`.
fn legend(sheet: &mut Sheet, column: &TraceColumn<'_>, left: f64) {
    sheet.text(column.title, (left, 12.0), Lettering::new(LABEL, Anchor::Start).bold());
    for (index, (name, colour)) in column.legend.iter().enumerate() {
        let y = TITLE + LINE * (index as f64 + 0.4);
        sheet.line((left, y), (left + 18.0, y), (Paint::solid(*colour), 2.4));
        sheet.text(name, (left + 24.0, y), note(Anchor::Start));
    }
}

struct Grid {
    across: Vec<Axis>,
    ranges: Vec<(f64, f64)>,
    head: f64,
}

impl Grid {
    fn new(columns: &[TraceColumn<'_>], rows: &[TraceRow<'_>], head: f64) -> Self {
        let end = extent(rows.iter().flat_map(|row| row.t.iter().copied())).map_or(1.0, |(_, end)| end);
        let width = (WIDTH - MARGIN - 12.0 + GAP) / columns.len().max(1) as f64;
        let left = |index: usize| MARGIN + index as f64 * width;
        let across =
            (0..columns.len()).map(|i| Axis::linear(0.0, end, left(i), left(i) + width - GAP)).collect();
        let ranges = (0..columns.len()).map(|index| range(rows, index)).collect();
        Self { across, ranges, head }
    }

    fn draw_row(&self, sheet: &mut Sheet, index: usize, row: &TraceRow<'_>) {
        let top = self.head + index as f64 * ROW;
        sheet.line((0.0, top), (WIDTH, top), (GRID, 1.0));
        let name = (2.0, top + 13.0);
        sheet.text(row.name, name, Lettering::new(LABEL, Anchor::Start).bold());
        if let Some(text) = &row.note {
            let after = self.across.get(1).map_or(WIDTH / 2.0, |across| across.ends().0);
            sheet.text(text, (after, top + 13.0), note(Anchor::Start));
        }
        for ((across, &range), curves) in self.across.iter().zip(&self.ranges).zip(&row.cells) {
            let up = Axis::linear(range.0, range.1, top + ROW - 6.0, top + ROW - 6.0 - CELL);
            let cell = Cell { across, up };
            cell.axes(sheet);
            curves.iter().for_each(|curve| cell.curve(sheet, row.t, curve));
        }
    }

    fn foot(&self, sheet: &mut Sheet, rows: usize) {
        let top = self.head + rows as f64 * ROW;
        for across in &self.across {
            for tick in across.ticks(4) {
                sheet.text(&tick.label, (across.at(tick.value), top + 8.0), note(Anchor::Middle));
            }
            let (left, right) = across.ends();
            let middle = ((left + right) / 2.0, top + 28.0);
            sheet.text("time [s]", middle, Lettering::new(NOTE, Anchor::Middle));
        }
    }
}

/// Range of one column over all rows, including zero, with a margin.
fn range(rows: &[TraceRow<'_>], column: usize) -> (f64, f64) {
    let cells = rows.iter().filter_map(|row| row.cells.get(column)).flatten();
    let half = |curve: &Curve| curve.band.iter().copied().fold(0.0, f64::max);
    let values = cells.flat_map(|curve| {
        let half = half(curve);
        curve.values.iter().flat_map(move |x| [x - half, x + half])
    });
    let (low, high) = extent(values.chain([0.0])).unwrap_or((0.0, 1.0));
    let air = 0.05 * (high - low).max(1e-9);
    (low - air, high + air)
}

struct Cell<'a> {
    across: &'a Axis,
    up: Axis,
}

impl Cell<'_> {
    fn axes(&self, sheet: &mut Sheet) {
        let (left, right) = self.across.ends();
        for tick in self.up.ticks(2) {
            let y = self.up.at(tick.value);
            let paint = if tick.value == 0.0 { BASE } else { GRID };
            sheet.line((left, y), (right, y), (paint, 1.0));
            sheet.text(
                &tick.label,
                (left - 5.0, y),
                Lettering::new(11.0, Anchor::End).painted(Paint::ink(0.7)),
            );
        }
    }

    fn curve(&self, sheet: &mut Sheet, t: &[f64], curve: &Curve) {
        let points = t.iter().zip(&curve.values).map(|(t, value)| (self.across.at(*t), self.up.at(*value)));
        let colour = curve.colour.unwrap_or(INK);
        if !curve.band.is_empty() {
            let side = |sign: f64| {
                let ends = t.iter().zip(&curve.values).zip(&curve.band);
                let points = ends.map(|((t, x), half)| (self.across.at(*t), self.up.at(x + sign * half)));
                thinned(points, MOST_POINTS)
            };
            let around: Vec<_> = side(1.0).into_iter().chain(side(-1.0).into_iter().rev()).collect();
            sheet.polyline(&around, Paint::solid(colour).faded(0.2));
        }
        let paint = Paint::solid(colour);
        let width = if curve.is_thin { 0.6 } else { 1.5 };
        sheet.polyline(&thinned(points, MOST_POINTS), (paint, width));
    }
}

/// At most about `most` points of a curve that keep its peaks: of each section the first, lowest and highest point.
/// Points that are not finite are dropped.
pub(crate) fn thinned(points: impl IntoIterator<Item = Point>, most: usize) -> Vec<Point> {
    let finite = points.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite());
    let points: Vec<Point> = finite.collect();
    if points.len() <= most {
        return points;
    }
    let stretch = (3 * points.len()).div_ceil(most.max(3));
    let mut kept: Vec<Point> = points.chunks(stretch).flat_map(landmarks).collect();
    kept.extend(points.last());
    kept
}

fn landmarks(stretch: &[Point]) -> Vec<Point> {
    let height = |i: &usize, j: &usize| stretch[*i].1.total_cmp(&stretch[*j].1);
    let lowest = (0..stretch.len()).min_by(height).unwrap_or(0);
    let highest = (0..stretch.len()).max_by(height).unwrap_or(0);
    let mut kept = vec![0, lowest, highest];
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|i| stretch[i]).collect()
}
