use maud::{Markup, html};

use crate::figures::HistogramPanel;

use super::dictionary::validation_input;
use super::histograms::ErrorFigure;
use super::number::{exact, percent};
use super::parts::{Figures, Section, missing};
use super::study::{Study, optimized_first};
use study::documents::DesignScores;
use study::estimates::distinct;
use study::scores::Row;

const PARAMETER: ErrorFigure<'_> = ErrorFigure::half("parameter-error", "parameter error [1]", 25.0)
    .captioned("Norm of the relative parameter errors; of true values of 0 that of the estimates.");
const SIMULATION: ErrorFigure<'_> =
    ErrorFigure::half("simulation-error", "norm of the simulation RMSE [m/s, m/s, rad/s]", 0.5)
        .captioned("Norm of the simulation errors.");
const CAPTIONS: [&str; 3] =
    ["Simulation error in surge.", "Simulation error in sway.", "Simulation error in yaw."];

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

/// The bound below which a run counts as good, and the share of runs that do.
type Good = (f64, fn(&DesignScores) -> f64);

fn drawn(study: &Study, scores: &[Row], figures: &mut Figures) -> Markup {
    let designs = distinct(scores.iter().map(|row| row.design.as_str()));
    let designs: Vec<&str> = optimized_first(&designs, |design| design).into_iter().copied().collect();
    let scored = study.scored();
    let panels = |value: &dyn Fn(&Row) -> Option<f64>, good: Option<Good>| -> Vec<HistogramPanel<'_>> {
        let values = |design: &str| scores.iter().filter(|row| row.design == design).map(value).collect();
        let note = |design: &str| {
            let ((bound, share), own) = (good?, scored.iter().find(|d| d.design == design)?);
            Some(format!("{} below {}", percent(share(own)), exact(bound)))
        };
        let all = designs.iter();
        all.map(|design| HistogramPanel { label: design, values: values(design), note: note(design) })
            .collect()
    };
    let bounds = study.validation.as_ref().map(|v| v.bounds);
    let parameter = bounds.map(|b| -> Good { (b.parameter_error, |d| d.parameter_error_share) });
    let simulation = bounds.map(|b| -> Good { (b.simulation_error, |d| d.simulation_error_share) });
    let degrees = ErrorFigure::thirds(["rmse-surge", "rmse-sway", "rmse-yaw"], [1.0, 0.25, 0.15]);
    html! {
        div.pair {
            (PARAMETER.bounded(parameter.map(|p| p.0)).place(&panels(&|r| r.parameter_error, parameter), figures))
            (SIMULATION.bounded(simulation.map(|s| s.0)).place(&panels(&|r| r.simulation_error, simulation), figures))
        }
        div.triple {
            @for (d, figure) in degrees.iter().enumerate() {
                (figure.captioned(CAPTIONS[d]).place(&panels(&|r| r.rmse[d], None), figures))
            }
        }
    }
}
