use maud::{Markup, html};
use refusal::listed;
use study::documents::{
    CaptiveValue, DeliveredKind, Estimator, FittedForces, FittedParameter, LeftOutScores, ModelDegree,
    ModelDocument, ModelParameter, SailedSum, SailedSums, SearchSummary,
};

use crate::figures::text::signed;
use crate::measured::MeasuredStudy;
use crate::number::{interval, or_dash, percent, three, three_or_dash, unit};
use crate::parts::{HtmlTable, Section, missing};

/// Parameters of the resulting model, and whether its estimator is the recommended one.
pub(super) fn delivered(measured: &MeasuredStudy) -> Section {
    let body = match &measured.model {
        None if measured.trust.is_some() => html! {
            p { "The estimate delivers no model: a degree of freedom has no estimate, or the free simulation of a recording diverges. See below." }
        },
        None => missing("The model is", "model.json", "estimate --fit together"),
        Some(model) => html! {
            @match measured.searched.as_ref().filter(|_| measured.left_out.is_none()) {
                Some(search) => (by_search(search)),
                None => (chosen(model.estimator, measured.left_out.as_ref())),
            }
            @match &model.forces {
                Some(forces) => (derivatives(forces)),
                None => {
                    (parameters(model))
                    (note(model))
                }
            }
            (surroundings(model))
        },
    };
    let by = measured.model.as_ref().map_or(String::new(), |model| format!(", by {}", model.estimator));
    Section::new("model", "Model", &format!("The delivered model{by}"), body)
}

/// Which model of a search this is.
fn by_search(found: &SearchSummary) -> Markup {
    match found.beside.as_ref().map(|beside| beside.delivered) {
        Some(DeliveredKind::Average) => html! {
            p {
                "The delivered model is the mean trajectory of two, which " code { "model.json" } " has as its members: the terms that the \
                 search found, and these forces. Stages that take a single model take these."
            }
        },
        Some(DeliveredKind::Forces) => {
            html! { p { "The forces alone are delivered." } }
        }
        Some(DeliveredKind::Search) => {
            html! { p { "The searched terms alone are delivered." } }
        }
        None => html! { p { "Found by the search above." } },
    }
}

/// Whether cross-validation recommends the estimator of the model.
fn chosen(estimator: Estimator, left_out: Option<&LeftOutScores>) -> Markup {
    let Some(left_out) = left_out else {
        return html! { p { "Estimated by " (estimator) ". No cross-validation says which estimator to take." } };
    };
    match left_out.recommended {
        Some(best) if best == estimator => {
            html! { p { "Estimated by " (estimator) ", which cross-validation recommends." } }
        }
        Some(best) => html! {
            p.missing {
                "Cross-validation recommends " (best) ", but this model was estimated by " (estimator) ". For one by " (best)
                " run " code { "estimate --fit together --estimator " (best) } "."
            }
        },
        None => html! { p { (undecided(estimator, &left_out.candidates)) } },
    }
}

/// Says that no estimator is recommended, and the rank of the model's own.
fn undecided(estimator: Estimator, candidates: &[Estimator]) -> String {
    let rest: Vec<String> = candidates.iter().skip(1).map(Estimator::to_string).collect();
    match candidates.iter().position(|candidate| *candidate == estimator) {
        Some(0) => format!(
            "No estimator is recommended. This model is by {estimator}, which has the least error in cross-validation, but the \
             recordings cannot tell it from {}.",
            listed(&rest)
        ),
        Some(_) => format!(
            "No estimator is recommended. This model is by {estimator}, which the recordings cannot tell from {}, the one of \
             least error.",
            candidates[0]
        ),
        None if candidates.is_empty() => {
            format!("No estimator could be simulated over all folds. This model is by {estimator}.")
        }
        None => format!(
            "No estimator is recommended, and this model is by {estimator}, which is worse than {} on the recordings left out.",
            candidates[0]
        ),
    }
}

/// A row per term and per constant of a degree of freedom, which is no parameter.
fn parameters(model: &ModelDocument) -> HtmlTable<(&ModelDegree, Option<&ModelParameter>)> {
    let rows = model.degrees.iter().flat_map(|degree| {
        degree.parameters.iter().map(Some).chain([None]).map(move |parameter| (degree, parameter))
    });
    let truth = |parameter: Option<&ModelParameter>| parameter.and_then(|p| p.truth);
    // Estimate less truth in standard errors.
    let off =
        |p: &ModelParameter| Some((p.value - p.truth?) / p.standard_error.filter(|error| *error > 0.0)?);
    let known = rows.clone().any(|(_, p)| truth(p).is_some());
    let mut table = HtmlTable::of(rows)
        .compact()
        .name("Parameter", |(d, p)| p.map_or(format!("{} constant", d.name), |p| p.name.clone()))
        .text("Degree", |(d, _)| d.name.as_str())
        .text("Term", |(_, p)| p.map_or("1", |p| p.term.as_str()))
        .text("Unit", |(d, p)| unit(p.map_or(&d.unit, |p| &p.unit)))
        .number("Estimate", |(d, p)| three(p.map_or(d.constant, |p| p.value)))
        .number("Standard error", |(_, p)| three_or_dash(p.and_then(|p| p.standard_error)));
    if known {
        table = table
            .number("True", |(_, p)| three_or_dash(truth(p)))
            .number("Off by, standard errors", |(_, p)| {
                or_dash(p.and_then(off).map(|off| signed(&format!("{off:.1}"))))
            });
    }
    table.number("Least squares", |(d, p)| {
        three_or_dash(p.map_or(d.constant_least_squares, |p| p.least_squares))
    })
}

/// The current that was found with the model, if it was unknown, a row per part.
fn surroundings(model: &ModelDocument) -> Markup {
    let Some(first) = model.surroundings.first() else { return html! {} };
    let named = HtmlTable::of(&model.surroundings)
        .compact()
        .name("Found around", |part| part.source.clone())
        .number("Part", |part| part.part.to_string());
    let table = first.found.iter().enumerate().fold(named, |table, (i, head)| {
        table.classed("number broken", format!("{} {}", head.name, unit(&head.unit)), |part| {
            let told =
                part.found.get(i).map(|value| (three(value.value), three_or_dash(value.standard_error)));
            or_dash(told.map(|(value, error)| format!("{value} ±\u{a0}{error}")))
        })
    });
    html! {
        h3 { "Unknown current" }
        (table)
        p.note {
            "With standard errors; along and across the vessel as she heads where the part starts. It keeps its direction over \
             ground as the vessel turns. Simulations on this page go without it."
        }
    }
}

fn note(model: &ModelDocument) -> Markup {
    html! {
        p.note {
            "What the state gains in a sample is the sum of estimate times term, and the constant; " (model.samples)
            " samples. The whole of it, with the covariance of the estimates and the range that the data covered, is in "
            code { "model.json" } ", which every stage takes for a " code { "vessel.toml" } "."
            @if model.degrees.iter().flat_map(|d| &d.parameters).any(|p| p.truth.is_some()) {
                " True: what the simulated logs were made with."
            }
        }
    }
}

/// The ship's free numbers, then what the recordings know of sway and yaw.
fn derivatives(found: &FittedForces) -> Markup {
    html! {
        (numbers(&found.parameters))
        p.note {
            "In the prime system where a number has one (unit 1), else in SI units, with 95\u{a0}% intervals. Prior: how much of the \
             estimate is the prior's. Entangled: the recordings know sums of such numbers, not one alone. The ship with these numbers, \
             and their covariance, is in " code { "model.json" } ", which stands for a " code { "vessel.toml" } "."
            @if let Some(source) = &found.captive_source {
                " Captive tests: " (source) ". They change no estimate; outside means outside the 95\u{a0}% interval."
            }
        }
        @if let Some(sailed) = &found.sailed { (sums(sailed)) }
    }
}

/// A number as it is shown: the estimate, its interval and its unit.
fn shown(parameter: &FittedParameter) -> (f64, Option<[f64; 2]>, &str) {
    match parameter.prime_value {
        Some(value) => (value, parameter.prime_interval, "1"),
        None => (parameter.si_value, parameter.si_interval, &parameter.si_unit),
    }
}

fn numbers(all: &[FittedParameter]) -> HtmlTable<&FittedParameter> {
    let mut table = HtmlTable::of(all)
        .compact()
        .mark("main", |parameter| outside(parameter.captive))
        .name("Number", |parameter| html! { code { (parameter.name) } })
        .text("Unit", |parameter| unit(shown(parameter).2))
        .number("Estimate", |parameter| three(shown(parameter).0))
        .number("Interval", |parameter| interval(shown(parameter).1))
        .number("Prior", |parameter| percent(parameter.prior_share))
        .text("Entangled", |parameter| if parameter.entangled { "yes" } else { "–" });
    if all.iter().any(|parameter| parameter.captive.is_some()) {
        table = captive(table, |parameter| parameter.captive);
    }
    if all.iter().any(|parameter| parameter.truth.is_some()) {
        table = table
            .number("As written", |parameter| three(parameter.value))
            .number("True, as written", |parameter| three_or_dash(parameter.truth));
    }
    table
}

fn sums(sailed: &SailedSums) -> Markup {
    let order = |sum: &SailedSum| match sum.order {
        1 => "linear".to_owned(),
        2 => "quadratic".to_owned(),
        3 => "cubic".to_owned(),
        other => format!("order {other}"),
    };
    let mut table = HtmlTable::of(&sailed.sums)
        .compact()
        .mark("main", |sum| outside(sum.captive))
        .name("Sum", |sum| format!("{}, {}", sum.degree, order(sum)))
        .text("Of", |sum| html! { code { (sum.terms.join(" ")) } })
        .number("Estimate", |sum| three(sum.value))
        .number("Interval", |sum| interval(Some(sum.interval)))
        .number("Deviation by priors", |sum| three_or_dash(sum.prior_deviation));
    if sailed.sums.iter().any(|sum| sum.captive.is_some()) {
        table = captive(table, |sum| sum.captive);
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
fn captive<'a, R>(table: HtmlTable<&'a R>, of: impl Fn(&'a R) -> Option<CaptiveValue>) -> HtmlTable<&'a R> {
    let verdict = |captive_value: CaptiveValue| match captive_value.within {
        Some(true) => "within",
        Some(false) => "outside",
        None => "–",
    };
    table
        .number("Captive tests", |row| three_or_dash(of(row).map(|captive| captive.value)))
        .text("In the interval", |row| of(row).map_or("–", verdict))
}

fn outside(captive: Option<CaptiveValue>) -> bool {
    captive.is_some_and(|captive| captive.within == Some(false))
}
