use crate::figures::axis::{Axis, COLUMN, PLOT, PLOT_FOOT, PLOT_TOP, Tick, extent, frame, note};
use crate::figures::palette::{BLUE, series};
use crate::figures::svg::{Anchor, Paint, Point, Sheet};
use crate::figures::text;

/// A candidate with its score.
#[derive(Clone, Copy, Debug)]
pub struct ScoredDot {
    /// The varied quantity.
    pub at: f64,
    /// Its score.
    pub score: f64,
    /// Its standard error, if there is one.
    pub standard_error: Option<f64>,
    /// Whether it is the one that was chosen.
    pub chosen: bool,
}

const HEIGHT: f64 = 300.0;

/// Scores with their standard errors over the varied quantity, on a logarithmic axis if `decades`; the chosen one is
/// filled. Dots in any order; those that are not finite are omitted.
pub fn scored(dots: &[ScoredDot], decades: bool, (across_title, up_title): (&str, &str)) -> String {
    let place = |at: f64| if decades { libm::log10(at) } else { at };
    let mut known: Vec<ScoredDot> =
        dots.iter().copied().filter(|dot| place(dot.at).is_finite() && dot.score.is_finite()).collect();
    known.sort_by(|a, b| a.at.total_cmp(&b.at));
    let ends = known.iter().flat_map(|dot| {
        let error = dot.standard_error.unwrap_or(0.0);
        [dot.score - error, dot.score + error]
    });
    let across = ranged(known.iter().map(|dot| place(dot.at)), 0.06, PLOT);
    let up = ranged(ends, 0.06, (HEIGHT - PLOT_FOOT, PLOT_TOP));
    Sheet::figure(COLUMN, HEIGHT, "Scores of the candidates", |sheet| {
        let ticks = if decades { powers(&across) } else { across.ticks(4) };
        frame(sheet, (&across, &ticks, across_title), (&up, &up.ticks(4), up_title));
        let path: Vec<Point> = known.iter().map(|dot| (across.at(place(dot.at)), up.at(dot.score))).collect();
        sheet.polyline(&path, (Paint::solid(BLUE).faded(0.55), 1.4));
        for (dot, (x, y)) in known.iter().zip(&path) {
            if let Some(error) = dot.standard_error {
                let (low, high) = (up.at(dot.score - error), up.at(dot.score + error));
                sheet.line((*x, low), (*x, high), (Paint::solid(BLUE).faded(0.55), 1.4));
            }
            mark(sheet, (*x, *y), dot.chosen, (3.2, 1.4));
        }
    })
}

/// A disc that is filled if it was `chosen`; else a smaller ring of this radius and width.
fn mark(sheet: &mut Sheet, at: Point, chosen: bool, (radius, width): (f64, f64)) {
    match chosen {
        true => sheet.disc(at, 6.0, Paint::solid(BLUE)),
        false => sheet.disc(at, radius, (Paint::solid(BLUE), width)),
    }
}

/// The range of `values`, and `margin` of it on both sides.
fn ranged(values: impl Iterator<Item = f64>, margin: f64, (from, to): (f64, f64)) -> Axis {
    let (low, high) = extent(values).unwrap_or((0.0, 1.0));
    let air = if high > low { margin * (high - low) } else { 0.5 };
    Axis::linear(low - air, high + air, from, to)
}

/// Powers of ten inside the range of their logarithms.
fn powers(axis: &Axis) -> Vec<Tick> {
    let all = axis.low.ceil() as i32..=axis.high.floor() as i32;
    let label = |power: i32| format!("10{}", text::superscript(power));
    all.map(|power| Tick { value: f64::from(power), label: label(power) }).collect()
}

/// The accuracy of one design over time.
#[derive(Clone, Debug)]
pub struct AccuracyCurve<'a> {
    /// Name of the design.
    pub label: &'a str,
    /// Duration \[s\] and standard error; both positive.
    pub points: Vec<(f64, f64)>,
}

const CURVES_HEIGHT: f64 = 320.0;

/// Curves of the standard error against the duration of the experiment, both logarithmic, and the wanted error with
/// the duration that reaches it. Points that are not positive are omitted.
pub fn accuracy(curves: &[AccuracyCurve<'_>], wanted: (f64, f64), title: &str) -> String {
    let drawn = |(s, e): &(f64, f64)| *s > 0.0 && *e > 0.0 && e.is_finite();
    let known: Vec<(&str, Vec<(f64, f64)>)> =
        curves.iter().map(|c| (c.label, c.points.iter().copied().filter(drawn).collect())).collect();
    let all = || known.iter().flat_map(|(_, points)| points).chain([&wanted]);
    let across = LogAxis::new(all().map(|p| p.0), PLOT);
    let up = LogAxis::new(all().map(|p| p.1), (CURVES_HEIGHT - PLOT_FOOT, PLOT_TOP));
    let ((left, right), (bottom, top)) = (across.0.ends(), up.0.ends());
    Sheet::figure(COLUMN, CURVES_HEIGHT, "Standard error against duration", |sheet| {
        let durations = (&across.0, &*across.ticks(), "duration of the experiment [s]");
        frame(sheet, durations, (&up.0, &up.ticks(), title));
        let target = (across.at(wanted.0), up.at(wanted.1));
        sheet.line((left, target.1), target, (Paint::ink(0.5), 1.2));
        sheet.line((target.0, bottom), target, (Paint::ink(0.5), 1.2));
        for (i, (label, points)) in known.iter().enumerate() {
            let path: Vec<Point> = points.iter().map(|(s, e)| (across.at(*s), up.at(*e))).collect();
            sheet.polyline(&path, (Paint::solid(series(i)), 2.0));
            let y = top + 12.0 + 16.0 * i as f64;
            sheet.line((right - 150.0, y), (right - 128.0, y), (Paint::solid(series(i)), 2.4));
            sheet.text(label, (right - 121.0, y), note(Anchor::Start));
        }
        sheet.disc(target, 5.0, Paint::solid(series(0)));
    })
}

/// A logarithmic axis: an axis of logarithms to base 10.
struct LogAxis(Axis);

impl LogAxis {
    fn new(values: impl Iterator<Item = f64>, (from, to): (f64, f64)) -> Self {
        let (low, high) = extent(values.map(libm::log10)).unwrap_or((0.0, 1.0));
        Self(Axis::linear(low - 0.05, high + 0.05, from, to))
    }

    fn at(&self, value: f64) -> f64 {
        self.0.at(libm::log10(value))
    }

    /// 1, 2 and 5 times powers of ten inside the range; powers of ten alone if there are many.
    fn ticks(&self) -> Vec<Tick> {
        let (low, high) = (self.0.low, self.0.high);
        let decades = low.floor() as i32..=high.ceil() as i32;
        let of = |factors: &[f64]| -> Vec<f64> {
            let all = decades.clone().flat_map(|d| factors.iter().map(move |f| f * 10f64.powi(d)));
            all.filter(|v| libm::log10(*v) >= low && libm::log10(*v) <= high).collect()
        };
        let fine = of(&[1.0, 2.0, 5.0]);
        let kept = if fine.len() <= 8 { fine } else { of(&[1.0]) };
        let label = |value: f64| text::number(value, libm::pow(10f64, libm::log10(value).floor()));
        kept.into_iter().map(|value| Tick { value: libm::log10(value), label: label(value) }).collect()
    }
}

/// One point of a front of information against cost.
#[derive(Clone, Debug)]
pub struct FrontDot<'a> {
    /// Its cost.
    pub cost: f64,
    /// log|det| of its information.
    pub log_det: f64,
    /// Label of the dot; may be empty.
    pub label: &'a str,
    /// Whether it is the one that was chosen.
    pub chosen: bool,
}

const RIGHT: f64 = PLOT.1;
/// With more dots than this only the chosen one is named.
const MOST_NAMED: usize = 12;

/// Dots of log|det| against cost, and the steps of the best value at each cost; the chosen dot is filled. Dots in any
/// order; those that are not finite are omitted.
pub fn front(dots: &[FrontDot<'_>], cost_title: &str) -> String {
    let mut known: Vec<&FrontDot<'_>> =
        dots.iter().filter(|dot| dot.cost.is_finite() && dot.log_det.is_finite()).collect();
    known.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.log_det.total_cmp(&b.log_det)));
    Sheet::figure(COLUMN, HEIGHT, "Information against cost", |sheet| {
        let across = ranged(known.iter().map(|dot| dot.cost), 0.14, PLOT);
        let up = ranged(known.iter().map(|dot| dot.log_det), 0.14, (HEIGHT - PLOT_FOOT, PLOT_TOP));
        let whole = known.iter().all(|dot| dot.cost.fract() == 0.0);
        let costs = (&across, &*cost_ticks(&across, whole), cost_title);
        frame(sheet, costs, (&up, &up.ticks(4), "log|det| of the moments [1]"));
        sheet.polyline(&steps(&known, &across, &up), (Paint::solid(BLUE).faded(0.55), 1.6));
        for dot in &known {
            draw_dot(sheet, (across.at(dot.cost), up.at(dot.log_det)), dot, known.len());
        }
    })
}

/// Round costs; whole numbers only for a cost in moves.
fn cost_ticks(across: &Axis, whole: bool) -> Vec<Tick> {
    let mut ticks = across.ticks(4);
    if whole {
        ticks.retain(|tick| tick.value.fract() == 0.0);
        ticks.iter_mut().for_each(|tick| tick.label = text::number(tick.value, 1.0));
    }
    ticks
}

/// The best value at each cost: constant until the next better dot.
fn steps(known: &[&FrontDot<'_>], across: &Axis, up: &Axis) -> Vec<Point> {
    let mut corners: Vec<Point> = Vec::new();
    let mut best = f64::NEG_INFINITY;
    for dot in known {
        if dot.log_det > best {
            let x = across.at(dot.cost);
            corners.extend((best > f64::NEG_INFINITY).then(|| (x, up.at(best))));
            corners.push((x, up.at(dot.log_det)));
            best = dot.log_det;
        }
    }
    corners.extend((best > f64::NEG_INFINITY).then(|| (RIGHT, up.at(best))));
    corners
}

fn draw_dot(sheet: &mut Sheet, (x, y): Point, dot: &FrontDot<'_>, dots: usize) {
    mark(sheet, (x, y), dot.chosen, (4.8, 1.6));
    if dot.chosen || dots <= MOST_NAMED {
        let (anchor, aside) = if x > 0.7 * RIGHT { (Anchor::End, -9.0) } else { (Anchor::Start, 9.0) };
        let lettering = note(anchor);
        let lettering = if dot.chosen { lettering.bold() } else { lettering };
        sheet.text(dot.label, (x + aside, y - 11.0), lettering);
    }
}
