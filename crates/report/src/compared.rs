use files::Error;
use maud::{Markup, html};
use study::documents::{
    CompareDocument, ComparedErrors, DegreeOfFreedom, ErrorCorrelations, ErrorKind, Traced, traces as columns,
};

use super::loader::Loader;
use super::number::{exact, fit, three_or_dash, three_within};
use super::parts::{Figures, Section, Table, grouped, statements};
use super::sailed::sailed;
use crate::figures::{
    CorrelationCell, CorrelationRow, Curve, TraceColumn, TraceRow, correlations, palette, traces,
};
use crate::number::three;

/// Windows beyond this many are not drawn.
const MOST_WINDOWS: usize = 24;

/// Reads `compare.json` and `compare.parquet`, if both exist.
pub(super) fn load(loader: &mut Loader) -> Result<Option<(CompareDocument, Vec<Traced>)>, Error> {
    let found = loader.document("compare.json", "the model on recordings that it was not fitted to")?;
    let Some(found) = found else { return Ok(None) };
    let reader =
        loader.table("compare.parquet", "the model over time on these recordings", ("compare", 1))?;
    let rows = reader.map(|reader| columns().read(&reader, &Traced::default())).transpose()?;
    Ok(Some((found, rows.unwrap_or_default())))
}

/// The model on recordings that it was not fitted to: the verdict, numbers, measured and simulated over time.
pub(super) fn compared(
    compared: Option<&(CompareDocument, Vec<Traced>)>,
    figures: &mut Figures,
) -> Option<Section> {
    let (found, trace) = compared?;
    let body = html! {
        (about(found))
        (statements(&found.statements))
        (models(found))
        (differences(found))
        @if !trace.is_empty() { (over_time(trace, figures)) }
        (recordings(found))
        (residuals(&found.correlations, figures))
    };
    Some(Section::new("compared", "Model on other recordings", "The model on other recordings", body))
}

fn about(found: &CompareDocument) -> Markup {
    let windows =
        found.window_s.map_or("whole recordings".to_owned(), |s| format!("windows of {} s", exact(s)));
    html! {
        p {
            "Each model is simulated freely over " (found.windows) " " (windows) ", " (found.samples)
            " samples, from the first measured state of each."
        }
    }
}

fn models(found: &CompareDocument) -> Markup {
    let named = Table::of(&found.models).compact().name("Model", |m| m.name.to_string());
    html! { (errors(named, |m| &m.errors)) }
}

/// Adds columns of errors.
fn errors<'a, R: Copy>(table: Table<R>, of: impl Fn(R) -> &'a ComparedErrors + Copy) -> Table<R> {
    table
        .number("Fit u", move |row| fit(of(row).fit_u))
        .number("Fit v", move |row| fit(of(row).fit_v))
        .number("Fit r", move |row| fit(of(row).fit_r))
        .number("RMSE u [m/s]", move |row| three_or_dash(of(row).rmse_u))
        .number("RMSE v [m/s]", move |row| three_or_dash(of(row).rmse_v))
        .number("RMSE r [rad/s]", move |row| three_or_dash(of(row).rmse_r))
        .number("Bias u [m/s]", move |row| three_or_dash(of(row).bias_u))
        .number("Bias v [m/s]", move |row| three_or_dash(of(row).bias_v))
        .number("Bias r [rad/s]", move |row| three_or_dash(of(row).bias_r))
        .number("Error norm", move |row| three_or_dash(of(row).error_norm))
        .number("Diverged", move |row| of(row).diverged)
}

fn differences(found: &CompareDocument) -> Markup {
    let table = Table::of(&found.differences)
        .name("Against", |d| d.name.to_string())
        .number("Its error norm lies above by", |d| three_within(d.median, Some(d.interval)))
        .number("Pairs", |d| d.pairs);
    html! {
        (table)
        p.note {
            "Median over recordings, or windows where there are few recordings, with its 95 % interval; one that contains 0 \
             tells no difference. Error norm: norm of RMSE over the standard deviations of u, v, r. The bands come from "
            @if found.spread.is_some() { "how far the models are apart" } @else { "the parameters' covariance" }
            " and the errors on the recordings that were fitted; those of a searched model from its errors on recordings left \
             out of the search."
        }
    }
}

/// A row per drawn window.
fn over_time(trace: &[Traced], figures: &mut Figures) -> Markup {
    let windows: Vec<&[Traced]> =
        trace.chunk_by(|a, b| a.source == b.source && a.window == b.window).collect();
    let drawn = &windows[..windows.len().min(MOST_WINDOWS)];
    let times: Vec<Vec<f64>> = drawn.iter().map(|own| own.iter().map(|row| row.t).collect()).collect();
    let legend = || vec![("simulated, with its 95 % band".to_owned(), palette::BLUE)];
    let columns = ["surge speed u [m/s]", "sway speed v [m/s]", "yaw rate r [rad/s]"]
        .map(|title| TraceColumn { title, legend: legend() });
    let cell = |own: &[Traced], d: usize| {
        let band: Vec<f64> = own.iter().filter_map(|row| row.half[d]).collect();
        let measured = own.iter().map(|row| row.measured[d]).collect();
        let simulated = own.iter().map(|row| row.simulated[d]).collect();
        vec![
            Curve { values: simulated, colour: Some(palette::BLUE), band, is_thin: false },
            Curve { values: measured, ..Curve::default() },
        ]
    };
    let row = |(own, t): (&&[Traced], &'_ Vec<f64>)| {
        (own[0].source.clone(), t.clone(), [0, 1, 2].map(|d| cell(own, d)))
    };
    let rows: Vec<_> = drawn.iter().zip(&times).map(row).collect();
    let rows: Vec<TraceRow> = rows
        .iter()
        .zip(drawn)
        .map(|((name, t, cells), own)| TraceRow {
            name,
            note: Some(format!("window {}", own[0].window + 1)),
            t,
            cells: cells.to_vec(),
        })
        .collect();
    let caption = html! {
        b { "Measured (black) and simulated (blue) over time." }
        " All rows of a column share one axis."
        @if windows.len() > drawn.len() { " The first " (drawn.len()) " of " (windows.len()) " windows." }
    };
    html! {
        (figures.place_wide("compared", traces(&columns, &rows), &caption))
        (sailed(&windows, figures))
    }
}

fn recordings(found: &CompareDocument) -> Markup {
    let rows = grouped(found.models.first(), |model| &model.recordings);
    let named = Table::of(rows.iter().map(|(_, _, recording)| *recording))
        .compact()
        .name("Recording", |r| r.source.as_str())
        .number("Windows", |r| r.errors.windows);
    html! {
        h3 { "Recording by recording" }
        (errors(named, |r| &r.errors))
        p.note { "Fits of a recording are against the standard deviations of its own states." }
    }
}

/// Inputs beyond this many are not drawn.
const MOST_INPUTS: usize = 7;

/// Correlations of the model's errors with themselves and with inputs: one-step residuals, then free-run errors.
fn residuals(found: &[ErrorCorrelations], figures: &mut Figures) -> Markup {
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
