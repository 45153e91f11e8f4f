use maud::{Markup, Render, display, html};
use study::documents::{DegreeOfFreedom, DesignSummary, EstimateDocument, Estimator, MeanRemoval};
use study::files::Vessel;

use super::estimators::recommendation;
use super::number::{or_dash, three, three_or_dash, unit};
use super::parts::{Figures, Section, Table, entry, missing};
use super::study::{Study, optimized_first};
use crate::figures::{ErrorRow, relative_errors};

/// The estimates of every parameter.
pub(super) fn parameters(study: &Study, figures: &mut Figures) -> Section {
    let body = match (&study.estimate, &study.vessel) {
        (Some(estimate), vessel) => estimated(&Shown::of(estimate, study), vessel.as_ref(), figures),
        (None, Some(vessel)) => html! {
            (missing("The estimates are", "estimate.json", "estimate"))
            (structure(vessel))
        },
        (None, None) => missing("The parameters are", "estimate.json", "estimate"),
    };
    Section::new("parameters", "Parameters", "Parameters", body)
}

/// The estimates that are shown.
struct Shown<'a> {
    estimator: Estimator,
    mean_removal: MeanRemoval,
    designs: &'a [DesignSummary],
    /// The reason for these, if several estimators were compared.
    why: Option<String>,
    /// Whether all runs were pooled: then the section on trust says what the model lacks.
    pooled: bool,
}

impl<'a> Shown<'a> {
    /// The estimates by the recommended estimator; else by the best one.
    fn of(estimate: &'a EstimateDocument, study: &Study) -> Self {
        let best = study.validation.as_ref().and_then(recommendation).and_then(|found| found.estimator);
        let compared = estimate.compared.as_deref().unwrap_or(&[]);
        let own = compared.iter().find(|own| Some(own.estimator) == best);
        let (estimator, designs) = match own {
            Some(own) => (own.estimator, &own.designs),
            None => (estimate.estimator, &estimate.designs),
        };
        let why = match own {
            Some(_) => format!("Estimates by {estimator}, which the validation recommends."),
            None => format!("No estimator is recommended; these are the estimates by {estimator}."),
        };
        let why = Some(why).filter(|_| !compared.is_empty());
        let pooled = estimate.trust.is_some();
        Self { estimator, mean_removal: estimate.mean_removal, designs, why, pooled }
    }
}

fn estimated(estimate: &Shown, vessel: Option<&Vessel>, figures: &mut Figures) -> Markup {
    let designs = optimized_first(estimate.designs, |d| &d.design);
    let rows = error_rows(&designs);
    let names: Vec<&str> = designs.iter().map(|d| d.design.as_str()).collect();
    let caption = html! {
        b { "Relative error of every parameter: mean (dot) and standard deviation (bar) over the runs." }
        " The axis is linear within ±10\u{a0}% and logarithmic beyond."
    };
    html! {
        @if let Some(why) = &estimate.why { p { (why) } }
        div.pair {
            @if rows.is_empty() {
                p.missing { "Relative errors are not shown: no parameter has a known true value other than zero." }
            } @else {
                (figures.place("relative-errors", relative_errors(&names, &rows), &caption))
            }
            (facts(estimate, &designs))
        }
        @for design in designs { (table(design, vessel)) }
    }
}

fn facts(estimate: &Shown, designs: &[&DesignSummary]) -> Markup {
    html! {
        dl.facts {
            (entry("Estimator", estimator(estimate.estimator)))
            (entry("Mean of the instruments removed", display(estimate.mean_removal)))
            @for design in designs {
                (entry(format!("Identified, {}", design.design), format!("{} of {} runs", design.identified, design.runs)))
                @if !estimate.pooled { (entry(format!("Model rejected, {}", design.design), rejected(design))) }
            }
            (entry("Spread", "standard deviation of the estimates over the identified runs"))
            (entry("Predicted", "median of the standard errors that the runs report of themselves"))
            (entry("Predicted / spread", "near 1: the reported standard errors can be trusted; below 1: they promise too much, or the runs are different experiments and the worst of them make the spread"))
        }
    }
}

/// The number of runs that reject the model.
fn rejected(design: &DesignSummary) -> String {
    match design.rejected {
        Some(rejected) => {
            format!("by {rejected} of {} runs; by chance by 1 in 20", design.identified)
        }
        None => "the runs were not asked what the model lacks".to_owned(),
    }
}

fn estimator(estimator: Estimator) -> &'static str {
    match estimator {
        Estimator::Iv => "instrumental variables",
        Estimator::Ls => "least squares",
        Estimator::OutputError => "output error: least errors of a free simulation",
        Estimator::PredictionError => "prediction error: least errors of a Kalman filter's predictions",
        Estimator::Auto => estimator.name(),
    }
}

fn error_rows<'a>(designs: &[&'a DesignSummary]) -> Vec<ErrorRow<'a>> {
    let parameters = designs.first().map_or(&[][..], |d| &d.parameters);
    let known = parameters.iter().filter(|parameter| parameter.relative_bias.is_some());
    let errors = |name: &str| designs.iter().map(|d| relative(d, name)).collect();
    known.map(|parameter| ErrorRow { name: &parameter.name, errors: errors(&parameter.name) }).collect()
}

fn relative(design: &DesignSummary, name: &str) -> Option<(f64, f64)> {
    let parameter = design.parameters.iter().find(|p| p.name == name)?;
    parameter.relative_bias.zip(parameter.relative_spread)
}

fn table(design: &DesignSummary, vessel: Option<&Vessel>) -> Markup {
    let table = Table::of(&design.parameters)
        .name("Parameter", |p| &p.name)
        .text("Term", |p| term(vessel, &p.name))
        .text("Unit", |p| unit(&p.unit))
        .number("True", |p| three_or_dash(p.truth))
        .number("Nominal", |p| three(p.nominal))
        .number("Mean estimate", |p| three_or_dash(p.mean))
        .number("Spread", |p| three_or_dash(p.spread))
        .number("Predicted", |p| three_or_dash(p.predicted_se))
        .number("Predicted / spread", |p| three_or_dash(p.se_ratio));
    html! { h3 { "Estimates, " (design.design) } (table) }
}

fn term(vessel: Option<&Vessel>, name: &str) -> String {
    or_dash(vessel.and_then(|v| terms(v).into_iter().find(|(_, own, _)| *own == name)).map(|(.., term)| term))
}

/// Every parameter with its degree of freedom and its term, in the order of `vessel.toml`.
fn terms(vessel: &Vessel) -> Vec<(DegreeOfFreedom, &str, &str)> {
    let degrees = DegreeOfFreedom::ALL.into_iter().zip(&vessel.model.degrees);
    let terms = degrees.flat_map(|(d, degree)| {
        degree
            .parameters
            .iter()
            .zip(&degree.terms)
            .map(move |(name, term)| (d, name.as_str(), term.text.as_str()))
    });
    terms.collect()
}

fn structure(vessel: &Vessel) -> Markup {
    let (terms, units) = (terms(vessel), vessel.model.parameter_units());
    let names: Vec<&str> = vessel.model.parameter_names().collect();
    // Those of forces belong to no one degree of freedom.
    let table = Table::of(0..names.len())
        .name("Parameter", |i| names[i])
        .text("Degree", |i| terms.get(i).map_or("–", |own| own.0.name()))
        .text("Term", |i| terms.get(i).map_or("–", |own| own.2))
        .text("Unit", |i| unit(&units[i]))
        .number("True", |i| three_or_dash(vessel.value[i]))
        .number("Nominal", |i| three(vessel.nominal[i]));
    table.render()
}
