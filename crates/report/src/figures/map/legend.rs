use crate::figures::map::areas::{MOST_REALIZATIONS, band, bands};
use crate::figures::map::input::{self, Class, Map, Purpose, Symbol, TrackStyle};
use crate::figures::map::spots;
use crate::figures::map::view::{self, LABEL};
use crate::figures::svg::{Anchor, Lettering, Look, Paint, Path, Point, Sheet};
use crate::figures::text;

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
    sections: Vec<(&'static str, Vec<LegendEntry>)>,
}

impl Legend {
    pub(crate) fn new(map: &Map) -> Self {
        let sections = [("Maneuvers", maneuvers(map)), ("Track", tracks(map)), ("Chart", chart(map))];
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

fn height(entries: &[LegendEntry]) -> f64 {
    HEADING + entries.len() as f64 * LINE + GAP
}

/// A chip with the sample that the label explains.
fn draw_sample(sheet: &mut Sheet, sample: Sample, at: Point) {
    let (corner, opposite) = ((at.0 - CHIP.0, at.1 - CHIP.1), (at.0 + CHIP.0, at.1 + CHIP.1));
    let mut chip = |look| sheet.bar(corner, opposite, look);
    match sample {
        Sample::Land => chip(input::LAND),
        Sample::NoGo => chip(input::NO_GO),
        Sample::Background { uncharted } => chip(edged(input::background(uncharted))),
        Sample::Depth { band, bands } => chip(edged(input::depth(band, bands))),
        _ => chip(input::depth(0, 1)),
    }
    let within = ((corner.0 + 3.0, at.1 - 4.0), (opposite.0 - 3.0, at.1 + 4.0));
    match sample {
        Sample::Track(style) => track(sheet, style, at),
        Sample::Hull => sheet.path(&hull(at), input::HULL),
        Sample::Start => sheet.disc(at, spots::START, input::START),
        Sample::Goal => sheet.disc(at, 0.9 * spots::GOAL, input::GOAL),
        Sample::Margin(purpose) => margin(sheet, purpose, corner, opposite),
        Sample::Danger => spots::danger(sheet, at),
        Sample::Tube => sheet.bar(within.0, within.1, input::TUBE),
        Sample::Corridor => sheet.bar(within.0, within.1, input::CORRIDOR),
        Sample::Abort => sheet.line((within.0.0, at.1), (within.1.0, at.1), input::ABORT),
        Sample::Edge => sheet.bar(within.0, within.1, input::EDGE),
        Sample::SpeedLimit => sheet.bar(within.0, within.1, input::SPEED_LIMIT),
        Sample::Contour => sheet.line((within.0.0, at.1), (within.1.0, at.1), input::CONTOUR),
        Sample::Sounding => {
            let letters = Lettering::new(9.0, Anchor::Middle).painted(input::DEPTH_DIGITS);
            sheet.text("7.4", at, letters);
        }
        _ => {}
    }
}

/// With a fine border, for a fill as pale as the page.
fn edged(look: Look) -> Look {
    look.outlined(input::DARK.faded(0.35), 0.6)
}

fn track(sheet: &mut Sheet, style: TrackStyle, (x, y): Point) {
    let ends = ((x - CHIP.0 + 3.0, y), (x + CHIP.0 - 3.0, y));
    let (look, within) = match style {
        TrackStyle::Maneuver(index) => input::maneuver(index),
        TrackStyle::Basic => (input::BASIC, None),
        TrackStyle::RunIn => (input::RUN_IN, None),
        TrackStyle::Realization => return sheaf(sheet, (x, y)),
    };
    [Some(look), within].into_iter().flatten().for_each(|look| sheet.line(ends.0, ends.1, look));
}

/// A few realizations that spread.
fn sheaf(sheet: &mut Sheet, (x, y): Point) {
    for k in -3..=3 {
        let spread = 1.6 * f64::from(k);
        let ends = ((x - CHIP.0 + 3.0, y + 0.3 * spread), (x + CHIP.0 - 3.0, y + spread));
        sheet.line(ends.0, ends.1, input::realization(20));
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
            sheet.line((x, opposite.1), (x + height, corner.1), input::HATCH);
        }
    }
    sheet.bar(corner, opposite, input::margin(purpose));
}

/// The sample next to a label of the legend.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sample {
    Track(TrackStyle),
    Hull,
    Start,
    Goal,
    Land,
    NoGo,
    Depth { band: usize, bands: usize },
    Background { uncharted: bool },
    Margin(Purpose),
    Danger,
    Sounding,
    Contour,
    Tube,
    Corridor,
    Abort,
    Edge,
    SpeedLimit,
}

/// A line of a legend.
type LegendEntry = (Sample, String);

/// The samples that the map has, with their labels.
fn present<const N: usize>(all: [(bool, Sample, &str); N]) -> impl Iterator<Item = LegendEntry> {
    all.into_iter().filter(|(is, ..)| *is).map(|(_, sample, label)| (sample, label.to_owned()))
}

/// Every maneuver, with its number of uses.
fn maneuvers(map: &Map) -> Vec<LegendEntry> {
    let entries = map.maneuvers.iter().enumerate();
    entries
        .map(|(k, (name, count))| {
            let count = format!(" × {count}");
            let name = text::shortened(name, 29_usize.saturating_sub(count.chars().count()));
            (Sample::Track(TrackStyle::Maneuver(k)), name + &count)
        })
        .collect()
}

/// Every other kind of line, and the marks.
fn tracks(map: &Map) -> Vec<LegendEntry> {
    let count = |style| map.tracks.iter().filter(|track| track.style == style).count();
    let realizations = match count(TrackStyle::Realization) {
        many if many > MOST_REALIZATIONS => format!("Monte Carlo, {MOST_REALIZATIONS} of {many}"),
        few => format!("Monte Carlo, {few}"),
    };
    let lines = [
        (TrackStyle::Basic, "basic move".to_owned()),
        (TrackStyle::RunIn, "run-in".to_owned()),
        (TrackStyle::Realization, realizations),
    ];
    let lines = lines.into_iter().filter(|(style, _)| count(*style) > 0);
    let mut entries: Vec<LegendEntry> = lines.map(|(style, label)| (Sample::Track(style), label)).collect();
    let swept = map.tube.iter().map(|tube| (Sample::Tube, format!("swept by {} vessels", tube.vessels)));
    entries.extend(swept);
    let marks = [
        (!map.corridors.is_empty(), Sample::Corridor, "corridor (XTD)"),
        (!map.aborts.is_empty(), Sample::Abort, "abort track"),
        (!map.hulls.is_empty(), Sample::Hull, "hull"),
        (map.start.is_some(), Sample::Start, "start"),
        (map.goal.is_some(), Sample::Goal, "goal"),
    ];
    entries.extend(present(marks));
    entries
}

/// Every class of the chart on the map.
fn chart(map: &Map) -> Vec<LegendEntry> {
    let limits = &map.depth_limits_m;
    let bands = bands(limits);
    let classes = || {
        let cells = map.cells.iter().flat_map(|cells| &cells.classes).flatten();
        map.areas.iter().map(|area| &area.class).chain(cells)
    };
    let shade = |class: &Class| match class {
        Class::Depth { least_m } => Some(band(*least_m, limits)),
        _ => None,
    };
    let spots = |symbol| map.spots.iter().any(|spot| spot.symbol == symbol);
    let margin = |purpose| map.margins.iter().any(|margin| margin.purpose == purpose);
    let dangers = [
        (classes().any(|class| *class == Class::Land), Sample::Land, "land"),
        (classes().any(|class| *class == Class::NoGo), Sample::NoGo, "no-go"),
        (spots(Symbol::Danger), Sample::Danger, "danger, depth over it [m]"),
        (spots(Symbol::Sounding), Sample::Sounding, "sounding [m]"),
        (!map.contours.is_empty(), Sample::Contour, "depth contour [m]"),
        (margin(Purpose::Transit), Sample::Margin(Purpose::Transit), "safety margin, transit"),
        (margin(Purpose::Trial), Sample::Margin(Purpose::Trial), "safety margin, trial"),
    ];
    let mut entries: Vec<LegendEntry> = present(dangers).collect();
    let charted = (0..bands).filter(|band| classes().any(|class| shade(class) == Some(*band)));
    entries.extend(charted.map(|band| (Sample::Depth { band, bands }, depth(band, limits))));
    let background = if map.uncharted { "not charted" } else { "water, no depth charted" };
    let outlines = [
        (!map.edge.is_empty(), Sample::Edge, "edge of the area"),
        (!map.speed_limits.is_empty(), Sample::SpeedLimit, "speed limit"),
    ];
    entries.extend(present(outlines));
    entries.push((Sample::Background { uncharted: map.uncharted }, background.to_owned()));
    entries
}

/// `least depth below 5 m`, `least depth 5–10 m`, `least depth 10 m and more`.
fn depth(band: usize, limits: &[f64]) -> String {
    let metres = |value: f64| format!("{value}").replace('-', "−");
    let above = band.checked_sub(1).map(|below| metres(limits[below]));
    match (above, limits.get(band).map(|limit| metres(*limit))) {
        (None, None) => "charted water".to_owned(),
        (None, Some(to)) => format!("least depth below {to} m"),
        (Some(from), Some(to)) => format!("least depth {from}–{to} m"),
        (Some(from), None) => format!("least depth {from} m and more"),
    }
}
