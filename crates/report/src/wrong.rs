//! What is wrong with a fitted ship: signs, inputs that act late, forces that she lacks.

use maud::{Markup, html};
use study::documents::{AbsentForce, ForceCriticism, LateActuator, TriedSign};

use super::number::{percent, probability, three, unit};
use super::parts::{coded, statements};
use super::table::Table;

/// Signs first; lags and forces only where these are right.
pub(super) fn wrong(found: &ForceCriticism) -> Markup {
    let parts = if found.whole_windows { "windows" } else { "pieces of windows" };
    html! {
        h3 { "What is wrong with the model" }
        (statements(&found.statements))
        @if !found.signs.is_empty() { (signs(&found.signs)) }
        @if !found.late.is_empty() { (late(&found.late)) }
        @if !found.absent.is_empty() { (absent(found)) }
        p.note {
            "Each sign is turned by itself, and the ship is fitted again. Then every candidate is added with a number of 0: its score is \
             what the fitted numbers cannot explain of the errors. Cost: by how much the candidate would lower it. p: how often any \
             of all candidates would seem so likely in a right model; " (found.units) " " (parts) " count as independent."
        }
        @if !found.hidden.is_empty() {
            p.note { "Not to be told from the model's own forces: " (coded(&found.hidden.join(", "))) "." }
        }
    }
}

fn signs(all: &[TriedSign]) -> Table<&TriedSign> {
    Table::of(all)
        .compact()
        .mark("main", |own| own.wrong)
        .name("Turned", |own| coded(&own.turned))
        .number("Cost", |own| own.share.map_or("diverges".to_owned(), |share| percent(-share)))
        .number("Windows that fit better", |own| format!("{} of {}", own.windows_better, own.windows))
        .number("p", |own| probability(own.p_value))
}

fn late(all: &[LateActuator]) -> Table<&LateActuator> {
    let best = |late_actuator: &LateActuator| match (&late_actuator.kind, late_actuator.time_s) {
        (Some(kind), Some(time)) => format!("{kind} of {} s", three(time)),
        _ => "–".to_owned(),
    };
    Table::of(all)
        .compact()
        .name("Input", |own| html! { code { (own.input) } })
        .number("Acts later by [s]", |own| format!("{} ± {}", three(own.late_s), three(own.standard_error)))
        .number("Cost", |own| percent(-own.share))
        .number("p", |own| probability(own.p_value))
        .text("Fits best as", best)
}

/// Forces that are shown.
const SHOWN: usize = 6;

fn absent(found: &ForceCriticism) -> Table<&AbsentForce> {
    let likely = found.absent.iter().take_while(|own| own.candidate).count();
    let first = &found.absent[..likely.max(SHOWN).min(found.absent.len())];
    Table::of(first)
        .compact()
        .mark("main", |own| own.candidate)
        .name("Not in the model", |own| html! { code { (own.term) } })
        .text("Degree", |own| own.degree.as_str())
        .number("If added", |own| format!("{} ± {}", three(own.value), three(own.standard_error)))
        .text("Unit", |own| unit(&own.unit))
        .number("Cost", |own| percent(-own.share))
        .number("p", |own| probability(own.p_value))
}
