use maud::{Markup, html};

use super::missing::missing;
use super::number::{exact, percent, three};
use super::study::Study;
use study::documents::{DesignDocument, Start};

/// How good the design is known to be.
pub(super) fn certificate(study: &Study) -> Markup {
    html! {
        section #certificate {
            h2 { "Certificate" }
            @match &study.design {
                Some(design) => (certified(design)),
                None => (missing("The certificate is", "design.json", "design")),
            }
        }
    }
}

fn certified(design: &DesignDocument) -> Markup {
    html! {
        p { (design.statement) }
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
            div { dt { "Status" } dd { (design.status) } }
            div { dt { "Global optimum" } dd { (proof(design)) } }
            @if let (Some(gap), Some(p)) = (design.gap, design.dimension) {
                div { dt { "Gap max g − p" } dd { (three(gap)) " (p = " (p) ")" } }
            }
            @if let Some(gap) = design.relative_gap { div { dt { "Relative gap" } dd { (three(gap)) } } }
            @if let Some(efficiency) = &design.efficiency {
                div { dt { "Efficiency of equal shares" } dd { (percent(efficiency.equal_shares)) } }
            }
            div { dt { "Criterion" } dd {
                (design.criterion.title()) "-optimality"
                @if let Some(removal) = design.mean_removal { ", instruments' mean removed: " (removal) }
            } }
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

fn starts(starts: &[Start]) -> Markup {
    html! {
        div.scroll { table.compact {
            thead { tr {
                th scope="col" { "Start" }
                th.number scope="col" { "log|det|" }
                th.number scope="col" { "Relative gap" }
                th.number scope="col" { "Iterations" }
                th scope="col" { "Agrees" }
            } }
            tbody { @for start in starts {
                tr.stray[!start.agrees] {
                    th scope="row" { (start.name) }
                    td.number { (exact((start.log_det * 1e8).round() / 1e8)) }
                    td.number { (three(start.relative_gap)) }
                    td.number { (start.iterations) }
                    td { @if start.agrees { "yes" } @else { "no" } }
                }
            } }
        } }
    }
}
