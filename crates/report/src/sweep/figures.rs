//! Figures of a sweep: each quantity against each axis, and over two.

use maud::{Markup, html};
use study::documents::{SweepDocument, SweepLine, SweptCell, SweptLine};

use super::axes::{along, place, places, short};
use crate::figures::{HeatCell, Places, SweptCurve, heat, swept};
use crate::parts::Figures;

/// Panels beyond this many per axis are not drawn.
const MOST: usize = 12;

/// The value of a line of a cell and both ends of its interval.
type Drawn = fn(&SweptLine) -> (f64, [f64; 2]);

/// A quantity that is drawn: its name in files and on the page, and its range.
struct Quantity {
    name: &'static str,
    title: &'static str,
    of: Drawn,
    range: Option<(f64, f64)>,
}

const QUANTITIES: [Quantity; 2] = [
    Quantity {
        name: "share",
        title: "parameter error below its bound [%]",
        of: share,
        range: Some((0.0, 100.0)),
    },
    Quantity { name: "median", title: "median parameter error", of: median, range: None },
];

fn share(line: &SweptLine) -> (f64, [f64; 2]) {
    let share = line.parameter_error_share;
    (100.0 * share.share, share.interval.map_or([f64::NAN; 2], |ends| ends.map(|end| 100.0 * end)))
}

fn median(line: &SweptLine) -> (f64, [f64; 2]) {
    let open = [f64::NEG_INFINITY, f64::INFINITY];
    let [low, high] = line.parameter_error_median_interval;
    (line.parameter_error_median.unwrap_or(f64::NAN), [low.unwrap_or(open[0]), high.unwrap_or(open[1])])
}

/// The label of a line.
pub(super) fn name(line: &SweepLine) -> String {
    format!("{}, {}", line.design, line.estimator)
}

/// Every quantity against every axis: a panel for each choice of the other axes' values.
pub(super) fn against_axes(sweep: &SweepDocument, figures: &mut Figures) -> Markup {
    html! {
        @for axis in (0..sweep.axes.len()).filter(|axis| sweep.axes[*axis].values.len() > 1) {
            h3 { "Against " code { (sweep.axes[axis].key) } }
            (panels(sweep, axis, figures))
        }
    }
}

fn panels(sweep: &SweepDocument, axis: usize, figures: &mut Figures) -> Markup {
    let groups = along(sweep, &[axis]);
    let places = places(&sweep.axes[axis]);
    html! {
        @for (i, group) in groups.iter().take(MOST).enumerate() {
            div.pair {
                @for quantity in &QUANTITIES {
                    (panel(sweep, (axis, i), group, &places, quantity, figures))
                }
            }
        }
        @if groups.len() > MOST {
            p.note { "The first " (MOST) " of " (groups.len()) " choices of the other values are drawn." }
        }
    }
}

fn panel(
    sweep: &SweepDocument,
    (axis, number): (usize, usize),
    group: &[&SweptCell],
    places: &Places,
    quantity: &Quantity,
    figures: &mut Figures,
) -> Markup {
    let curve = |line: &SweepLine| {
        let point = |cell: &&SweptCell| {
            let (value, ends) = (quantity.of)(cell.line(line)?);
            Some((*places.at.get(*cell.at.get(axis)?)?, value, ends))
        };
        SweptCurve { label: name(line), points: group.iter().filter_map(point).collect() }
    };
    let curves: Vec<SweptCurve> = sweep.lines().iter().map(curve).collect();
    let held = group.first().map_or_else(String::new, |cell| place(sweep, &cell.at, &[axis]));
    let caption = html! {
        @if held.is_empty() { b { (quantity.title) } } @else { b { (held) } ": " (quantity.title) }
        ", with 95 % intervals."
    };
    let svg = swept(places, &curves, quantity.title, quantity.range);
    figures.place(&format!("sweep-{}-{axis}-{number}", quantity.name), svg, &caption)
}

/// The share over every two axes, a map for each line.
pub(super) fn maps(sweep: &SweepDocument, figures: &mut Figures) -> Markup {
    let varied: Vec<usize> = (0..sweep.axes.len()).filter(|i| sweep.axes[*i].values.len() > 1).collect();
    let [down, right] = varied[..] else {
        return html! { p.note { "A map is drawn where two keys are varied; here there are " (varied.len()) "." } };
    };
    let (up, across) = (places(&sweep.axes[down]), places(&sweep.axes[right]));
    let short = |places: Places| Places { title: short(sweep, &places.title).to_owned(), ..places };
    let (up, across) = (short(up), short(across));
    html! {
        div.pair {
            @for (i, line) in sweep.lines().iter().enumerate() {
                (figures.place(&format!("sweep-map-{i}"), heat(&across, &up, &cells(sweep, line, [right, down]), &name(line)), &html! {
                    b { "Runs whose parameter error lies below its bound [%]." } " Crossed out: refused."
                }))
            }
        }
    }
}

fn cells(sweep: &SweepDocument, line: &SweepLine, [across, up]: [usize; 2]) -> Vec<HeatCell> {
    let place = |at: &[usize]| Some((*at.get(across)?, *at.get(up)?));
    let counted = sweep.cells.iter().filter_map(|cell| {
        let (i, j) = place(&cell.at)?;
        Some((i, j, Some(cell.line(line)?.parameter_error_share.share)))
    });
    let refused = sweep.refused.iter().filter_map(|cell| place(&cell.at).map(|(i, j)| (i, j, None)));
    counted.chain(refused).collect()
}
