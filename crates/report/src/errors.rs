use crate::figures::{Histogram, HistogramAxis, HistogramPanel, histogram_pair};
use maud::{Markup, html};

use super::caption::{below, truncation};
use super::dictionary::validation_input;
use super::missing::missing;
use super::placed::Figures;
use super::study::{ScoreSet, Study, optimized_first};
use study::documents::DesignScores;

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
    let shares = |share: fn(&DesignScores) -> f64| -> Vec<Option<f64>> {
        let own = |s: &&ScoreSet| study.scored().into_iter().find(|d| d.design == s.design).map(share);
        scores.iter().map(own).collect()
    };
    let mut place = |quantity: &Quantity, bound: Option<f64>, shares: &[Option<f64>]| {
        let panels = panels(quantity, &scores, bound, shares);
        let drawing = histogram_pair(&quantity.axis(bound), &panels);
        figures.place(quantity.file, drawing, &caption(quantity, &scores))
    };
    let parameter =
        place(&PARAMETER, bounds.map(|b| b.parameter_error), &shares(|d| d.parameter_error_share));
    let simulation =
        place(&SIMULATION, bounds.map(|b| b.simulation_error), &shares(|d| d.simulation_error_share));
    let degrees = [0, 1, 2].map(|d: usize| place(&DEGREES[d], None, &[]));
    html! {
        div.pair { (parameter) (simulation) }
        div.triple { @for degree in degrees { (degree) } }
    }
}

impl Quantity {
    fn axis(&self, bound: Option<f64>) -> HistogramAxis<'static> {
        HistogramAxis { title: self.title, limit: self.limit, bins: BINS, bound, width: self.width }
    }
}

/// A panel per design; `shares` of the runs are below the bound.
fn panels<'a>(
    quantity: &Quantity,
    scores: &[&'a ScoreSet],
    bound: Option<f64>,
    shares: &[Option<f64>],
) -> Vec<HistogramPanel<'a>> {
    let panel = |(colour, scores): (usize, &&'a ScoreSet)| HistogramPanel {
        label: &scores.design,
        values: (quantity.values)(scores),
        note: bound.zip(shares.get(colour).copied().flatten()).map(|(bound, share)| below(share, bound)),
        colour,
    };
    scores.iter().enumerate().map(panel).collect()
}

fn caption(quantity: &Quantity, scores: &[&ScoreSet]) -> Markup {
    let count = |scores: &&ScoreSet| Histogram::new((quantity.values)(scores), quantity.limit, BINS);
    let counted: Vec<Histogram> = scores.iter().map(count).collect();
    let named: Vec<(&str, &Histogram)> = scores.iter().map(|s| s.design.as_str()).zip(&counted).collect();
    html! { b { (quantity.caption) } " " (truncation(&named, quantity.limit)) }
}
