use super::input::{Map, Purpose, TrackStyle};
use super::legend_entries::{self, Entry, Sample};
use super::view::{self, LABEL};
use super::{colours, marks, spots};
use crate::figures::svg::{Anchor, Lettering, Look, Paint, Path, Point, Sheet};

/// Width of the legend's column \[px\].
pub(crate) const WIDTH: f64 = 290.0;
const LINE: f64 = 22.0;
const HEADING: f64 = 23.0;
const GAP: f64 = 8.0;
const LEFT: f64 = view::WIDTH + 10.0;
const TOP: f64 = 4.0;
/// Half the size of the chip next to a label [px].
const CHIP: (f64, f64) = (17.0, 7.5);

/// The legend, in sections, next to the map.
pub(crate) struct Legend {
    sections: Vec<(&'static str, Vec<Entry>)>,
}

impl Legend {
    pub(crate) fn new(map: &Map) -> Self {
        let sections = [
            ("Maneuvers", legend_entries::maneuvers(map)),
            ("Track", legend_entries::tracks(map)),
            ("Chart", legend_entries::chart(map)),
        ];
        Self { sections: sections.into_iter().filter(|(_, entries)| !entries.is_empty()).collect() }
    }

    pub(crate) fn height(&self) -> f64 {
        TOP + self.sections.iter().map(|(_, entries)| height(entries)).sum::<f64>()
    }

    pub(crate) fn draw(&self, sheet: &mut Sheet) {
        let mut top = TOP;
        for (heading, entries) in &self.sections {
            let letters = Lettering::new(LABEL, Anchor::Start).painted(Paint::ink(1.0)).bold();
            sheet.text(heading, (LEFT, top + 0.45 * HEADING), letters);
            for (index, (sample, label)) in entries.iter().enumerate() {
                let y = top + HEADING + LINE * (index as f64 + 0.45);
                draw_sample(sheet, *sample, (LEFT + CHIP.0, y));
                let letters = Lettering::new(LABEL, Anchor::Start).painted(Paint::ink(0.9));
                sheet.text(label, (LEFT + 2.0 * CHIP.0 + 8.0, y), letters);
            }
            top += height(entries);
        }
    }
}

fn height(entries: &[Entry]) -> f64 {
    HEADING + entries.len() as f64 * LINE + GAP
}

/// A chip with the sample that the label explains.
fn draw_sample(sheet: &mut Sheet, sample: Sample, at: Point) {
    let (corner, opposite) = ((at.0 - CHIP.0, at.1 - CHIP.1), (at.0 + CHIP.0, at.1 + CHIP.1));
    let mut chip = |look| sheet.bar(corner, opposite, look);
    match sample {
        Sample::Land => chip(colours::LAND),
        Sample::NoGo => chip(colours::NO_GO),
        Sample::Background { uncharted } => chip(edged(colours::background(uncharted))),
        Sample::Depth { band, bands } => chip(edged(colours::depth(band, bands))),
        _ => chip(colours::depth(0, 1)),
    }
    let within = ((corner.0 + 3.0, at.1 - 4.0), (opposite.0 - 3.0, at.1 + 4.0));
    match sample {
        Sample::Track(style) => track(sheet, style, at),
        Sample::Hull => sheet.path(&hull(at), colours::HULL),
        Sample::Start => sheet.disc(at, marks::START, colours::START),
        Sample::Goal => sheet.disc(at, 0.9 * marks::GOAL, colours::GOAL),
        Sample::Margin(purpose) => margin(sheet, purpose, corner, opposite),
        Sample::Danger => spots::danger(sheet, at),
        Sample::Tube => sheet.bar(within.0, within.1, colours::TUBE),
        Sample::Corridor => sheet.bar(within.0, within.1, colours::CORRIDOR),
        Sample::Edge => sheet.bar(within.0, within.1, colours::EDGE),
        Sample::SpeedLimit => {
            sheet.bar(within.0, within.1, colours::SPEED_LIMIT);
        }
        Sample::Contour => sheet.line((within.0.0, at.1), (within.1.0, at.1), colours::CONTOUR),
        Sample::Sounding => {
            let letters = Lettering::new(9.0, Anchor::Middle).painted(colours::DEPTH_DIGITS);
            sheet.text("7.4", at, letters);
        }
        _ => {}
    }
}

/// With a fine border, for a fill as pale as the page.
fn edged(look: Look) -> Look {
    look.outlined(colours::DARK.faded(0.35), 0.6)
}

fn track(sheet: &mut Sheet, style: TrackStyle, (x, y): Point) {
    let ends = ((x - CHIP.0 + 3.0, y), (x + CHIP.0 - 3.0, y));
    let (look, within) = match style {
        TrackStyle::Maneuver(index) => colours::maneuver(index),
        TrackStyle::Basic => (colours::BASIC, None),
        TrackStyle::RunIn => (colours::RUN_IN, None),
        TrackStyle::Realization => return sheaf(sheet, (x, y)),
    };
    [Some(look), within].into_iter().flatten().for_each(|look| sheet.line(ends.0, ends.1, look));
}

/// A few realizations that spread.
fn sheaf(sheet: &mut Sheet, (x, y): Point) {
    for k in -3..=3 {
        let spread = 1.6 * f64::from(k);
        let ends = ((x - CHIP.0 + 3.0, y + 0.3 * spread), (x + CHIP.0 - 3.0, y + spread));
        sheet.line(ends.0, ends.1, colours::realization(20));
    }
}

/// A hull that heads east.
fn hull((x, y): Point) -> Path {
    let mut path = Path::default();
    path.ring(&[
        (x - 11.0, y - 3.0),
        (x + 6.0, y - 3.0),
        (x + 12.0, y),
        (x + 6.0, y + 3.0),
        (x - 11.0, y + 3.0),
    ]);
    path
}

fn margin(sheet: &mut Sheet, purpose: Purpose, corner: Point, opposite: Point) {
    if purpose == Purpose::Trial {
        let height = opposite.1 - corner.1;
        for k in 0..4 {
            let x = corner.0 + f64::from(k) * 6.3;
            sheet.line((x, opposite.1), (x + height, corner.1), colours::HATCH);
        }
    }
    sheet.bar(corner, opposite, colours::margin(purpose));
}
