use std::collections::BTreeMap;

use crate::figures::{FrontDot, front as drawing};
use maud::{Markup, html};

use super::words::{cost_title, minutes};
use crate::number::{exact, percent, three};
use crate::parts::{Figures, Table};
use study::documents::{FrontPoint, PlanDocument, Voyage};

/// The Pareto front of counts: fewer uses for less cost.
pub(super) fn front(plan: &PlanDocument, voyage: &Voyage, figures: &mut Figures) -> Markup {
    let body = if voyage.front.is_empty() {
        html! { p.missing { "Not shown: the search was not exhaustive, so what fewer uses would cost is not known." } }
    } else {
        shown(plan, voyage, figures)
    };
    html! { h3 { "Information against cost" } (body) }
}

fn shown(plan: &PlanDocument, voyage: &Voyage, figures: &mut Figures) -> Markup {
    let labels: Vec<String> = voyage.front.iter().map(|point| uses(&point.counts)).collect();
    let dots: Vec<FrontDot<'_>> = voyage
        .front
        .iter()
        .zip(&labels)
        .map(|(point, label)| FrontDot {
            cost: point.cost,
            log_det: point.log_det,
            label,
            chosen: is_own(plan, point),
        })
        .collect();
    let order: Vec<&str> = plan.counts.keys().map(String::as_str).collect();
    let caption = html! {
        b { "Fewer uses for less." } " Each dot is the best plan with other counts (" (order.join(", "))
        "); counts that cost more and tell less are left out. Filled: this plan."
    };
    html! {
        div.pair.front {
            (figures.place("front", drawing(&dots, cost_title(plan.cost_unit)), &caption))
            (table(plan, voyage))
        }
    }
}

/// `3·2·3`, in the order of the names.
fn uses(counts: &BTreeMap<String, u64>) -> String {
    counts.values().map(u64::to_string).collect::<Vec<_>>().join("·")
}

fn is_own(plan: &PlanDocument, point: &FrontPoint) -> bool {
    point.counts == plan.counts
}

fn table(plan: &PlanDocument, voyage: &Voyage) -> Markup {
    let dimension = voyage.information.dimension as f64;
    let own = voyage.front.iter().find(|point| is_own(plan, point)).map(|point| point.log_det);
    let marked = Table::of(&voyage.front).class("compact tight").mark("main", |point| is_own(plan, point));
    let mut table = plan
        .counts
        .keys()
        .fold(marked, |table, name| table.number(name, |point| point.counts.get(name).copied().unwrap_or(0)));
    table = table
        .number(cost_title(plan.cost_unit), |point| exact((point.cost * 1e3).round() / 1e3))
        .number("Informative legs", |point| minutes(point.informative_s))
        .number("log|det|", |point| three(point.log_det));
    if let Some(own) = own {
        table = table.number("Efficiency", |point| percent(libm::exp((point.log_det - own) / dimension)));
    }
    html! {
        div {
            (table)
            p.note {
                "Informative legs: with approach and recovery. log|det|: as the counts promise it."
                @if own.is_some() { " Efficiency: against this plan (bold), the ratio of the determinants to the power 1/" (voyage.information.dimension) "." }
            }
        }
    }
}
