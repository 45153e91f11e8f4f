use maud::{Markup, html};
use study::documents::{DegreeOfFreedom, ErrorCorrelations, ErrorKind};

use super::number::{exact, three};
use super::parts::Figures;
use crate::figures::{CorrelationCell, CorrelationRow, correlations};

/// Inputs beyond this many are not drawn.
const MOST_INPUTS: usize = 7;

/// Correlations of the model's errors with themselves and with inputs: one-step residuals, then free-run errors.
pub(super) fn residuals(found: &[ErrorCorrelations], figures: &mut Figures) -> Markup {
    let of = |kind: ErrorKind| found.iter().filter(|own| own.of == kind).collect::<Vec<_>>();
    html! {
        @if !found.is_empty() { h3 { "What is left of the errors" } }
        (drawn("residual-correlations", &of(ErrorKind::OneStep), figures, &one_step()))
        (drawn("error-correlations", &of(ErrorKind::FreeRun), figures, &free_run()))
    }
}

fn one_step() -> Markup {
    html! {
        b { "Correlations of one-step residuals" }
        " (measured increments less predicted ones) with themselves and with the inputs, of which those at lags above 0 came \
         before. They are moving averages by construction, however right the model is: the noise of a measured sample enters \
         two increments with opposite signs, hence about −0.5 at lag 1 where it is all there is. So do not judge the structure \
         by them: " b { "What the model lacks" } ", in the section on trust, tests whitened residuals, which are free of this. \
         What counts here is an input, or a lag above 1, that stands out."
    }
}

fn free_run() -> Markup {
    html! {
        b { "Correlations of free-run errors" }
        " (measured less simulated states). A free simulation sums up whatever it lacks, so its errors stay correlated for as \
         long as the ship remembers, and the band does not hold for them. A correlation with an input is what the model could \
         still have learnt from it: at lags above 0 its effect is too weak, too strong or of another form; at lags below 0 the \
         helm answered to motion that the model does not have. Inputs that change slowly spread it over many lags."
    }
}

fn drawn(name: &str, found: &[&ErrorCorrelations], figures: &mut Figures, caption: &Markup) -> Markup {
    let Some(first) = found.first() else { return html! {} };
    let inputs: Vec<&str> = first.inputs.iter().map(|input| input.name.as_str()).collect();
    let shown = &inputs[..inputs.len().min(MOST_INPUTS)];
    let titles: Vec<&str> = ["itself"].into_iter().chain(shown.iter().copied()).collect();
    let rows: Vec<CorrelationRow> = found.iter().map(|own| row(own, shown)).collect();
    let caption = html! {
        (caption) " " (band(first))
        @if shown.len() < inputs.len() { " The first " (shown.len()) " of " (inputs.len()) " inputs." }
    };
    figures.place_wide(name, correlations(&titles, &rows), &caption)
}

fn row<'a>(error_correlations: &'a ErrorCorrelations, shown: &[&str]) -> CorrelationRow<'a> {
    let crossed = |name: &&str| match error_correlations.inputs.iter().find(|input| input.name == *name) {
        Some(input) => cell(-half(input.crossed.len()), &input.crossed),
        None => cell(0, &[]),
    };
    let name = DegreeOfFreedom::ALL.into_iter().find(|d| d.state() == error_correlations.state);
    let cells = std::iter::once(cell(1, &error_correlations.own)).chain(shown.iter().map(crossed));
    CorrelationRow {
        name: name.map_or("", DegreeOfFreedom::name),
        bound: error_correlations.bound,
        cells: cells.collect(),
    }
}

fn cell(first: i32, values: &[f64]) -> CorrelationCell<'_> {
    CorrelationCell { first, values }
}

/// Lags on either side of 0.
fn half(lags: usize) -> i32 {
    i32::try_from(lags / 2).unwrap_or(0)
}

fn band(found: &ErrorCorrelations) -> Markup {
    html! {
        "Grey: ±1.96/√N = ±" (three(found.bound)) " with N = " (exact(found.samples as f64))
        "; of white errors, 95 % of the correlations lie in it and one in twenty does not."
    }
}
