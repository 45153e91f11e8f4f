use std::collections::BTreeMap;

use crate::figures::{FrontDot, front as drawing};
use maud::{Markup, html};

use super::number::{exact, percent, three};
use super::placed::Figures;
use super::trajectory_words::{cost_title, minutes};
use study::documents::{PlanDocument, Voyage};
use trial::voyage::FrontPoint;

/// Fewer uses for less cost: the counts that no others beat.
pub(super) fn front(plan: &PlanDocument, voyage: &Voyage, figures: &mut Figures) -> Markup {
    let body = if voyage.front.is_empty() {
        html! { p.missing { "Not shown: the search was not exhaustive, so what fewer uses would cost is not known." } }
    } else {
        shown(plan, voyage, figures)
    };
    html! { h3 { "Information against cost" } (body) }
}

fn shown(plan: &PlanDocument, voyage: &Voyage, figures: &mut Figures) -> Markup {
    let names: Vec<String> = voyage.front.iter().map(|point| uses(&point.counts)).collect();
    let dot = |(point, name): (&FrontPoint, &'_ String)| {
        (point.cost, point.log_det, name.clone(), is_own(plan, point))
    };
    let kept: Vec<(f64, f64, String, bool)> = voyage.front.iter().zip(&names).map(dot).collect();
    let dots: Vec<FrontDot<'_>> = kept
        .iter()
        .map(|(cost, log_det, label, chosen)| FrontDot {
            cost: *cost,
            log_det: *log_det,
            label,
            chosen: *chosen,
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
    html! {
        div {
            div.scroll { table.compact.tight {
                thead { tr {
                    @for name in plan.counts.keys() { th.number scope="col" { (name) } }
                    th.number scope="col" { (cost_title(plan.cost_unit)) }
                    th.number scope="col" { "Informative legs" }
                    th.number scope="col" { "log|det|" }
                    @if own.is_some() { th.number scope="col" { "Efficiency" } }
                } }
                tbody { @for point in &voyage.front {
                    tr.main[is_own(plan, point)] {
                        @for name in plan.counts.keys() { td.number { (point.counts.get(name).copied().unwrap_or(0)) } }
                        td.number { (exact((point.cost * 1e3).round() / 1e3)) }
                        td.number { (minutes(point.informative_s)) }
                        td.number { (three(point.log_det)) }
                        @if let Some(own) = own { td.number { (percent(((point.log_det - own) / dimension).exp())) } }
                    }
                } }
            } }
            p.note {
                "Informative legs: with approach and recovery. log|det|: as the counts promise it."
                @if own.is_some() { " Efficiency: against this plan (bold), the ratio of the determinants to the power 1/" (voyage.information.dimension) "." }
            }
        }
    }
}
