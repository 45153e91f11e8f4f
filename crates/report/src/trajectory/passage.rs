use maud::{Markup, html};

use super::words::{clock, heading, knots, latitude, longitude, miles, minutes};
use crate::number::{or_dash, three};
use study::documents::{Passage, PassageLeg};

/// The passage plan, to be printed for the bridge.
pub(super) fn passage(passage: &Passage) -> Markup {
    html! {
        @if !passage.legs.is_empty() {
            div.crew {
                h3 { "Passage plan" }
                p.note {
                    "Waypoints are those of the route files: where the course or what is done changes, and where the courses of a turn cross. \
                     Courses are true, along loxodromes. XTD is as far as the simulated tracks of the check come to port and to starboard of \
                     the line; radii are those that the ship turns with. "
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
                            th.number scope="col" { "XTD port" br; "[m]" }
                            th.number scope="col" { "XTD starboard" br; "[m]" }
                            th.number scope="col" { "Radius" br; "[m]" }
                            th scope="col" { "What" }
                        }
                    }
                    tbody {
                        tr {
                            th scope="row" { "0" }
                            (place(passage.latitude_deg, passage.longitude_deg))
                            td colspan="3" { "" }
                            td.time { (clock(0.0)) }
                            td colspan="3" { "" }
                            td.wrap { (passage.before.join(", ")) }
                        }
                        @for (index, leg) in passage.legs.iter().enumerate() { (line(index + 1, leg)) }
                    }
                } }
            }
        }
    }
}

fn line(number: usize, leg: &PassageLeg) -> Markup {
    let what: Vec<&str> = std::iter::once(&leg.what).chain(&leg.then).map(String::as_str).collect();
    html! {
        tr.informative[leg.informative] {
            th scope="row" { (number) }
            (place(leg.latitude_deg, leg.longitude_deg))
            td.number { (heading(leg.course_deg)) }
            td.number { (miles(leg.distance_m)) }
            td.number { (knots(leg.speed_m_s)) }
            td.time { (clock(leg.end_s)) }
            td.number { (metres(leg.xtd_port_m)) }
            td.number { (metres(leg.xtd_starboard_m)) }
            td.number { (or_dash(leg.turn_radius_m.map(metres))) }
            td.wrap { (what.join(", ")) }
        }
    }
}

fn place(latitude_deg: f64, longitude_deg: f64) -> Markup {
    html! { td.place { (latitude(latitude_deg)) br; (longitude(longitude_deg)) } }
}

/// Up to the next metre: a corridor may not be told too narrow.
fn metres(value: f64) -> String {
    or_dash(value.is_finite().then(|| format!("{:.0}", value.ceil())))
}
