use maud::{Markup, html};
use study::documents::{
    Bounds, Departures, DesignScores, DesignSummary, ParameterSummary, Passage, PassageLeg,
};

use crate::number::{exact, median, or_dash, parameter_share, q90, simulation_share, three, three_or_dash};
use crate::parts::{HtmlTable, missing};
use crate::study::{Study, Trajectory, optimized_first};
use crate::trajectory::words::{clock, heading, knots, latitude, longitude, miles, minutes};

/// The planned experiment compared with the others: errors of the models that are estimated from it.
pub(super) fn trials(study: &Study, trajectory: &Trajectory) -> Markup {
    html! {
        h3 { "The plan as an experiment" }
        @match &trajectory.validation {
            Some(planned) => {
                (compared(study, trajectory))
                (bounds_note(study.validation.as_ref().map(|v| v.bounds), planned.bounds))
                (table(study, planned.bounds, &planned.designs))
                @if study.validation.is_none() { (missing("The designs to compare with are", "validation.json", "validate")) }
            }
            None => (missing("The errors of models estimated from the planned trial are", "planned/validation.json", "validate")),
        }
        @match &trajectory.estimate {
            Some(planned) => (spreads(study, &planned.designs)),
            None => (missing("The spread of the estimates from the planned trial is", "planned/estimate.json", "estimate")),
        }
    }
}

/// Says what is compared, and what is not.
fn compared(study: &Study, trajectory: &Trajectory) -> Markup {
    let voyage = trajectory.main.as_ref().and_then(|main| main.plan.voyage.as_ref());
    html! {
        p {
            "The planned experiment is the whole trial"
            @if let Some(voyage) = voyage { " of " (exact(voyage.duration_s)) "\u{a0}s, " (exact(voyage.informative_s)) "\u{a0}s of it in maneuvers" }
            ": it also contains the legs between the maneuvers, while the other experiments"
            @if let Some(length) = study.experiment_s { " of " (exact(length)) "\u{a0}s" }
            " consist of maneuvers alone and know no chart, so its row says what the trial tells as a whole and not that its maneuvers are better chosen."
        }
    }
}

fn bounds_note(others: Option<Bounds>, planned: Bounds) -> Markup {
    let same = |b: &Bounds| {
        b.parameter_error == planned.parameter_error && b.simulation_error == planned.simulation_error
    };
    html! {
        @if let Some(others) = others.filter(|b| !same(b)) {
            p.missing {
                "Shares are not comparable: the planned trial is counted against the bounds " (exact(planned.parameter_error)) " and "
                (exact(planned.simulation_error)) ", the others against " (exact(others.parameter_error)) " and "
                (exact(others.simulation_error)) "."
            }
        }
    }
}

fn table(study: &Study, bounds: Bounds, planned: &[DesignScores]) -> Markup {
    html! {
        div.scroll { table {
            thead {
                tr {
                    th scope="col" rowspan="2" { "Design" }
                    th.number scope="col" rowspan="2" { "Runs" }
                    th.number.spanned scope="col" colspan="3" { "Parameter error" }
                    th.number.spanned scope="col" colspan="3" { "Simulation error" }
                    th.number scope="col" rowspan="2" { "Without" br; "a value" }
                }
                tr {
                    th.number scope="col" { "below " (exact(bounds.parameter_error)) }
                    th.number scope="col" { "median" }
                    th.number scope="col" { "90\u{a0}%" }
                    th.number scope="col" { "below " (exact(bounds.simulation_error)) }
                    th.number scope="col" { "median" }
                    th.number scope="col" { "90\u{a0}%" }
                }
            }
            tbody {
                @for scores in study.scored() { (row(scores, false)) }
                @for scores in planned { (row(scores, true)) }
            }
        } }
        p.note { "Quantiles over the runs. Without a value: not identifiable, or the free simulation diverged; such a run counts as above every bound." }
    }
}

fn row(scores: &DesignScores, planned: bool) -> Markup {
    html! {
        tr.main[planned] {
            th scope="row" { (scores.design) }
            td.number { (scores.runs) }
            td.number { (parameter_share(scores)) }
            td.number { (median(&scores.parameter_error)) }
            td.number { (q90(&scores.parameter_error)) }
            td.number { (simulation_share(scores)) }
            td.number { (median(&scores.simulation_error)) }
            td.number { (q90(&scores.simulation_error)) }
            td.number { (scores.not_identifiable + scores.diverged) }
        }
    }
}

/// Spread of every estimate over its true value, per design.
fn spreads(study: &Study, planned: &[DesignSummary]) -> Markup {
    let others = study.estimate.iter().flat_map(|e| optimized_first(&e.designs, |d| &d.design));
    let designs: Vec<&DesignSummary> = others.chain(planned).collect();
    let known = |p: &&ParameterSummary| p.relative_spread.is_some();
    let parameters: Vec<&ParameterSummary> =
        planned.first().into_iter().flat_map(|d| &d.parameters).filter(known).collect();
    if parameters.is_empty() {
        return html! {};
    }
    let named = HtmlTable::of(parameters).class("compact few").name("Relative spread", |p| &p.name);
    let table = designs.iter().fold(named, |table, design| {
        table.number(&design.design, |p| {
            let same = design.parameters.iter().find(|other| other.name == p.name);
            three_or_dash(same.and_then(|same| same.relative_spread))
        })
    });
    html! {
        (table)
        p.note { "Relative spread: standard deviation of the estimate over the identified runs, divided by the modulus of the true value." }
    }
}

/// The passage plan, to be printed for the bridge.
pub(super) fn passage(passage: &Passage) -> Markup {
    let with_depth = passage.legs.iter().any(|leg| leg.least_depth_m.is_some());
    let under_keel = passage.legs.iter().any(|leg| leg.under_keel_m.is_some());
    let squats = under_keel && passage.legs.iter().any(|leg| leg.squat_m.is_some());
    let depth_head = if under_keel { ["Under keel", "[m]"] } else { ["Least depth", "[m]"] };
    html! {
        @if !passage.legs.is_empty() {
            div.crew {
                h3 { "Passage plan" }
                p.note {
                    "Waypoints are those of the route files: where the course or what is done changes, and where the courses of a turn cross. \
                     Courses are true, along loxodromes. XTD is as far as the simulated tracks of the check come to port and to starboard of \
                     the line; radii are those that the ship turns with. \
                     The nearest danger is that along the nominal track, with the doubt about its place taken off; depths are the least \
                     within XTD" @if squats { ", less squat in open water (Barrass)" } ". "
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
                    @if let Some(departures) = &passage.departures { " " (may_depart(departures)) }
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
            td.wrap {
                (what.join(", "))
                @if !leg.passes.is_empty() { br; span.aside { "passes " (leg.passes.join("; ")) } }
            }
        }
    }
}

/// For which departures the plan holds, and what closes it.
fn may_depart(departures: &Departures) -> String {
    let Departures { earliest, before, latest, after, best } = departures;
    let best =
        best.as_ref().map_or_else(String::new, |best| format!("; most water under the keel at {best}"));
    format!(
        "The plan holds for departures from {earliest} (before: {before}) to {latest} (after: {after}){best}."
    )
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
