use crate::figures::{ErrorRow, relative_errors};
use identification::Estimator;
use maud::{Markup, html};

use super::missing::missing;
use super::number::{three, three_or_dash, unit};
use super::placed::Figures;
use super::study::{ParameterRow, Study, VesselSummary, optimized_first};
use study::documents::{DesignSummary, EstimateDocument};

/// What the estimates say about every parameter.
pub(super) fn parameters(study: &Study, figures: &mut Figures) -> Markup {
    let body = match (&study.estimate, &study.vessel) {
        (Some(estimate), vessel) => estimated(estimate, vessel.as_ref(), figures),
        (None, Some(vessel)) => html! {
            (missing("The estimates are", "estimate.json", "estimate"))
            (structure(vessel))
        },
        (None, None) => missing("The parameters are", "estimate.json", "estimate"),
    };
    html! { section #parameters { h2 { "Parameters" } (body) } }
}

fn estimated(estimate: &EstimateDocument, vessel: Option<&VesselSummary>, figures: &mut Figures) -> Markup {
    let designs = optimized_first(&estimate.designs, |d| &d.design);
    let rows = error_rows(&designs);
    let names: Vec<&str> = designs.iter().map(|d| d.design.as_str()).collect();
    let caption = html! {
        b { "Relative error of every parameter: mean (dot) and standard deviation (bar) over the runs." }
        " The axis is linear within ±10\u{a0}% and logarithmic beyond."
    };
    html! {
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

fn facts(estimate: &EstimateDocument, designs: &[&DesignSummary]) -> Markup {
    html! {
        dl.facts {
            div { dt { "Estimator" } dd { (estimator(estimate.estimator)) } }
            div { dt { "Mean of the instruments removed" } dd { (estimate.mean_removal) } }
            @for design in designs {
                div { dt { "Identified, " (design.design) } dd { (design.identified) " of " (design.runs) " runs" } }
            }
            div { dt { "Spread" } dd { "standard deviation of the estimates over the identified runs" } }
            div { dt { "Predicted" } dd { "median of the standard errors that the runs report of themselves" } }
            div { dt { "Predicted / spread" } dd { "near 1: the reported standard errors can be trusted; below 1: they promise too much, or the runs are different experiments and the worst of them make the spread" } }
        }
    }
}

fn estimator(estimator: Estimator) -> &'static str {
    match estimator {
        Estimator::Iv => "instrumental variables",
        Estimator::Ls => "least squares",
        Estimator::RefinedIv => {
            "instrumental variables, instruments simulated again with the estimate, all signals filtered by its poles"
        }
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

fn table(design: &DesignSummary, vessel: Option<&VesselSummary>) -> Markup {
    html! {
        h3 { "Estimates, " (design.design) }
        div.scroll { table {
            thead { tr {
                th scope="col" { "Parameter" } th scope="col" { "Term" } th scope="col" { "Unit" }
                @for title in ["True", "Nominal", "Mean estimate", "Spread", "Predicted", "Predicted / spread"] {
                    th.number scope="col" { (title) }
                }
            } }
            tbody { @for parameter in &design.parameters {
                tr {
                    th scope="row" { (parameter.name) }
                    td { (term(vessel, &parameter.name)) }
                    td { (unit(&parameter.unit)) }
                    td.number { (three_or_dash(parameter.truth)) }
                    td.number { (three(parameter.nominal)) }
                    td.number { (three_or_dash(parameter.mean)) }
                    td.number { (three_or_dash(parameter.spread)) }
                    td.number { (three_or_dash(parameter.predicted_se)) }
                    td.number { (three_or_dash(parameter.se_ratio)) }
                }
            } }
        } }
    }
}

fn term(vessel: Option<&VesselSummary>, name: &str) -> String {
    let row = vessel.and_then(|v| v.parameters.iter().find(|p| p.name == name));
    row.map_or("–".to_owned(), |row| row.term.clone())
}

fn structure(vessel: &VesselSummary) -> Markup {
    let row = |parameter: &ParameterRow| {
        html! { tr {
            th scope="row" { (parameter.name) }
            td { (parameter.degree) } td { (parameter.term) } td { (unit(&parameter.unit)) }
            td.number { (three_or_dash(parameter.truth)) } td.number { (three(parameter.nominal)) }
        } }
    };
    html! {
        div.scroll { table {
            thead { tr {
                th scope="col" { "Parameter" } th scope="col" { "Degree" } th scope="col" { "Term" } th scope="col" { "Unit" }
                th.number scope="col" { "True" } th.number scope="col" { "Nominal" }
            } }
            tbody { @for parameter in &vessel.parameters { (row(parameter)) } }
        } }
    }
}
