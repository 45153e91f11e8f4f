use super::axis::{COLUMN, Rows, note};
use crate::figures::axis::{Axis, Tick};
use crate::figures::palette::series;
use crate::figures::svg::{Anchor, Paint, Sheet};
use crate::figures::text;

/// One parameter's relative error under each design.
#[derive(Clone, Debug)]
pub struct ErrorRow<'a> {
    /// Name of the parameter.
    pub name: &'a str,
    /// Per design, in the order of the names: mean and standard deviation of (estimate − truth)/|truth|.
    pub errors: Vec<Option<(f64, f64)>>,
}

/// The axis is linear within this relative error.
const LINEAR: f64 = 0.1;
/// Pixels between the designs of one row.
const SPACING: f64 = 11.0;

/// Mean ± standard deviation of the relative error per parameter, one colour per design. The axis is linear within
/// ±10 % and logarithmic beyond.
pub fn relative_errors(designs: &[&str], rows: &[ErrorRow<'_>]) -> String {
    let layout = Rows::new(rows.iter().map(|row| row.name), 14.0 + SPACING * designs.len() as f64, 18.0);
    Sheet::figure(COLUMN, layout.height(), "Relative error per parameter, mean and spread", |sheet| {
        let (left, right) = layout.span();
        let axis = Axis::symmetric(most(rows), LINEAR, left, right);
        layout.draw(sheet, &axis, &ticks(&axis), "relative error of the estimates [%]");
        let zero = axis.at(0.0);
        sheet.line((zero, layout.top()), (zero, layout.bottom()), (Paint::ink(0.7), 1.2));
        for (index, row) in rows.iter().enumerate() {
            draw_row(sheet, &axis, layout.middle(index), row);
        }
        key(sheet, designs, left);
    })
}

/// Half-width of the axis: the farthest whisker, rounded up to 1, 2 or 5 times a power of ten.
fn most(rows: &[ErrorRow<'_>]) -> f64 {
    let errors = rows.iter().flat_map(|row| row.errors.iter().flatten());
    let ends = errors.map(|(mean, spread)| mean.abs() + spread.abs());
    let farthest = ends.filter(|end| end.is_finite()).fold(LINEAR, f64::max);
    crate::figures::axis::round_step(farthest.min(1e9))
}

fn ticks(axis: &Axis) -> Vec<Tick> {
    let powers = (0..12).map(|power| LINEAR * 10f64.powi(power));
    let decades: Vec<f64> = powers.take_while(|value| *value <= axis.high * (1.0 + 1e-9)).collect();
    let every = decades.len().div_ceil(4).max(1);
    let kept: Vec<f64> = decades.into_iter().step_by(every).collect();
    let negative = kept.iter().rev().map(|value| -value);
    let values = negative.chain([0.0]).chain(kept.iter().copied());
    values.map(|value| Tick { value, label: text::number(100.0 * value, 1.0) }).collect()
}

fn draw_row(sheet: &mut Sheet, axis: &Axis, middle: f64, row: &ErrorRow<'_>) {
    let first = middle - 0.5 * SPACING * (row.errors.len() as f64 - 1.0);
    for (index, error) in row.errors.iter().enumerate() {
        if let Some((mean, spread)) = error {
            let y = first + SPACING * index as f64;
            whisker(sheet, axis, y, (*mean, *spread), Paint::solid(series(index)));
        }
    }
}

fn whisker(sheet: &mut Sheet, axis: &Axis, y: f64, (mean, spread): (f64, f64), paint: Paint) {
    if !(mean.is_finite() && spread.is_finite()) {
        return;
    }
    let (from, to) = (axis.inside(mean - spread), axis.inside(mean + spread));
    sheet.line((from, y), (to, y), (paint, 2.2));
    for end in [from, to] {
        sheet.line((end, y - 3.5), (end, y + 3.5), (paint, 1.6));
    }
    sheet.disc((axis.inside(mean), y), 4.0, paint);
}

fn key(sheet: &mut Sheet, designs: &[&str], left: f64) {
    let mut x = left;
    for (index, design) in designs.iter().enumerate() {
        let paint = Paint::solid(series(index));
        sheet.line((x, 11.0), (x + 22.0, 11.0), (paint, 2.2));
        sheet.disc((x + 11.0, 11.0), 4.0, paint);
        sheet.text(design, (x + 28.0, 11.0), note(Anchor::Start));
        x += 44.0 + text::width(design, 12.0);
    }
}
