use crate::figures::axis::{Axis, extent};
use crate::figures::layout::{BASE, COLUMN, GRID, LABEL, note};
use crate::figures::palette::series;
use crate::figures::svg::{Anchor, Lettering, Paint, Point, Sheet};
use crate::figures::text;

/// How accurate one design is after some time.
#[derive(Clone, Debug)]
pub struct AccuracyCurve<'a> {
    /// Name of the design.
    pub label: &'a str,
    /// Duration \[s\] and standard error; both above zero.
    pub points: Vec<(f64, f64)>,
}

const HEIGHT: f64 = 320.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = COLUMN - 16.0;
const TOP: f64 = 16.0;
const BOTTOM: f64 = HEIGHT - 48.0;

/// Curves of the standard error against the duration of the experiment, both logarithmic, and the wanted error with the
/// duration that reaches it. Points that are not above zero are left out.
pub fn accuracy(curves: &[AccuracyCurve<'_>], wanted: (f64, f64), title: &str) -> String {
    let known: Vec<(&str, Vec<(f64, f64)>)> = curves
        .iter()
        .map(|c| {
            (
                c.label,
                c.points.iter().copied().filter(|(s, e)| *s > 0.0 && *e > 0.0 && e.is_finite()).collect(),
            )
        })
        .collect();
    let all = || known.iter().flat_map(|(_, points)| points).chain([&wanted]);
    let across = Scale::new(all().map(|p| p.0), LEFT, RIGHT);
    let up = Scale::new(all().map(|p| p.1), BOTTOM, TOP);
    Sheet::figure(COLUMN, HEIGHT, "Standard error against duration", |sheet| {
        frame(sheet, &across, &up, title);
        let target = (across.at(wanted.0), up.at(wanted.1));
        sheet.line((LEFT, target.1), target, (Paint::ink(0.5), 1.2));
        sheet.line((target.0, BOTTOM), target, (Paint::ink(0.5), 1.2));
        for (i, (label, points)) in known.iter().enumerate() {
            let path: Vec<Point> = points.iter().map(|(s, e)| (across.at(*s), up.at(*e))).collect();
            sheet.polyline(&path, (Paint::solid(series(i)), 2.0));
            let y = TOP + 12.0 + 16.0 * i as f64;
            sheet.line((RIGHT - 150.0, y), (RIGHT - 128.0, y), (Paint::solid(series(i)), 2.4));
            sheet.text(label, (RIGHT - 121.0, y), note(Anchor::Start));
        }
        sheet.disc(target, 5.0, Paint::solid(series(0)));
    })
}

/// A logarithmic axis.
struct Scale {
    axis: Axis,
    low: f64,
    high: f64,
}

impl Scale {
    fn new(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let (low, high) = extent(values.map(f64::log10)).unwrap_or((0.0, 1.0));
        let (low, high) = (low - 0.05, high + 0.05);
        Self { axis: Axis::linear(low, high, from, to), low, high }
    }

    fn at(&self, value: f64) -> f64 {
        self.axis.at(value.log10())
    }

    /// 1, 2 and 5 times powers of ten inside the range; powers of ten alone where those are many.
    fn ticks(&self) -> Vec<f64> {
        let decades = self.low.floor() as i32..=self.high.ceil() as i32;
        let of = |factors: &[f64]| -> Vec<f64> {
            let all = decades.clone().flat_map(|d| factors.iter().map(move |f| f * 10f64.powi(d)));
            all.filter(|v| v.log10() >= self.low && v.log10() <= self.high).collect()
        };
        let fine = of(&[1.0, 2.0, 5.0]);
        if fine.len() <= 8 { fine } else { of(&[1.0]) }
    }
}

fn frame(sheet: &mut Sheet, across: &Scale, up: &Scale, title: &str) {
    let label = |value: f64| text::number(value, 10f64.powf(value.log10().floor()));
    for value in across.ticks() {
        let x = across.at(value);
        sheet.line((x, TOP), (x, BOTTOM), (GRID, 1.0));
        sheet.text(&label(value), (x, BOTTOM + 13.0), note(Anchor::Middle));
    }
    for value in up.ticks() {
        let y = up.at(value);
        sheet.line((LEFT, y), (RIGHT, y), (GRID, 1.0));
        sheet.text(&label(value), (LEFT - 8.0, y), note(Anchor::End));
    }
    sheet.line((LEFT, BOTTOM), (RIGHT, BOTTOM), (BASE, 1.0));
    sheet.line((LEFT, TOP), (LEFT, BOTTOM), (BASE, 1.0));
    let lettering = Lettering::new(LABEL, Anchor::Middle);
    sheet.text("duration of the experiment [s]", ((LEFT + RIGHT) / 2.0, BOTTOM + 36.0), lettering);
    sheet.text(title, (14.0, (TOP + BOTTOM) / 2.0), lettering.upwards());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_of_a_logarithmic_axis_are_inside_and_few() {
        let scale = Scale::new([8.0, 2100.0].into_iter(), 0.0, 100.0);
        let ticks = scale.ticks();
        assert!(ticks.iter().all(|t| (0.0..=100.0).contains(&scale.at(*t))), "{ticks:?}");
        assert!((2..=8).contains(&ticks.len()), "{ticks:?}");
        let fine = Scale::new([0.9, 11.0].into_iter(), 0.0, 100.0).ticks();
        assert_eq!(fine.len(), 4, "{fine:?}");
    }

    #[test]
    fn law_a_curve_of_one_over_the_root_of_time_is_straight() {
        let points: Vec<(f64, f64)> = (1..=8).map(|i| (f64::from(i * i), 1.0 / f64::from(i))).collect();
        let curve = AccuracyCurve { label: "design", points };
        let svg = accuracy(&[curve], (16.0, 0.25), "error [1]");
        assert!(svg.starts_with("<svg") && svg.contains("duration of the experiment"));
        let (across, up) =
            (Scale::new([1.0, 64.0].into_iter(), 0.0, 1.0), Scale::new([1.0, 0.125].into_iter(), 0.0, 1.0));
        let slope = |i: f64| {
            (up.at(1.0 / (i + 1.0)) - up.at(1.0 / i)) / (across.at((i + 1.0).powi(2)) - across.at(i * i))
        };
        assert!((slope(1.0) - slope(6.0)).abs() < 1e-9);
    }
}
