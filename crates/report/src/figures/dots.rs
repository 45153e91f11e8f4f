use super::axis::{COLUMN, PLOT, PLOT_FOOT, PLOT_TOP, frame};
use super::text;
use crate::figures::axis::{Axis, Tick, extent};
use crate::figures::palette::BLUE;
use crate::figures::svg::{Paint, Point, Sheet};

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
    let across = ranged(known.iter().map(|dot| place(dot.at)), PLOT);
    let up = ranged(ends, (HEIGHT - PLOT_FOOT, PLOT_TOP));
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
            if dot.chosen {
                sheet.disc((*x, *y), 6.0, Paint::solid(BLUE));
            } else {
                sheet.disc((*x, *y), 3.2, (Paint::solid(BLUE), 1.4));
            }
        }
    })
}

/// The range of `values` with a margin on both sides.
fn ranged(values: impl Iterator<Item = f64>, (from, to): (f64, f64)) -> Axis {
    let (low, high) = extent(values).unwrap_or((0.0, 1.0));
    let air = if high > low { 0.06 * (high - low) } else { 0.5 };
    Axis::linear(low - air, high + air, from, to)
}

/// Powers of ten inside the range of their logarithms.
fn powers(axis: &Axis) -> Vec<Tick> {
    let all = axis.low.ceil() as i32..=axis.high.floor() as i32;
    let label = |power: i32| format!("10{}", text::superscript(power));
    all.map(|power| Tick { value: f64::from(power), label: label(power) }).collect()
}
