use crate::figures::{Histogram, HistogramAxis, HistogramPanel, histogram_pair};
use maud::{Markup, html};

use super::caption::{below, truncation};
use super::dictionary::validation_input;
use super::missing::missing;
use super::placed::Figures;
use super::study::{ScoreSet, Study, optimized_first};

/// One histogram figure: which value, its axis, its width [px] and the name of its file.
struct Quantity {
    file: &'static str,
    title: &'static str,
    caption: &'static str,
    limit: f64,
    width: f64,
    values: fn(&ScoreSet) -> &[Option<f64>],
}

const BINS: usize = 50;

const PARAMETER: Quantity = Quantity {
    file: "parameter-error",
    title: "parameter error [1]",
    caption: "Norm of the relative parameter errors.",
    limit: 25.0,
    width: 460.0,
    values: |scores| &scores.parameter_error,
};
const SIMULATION: Quantity = Quantity {
    file: "simulation-error",
    title: "norm of the simulation RMSE [m/s, m/s, rad/s]",
    caption: "Norm of the simulation errors.",
    limit: 0.5,
    width: 460.0,
    values: |scores| &scores.simulation_error,
};
const DEGREES: [Quantity; 3] = [
    Quantity {
        file: "rmse-surge",
        title: "RMSE in surge [m/s]",
        caption: "Simulation error in surge.",
        limit: 1.0,
        width: 360.0,
        values: |scores| &scores.rmse_u,
    },
    Quantity {
        file: "rmse-sway",
        title: "RMSE in sway [m/s]",
        caption: "Simulation error in sway.",
        limit: 0.25,
        width: 360.0,
        values: |scores| &scores.rmse_v,
    },
    Quantity {
        file: "rmse-yaw",
        title: "RMSE in yaw rate [rad/s]",
        caption: "Simulation error in yaw.",
        limit: 0.15,
        width: 360.0,
        values: |scores| &scores.rmse_r,
    },
];

/// The histograms of all errors over the runs, and the input of the validation.
pub(super) fn errors(study: &Study, figures: &mut Figures) -> Markup {
    let body = match study.scores.as_deref() {
        Some(scores) if !scores.is_empty() => drawn(study, scores, figures),
        _ => missing("The histograms are", "scores.parquet", "validate"),
    };
    let input = match &study.validation_trace {
        Some(trace) => validation_input(trace, figures),
        None => missing("The validation input is", "validation.parquet", "simulate validation"),
    };
    html! { section #errors { h2 { "Errors of the estimated models" } (body) (input) } }
}

fn drawn(study: &Study, scores: &[ScoreSet], figures: &mut Figures) -> Markup {
    let scores = optimized_first(scores, |s| &s.design);
    let bounds = study.validation.as_ref().map(|v| v.bounds);
    let mut place = |quantity: &Quantity, bound: Option<f64>| place(quantity, &scores, bound, figures);
    let parameter = place(&PARAMETER, bounds.map(|b| b.parameter_error));
    let simulation = place(&SIMULATION, bounds.map(|b| b.simulation_error));
    let degrees = [place(&DEGREES[0], None), place(&DEGREES[1], None), place(&DEGREES[2], None)];
    html! {
        div.pair { (parameter) (simulation) }
        div.triple { @for degree in degrees { (degree) } }
    }
}

fn place(quantity: &Quantity, scores: &[&ScoreSet], bound: Option<f64>, figures: &mut Figures) -> Markup {
    let axis = HistogramAxis {
        title: quantity.title,
        limit: quantity.limit,
        bins: BINS,
        bound,
        width: quantity.width,
    };
    let panels: Vec<HistogramPanel<'_>> =
        scores.iter().enumerate().map(|(index, scores)| panel(quantity, index, scores, bound)).collect();
    figures.place(quantity.file, histogram_pair(&axis, &panels), &caption(quantity, scores))
}

fn panel<'a>(
    quantity: &Quantity,
    index: usize,
    scores: &'a ScoreSet,
    bound: Option<f64>,
) -> HistogramPanel<'a> {
    let values = (quantity.values)(scores);
    let note = bound.map(|bound| below(share_below(values, bound), bound));
    HistogramPanel { label: &scores.design, values, note, colour: index }
}

/// Share of all runs, those without a value included, that are below `bound`.
fn share_below(values: &[Option<f64>], bound: f64) -> f64 {
    let good = values.iter().flatten().filter(|value| **value < bound).count();
    good as f64 / values.len() as f64
}

fn caption(quantity: &Quantity, scores: &[&ScoreSet]) -> Markup {
    let count = |scores: &&ScoreSet| Histogram::new((quantity.values)(scores), quantity.limit, BINS);
    let counted: Vec<Histogram> = scores.iter().map(count).collect();
    let named: Vec<(&str, &Histogram)> = scores.iter().map(|s| s.design.as_str()).zip(&counted).collect();
    html! { b { (quantity.caption) } " " (truncation(&named, quantity.limit)) }
}
