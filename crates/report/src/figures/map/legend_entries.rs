use super::areas::{band, bands};
use super::input::{Class, Map, Purpose, Symbol, TrackStyle};
use super::tracks::MOST_REALIZATIONS;
use crate::figures::text;

/// The sample next to a label of the legend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Sample {
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
    Edge,
    SpeedLimit,
}

/// A line of a legend.
pub(crate) type Entry = (Sample, String);

/// Every maneuver, with its number of uses.
pub(crate) fn maneuvers(map: &Map) -> Vec<Entry> {
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
pub(crate) fn tracks(map: &Map) -> Vec<Entry> {
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
    let present = lines.into_iter().filter(|(style, _)| count(*style) > 0);
    let mut entries: Vec<Entry> = present.map(|(style, label)| (Sample::Track(style), label)).collect();
    let swept = map.tube.iter().map(|tube| (Sample::Tube, format!("swept by {} vessels", tube.vessels)));
    entries.extend(swept);
    let marks = [
        (!map.corridors.is_empty(), Sample::Corridor, "corridor (XTD)"),
        (!map.hulls.is_empty(), Sample::Hull, "hull"),
        (map.start.is_some(), Sample::Start, "start"),
        (map.goal.is_some(), Sample::Goal, "goal"),
    ];
    let present = marks.into_iter().filter(|mark| mark.0);
    entries.extend(present.map(|(_, sample, label)| (sample, label.to_owned())));
    entries
}

/// Every class of the chart on the map.
pub(crate) fn chart(map: &Map) -> Vec<Entry> {
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
    let dangers = dangers.into_iter().filter(|danger| danger.0);
    let mut entries: Vec<Entry> = dangers.map(|(_, sample, label)| (sample, label.to_owned())).collect();
    let charted = (0..bands).filter(|band| classes().any(|class| shade(class) == Some(*band)));
    entries.extend(charted.map(|band| (Sample::Depth { band, bands }, depth(band, limits))));
    let background = if map.uncharted { "not charted" } else { "water, no depth charted" };
    let outlines = [
        (!map.edge.is_empty(), Sample::Edge, "edge of the area"),
        (!map.speed_limits.is_empty(), Sample::SpeedLimit, "speed limit"),
    ];
    let outlines = outlines.into_iter().filter(|outline| outline.0);
    entries.extend(outlines.map(|(_, sample, label)| (sample, label.to_owned())));
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
