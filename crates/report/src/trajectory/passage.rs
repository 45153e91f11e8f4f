use maud::{Markup, html};

use super::words::{clock, heading, knots, latitude, longitude, miles, minutes};
use crate::number::{or_dash, three};
use study::documents::{Passage, PassageLeg};

/// The passage plan, to be printed for the bridge.
pub(super) fn passage(passage: &Passage) -> Markup {
    let with_depth = passage.legs.iter().any(|leg| leg.least_depth_m.is_some());
    let under_keel = passage.legs.iter().any(|leg| leg.under_keel_m.is_some());
    let depth_head = if under_keel { ["Under keel", "[m]"] } else { ["Least depth", "[m]"] };
    html! {
        @if !passage.legs.is_empty() {
            div.crew {
                h3 { "Passage plan" }
                p.note {
                    "Waypoints are those of the route files: where the course or what is done changes, and where the courses of a turn cross. \
                     Courses are true, along loxodromes. XTD is as far as the simulated tracks of the check come to port and to starboard of \
                     the line; radii are those that the ship turns with. \
                     Depths and the nearest danger are those along the nominal track; the doubt about a danger's place is taken off. "
                    @match &passage.departure {
                        Some(departure) => { "Times count from the departure at " (departure) "." }
                        None => {
                            "Times count from the departure; say it in " code { "plan.toml" } " for times of day in the route files."
                        }
                    }
                    @if let Some(tide) = &passage.tide {
                        " Charted depths count with a tide of " (three(tide.level_m)) "\u{a0}m, its least over the "
                        (minutes(tide.slot_s)) " of the slot."
                    }
                }
                div.scroll { table.compact.tight.sheet {
                    thead {
                        tr {
                            th scope="col" { "To" }
                            th scope="col" { "Position" }
                            th.number scope="col" { "Course" }
                            th.number scope="col" { "Distance" br; "[NM]" }
                            th.number scope="col" { "Speed" br; "[kn]" }
                            th scope="col" { "Time" br; "h:min:s" }
                            th.number scope="col" { "XTD [m]" br; "port, starb." }
                            th.number scope="col" { "Radius" br; "[m]" }
                            @if with_depth { th.number scope="col" { (depth_head[0]) br; (depth_head[1]) } }
                            th scope="col" { "Nearest danger" }
                            th scope="col" { "What" }
                        }
                    }
                    tbody {
                        tr {
                            th scope="row" { "0" }
                            (place(passage.latitude_deg, passage.longitude_deg))
                            td colspan="3" { "" }
                            td.time { (clock(0.0)) (stay(0.0, passage.leave_s)) }
                            td colspan=(if with_depth { 4 } else { 3 }) { "" }
                            td.wrap { (passage.before.join(", ")) }
                        }
                        @for (index, leg) in passage.legs.iter().enumerate() { (line(index + 1, leg, with_depth)) }
                    }
                } }
            }
        }
    }
}

fn line(number: usize, leg: &PassageLeg, with_depth: bool) -> Markup {
    let what: Vec<&str> = std::iter::once(&leg.what).chain(&leg.then).map(String::as_str).collect();
    html! {
        tr.informative[leg.informative] {
            th scope="row" { (number) }
            (place(leg.latitude_deg, leg.longitude_deg))
            td.number { (heading(leg.course_deg)) }
            td.number { (miles(leg.distance_m)) }
            td.number { (knots(leg.speed_m_s)) }
            td.time { (clock(leg.end_s)) (stay(leg.end_s, leg.leave_s)) }
            td.number { (metres(leg.xtd_port_m)) ", " (metres(leg.xtd_starboard_m)) }
            td.number { (or_dash(leg.turn_radius_m.map(metres))) }
            @if with_depth { td.number { (or_dash(leg.under_keel_m.or(leg.least_depth_m).map(tenths))) } }
            td.danger { (nearest(leg)) }
            td.wrap { (what.join(", ")) }
        }
    }
}

/// When the ship goes on, if that is later than when she arrives.
fn stay(end_s: f64, leave_s: f64) -> Markup {
    html! { @if leave_s > end_s { br; "on at " (clock(leave_s)) } }
}

fn place(latitude_deg: f64, longitude_deg: f64) -> Markup {
    html! { td.place { (latitude(latitude_deg)) br; (longitude(longitude_deg)) } }
}

fn nearest(leg: &PassageLeg) -> String {
    let nearest = leg.nearest.as_ref().map(|nearest| {
        let (what, distance_m) = (&nearest.what, nearest.distance_m.floor());
        format!("{what}, {distance_m:.0} m, bearing {}", heading(nearest.bearing_deg))
    });
    or_dash(nearest)
}

/// Rounds down to a tenth, so that water is never reported too deep.
fn tenths(value: f64) -> String {
    or_dash(value.is_finite().then(|| format!("{:.1}", (value * 10.0).floor() / 10.0)))
}

/// Rounds up to a metre, so that a corridor is never reported too narrow.
fn metres(value: f64) -> String {
    or_dash(value.is_finite().then(|| format!("{:.0}", value.ceil())))
}
