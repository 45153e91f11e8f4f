use super::axis::{COLUMN, PLOT, PLOT_FOOT, PLOT_TOP, frame, note};
use crate::figures::axis::{Axis, Tick, extent};
use crate::figures::palette::series;
use crate::figures::svg::{Anchor, Paint, Point, Sheet};
use crate::figures::text;

/// The accuracy of one design over time.
#[derive(Clone, Debug)]
pub struct AccuracyCurve<'a> {
    /// Name of the design.
    pub label: &'a str,
    /// Duration \[s\] and standard error; both positive.
    pub points: Vec<(f64, f64)>,
}

const HEIGHT: f64 = 320.0;

/// Curves of the standard error against the duration of the experiment, both logarithmic, and the wanted error with
/// the duration that reaches it. Points that are not positive are omitted.
pub fn accuracy(curves: &[AccuracyCurve<'_>], wanted: (f64, f64), title: &str) -> String {
    let drawn = |(s, e): &(f64, f64)| *s > 0.0 && *e > 0.0 && e.is_finite();
    let known: Vec<(&str, Vec<(f64, f64)>)> =
        curves.iter().map(|c| (c.label, c.points.iter().copied().filter(drawn).collect())).collect();
    let all = || known.iter().flat_map(|(_, points)| points).chain([&wanted]);
    let across = Scale::new(all().map(|p| p.0), PLOT);
    let up = Scale::new(all().map(|p| p.1), (HEIGHT - PLOT_FOOT, PLOT_TOP));
    let ((left, right), (bottom, top)) = (across.0.ends(), up.0.ends());
    Sheet::figure(COLUMN, HEIGHT, "Standard error against duration", |sheet| {
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
struct Scale(Axis);

impl Scale {
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
