use super::axis::{COLUMN, PLOT, PLOT_FOOT, PLOT_TOP, frame, note};
use crate::figures::axis::{Axis, Tick, extent};
use crate::figures::palette::BLUE;
use crate::figures::svg::{Anchor, Paint, Point, Sheet};
use crate::figures::text;

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

const HEIGHT: f64 = 300.0;
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
        let across = axis(known.iter().map(|dot| dot.cost), PLOT);
        let up = axis(known.iter().map(|dot| dot.log_det), (HEIGHT - PLOT_FOOT, PLOT_TOP));
        let whole = known.iter().all(|dot| dot.cost.fract() == 0.0);
        let costs = (&across, &*cost_ticks(&across, whole), cost_title);
        frame(sheet, costs, (&up, &up.ticks(4), "log|det| of the moments [1]"));
        sheet.polyline(&steps(&known, &across, &up), (Paint::solid(BLUE).faded(0.55), 1.6));
        for dot in &known {
            draw_dot(sheet, (across.at(dot.cost), up.at(dot.log_det)), dot, known.len());
        }
    })
}

/// The range of `values` with a margin on both sides.
fn axis(values: impl Iterator<Item = f64>, (from, to): (f64, f64)) -> Axis {
    let (low, high) = extent(values).unwrap_or((0.0, 1.0));
    let air = if high > low { 0.14 * (high - low) } else { 0.5 };
    Axis::linear(low - air, high + air, from, to)
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
    for dot in known.iter().filter(|dot| dot.log_det.is_finite()) {
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
    if dot.chosen {
        sheet.disc((x, y), 6.0, Paint::solid(BLUE));
    } else {
        sheet.disc((x, y), 4.8, (Paint::solid(BLUE), 1.6));
    }
    if dot.chosen || dots <= MOST_NAMED {
        let (anchor, aside) = if x > 0.7 * RIGHT { (Anchor::End, -9.0) } else { (Anchor::Start, 9.0) };
        let lettering = note(anchor);
        let lettering = if dot.chosen { lettering.bold() } else { lettering };
        sheet.text(dot.label, (x + aside, y - 11.0), lettering);
    }
}
