use maud::{Markup, display, html};

use super::number::{exact, percent, three};
use super::parts::{Section, coded, entry, missing};
use super::study::Study;
use super::table::Table;
use study::documents::{DesignDocument, Start};

/// The certificate of the design.
pub(super) fn certificate(study: &Study) -> Section {
    let body = match &study.design {
        Some(design) => certified(design),
        None => missing("The certificate is", "design.json", "design"),
    };
    Section::new("certificate", "Certificate", "Certificate", body)
}

fn certified(design: &DesignDocument) -> Markup {
    html! {
        p { (design.statement) }
        @if let Some(promise) = &design.promise { p { (promise.statement) } }
        @if let Some(prior) = &design.prior { p { (prior.statement) } }
        (super::parts::held(design.held_in_words().as_ref()))
        (super::parts::beyond(&design.beyond))
        @if let Some(found) = &design.unreached { p.caution { b { "Missed by inputs." } " " (coded(&found.statement)) } }
        (facts(design))
        @if !design.starts.is_empty() {
            p { (agreement(&design.starts)) }
            (starts(&design.starts))
        }
    }
}

fn facts(design: &DesignDocument) -> Markup {
    html! {
        dl.facts {
            (entry("Status", display(design.status)))
            (entry("Global optimum", proof(design)))
            @if let (Some(gap), Some(p)) = (design.gap, design.dimension) {
                (entry("Gap max g − p", format!("{} (p = {p})", three(gap))))
            }
            @if let Some(gap) = design.relative_gap { (entry("Relative gap", three(gap))) }
            @if let Some(efficiency) = &design.efficiency {
                (entry("Efficiency of equal shares", percent(efficiency.equal_shares)))
            }
            (entry("Criterion", html! {
                (design.criterion.title()) "-optimality"
                @if let Some(removal) = design.mean_removal { ", instruments' mean removed: " (removal) }
            }))
        }
    }
}

fn proof(design: &DesignDocument) -> &'static str {
    if design.proved_global {
        "proved: the problem is concave and the gap bounds the distance"
    } else {
        "not proved: the problem is not concave, so the gap certifies a stationary point"
    }
}

fn agreement(starts: &[Start]) -> String {
    let strays: Vec<&str> = starts.iter().filter(|s| !s.agrees).map(|s| s.name.as_str()).collect();
    match (starts.len(), strays.len()) {
        (1, 0) => "The solver was started once, from the shares named below.".to_owned(),
        (all, 0) => format!("All {all} starts reached the same value."),
        (all, off) => {
            format!("{} of {all} starts reached the best value; not so: {}.", all - off, strays.join(", "))
        }
    }
}

fn starts(starts: &[Start]) -> Table<&Start> {
    Table::of(starts)
        .compact()
        .mark("stray", |start| !start.agrees)
        .name("Start", |start| &start.name)
        .number("log|det|", |start| exact((start.log_det * 1e8).round() / 1e8))
        .number("Relative gap", |start| three(start.relative_gap))
        .number("Iterations", |start| start.iterations)
        .text("Agrees", |start| if start.agrees { "yes" } else { "no" })
}
