use crate::figures::axis::{Axis, BASE, COLUMN, LABEL, NamedRows, TOP, Tick, extent, note, round_step};
use crate::figures::palette::{BLUE, series};
use crate::figures::svg::{Anchor, Lettering, Paint, Sheet};
use crate::figures::text::{self, percent};

/// One maneuver's share of the experiment time.
#[derive(Clone, Debug)]
pub struct ShareRow<'a> {
    /// Name of the maneuver.
    pub name: &'a str,
    /// Optimal share, 0 to 1.
    pub share: f64,
    /// Published share, 0 to 1, if there is one.
    pub published: Option<f64>,
}

/// Height of a row of shares or sensitivities, of a bar of ours, and of a published one [px].
const ROW: f64 = 32.0;
const OURS: f64 = 13.0;
const PUBLISHED: f64 = 9.0;

/// Horizontal bars of the shares; published shares as outlined bars below ours.
pub fn shares(rows: &[ShareRow<'_>]) -> String {
    let layout = NamedRows::new(rows.iter().map(|row| row.name), ROW, 58.0);
    let published = rows.iter().any(|row| row.published.is_some());
    Sheet::figure(COLUMN, layout.height(), "Optimal share of the experiment time per maneuver", |sheet| {
        let (left, right) = layout.span();
        let both = rows.iter().flat_map(|row| [Some(row.share), row.published]).flatten();
        let greatest = both.filter(|share| share.is_finite()).fold(0.05, f64::max);
        let axis = Axis::linear(0.0, 100.0 * greatest, left, right);
        layout.draw(sheet, &axis, &axis.ticks(5), "share of the experiment time [%]");
        sheet.line((left, TOP), (left, layout.bottom()), (BASE, 1.0));
        for (index, row) in rows.iter().enumerate() {
            draw_row(sheet, &axis, layout.middle(index), row, published);
        }
        key(sheet, left, published);
    })
}

fn draw_row(sheet: &mut Sheet, axis: &Axis, middle: f64, row: &ShareRow<'_>, published: bool) {
    let lift = if published { 0.5 * PUBLISHED } else { 0.0 };
    if row.share.is_finite() {
        bar(sheet, axis, middle - lift, row.share);
    }
    if let Some(share) = row.published.filter(|share| *share > 0.0 && share.is_finite()) {
        let (top, end) = (middle - lift + 0.5 * OURS + 0.5, axis.inside(100.0 * share));
        sheet.bar((axis.at(0.0), top), (end, top + PUBLISHED), (Paint::ink(0.6), 1.2));
    }
}

fn bar(sheet: &mut Sheet, axis: &Axis, middle: f64, share: f64) {
    let (from, to) = (axis.at(0.0), axis.inside(100.0 * share));
    sheet.bar((from, middle - 0.5 * OURS), (to, middle + 0.5 * OURS), Paint::solid(BLUE));
    let (label, weight) = match share < 5e-4 {
        true => ("0".to_owned(), note(Anchor::Start)),
        false => (percent(share), Lettering::new(LABEL - 1.0, Anchor::Start).bold()),
    };
    sheet.text(&label, (to + 5.0, middle), weight);
}

fn key(sheet: &mut Sheet, left: f64, published: bool) {
    sheet.bar((left, 6.0), (left + 22.0, 16.0), Paint::solid(BLUE));
    sheet.text("here", (left + 28.0, 11.0), note(Anchor::Start));
    if published {
        sheet.bar((left + 76.0, 6.0), (left + 98.0, 16.0), (Paint::ink(0.6), 1.2));
        sheet.text("published", (left + 104.0, 11.0), note(Anchor::Start));
    }
}

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
    let layout = NamedRows::new(rows.iter().map(|row| row.name), 14.0 + SPACING * designs.len() as f64, 18.0);
    Sheet::figure(COLUMN, layout.height(), "Relative error per parameter, mean and spread", |sheet| {
        let (left, right) = layout.span();
        let axis = Axis::symmetric(most(rows), LINEAR, left, right);
        layout.draw(sheet, &axis, &ticks(&axis), "relative error of the estimates [%]");
        let zero = axis.at(0.0);
        sheet.line((zero, TOP), (zero, layout.bottom()), (Paint::ink(0.7), 1.2));
        for (index, row) in rows.iter().enumerate() {
            draw_error_row(sheet, &axis, layout.middle(index), row);
        }
        key_of_designs(sheet, designs, left);
    })
}

/// Half-width of the axis: the farthest whisker, rounded up to 1, 2 or 5 times a power of ten.
fn most(rows: &[ErrorRow<'_>]) -> f64 {
    let errors = rows.iter().flat_map(|row| row.errors.iter().flatten());
    let ends = errors.map(|(mean, spread)| mean.abs() + spread.abs());
    let farthest = ends.filter(|end| end.is_finite()).fold(LINEAR, f64::max);
    round_step(farthest.min(1e9))
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

fn draw_error_row(sheet: &mut Sheet, axis: &Axis, middle: f64, row: &ErrorRow<'_>) {
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

fn key_of_designs(sheet: &mut Sheet, designs: &[&str], left: f64) {
    let mut x = left;
    for (index, design) in designs.iter().enumerate() {
        let paint = Paint::solid(series(index));
        sheet.line((x, 11.0), (x + 22.0, 11.0), (paint, 2.2));
        sheet.disc((x + 11.0, 11.0), 4.0, paint);
        sheet.text(design, (x + 28.0, 11.0), note(Anchor::Start));
        x += 44.0 + text::width(design, 12.0);
    }
}

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

/// What a label beside a dot takes of the width.
const LABEL_WIDTH: f64 = 40.0;

/// Dots of the sensitivities against the line at `dimension` that a maneuver in use touches. The rows are as high as
/// those of [`super::shares`], so that the two figures match side by side.
pub fn sensitivities(rows: &[SensitivityRow<'_>], dimension: f64) -> String {
    let layout = NamedRows::new(rows.iter().map(|row| row.name), ROW, 24.0);
    Sheet::figure(COLUMN, layout.height(), "Sensitivity per maneuver", |sheet| {
        let axis = axis(rows, dimension, layout.span());
        layout.draw(sheet, &axis, &axis.ticks(6), "sensitivity g [1]");
        let x = axis.at(dimension);
        sheet.line((x, TOP - 5.0), (x, layout.bottom()), (Paint::ink(0.8), 1.4));
        let label = format!("worth its time: g = p = {}", text::number(dimension, 1.0));
        sheet.text(&label, (x + 2.0, 11.0), note(Anchor::End));
        for (index, row) in rows.iter().enumerate() {
            draw_sensitivity_row(sheet, &axis, layout.middle(index), row, dimension);
        }
    })
}

fn axis(rows: &[SensitivityRow<'_>], dimension: f64, (left, right): (f64, f64)) -> Axis {
    let values = rows.iter().map(|row| row.sensitivity).chain([0.0, dimension]);
    let (low, high) = extent(values).unwrap_or((0.0, 1.0));
    let air = 0.06 * (high - low);
    Axis::linear(if low < 0.0 { low - air } else { 0.0 }, high + air, left, right)
}

fn draw_sensitivity_row(sheet: &mut Sheet, axis: &Axis, y: f64, row: &SensitivityRow<'_>, dimension: f64) {
    let x = axis.at(row.sensitivity);
    if row.used {
        sheet.disc((x, y), 5.5, Paint::solid(BLUE));
    } else {
        sheet.line((x, y), (axis.at(dimension), y), (Paint::ink(0.35), 1.0));
        sheet.disc((x, y), 4.8, (Paint::solid(BLUE), 1.6));
        let label = text::number(row.sensitivity, 0.1);
        // Beside the dot, or above the line where there is no room before the names.
        let is_far_left = x - axis.at(0.0) < LABEL_WIDTH;
        let (place, anchor) =
            if is_far_left { ((x + 8.0, y - 8.0), Anchor::Start) } else { ((x - 10.0, y), Anchor::End) };
        sheet.text(&label, place, note(anchor));
    }
}
