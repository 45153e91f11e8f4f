//! Numbers of a fitted ship with forces, and sums of them, beside values of captive tests.

use maud::{Markup, html};
use study::documents::{CaptiveValue, FittedForces, FittedParameter, SailedSum, SailedSums};

use super::number::{interval, percent, three, three_or_dash, unit};
use super::table::Table;

/// The ship's free numbers, then what the recordings know of sway and yaw.
pub(super) fn derivatives(found: &FittedForces) -> Markup {
    html! {
        (numbers(&found.parameters))
        p.note {
            "In the prime system where a number has one (unit 1), else in SI units, with 95\u{a0}% intervals. Prior: how much of the \
             estimate is the prior's. Entangled: the recordings know sums of such numbers, not one alone. The ship with these numbers, \
             and their covariance, is in " code { "model.json" } ", which stands for a " code { "vessel.toml" } "."
            (source(found))
        }
        @if let Some(sailed) = &found.sailed { (sums(sailed)) }
    }
}

fn source(found: &FittedForces) -> Markup {
    html! {
        @if let Some(source) = &found.captive_source {
            " Captive tests: " (source) ". They change no estimate; outside means outside the 95\u{a0}% interval."
        }
    }
}

/// A number as it is shown: the estimate, its interval and its unit.
fn shown(own: &FittedParameter) -> (f64, Option<[f64; 2]>, &str) {
    match own.prime_value {
        Some(value) => (value, own.prime_interval, "1"),
        None => (own.si_value, own.si_interval, &own.si_unit),
    }
}

fn numbers(all: &[FittedParameter]) -> Markup {
    let known = all.iter().any(|own| own.truth.is_some());
    let mut table = Table::of(all)
        .compact()
        .mark("main", |own| outside(own.captive))
        .name("Number", |own| html! { code { (own.name) } })
        .text("Unit", |own| unit(shown(own).2))
        .number("Estimate", |own| three(shown(own).0))
        .number("Interval", |own| interval(shown(own).1))
        .number("Prior", |own| percent(own.prior_share))
        .text("Entangled", |own| if own.entangled { "yes" } else { "–" });
    if all.iter().any(|own| own.captive.is_some()) {
        table = captive(table, |own| own.captive);
    }
    if known {
        table = table
            .number("As written", |own| three(own.value))
            .number("True, as written", |own| three_or_dash(own.truth));
    }
    html! { (table) }
}

fn sums(sailed: &SailedSums) -> Markup {
    let order = |sailed_sum: &SailedSum| match sailed_sum.order {
        1 => "linear".to_owned(),
        2 => "quadratic".to_owned(),
        3 => "cubic".to_owned(),
        other => format!("order {other}"),
    };
    let mut table = Table::of(&sailed.sums)
        .compact()
        .mark("main", |own| outside(own.captive))
        .name("Sum", |own| format!("{}, {}", own.degree, order(own)))
        .text("Of", |own| html! { code { (own.terms.join(" ")) } })
        .number("Estimate", |own| three(own.value))
        .number("Interval", |own| interval(Some(own.interval)))
        .number("Deviation by priors", |own| three_or_dash(own.prior_deviation));
    if sailed.sums.iter().any(|own| own.captive.is_some()) {
        table = captive(table, |own| own.captive);
    }
    html! {
        h3 { "What was sailed" }
        (table)
        p.note {
            "Sums of terms of one order where v = " (three(sailed.drift)) " r L, as these recordings have it on average, in the prime \
             system. Free runs know such sums better than their terms."
        }
    }
}

/// With columns for the captive value and whether the interval holds it.
fn captive<'a, R>(table: Table<&'a R>, of: impl Fn(&'a R) -> Option<CaptiveValue>) -> Table<&'a R> {
    let verdict = |captive_value: CaptiveValue| match captive_value.within {
        Some(true) => "within",
        Some(false) => "outside",
        None => "–",
    };
    table
        .number("Captive tests", |own| three_or_dash(of(own).map(|own| own.value)))
        .text("In the interval", |own| of(own).map_or("–", verdict))
}

fn outside(own: Option<CaptiveValue>) -> bool {
    own.is_some_and(|own| own.within == Some(false))
}
