use crate::figures::layout::{LABEL, note};
use crate::figures::palette::Rgb;
use crate::figures::svg::{Anchor, Lettering, Paint, Sheet};

/// One column of the small multiples: a quantity whose vertical axis all rows share.
#[derive(Clone, Debug)]
pub struct TraceColumn<'a> {
    /// Quantity and unit: `surge u [m/s]`.
    pub title: &'a str,
    /// What its curves are called, in order; empty for a single black curve.
    pub legend: Vec<(String, Rgb)>,
}

const TITLE: f64 = 26.0;
const LINE: f64 = 17.0;

/// Height of the titles and legends above the first row \[px\].
pub(crate) fn height(columns: &[TraceColumn<'_>]) -> f64 {
    let lines = columns.iter().map(|column| column.legend.len()).max().unwrap_or(0);
    TITLE + LINE * lines as f64 + 6.0
}

/// Title and legend of one column whose cells begin at pixel `left`.
pub(crate) fn draw(sheet: &mut Sheet, column: &TraceColumn<'_>, left: f64) {
    sheet.text(column.title, (left, 12.0), Lettering::new(LABEL, Anchor::Start).bold());
    for (index, (name, colour)) in column.legend.iter().enumerate() {
        let y = TITLE + LINE * (index as f64 + 0.4);
        sheet.line((left, y), (left + 18.0, y), (Paint::solid(*colour), 2.4));
        sheet.text(name, (left + 24.0, y), note(Anchor::Start));
    }
}
