use crate::figures::axis::{Axis, BASE, GRID, LABEL, NOTE, extent, note, round_step};
use crate::figures::palette::{INK, Rgb};
use crate::figures::svg::{Anchor, Lettering, Paint, Point, Sheet};
use crate::figures::text;

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
        let grid = TraceGrid::new(columns, rows, head);
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

struct TraceGrid {
    across: Vec<Axis>,
    ranges: Vec<(f64, f64)>,
    head: f64,
}

impl TraceGrid {
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
            draw_axes(sheet, across, &up);
            curves.iter().for_each(|curve| draw_curve(sheet, (across, &up), row.t, curve));
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

fn draw_axes(sheet: &mut Sheet, across: &Axis, up: &Axis) {
    let (left, right) = across.ends();
    let lettering = Lettering::new(11.0, Anchor::End).painted(Paint::ink(0.7));
    for tick in up.ticks(2) {
        let y = up.at(tick.value);
        let paint = if tick.value == 0.0 { BASE } else { GRID };
        sheet.line((left, y), (right, y), (paint, 1.0));
        sheet.text(&tick.label, (left - 5.0, y), lettering);
    }
}

fn draw_curve(sheet: &mut Sheet, (across, up): (&Axis, &Axis), t: &[f64], curve: &Curve) {
    let points = t.iter().zip(&curve.values).map(|(t, value)| (across.at(*t), up.at(*value)));
    let paint = Paint::solid(curve.colour.unwrap_or(INK));
    if !curve.band.is_empty() {
        let side = |sign: f64| {
            let ends = t.iter().zip(&curve.values).zip(&curve.band);
            let points = ends.map(|((t, x), half)| (across.at(*t), up.at(x + sign * half)));
            thinned(points, MOST_POINTS)
        };
        let around: Vec<_> = side(1.0).into_iter().chain(side(-1.0).into_iter().rev()).collect();
        sheet.polyline(&around, paint.faded(0.2));
    }
    let width = if curve.is_thin { 0.6 } else { 1.5 };
    sheet.polyline(&thinned(points, MOST_POINTS), (paint, width));
}

/// At most about `most` points of a curve that keep its peaks: of each section the first, lowest and highest point.
/// Points that are not finite are dropped.
fn thinned(points: impl IntoIterator<Item = Point>, most: usize) -> Vec<Point> {
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

/// One or several tracks in the plane, in one cell.
#[derive(Clone, Debug)]
pub struct TrackCell<'a> {
    /// Name of the maneuver or recording.
    pub name: &'a str,
    /// Drawn in this order; the first begins at the dot.
    pub lines: Vec<TrackLine<'a>>,
}

/// One track.
#[derive(Clone, Copy, Debug)]
pub struct TrackLine<'a> {
    /// Position along the initial heading \[m\].
    pub x: &'a [f64],
    /// Position to starboard of it \[m\].
    pub y: &'a [f64],
    /// Its colour; `None` for ink.
    pub colour: Option<Rgb>,
}

const NARROWEST: f64 = 150.0;
const TALLEST: f64 = 230.0;
const HEAD: f64 = 26.0;
const PAD: f64 = 10.0;
const LONGEST_NAME: usize = 24;
const LETTER: f64 = 6.6;

/// Plan views, all at the same scale: x upwards, y to the right, a dot at the start.
pub fn tracks(tracks: &[TrackCell<'_>]) -> String {
    let cells = TrackCells::new(tracks);
    let rows = tracks.len().div_ceil(cells.columns);
    let height = rows as f64 * cells.cell.1 + 34.0;
    Sheet::figure(WIDTH, height, "Plan view of every maneuver", |sheet| {
        for (index, track) in tracks.iter().enumerate() {
            cells.draw(sheet, index, track);
        }
        cells.scale_bar(sheet, height - 16.0);
    })
}

/// Number of columns, size of the cells [px], and pixels per metre.
struct TrackCells {
    columns: usize,
    cell: (f64, f64),
    scale: f64,
}

impl TrackCells {
    fn new(tracks: &[TrackCell<'_>]) -> Self {
        let length = |(low, high): (f64, f64)| high - low;
        let widest = tracks.iter().map(|track| length(track.across())).fold(1e-3, f64::max);
        let longest = tracks.iter().map(|track| length(track.along())).fold(1e-3, f64::max);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a handful")]
        let most = (WIDTH / NARROWEST) as usize;
        let candidates = (1..=most.min(tracks.len().max(1))).map(|columns| {
            let room = WIDTH / columns as f64 - 2.0 * PAD;
            (columns, (room / widest).min(TALLEST / longest))
        });
        let best = candidates.max_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let (columns, scale) = best.unwrap_or((1, 1.0));
        let cell = (WIDTH / columns as f64, HEAD + longest * scale + 3.0 * PAD);
        Self { columns, cell, scale }
    }

    fn draw(&self, sheet: &mut Sheet, index: usize, track: &TrackCell<'_>) {
        let left = (index % self.columns) as f64 * self.cell.0;
        let top = (index / self.columns) as f64 * self.cell.1;
        sheet.bar((left + 3.0, top + 3.0), (left + self.cell.0 - 3.0, top + self.cell.1 - 3.0), (GRID, 1.0));
        sheet.text(&abridged(track.name, self.letters()), (left + PAD, top + 16.0), note(Anchor::Start));
        let centre = (left + 0.5 * self.cell.0, top + HEAD + 0.5 * (self.cell.1 - HEAD));
        for (i, line) in track.lines.iter().enumerate() {
            let points = self.placed(track, line, centre);
            let paint = Paint::solid(line.colour.unwrap_or(INK));
            sheet.polyline(&thinned(points.iter().copied(), MOST_POINTS), (paint, 1.8));
            let start = points.iter().find(|p| p.0.is_finite() && p.1.is_finite());
            if let Some(start) = start.filter(|_| i == 0) {
                sheet.disc(*start, 3.5, Paint::ink(0.9));
            }
        }
    }

    /// Maximum length of a name.
    fn letters(&self) -> usize {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a handful")]
        let most = ((self.cell.0 - 2.0 * PAD) / LETTER) as usize;
        most.min(LONGEST_NAME)
    }

    /// Pixels of a line with the centre of the extent of all of `track` at `centre`.
    fn placed(&self, track: &TrackCell<'_>, line: &TrackLine<'_>, centre: Point) -> Vec<Point> {
        let [north, east] = [track.along(), track.across()].map(|(low, high)| 0.5 * (low + high));
        let pairs = line.x.iter().zip(line.y);
        pairs
            .map(|(x, y)| (centre.0 + self.scale * (y - east), centre.1 - self.scale * (x - north)))
            .collect()
    }

    fn scale_bar(&self, sheet: &mut Sheet, y: f64) {
        let metres = round_step(0.5 * 100.0 / self.scale);
        let end = 4.0 + metres * self.scale;
        sheet.line((4.0, y), (end, y), (Paint::ink(0.8), 2.0));
        for x in [4.0, end] {
            sheet.line((x, y - 4.0), (x, y + 4.0), (Paint::ink(0.8), 1.4));
        }
        let label = format!("{} m", text::number(metres, metres));
        sheet.text(&label, (end + 0.7 * NOTE, y), note(Anchor::Start));
    }
}

impl TrackCell<'_> {
    /// Least and largest x of all lines.
    fn along(&self) -> (f64, f64) {
        extent(self.lines.iter().flat_map(|line| line.x.iter().copied())).unwrap_or_default()
    }

    /// Least and largest y of all lines.
    fn across(&self) -> (f64, f64) {
        extent(self.lines.iter().flat_map(|line| line.y.iter().copied())).unwrap_or_default()
    }
}

/// `name` without its middle if it is longer than `most`: names of recordings often differ at their ends.
fn abridged(name: &str, most: usize) -> String {
    let letters: Vec<char> = name.chars().collect();
    if letters.len() <= most {
        return name.to_owned();
    }
    let (head, tail) = (most / 2, most.saturating_sub(most / 2 + 1));
    letters[..head].iter().chain(&['…']).chain(&letters[letters.len() - tail..]).collect()
}
