use maud::{Markup, html};
use study::documents::{FigureMerit, ManeuverMerit, MeritDocument};

use crate::figures::{Curve, TraceColumn, TraceRow, TrackCell, TrackLine, palette, traces, tracks};
use crate::number::{interval, or_dash, three};
use crate::parts::{Figures, HtmlTable, Section, grouped};
use crate::study::Study;

/// Figures of merit of the standard maneuvers; none in a study without.
pub(super) fn merit(study: &Study, figures: &mut Figures) -> Option<Section> {
    // Logs may show no standard maneuver.
    let merit =
        study.merit.as_ref().filter(|merit| merit.maneuvers.iter().any(|maneuver| maneuver.runs > 0))?;
    let caption = html! {
        b { "Track of every standard maneuver, the first run." }
        " Up is the course of the approach, right is starboard; the dot marks the start."
    };
    let tracks = tracks_of(&merit.maneuvers.iter().collect::<Vec<_>>(), merit.length_m);
    let body = html! {
        (table(merit))
        (figures.place_wide("merit-tracks", tracks, &caption))
        (over_time(merit, figures))
    };
    Some(Section::new("merit", "Figures of merit", "Figures of merit", body))
}

fn table(found: &MeritDocument) -> Markup {
    let table = HtmlTable::of(grouped(&found.maneuvers, |maneuver| &maneuver.figures))
        .mark("first", |(first, ..)| first)
        .name("Maneuver", |(first, maneuver, _)| if first { maneuver.name.as_str() } else { "" })
        .text("Figure", |(.., figure)| &figure.what)
        .number("Value", |(.., figure)| value(figure.value, figure))
        .number("Without current", |(.., figure)| {
            or_dash(figure.corrected.map(|corrected| value(corrected, figure)))
        })
        .number("95 % interval", |(.., figure)| {
            interval(figure.low.zip(figure.high).map(|(low, high)| [low, high]))
        })
        .number("IMO allows", |(.., figure)| or_dash(figure.most.map(three)))
        .text("Verdict", |(.., figure)| verdict(figure));
    let of = match found.intervals.as_str() {
        "parameters" => "Intervals hold 95 % of the ships that the model's parameters leave possible.",
        _ => "Intervals are those of the mean over all runs; a single run has none.",
    };
    html! {
        (table)
        (remarks(found))
        p.note {
            "L: ship lengths of " (three(found.length_m)) " m. Definitions and limits are those of IMO MSC.137(76), which "
            "asks for them at 90 % of the speed of 85 % of the power, in calm deep water. " (of)
            @for (name, lacking) in found.maneuvers.iter().filter_map(|maneuver| Some((&maneuver.name, maneuver.lacking()?))) {
                " " (name) ": " (lacking) "."
            }
        }
    }
}

/// What was sailed, what is to be known of the figures, and what has none.
fn remarks(found: &MeritDocument) -> Markup {
    html! {
        @for maneuver in &found.maneuvers {
            @let sailed = maneuver.sailed.as_ref().map(|sailed| format!("By the log: {sailed}."));
            @let without = maneuver.reason.as_ref().map(|reason| format!("Without figures: {reason}."));
            @let all: Vec<String> = sailed.into_iter().chain(maneuver.remarks.iter().map(|remark| format!("{remark}."))).chain(without).collect();
            @if !all.is_empty() { p.note { b { (maneuver.name) } " " (all.join(" ")) } }
        }
    }
}

fn value(value: f64, figure: &FigureMerit) -> String {
    let unit = if figure.unit == "1" { "" } else { &figure.unit };
    format!("{} {}", three(value), unit.replace("deg", "°")).trim_end().to_owned()
}

fn verdict(figure: &FigureMerit) -> &'static str {
    match (figure.most, figure.passes) {
        (Some(_), Some(true)) => "passes",
        (Some(_), Some(false)) => "fails",
        (Some(_), None) => "open",
        (None, _) => "",
    }
}

/// The track of the first maneuver of each kind.
fn first_tracks(found: &MeritDocument) -> String {
    let mut kinds = Vec::new();
    let first = |maneuver: &&ManeuverMerit| {
        let is_new = !kinds.contains(&maneuver.kind);
        kinds.push(maneuver.kind.clone());
        is_new && !maneuver.track.t_s.is_empty()
    };
    let firsts: Vec<&ManeuverMerit> = found.maneuvers.iter().filter(first).collect();
    tracks_of(&firsts, found.length_m)
}

/// Tracks of maneuvers of a ship of this length \[m\].
fn tracks_of(maneuvers: &[&ManeuverMerit], length_m: f64) -> String {
    let metres = |of: &[f64]| of.iter().map(|lengths| lengths * length_m).collect::<Vec<_>>();
    let placed = |maneuver: &&ManeuverMerit| [metres(&maneuver.track.ahead), metres(&maneuver.track.abeam)];
    let placed: Vec<[Vec<f64>; 2]> = maneuvers.iter().map(placed).collect();
    let drawn = maneuvers.iter().zip(&placed).map(|(maneuver, [x, y])| TrackCell {
        name: &maneuver.name,
        lines: vec![TrackLine { x, y, colour: Some(palette::BLUE) }],
    });
    tracks(&drawn.collect::<Vec<_>>())
}

fn over_time(found: &MeritDocument, figures: &mut Figures) -> Markup {
    let columns = ["heading [°]", "surge speed u [m/s]", "yaw rate r [°/s]"]
        .map(|title| TraceColumn { title, legend: Vec::new() });
    let curve = |values: &Vec<f64>| vec![Curve { values: values.clone(), ..Curve::default() }];
    let rows: Vec<TraceRow<'_>> = found
        .maneuvers
        .iter()
        .map(|ManeuverMerit { name, track, .. }| TraceRow {
            name,
            note: None,
            t: &track.t_s,
            cells: [&track.heading_deg, &track.surge_m_s, &track.yaw_rate_deg_s].map(curve).into(),
        })
        .collect();
    let caption = html! {
        b { "Heading, speed and yaw rate of the same runs." }
        " All rows of a column share one axis."
    };
    figures.place_wide("merit-time", traces(&columns, &rows), &caption)
}

/// Width and height of the map, of histograms of three designs, and the gap between, in units of the picture.
const MAP: [u32; 2] = [1140, 760];
const HISTOGRAM: [u32; 2] = [560, 670];
const GAP: u32 = 20;

/// `map` above, `histograms` side by side below, on white: whole `<svg>` elements as this crate draws them.
pub fn picture(map: &str, histograms: &[&str; 2]) -> String {
    let (width, height) = (MAP[0] + 2 * GAP, MAP[1] + HISTOGRAM[1] + 3 * GAP);
    let below = MAP[1] + 2 * GAP;
    let placed = [
        placed(map, [GAP, GAP], MAP),
        placed(histograms[0], [GAP, below], HISTOGRAM),
        placed(histograms[1], [2 * GAP + HISTOGRAM[0], below], HISTOGRAM),
    ];
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" color=\"#1d242b\">\n\
        <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n{}</svg>\n",
        placed.concat()
    )
}

/// The track of the first maneuver of each kind, on white.
pub fn maneuvers_picture(found: &MeritDocument) -> String {
    let tracks = first_tracks(found);
    let white = |tag: &str| format!("{tag} color=\"#1d242b\" style=\"background: #ffffff\" ");
    tracks.replacen("<svg ", &white("<svg"), 1) + "\n"
}

/// `figure` at a position and size; its `viewBox` scales it.
fn placed(figure: &str, at: [u32; 2], size: [u32; 2]) -> String {
    let place = format!("<svg x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" ", at[0], at[1], size[0], size[1]);
    figure.trim_end().replacen("<svg ", &place, 1) + "\n"
}
