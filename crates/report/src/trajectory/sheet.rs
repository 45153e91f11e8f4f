use crate::figures::palette;
use maud::{Markup, html};

use super::words::{action, clock, heading, knots, latitude, level, longitude, minutes};
use crate::number::{or_dash, three, unit};
use crate::study::Study;
use study::documents::{PlanDocument, PlanStep, Voyage, VoyageLeg};

/// An input that never exceeds this counts as zero: rounding, in any unit.
const RESIDUE: f64 = 1e-9;

/// The plan step by step, to be printed for the crew.
pub(super) fn sheet(study: &Study, plan: &PlanDocument, voyage: &Voyage) -> Markup {
    let inputs = Inputs::of(study, voyage);
    html! {
        div.crew {
            h3 { "Maneuver sheet" }
            p.note {
                "Numbered steps are informative maneuvers, with the number of the map: an approach, then the planned inputs without \
                 corrections, then the recovery onto the next position. Positions (WGS\u{a0}84), headings (true) and speeds are those of \
                 the plan; times, durations and inputs are as simulated by the nominal model. "
                b { "Not for navigation." }
                @if !voyage.check.safe { " " b { "Unsafe: the plan fails its own check." } }
            }
            div.scroll { table.compact.tight.sheet {
                (head(&inputs))
                tbody {
                    @for row in rows(plan, voyage) { (line(&row, voyage, &inputs)) }
                    (end(plan, voyage, &inputs))
                }
            } }
            @if !inputs.known {
                p.missing { "Units of the inputs not shown: there is no " code { "vessel.toml" } "." }
            }
        }
    }
}

/// One step with its number in the plan and, for an informative one, on the map.
struct Row<'a> {
    number: Option<usize>,
    /// Index of the maneuver among the counts, for its colour on the map.
    colour: usize,
    step: &'a PlanStep,
    leg: &'a VoyageLeg,
}

fn rows<'a>(plan: &'a PlanDocument, voyage: &'a Voyage) -> Vec<Row<'a>> {
    let mut informative = 0;
    let row = |(step, leg): (&'a PlanStep, &'a VoyageLeg)| {
        informative += usize::from(leg.informative);
        let colour = plan.counts.keys().position(|name| *name == leg.name).unwrap_or(0);
        Row { number: leg.informative.then_some(informative), colour, step, leg }
    };
    plan.steps.iter().zip(&voyage.legs).map(row).collect()
}

/// Names of the inputs with their units and decimals.
struct Inputs {
    all: Vec<(String, String, usize)>,
    /// Whether units are known.
    known: bool,
}

impl Inputs {
    fn of(study: &Study, voyage: &Voyage) -> Self {
        let declared = study.inputs();
        let mut names: Vec<&str> = declared.iter().map(|input| input.name.as_str()).collect();
        for name in voyage.legs.iter().flat_map(|leg| leg.largest_inputs.keys()) {
            if !names.contains(&name.as_str()) {
                names.push(name);
            }
        }
        let one = |name: &str| {
            let own = declared.iter().find(|input| input.name == name).map(|input| input.unit.clone());
            (name.to_owned(), own.unwrap_or_default(), decimals(voyage, name))
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

fn head(inputs: &Inputs) -> Markup {
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
            }
            tr {
                th.number scope="col" { "[m/s]" }
                th.number scope="col" { "[kn]" }
                th.number scope="col" { "approach" }
                th.number scope="col" { "maneuver" }
                th.number scope="col" { "in all" }
                @for (name, own, _) in &inputs.all {
                    th.number scope="col" { (name) @if inputs.known { br; span.unit { (unit(own)) } } }
                }
            }
        }
    }
}

fn line(row: &Row, voyage: &Voyage, inputs: &Inputs) -> Markup {
    let Row { step, leg, .. } = row;
    html! {
        tr.informative[leg.informative] {
            th scope="row" { (badge(row)) }
            td.time { (clock(leg.start_s)) }
            td.place { (latitude(leg.latitude_deg)) br; (longitude(leg.longitude_deg)) }
            td.number { (heading(leg.heading_deg)) }
            td.number { (rounded(leg.speed_m_s)) }
            td.number { (knots(leg.speed_m_s)) }
            td.wrap { (action(step, leg, &voyage.lattice)) }
            td.number { (seconds(leg.maneuver_start_s.map(|start| start - leg.start_s))) }
            td.number { (seconds(leg.maneuver_s)) }
            td.number { (seconds(Some(leg.duration_s))) }
            @for (name, _, decimals) in &inputs.all { td.number { (largest(leg, name, *decimals)) } }
        }
    }
}

/// The number as on the map, or a grey dot for a basic move.
fn badge(row: &Row) -> Markup {
    match row.number {
        Some(number) => {
            let ring = format!("border-color:{}", palette::hex(palette::series(row.colour)));
            html! { span.badge style=(ring) { (number) } }
        }
        None => html! { span.basic aria-label="basic move" { "·" } },
    }
}

fn end(plan: &PlanDocument, voyage: &Voyage, inputs: &Inputs) -> Markup {
    let to = plan.steps.last().map(|step| level(&voyage.lattice, step.to.h));
    html! {
        tr.end {
            th scope="row" { "" }
            td.time { (clock(voyage.duration_s)) }
            td { "" }
            td.number { (or_dash(to)) }
            td colspan=(6 + inputs.all.len()) { "end of the trial, after " (minutes(voyage.duration_s)) }
        }
    }
}

fn rounded(speed_m_s: f64) -> String {
    if speed_m_s.is_finite() { format!("{speed_m_s:.1}") } else { three(speed_m_s) }
}

fn seconds(value: Option<f64>) -> String {
    or_dash(value.filter(|s| s.is_finite()).map(|s| format!("{s:.0}")))
}

fn largest(leg: &VoyageLeg, name: &str, decimals: usize) -> String {
    let value = leg.largest_inputs.get(name).filter(|v| v.is_finite());
    or_dash(value.map(|v| format!("{v:.decimals$}")))
}
