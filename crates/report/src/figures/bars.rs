use super::axis::{BASE, COLUMN, LABEL, Rows, note};
use crate::figures::axis::Axis;
use crate::figures::palette::BLUE;
use crate::figures::svg::{Anchor, Lettering, Paint, Sheet};
use crate::figures::text::percent;

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

const ROW: f64 = 32.0;
const OURS: f64 = 13.0;
const PUBLISHED: f64 = 9.0;

/// Horizontal bars of the shares; published shares as outlined bars below ours.
pub fn shares(rows: &[ShareRow<'_>]) -> String {
    let layout = Rows::new(rows.iter().map(|row| row.name), ROW, 58.0);
    let published = rows.iter().any(|row| row.published.is_some());
    Sheet::figure(COLUMN, layout.height(), "Optimal share of the experiment time per maneuver", |sheet| {
        let (left, right) = layout.span();
        let axis = Axis::linear(0.0, 100.0 * greatest(rows), left, right);
        layout.draw(sheet, &axis, &axis.ticks(5), "share of the experiment time [%]");
        sheet.line((left, layout.top()), (left, layout.bottom()), (BASE, 1.0));
        for (index, row) in rows.iter().enumerate() {
            draw_row(sheet, &axis, layout.middle(index), row, published);
        }
        key(sheet, left, published);
    })
}

fn greatest(rows: &[ShareRow<'_>]) -> f64 {
    let both = rows.iter().flat_map(|row| [Some(row.share), row.published]).flatten();
    both.filter(|share| share.is_finite()).fold(0.05, f64::max)
}

fn draw_row(sheet: &mut Sheet, axis: &Axis, middle: f64, row: &ShareRow<'_>, published: bool) {
    let lift = if published { 0.5 * PUBLISHED } else { 0.0 };
    if row.share.is_finite() {
        bar(sheet, axis, middle - lift, row.share);
    }
    if let Some(share) = row.published.filter(|share| *share > 0.0 && share.is_finite()) {
        outline(sheet, axis, middle - lift + 0.5 * OURS + 0.5, share);
    }
}

fn bar(sheet: &mut Sheet, axis: &Axis, middle: f64, share: f64) {
    let (from, to) = (axis.at(0.0), axis.inside(100.0 * share));
    sheet.bar((from, middle - 0.5 * OURS), (to, middle + 0.5 * OURS), Paint::solid(BLUE));
    let (label, weight) =
        if share < 5e-4 { ("0".to_owned(), note(Anchor::Start)) } else { (percent(share), value()) };
    sheet.text(&label, (to + 5.0, middle), weight);
}

fn value() -> Lettering {
    Lettering::new(LABEL - 1.0, Anchor::Start).bold()
}

fn outline(sheet: &mut Sheet, axis: &Axis, top: f64, share: f64) {
    let end = axis.inside(100.0 * share);
    sheet.bar((axis.at(0.0), top), (end, top + PUBLISHED), (Paint::ink(0.6), 1.2));
}

fn key(sheet: &mut Sheet, left: f64, published: bool) {
    sheet.bar((left, 6.0), (left + 22.0, 16.0), Paint::solid(BLUE));
    sheet.text("here", (left + 28.0, 11.0), note(Anchor::Start));
    if published {
        sheet.bar((left + 76.0, 6.0), (left + 98.0, 16.0), (Paint::ink(0.6), 1.2));
        sheet.text("published", (left + 104.0, 11.0), note(Anchor::Start));
    }
}
