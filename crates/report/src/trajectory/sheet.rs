use maud::{Markup, html};
use study::documents::{
    Check, Information, PlanDocument, PlanStep, Secondary, SecondaryCost, Voyage, VoyageLeg, WheelOver,
    WorstVessel, WorstVessels,
};

use crate::figures::palette;
use crate::number::{exact, or_dash, percent, three, three_or_dash, unit};
use crate::parts::entry;
use crate::study::Study;
use crate::trajectory::words::{
    action, clearance, clock, cost, failing, gap, heading, knots, latitude, level, longitude, minutes, part,
};

/// An input that never exceeds this counts as zero: rounding, in any unit.
const RESIDUE: f64 = 1e-9;

/// The plan step by step, to be printed for the crew.
pub(super) fn sheet(study: &Study, plan: &PlanDocument, voyage: &Voyage) -> Markup {
    let inputs = InputColumns::of(study, voyage);
    html! {
        div.crew {
            h3 { "Maneuver sheet" }
            p.note {
                "Numbered steps are informative maneuvers, with the number of the map: an approach, then the planned inputs without \
                 corrections, then the recovery onto the next position. Positions (WGS\u{a0}84), headings (true) and speeds are those of \
                 the plan; times, durations and inputs are as simulated by the nominal model. "
                @if let Some(aborts) = voyage.aborts() {
                    "If it fails: where she may wait, from the end of the leg, dashed on the map, and what she drifts to with her \
                     engine stopped anywhere on it (" (aborts) "). "
                }
                b { "Not for navigation." }
                @if !voyage.check.safe { " " b { "Unsafe: the plan fails its own check." } }
            }
            div.scroll { table.compact.tight.sheet {
                (head(&inputs))
                tbody {
                    @for (step, row) in rows(plan, voyage).iter().enumerate() { (line(step, row, voyage, &inputs)) }
                    (end(plan, voyage, &inputs))
                }
            } }
            @if !inputs.known {
                p.missing { "Units of the inputs not shown: there is no " code { "vessel.toml" } "." }
            }
        }
    }
}

/// A step and, for an informative one, its number on the map with its colour there.
type SheetRow<'a> = (&'a PlanStep, &'a VoyageLeg, Option<(usize, palette::Rgb)>);

fn rows<'a>(plan: &'a PlanDocument, voyage: &'a Voyage) -> Vec<SheetRow<'a>> {
    let mut informative = 0;
    let row = |(step, leg): (&'a PlanStep, &'a VoyageLeg)| {
        informative += usize::from(leg.informative);
        let maneuver = plan.counts.keys().position(|name| *name == leg.name).unwrap_or(0);
        (step, leg, leg.informative.then(|| (informative, palette::series(maneuver))))
    };
    plan.steps.iter().zip(&voyage.legs).map(row).collect()
}

/// Names of the inputs with their units and decimals.
struct InputColumns {
    all: Vec<(String, String, usize)>,
    /// Whether units are known.
    known: bool,
}

impl InputColumns {
    fn of(study: &Study, voyage: &Voyage) -> Self {
        let declared = study.inputs();
        let mut names: Vec<&str> = declared.iter().map(|input| input.name.as_str()).collect();
        for name in voyage.legs.iter().flat_map(|leg| leg.largest_inputs.keys()) {
            if !names.contains(&name.as_str()) {
                names.push(name);
            }
        }
        let one = |name: &str| {
            let unit = declared.iter().find(|input| input.name == name).map(|input| input.unit.clone());
            (name.to_owned(), unit.unwrap_or_default(), decimals(voyage, name))
        };
        Self { all: names.into_iter().map(one).collect(), known: study.vessel.is_some() }
    }
}

/// The number of decimals of three significant digits of the largest value.
fn decimals(voyage: &Voyage, name: &str) -> usize {
    let values = voyage.legs.iter().filter_map(|leg| leg.largest_inputs.get(name));
    let most = values.filter(|v| v.is_finite()).fold(0.0, |most: f64, v| most.max(v.abs()));
    if most > RESIDUE { (2.0 - libm::log10(most).floor()).clamp(0.0, 9.0) as usize } else { 0 }
}

fn head(inputs: &InputColumns) -> Markup {
    html! {
        thead {
            tr {
                th scope="col" rowspan="2" { "No." }
                th scope="col" rowspan="2" { "Time" br; "h:min:s" }
                th scope="col" rowspan="2" { "Position" }
                th.number scope="col" rowspan="2" { "Heading" }
                th.number scope="col" colspan="2" { "Speed" }
                th scope="col" rowspan="2" { "What" }
                th.number.spanned scope="col" colspan="3" { "Duration [s]" }
                @if !inputs.all.is_empty() { th.number.spanned scope="col" colspan=(inputs.all.len()) { "Largest inputs" } }
                th scope="col" rowspan="2" { "If it fails" }
            }
            tr {
                th.number scope="col" { "[m/s]" }
                th.number scope="col" { "[kn]" }
                th.number scope="col" { "approach" }
                th.number scope="col" { "maneuver" }
                th.number scope="col" { "in all" }
                @for (name, of, _) in &inputs.all {
                    th.number scope="col" { (name) @if inputs.known { br; span.unit { (unit(of)) } } }
                }
            }
        }
    }
}

fn line(step: usize, row: &SheetRow, voyage: &Voyage, inputs: &InputColumns) -> Markup {
    let (done, leg, number) = row;
    let largest = |name: &str, decimals: usize| {
        let value = leg.largest_inputs.get(name).filter(|v| v.is_finite());
        or_dash(value.map(|v| format!("{v:.decimals$}")))
    };
    html! {
        tr.informative[leg.informative] data-step=(step) {
            th scope="row" { (badge(*number)) }
            td.time { (clock(leg.start_s)) }
            td.place { (latitude(leg.latitude_deg)) br; (longitude(leg.longitude_deg)) }
            td.number { (heading(leg.heading_deg)) }
            td.number { (or_dash(Some(leg.speed_m_s).filter(|v| v.is_finite()).map(|v| format!("{v:.1}")))) }
            td.number { (knots(leg.speed_m_s)) }
            td.wrap {
                (action(done, leg, &voyage.lattice))
                @for at in &leg.wheel_over { br; span.aside { (wheel_over(at, inputs)) } }
            }
            td.number { (seconds(leg.maneuver_start_s.map(|start| start - leg.start_s))) }
            td.number { (seconds(leg.maneuver_s)) }
            td.number { (seconds(Some(leg.duration_s))) }
            @for (name, _, decimals) in &inputs.all { td.number { (largest(name, *decimals)) } }
            td.wrap { (failing(leg)) }
        }
    }
}

/// When and where an input changes, and to what: `00:04:50, 60° 08.918′ N 024° 57.211′ E, 274°: delta -20°`.
fn wheel_over(at: &WheelOver, inputs: &InputColumns) -> String {
    let set = inputs.all.iter().filter_map(|(name, unit, decimals)| {
        let value = at.inputs.get(name)?;
        Some(match unit.as_str() {
            "rad" => format!("{name} {:.0}°", value.to_degrees()),
            unit => format!("{name} {value:.decimals$} {unit}"),
        })
    });
    let set: Vec<String> = set.collect();
    let [north, east] = [latitude(at.latitude_deg), longitude(at.longitude_deg)];
    format!("{}, {north} {east}, {}: {}", clock(at.start_s), heading(at.heading_deg), set.join(", "))
}

/// The number as on the map, or a grey dot for a basic move.
fn badge(number: Option<(usize, palette::Rgb)>) -> Markup {
    match number {
        Some((number, colour)) => {
            html! { span.badge style={ "border-color:" (palette::hex(colour)) } { (number) } }
        }
        None => html! { span.basic aria-label="basic move" { "·" } },
    }
}

fn end(plan: &PlanDocument, voyage: &Voyage, inputs: &InputColumns) -> Markup {
    let to = plan.steps.last().map(|step| level(&voyage.lattice, step.to.h));
    html! {
        tr.end {
            th scope="row" { "" }
            td.time { (clock(voyage.duration_s)) }
            td { "" }
            td.number { (or_dash(to)) }
            td colspan=(7 + inputs.all.len()) { "end of the trial, after " (minutes(voyage.duration_s)) }
        }
    }
}

fn seconds(value: Option<f64>) -> String {
    or_dash(value.filter(|s| s.is_finite()).map(|s| format!("{s:.0}")))
}

/// Facts about the plan and about the vessel at sea.
pub(super) fn facts(plan: &PlanDocument) -> Markup {
    html! {
        (search(plan))
        @if let Some(voyage) = &plan.voyage {
            (at_sea(plan, voyage))
            (currents(&voyage.check))
        }
    }
}

fn fact(term: &str, value: &str, note: &str) -> Markup {
    entry(term, html! { (value) @if !note.is_empty() { " " span.aside { (note) } } })
}

fn search(plan: &PlanDocument) -> Markup {
    let unit = plan.cost_unit;
    let proof = gap(plan).unwrap_or("proved".to_owned());
    let uses: Vec<String> =
        plan.counts.iter().map(|(name, count)| format!("{count}\u{a0}× {name}")).collect();
    let uses = if uses.is_empty() { String::new() } else { format!("with {}", uses.join(", ")) };
    html! {
        h3 { "Plan" }
        dl.facts {
            (fact("Status", plan.status.name(), &proof))
            (fact("Cost", &cost(plan.cost, unit), &format!("no plan costs less than {}", cost(plan.lower_bound, unit))))
            (fact("Steps", &plan.steps.len().to_string(), &uses))
            @if let Some(secondary) = &plan.secondary { (ties(secondary)) }
        }
    }
}

fn ties(secondary: &SecondaryCost) -> Markup {
    let value = exact((secondary.value * 1e3).round() / 1e3);
    match secondary.name {
        Secondary::Seconds => {
            fact("Ties broken by", &format!("{value}\u{a0}s"), "of moves, each as rehearsed on its own")
        }
        Secondary::Turns => fact("Ties broken by", &format!("{value} turns"), ""),
        Secondary::Clearance => fact("Ties broken by", &value, "classes of nearness to obstacles, summed"),
    }
}

fn at_sea(plan: &PlanDocument, voyage: &Voyage) -> Markup {
    let maneuvers: u64 = plan.counts.values().sum();
    let share = voyage.informative_s / voyage.duration_s;
    let clear = clearance(&voyage.check).unwrap_or("none: the hull touches an obstacle".to_owned());
    let margin = match voyage.check.shortfall_m > 0.0 {
        true => format!("{}\u{a0}m short of it", three(voyage.check.shortfall_m)),
        false => "kept".to_owned(),
    };
    html! {
        h3 { "At sea, simulated by the nominal model" }
        dl.facts {
            (fact("Duration", &minutes(voyage.duration_s), &format!("{}\u{a0}s", exact(voyage.duration_s))))
            (fact("Proved to take", &format!("{}\u{a0}s", exact(voyage.check.proved_s)),
                &format!("each move from its node; sailed in {}\u{a0}s", exact(voyage.check.sailed_s))))
            (fact("In informative maneuvers", &minutes(voyage.informative_s),
                &format!("{} of the time, {maneuvers} maneuvers", percent(share))))
            (fact("Clearance", &clear, "of the hull from anything charted as an obstacle"))
            (fact("Margin", &format!("{}\u{a0}m asked for", exact(voyage.check.margin_m)), &margin))
        }
    }
}

fn currents(check: &Check) -> Markup {
    if check.runs == 0 {
        return html! { h3 { "In unknown current" } p.missing { "Not simulated: the plan asks for no runs." } };
    }
    let [least, low, median] = check.clearance_quantiles_m.map(three);
    let [from, to] = check.aground_interval.map(percent);
    let searches = match check.rounds {
        1 => "of the first plan that was found".to_owned(),
        rounds => format!("{rounds} searches, each with what the check before taught"),
    };
    // On the probability if no run is aground, with 95 % confidence.
    let bound =
        check.aground_bound.map_or("not bounded".to_owned(), |bound| format!("below {}", percent(bound)));
    let unmoved = check.clearance_quantiles_m.iter().all(|c| *c == check.clearance_m);
    html! {
        h3 { "In unknown current, with parameters that are off" }
        p.note {
            (check.runs) " simulations of the whole plan (seed " (check.seed) "), each with a constant current of its own, up to "
            (exact(check.unknown_current_m_s)) "\u{a0}m/s and from any side, and with parameters of its own, "
            (errors(check)) ". Errors of one leg are carried into the next."
        }
        @if let Some(worst) = &check.worst { (searched(worst, check.margin_m)) }
        dl.facts {
            (fact("Aground", &part(check.aground, check.runs), &format!("95\u{a0}% interval {from} to {to}; position corrected between the maneuvers")))
            (fact("Nearer than the margin", &part(check.below_margin, check.runs), &format!("of {}\u{a0}m, those aground among them", exact(check.margin_m))))
            (fact("Going aground", &bound, "for a vessel and a current drawn like these"))
            (fact("Ends of moves beyond a tolerance", &part(check.ends_astray, check.ends),
                &searches))
            (fact("Outside of the area", &part(check.left_area, check.runs), "its edge is no obstacle"))
            (fact("Aground if sailed open loop", &part(check.aground_open_loop, check.runs), "the planned inputs, never corrected"))
            (fact("Least clearance of a run", &format!("{least}\u{a0}m"),
                &format!("5\u{a0}% of runs: {low}\u{a0}m; median: {median}\u{a0}m")))
        }
        @if unmoved {
            p.note {
                "Every run has the clearance of the undisturbed plan: distances are measured in steps of the chart's raster, and the nearest \
                 point may be one that no current moves, such as the start."
            }
        }
    }
}

/// How the parameters of the runs are off.
fn errors(check: &Check) -> String {
    match check.standard_errors {
        Some(errors) => format!("jointly within {} {}", exact(errors), check.errors_of()),
        None => format!("evenly within {} of the nominal ones", percent(check.parameter_error)),
    }
}

/// What the search for the worst vessels found, apart from the drawn ones.
fn searched(worst: &WorstVessels, margin_m: f64) -> Markup {
    let vessels = |count: u64, what: &str| match count {
        0 => format!("none found that {what}"),
        _ => format!("{count} found that {what}"),
    };
    let at = |who: &WorstVessel| format!("step {} {}, by a vessel with {}", who.step, who.leg, who.words());
    html! {
        p.note { (worst.searched) " vessels and currents within the same bounds were searched for what is worst for each leg." }
        dl.facts {
            (fact("Worst vessels", &vessels(worst.aground, "run aground"), &format!("of {} searched", worst.searched)))
            (fact("Nearer than the margin", &vessels(worst.below_margin, "come nearer"), &format!("of {}\u{a0}m, those aground among them", exact(margin_m))))
            (fact("Least clearance found", &format!("{}\u{a0}m", three(worst.clearance_m)), &at(&worst.nearest)))
            (fact("Largest part of a tolerance found", &percent(worst.tolerance_used), &at(&worst.farthest)))
        }
    }
}

/// The information of the trial compared with that promised by its counts.
pub(super) fn information(information: &Information, designed: bool) -> Markup {
    let dimension = information.dimension;
    // exp((log det − promised)/p).
    let gain = information
        .whole_log_det
        .zip(information.predicted_log_det)
        .map(|(whole, promised)| whole - promised);
    let whole = gain.map(|gain| libm::exp(gain / dimension as f64));
    let reason = match (information.design_efficiency, designed) {
        (Some(_), _) => "against the design's shares over the same time in maneuvers",
        (None, false) => "no design was given to compare with",
        (None, true) => "not compared: plan.json was made without design.json",
    };
    html! {
        h3 { "Information of the trial, log|det|" }
        dl.facts.information {
            (fact("Promised by the counts", &three_or_dash(information.predicted_log_det), ""))
            (fact("In the maneuvers as sailed", &three_or_dash(information.realised_log_det), &against(information.efficiency)))
            (fact("In the whole track", &three_or_dash(information.whole_log_det), &against(whole)))
            (fact("Efficiency of the counts", &or_dash(information.design_efficiency.map(percent)), reason))
        }
        p.note {
            "Efficiency: the ratio of the determinants to the power 1/" (dimension) ". Above 100\u{a0}%, what is sailed tells more than \
             the maneuvers of the dictionary on their own, for example because the vessel enters them at other speeds."
        }
    }
}

fn against(efficiency: Option<f64>) -> String {
    efficiency.map_or("not comparable: a direction is not excited".to_owned(), |e| {
        format!("{} of the promise", percent(e))
    })
}
