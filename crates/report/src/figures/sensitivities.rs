use super::axis::{COLUMN, Rows, note};
use crate::figures::axis::{Axis, extent};
use crate::figures::palette::BLUE;
use crate::figures::svg::{Anchor, Paint, Sheet};
use crate::figures::text;

/// One maneuver's sensitivity.
#[derive(Clone, Debug)]
pub struct SensitivityRow<'a> {
    /// Name of the maneuver.
    pub name: &'a str,
    /// g_q = tr(M(w)⁻¹ M_q).
    pub sensitivity: f64,
    /// Whether the design spends time on it.
    pub used: bool,
}

const ROW: f64 = 32.0;

/// What a label beside a dot takes of the width.
const LABEL: f64 = 40.0;

/// Dots of the sensitivities against the line at `dimension` that a maneuver in use touches. The rows are as high as
/// those of [`super::shares`], so that the two figures match side by side.
pub fn sensitivities(rows: &[SensitivityRow<'_>], dimension: f64) -> String {
    let layout = Rows::new(rows.iter().map(|row| row.name), ROW, 24.0);
    Sheet::figure(COLUMN, layout.height(), "Sensitivity per maneuver", |sheet| {
        let axis = axis(rows, dimension, layout.span());
        layout.draw(sheet, &axis, &axis.ticks(6), "sensitivity g [1]");
        threshold(sheet, &layout, axis.at(dimension), dimension);
        for (index, row) in rows.iter().enumerate() {
            draw_row(sheet, &axis, layout.middle(index), row, dimension);
        }
    })
}

fn axis(rows: &[SensitivityRow<'_>], dimension: f64, (left, right): (f64, f64)) -> Axis {
    let values = rows.iter().map(|row| row.sensitivity).chain([0.0, dimension]);
    let (low, high) = extent(values).unwrap_or((0.0, 1.0));
    let air = 0.06 * (high - low);
    Axis::linear(if low < 0.0 { low - air } else { 0.0 }, high + air, left, right)
}

fn threshold(sheet: &mut Sheet, layout: &Rows, x: f64, dimension: f64) {
    sheet.line((x, layout.top() - 5.0), (x, layout.bottom()), (Paint::ink(0.8), 1.4));
    let label = format!("worth its time: g = p = {}", text::number(dimension, 1.0));
    sheet.text(&label, (x + 2.0, 11.0), note(Anchor::End));
}

fn draw_row(sheet: &mut Sheet, axis: &Axis, y: f64, row: &SensitivityRow<'_>, dimension: f64) {
    let x = axis.at(row.sensitivity);
    if row.used {
        sheet.disc((x, y), 5.5, Paint::solid(BLUE));
    } else {
        sheet.line((x, y), (axis.at(dimension), y), (Paint::ink(0.35), 1.0));
        sheet.disc((x, y), 4.8, (Paint::solid(BLUE), 1.6));
        let label = text::number(row.sensitivity, 0.1);
        // Beside the dot, or above the line where there is no room before the names.
        let is_far_left = x - axis.at(0.0) < LABEL;
        let (place, anchor) =
            if is_far_left { ((x + 8.0, y - 8.0), Anchor::Start) } else { ((x - 10.0, y), Anchor::End) };
        sheet.text(&label, place, note(anchor));
    }
}
