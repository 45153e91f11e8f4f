use maud::{Markup, html};

use super::dictionary::validation_input;
use super::histograms::{DesignErrors, ErrorFigure};
use super::parts::{Figures, Section, missing};
use super::study::{Study, optimized_first};
use study::documents::DesignScores;
use study::estimates::distinct;
use study::scores::Row;

const PARAMETER: ErrorFigure<'_> = ErrorFigure::half("parameter-error", "parameter error [1]", 25.0)
    .captioned("Norm of the relative parameter errors.");
const SIMULATION: ErrorFigure<'_> =
    ErrorFigure::half("simulation-error", "norm of the simulation RMSE [m/s, m/s, rad/s]", 0.5)
        .captioned("Norm of the simulation errors.");
const DEGREES: [ErrorFigure<'_>; 3] = [
    ErrorFigure::third("rmse-surge", "RMSE in surge [m/s]", 1.0).captioned("Simulation error in surge."),
    ErrorFigure::third("rmse-sway", "RMSE in sway [m/s]", 0.25).captioned("Simulation error in sway."),
    ErrorFigure::third("rmse-yaw", "RMSE in yaw rate [rad/s]", 0.15).captioned("Simulation error in yaw."),
];

/// The histograms of all errors over the runs, and the input of the validation.
pub(super) fn errors(study: &Study, figures: &mut Figures) -> Section {
    let body = match study.scores.as_deref() {
        Some(scores) if !scores.is_empty() => drawn(study, scores, figures),
        _ => missing("The histograms are", "scores.parquet", "validate"),
    };
    let input = match &study.validation_trace {
        Some(trace) => validation_input(trace, figures),
        None => missing("The validation input is", "validation.parquet", "simulate validation"),
    };
    Section::new("errors", "Errors", "Errors of the estimated models", html! { (body) (input) })
}

fn drawn(study: &Study, scores: &[Row], figures: &mut Figures) -> Markup {
    let designs = distinct(scores.iter().map(|row| row.design.as_str()));
    let designs: Vec<&str> = optimized_first(&designs, |design| design).into_iter().copied().collect();
    let scored = study.scored();
    let errors = |value: &dyn Fn(&Row) -> Option<f64>, share: Option<fn(&DesignScores) -> f64>| {
        let values = |design: &str| scores.iter().filter(|row| row.design == design).map(value).collect();
        let below = |design: &str| Some(share?(scored.iter().find(|d| d.design == design)?));
        let all = designs.iter();
        all.map(|design| DesignErrors { design, values: values(design), below: below(design) })
            .collect::<Vec<_>>()
    };
    let bounds = study.validation.as_ref().map(|v| v.bounds);
    let parameter = PARAMETER.bounded(bounds.map(|b| b.parameter_error));
    let simulation = SIMULATION.bounded(bounds.map(|b| b.simulation_error));
    html! {
        div.pair {
            (parameter.place(&errors(&|r| r.parameter_error, Some(|d| d.parameter_error_share)), figures))
            (simulation.place(&errors(&|r| r.simulation_error, Some(|d| d.simulation_error_share)), figures))
        }
        div.triple {
            @for (d, figure) in DEGREES.iter().enumerate() { (figure.place(&errors(&|r| r.rmse[d], None), figures)) }
        }
    }
}
