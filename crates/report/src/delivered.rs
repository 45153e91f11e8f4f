use maud::{Markup, html};
use refusal::listed;
use study::documents::{
    CaptiveValue, CrossvalDocument, DeliveredKind, Estimator, FittedForces, FittedParameter, ModelDegree,
    ModelDocument, ModelParameter, SailedSum, SailedSums, SearchDocument,
};

use super::measured::Measured;
use super::number::{or_dash, three, three_or_dash, unit};
use super::parts::{Section, Table, missing};
use crate::figures::text::signed;
use crate::number::{interval, percent};

/// Parameters of the resulting model, and whether its estimator is the recommended one.
pub(super) fn delivered(measured: &Measured) -> Section {
    let body = match &measured.model {
        None if measured.trust.is_some() => html! {
            p { "The estimate delivers no model: a degree of freedom has no estimate, or the free simulation of a recording diverges. See below." }
        },
        None => missing("The model is", "model.json", "estimate pool"),
        Some(model) => html! {
            @match measured.searched.as_ref().filter(|_| measured.crossval.is_none()) {
                Some(found) => (by_search(found)),
                None => (chosen(model.estimator, measured.crossval.as_ref())),
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
    Section::new("model", "Model", &heading(measured.model.as_ref()), body)
}

/// Which model of a search this is.
fn by_search(found: &SearchDocument) -> Markup {
    let average = code("average.json");
    match found.beside.as_ref().map(|own| own.delivered) {
        Some(DeliveredKind::Average) => html! {
            p {
                "The delivered model is the mean trajectory of two, which are in " (average) ": the terms that the search found, and these \
                 forces. Stages that take a single model take these."
            }
        },
        Some(DeliveredKind::Forces) => {
            html! { p { "The forces alone are delivered, in " (average) " too." } }
        }
        Some(DeliveredKind::Search) => {
            html! { p { "The searched terms alone are delivered, in " (average) " too." } }
        }
        None => html! { p { "Found by the search above." } },
    }
}

fn code(text: &str) -> Markup {
    html! { code { (text) } }
}

fn heading(model: Option<&ModelDocument>) -> String {
    model.map_or("The delivered model".to_owned(), |model| {
        format!("The delivered model, by {}", model.estimator)
    })
}

/// Whether cross-validation recommends the estimator of the model.
fn chosen(estimator: Estimator, crossval: Option<&CrossvalDocument>) -> Markup {
    let Some(found) = crossval else {
        return html! { p { "Estimated by " (estimator) ". No cross-validation says which estimator to take." } };
    };
    match found.recommended {
        Some(best) if best == estimator => {
            html! { p { "Estimated by " (estimator) ", which cross-validation recommends." } }
        }
        Some(best) => html! {
            p.missing {
                "Cross-validation recommends " (best) ", but this model was estimated by " (estimator) ". For one by " (best)
                " run " code { "estimate pool --estimator " (best) } "."
            }
        },
        None => html! { p { (undecided(estimator, &found.candidates)) } },
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

/// A row of the table: a term, or the constant of a degree of freedom.
#[derive(Clone, Copy)]
struct Row<'a> {
    degree: &'a ModelDegree,
    /// `None`: the constant.
    parameter: Option<&'a ModelParameter>,
}

fn parameters(model: &ModelDocument) -> Markup {
    let rows: Vec<Row> = model.degrees.iter().flat_map(Row::all).collect();
    let known = rows.iter().any(|row| row.truth().is_some());
    let mut table = Table::of(rows)
        .compact()
        .name("Parameter", |row| row.name())
        .text("Degree", |row| row.degree.name.as_str())
        .text("Term", |row| row.parameter.map_or("1", |p| p.term.as_str()))
        .text("Unit", |row| unit(row.parameter.map_or(&row.degree.unit, |p| &p.unit)))
        .number("Estimate", |row| three(row.parameter.map_or(row.degree.constant, |p| p.value)))
        .number("Standard error", |row| three_or_dash(row.parameter.and_then(|p| p.standard_error)));
    if known {
        table =
            table.number("True", |row| three_or_dash(row.truth())).number("Off by, standard errors", |row| {
                or_dash(row.off().map(|off| signed(&format!("{off:.1}"))))
            });
    }
    let table = table.number("Least squares", |row| three_or_dash(row.least_squares()));
    html! { (table) }
}

impl<'a> Row<'a> {
    fn all(degree: &'a ModelDegree) -> impl Iterator<Item = Self> {
        (0..=degree.parameters.len()).map(move |i| Self { degree, parameter: degree.parameters.get(i) })
    }

    fn name(self) -> String {
        self.parameter.map_or(format!("{} constant", self.degree.name), |p| p.name.clone())
    }

    fn truth(self) -> Option<f64> {
        self.parameter.and_then(|p| p.truth)
    }

    /// Estimate less truth in standard errors.
    fn off(self) -> Option<f64> {
        let p = self.parameter?;
        Some((p.value - p.truth?) / p.standard_error.filter(|error| *error > 0.0)?)
    }

    fn least_squares(self) -> Option<f64> {
        self.parameter.map_or(self.degree.constant_least_squares, |p| p.least_squares)
    }
}

/// The current that was found with the model, if it was unknown, a row per part.
fn surroundings(model: &ModelDocument) -> Markup {
    let Some(first) = model.surroundings.first() else { return html! {} };
    let named = Table::of(&model.surroundings)
        .compact()
        .name("Found around", |own| own.source.clone())
        .number("Part", |own| own.part.to_string());
    let table = first.found.iter().enumerate().fold(named, |table, (i, head)| {
        table.classed("number broken", format!("{} {}", head.name, unit(&head.unit)), |own| {
            let told = own.found.get(i).map(|own| (three(own.value), three_or_dash(own.standard_error)));
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

// Numbers of a fitted ship with forces, and sums of them, beside values of captive tests.

/// The ship's free numbers, then what the recordings know of sway and yaw.
fn derivatives(found: &FittedForces) -> Markup {
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
