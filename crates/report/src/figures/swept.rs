use crate::figures::axis::{Axis, Tick, extent};
use crate::figures::layout::{COLUMN, LABEL, PLOT, PLOT_FOOT, frame, note};
use crate::figures::palette::{Rgb, series};
use crate::figures::svg::{Anchor, Lettering, Paint, Point, Sheet};
use crate::figures::text;

/// The positions of the values of a swept quantity on an axis.
#[derive(Clone, Debug)]
pub struct Places {
    /// The varied quantity.
    pub title: String,
    /// The labels of the values.
    pub labels: Vec<String>,
    /// The position of each.
    pub at: Vec<f64>,
}

/// A quantity over the varied one, with its interval.
#[derive(Clone, Debug)]
pub struct SweptCurve {
    /// Its name.
    pub label: String,
    /// Position on the axis, value, and both ends of its interval; an end that is not finite leaves the interval open
    /// there.
    pub points: Vec<(f64, f64, [f64; 2])>,
}

const HEIGHT: f64 = 320.0;
const KEY: f64 = 17.0;

impl Places {
    /// Places numbers to scale, on a logarithmic scale if their gaps are very uneven; all else evenly.
    pub fn new(title: String, labels: Vec<String>, numbers: Option<&[f64]>) -> Self {
        let even: Vec<f64> = (0..labels.len()).map(|place| place as f64).collect();
        let at = numbers.and_then(|numbers| placed(numbers.to_vec()).or_else(|| logarithmic(numbers)));
        Self { title, labels, at: at.unwrap_or(even) }
    }

    fn axis(&self, (from, to): (f64, f64)) -> Axis {
        let (low, high) = extent(self.at.iter().copied()).unwrap_or((0.0, 1.0));
        let air = if high > low { 0.06 * (high - low) } else { 0.5 };
        Axis::linear(low - air, high + air, from, to)
    }

    /// A tick for every value with enough space after the previous one.
    fn ticks(&self, axis: &Axis) -> Vec<Tick> {
        let mut order: Vec<usize> = (0..self.at.len()).collect();
        order.sort_by(|a, b| self.at[*a].total_cmp(&self.at[*b]));
        let mut free = f64::NEG_INFINITY;
        let mut ticks = Vec::new();
        for i in order {
            let label = text::shortened(&self.labels[i], 14);
            let half = 0.5 * text::width(&label, 12.0);
            if axis.at(self.at[i]) - half >= free {
                free = axis.at(self.at[i]) + half + 6.0;
                ticks.push(Tick { value: self.at[i], label });
            }
        }
        ticks
    }
}

/// `numbers`, if none of their gaps is very much wider than another.
fn placed(numbers: Vec<f64>) -> Option<Vec<f64>> {
    let mut sorted = numbers.clone();
    sorted.sort_by(f64::total_cmp);
    let gaps = || sorted.windows(2).map(|pair| pair[1] - pair[0]);
    let (least, most) = (gaps().fold(f64::INFINITY, f64::min), gaps().fold(0.0, f64::max));
    (numbers.iter().all(|n| n.is_finite()) && most <= 4.0 * least).then_some(numbers)
}

fn logarithmic(numbers: &[f64]) -> Option<Vec<f64>> {
    numbers.iter().all(|n| *n > 0.0).then(|| numbers.iter().map(|n| libm::log10(*n)).collect())
}

/// Curves over the varied quantity, each with the band of its intervals. `range`: of the vertical axis, if given.
pub fn swept(places: &Places, curves: &[SweptCurve], title: &str, range: Option<(f64, f64)>) -> String {
    let top = 14.0 + KEY * curves.len() as f64;
    let height = HEIGHT + KEY * curves.len() as f64;
    let across = places.axis(PLOT);
    let (low, high) = range.unwrap_or_else(|| reached(curves));
    let up = Axis::linear(low, high, height - PLOT_FOOT, top);
    Sheet::figure(COLUMN, height, title, |sheet| {
        frame(sheet, (&across, &places.ticks(&across), &places.title), (&up, &up.ticks(4), title));
        for (i, curve) in curves.iter().enumerate() {
            key(sheet, 10.0 + KEY * i as f64, &curve.label, series(i));
            draw(sheet, (&across, &up), curve, series(i));
        }
    })
}

fn key(sheet: &mut Sheet, y: f64, label: &str, colour: Rgb) {
    sheet.line((PLOT.0, y), (PLOT.0 + 22.0, y), (Paint::solid(colour), 2.4));
    sheet.text(label, (PLOT.0 + 29.0, y), note(Anchor::Start));
}

/// The range of all values and of the bounded intervals, with a margin.
fn reached(curves: &[SweptCurve]) -> (f64, f64) {
    let points = curves.iter().flat_map(|curve| &curve.points);
    let (low, high) = extent(points.flat_map(|(_, value, [a, b])| [*value, *a, *b])).unwrap_or((0.0, 1.0));
    let air = 0.06 * (high - low).max(1e-9);
    (low - air, high + air)
}

fn draw(sheet: &mut Sheet, (across, up): (&Axis, &Axis), curve: &SweptCurve, colour: Rgb) {
    let mut points = curve.points.clone();
    points.retain(|(_, value, _)| value.is_finite());
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let end = |which: usize| {
        let open = if which == 0 { up.low } else { up.high };
        points.iter().map(move |(at, _, ends)| {
            let end = if ends[which].is_finite() { ends[which] } else { open };
            (across.at(*at), up.inside(end))
        })
    };
    let (lower, upper): (Vec<Point>, Vec<Point>) = (end(0).collect(), end(1).collect());
    let around: Vec<Point> = lower.iter().copied().chain(upper.iter().rev().copied()).collect();
    sheet.polyline(&around, Paint::solid(colour).faded(0.16));
    let line: Vec<Point> = points.iter().map(|(at, value, _)| (across.at(*at), up.inside(*value))).collect();
    sheet.polyline(&line, (Paint::solid(colour), 1.8));
    for ((low, high), dot) in lower.iter().zip(&upper).zip(&line) {
        sheet.line(*low, *high, (Paint::solid(colour).faded(0.7), 1.2));
        sheet.disc(*dot, 3.2, Paint::solid(colour));
    }
}

/// A cell of a heat map: across, up, its share from 0 to 1, or `None` if it was refused.
pub type HeatCell = (usize, usize, Option<f64>);

/// Shares over two axes as colours with their numbers in percent; a refused cell is crossed out.
pub fn heat(across: &Places, up: &Places, cells: &[HeatCell], title: &str) -> String {
    let labels = up.labels.iter().map(|label| text::shortened(label, 14));
    let left = 44.0 + labels.clone().map(|label| text::width(&label, 12.0)).fold(20.0, f64::max);
    let (columns, rows) = (across.labels.len().max(1) as f64, up.labels.len().max(1) as f64);
    let width = (COLUMN - 12.0 - left) / columns;
    let (tall, top) = ((width * 0.7).clamp(22.0, 46.0), 26.0);
    let bottom = top + rows * tall;
    Sheet::figure(COLUMN, bottom + 50.0, title, |sheet| {
        sheet.text(title, (left, 11.0), Lettering::new(LABEL, Anchor::Start).bold());
        for (i, j, share) in cells {
            let corner = (left + width * *i as f64, bottom - tall * *j as f64);
            square(sheet, corner, (corner.0 + width - 2.0, corner.1 - tall + 2.0), *share);
        }
        for (i, label) in across.labels.iter().enumerate() {
            let most = (width / 7.0).max(3.0) as usize;
            let at = (left + width * (i as f64 + 0.5) - 1.0, bottom + 13.0);
            sheet.text(&text::shortened(label, most), at, note(Anchor::Middle));
        }
        for (j, label) in labels.enumerate() {
            sheet.text(&label, (left - 7.0, bottom - tall * (j as f64 + 0.5)), note(Anchor::End));
        }
        let name = Lettering::new(LABEL, Anchor::Middle);
        sheet.text(&across.title, ((left + COLUMN - 12.0) / 2.0, bottom + 36.0), name);
        sheet.text(&up.title, (12.0, (top + bottom) / 2.0), name.upwards());
    })
}

fn square(sheet: &mut Sheet, corner: Point, opposite: Point, share: Option<f64>) {
    let middle = (0.5 * (corner.0 + opposite.0), 0.5 * (corner.1 + opposite.1));
    let Some(share) = share else {
        sheet.bar(corner, opposite, (Paint::ink(0.4), 1.0));
        sheet.line(corner, opposite, (Paint::ink(0.4), 1.0));
        sheet.line((corner.0, opposite.1), (opposite.0, corner.1), (Paint::ink(0.4), 1.0));
        return;
    };
    // Never too dark for text on it.
    sheet.bar(corner, opposite, Paint::solid(series(0)).faded(0.06 + 0.5 * share.clamp(0.0, 1.0)));
    let lettering = Lettering::new(if opposite.0 - corner.0 < 40.0 { 11.0 } else { 13.0 }, Anchor::Middle);
    sheet.text(&format!("{:.0}", 100.0 * share), middle, lettering);
}
