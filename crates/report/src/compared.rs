use files::Error;
use maud::{Markup, html};
use ship::engine::{Pose, track};
use study::documents::{
    Compared, ComparedErrors, DegreeOfFreedom, ErrorCorrelations, ErrorKind, Traced, traces as columns,
};

use crate::figures::{
    CorrelationCell, CorrelationRow, Curve, TraceColumn, TraceRow, TrackCell, TrackLine, correlations,
    palette, traces, tracks,
};
use crate::interactive;
use crate::loader::Loader;
use crate::number::{exact, fit, three, three_or_dash, three_within, windows_of};
use crate::parts::{Figures, HtmlTable, Section, grouped, statements};

/// Windows, and recordings, beyond this many are not drawn.
const MOST: usize = 24;

/// The model on `recordings`, and over time by `compare.parquet`.
pub(super) fn load(
    loader: &mut Loader,
    recordings: Option<Compared>,
) -> Result<Option<(Compared, Vec<Traced>)>, Error> {
    let Some(recordings) = recordings else { return Ok(None) };
    let reader =
        loader.table("compare.parquet", "the model over time on these recordings", ("compare", 1))?;
    let rows = reader.map(|reader| columns().read(&reader, &Traced::default())).transpose()?;
    Ok(Some((recordings, rows.unwrap_or_default())))
}

/// The model on recordings that it was not fitted to: the verdict, numbers, measured and simulated over time.
pub(super) fn compared(compared: Option<&(Compared, Vec<Traced>)>, figures: &mut Figures) -> Option<Section> {
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

fn about(found: &Compared) -> Markup {
    let windows = windows_of(found.window_s);
    html! {
        p {
            "Each model is simulated freely over " (found.windows) " " (windows) ", " (found.samples)
            " samples, from the first measured state of each."
        }
    }
}

fn models(found: &Compared) -> Markup {
    let named = HtmlTable::of(&found.models).compact().name("Model", |m| m.name.to_string());
    html! { (errors(named, |m| &m.errors)) }
}

/// Adds columns of errors.
fn errors<'a, R: Copy>(table: HtmlTable<R>, of: impl Fn(R) -> &'a ComparedErrors + Copy) -> HtmlTable<R> {
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

fn differences(found: &Compared) -> Markup {
    let table = HtmlTable::of(&found.differences)
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
    let drawn = &windows[..windows.len().min(MOST)];
    let times: Vec<Vec<f64>> = drawn.iter().map(|window| window.iter().map(|row| row.t).collect()).collect();
    let legend = || vec![("simulated, with its 95 % band".to_owned(), palette::BLUE)];
    let columns = ["surge speed u [m/s]", "sway speed v [m/s]", "yaw rate r [rad/s]"]
        .map(|title| TraceColumn { title, legend: legend() });
    let cell = |window: &[Traced], d: usize| {
        let band: Vec<f64> = window.iter().filter_map(|row| row.half[d]).collect();
        let measured = window.iter().map(|row| row.measured[d]).collect();
        let simulated = window.iter().map(|row| row.simulated[d]).collect();
        vec![
            Curve { values: simulated, colour: Some(palette::BLUE), band, is_thin: false },
            Curve { values: measured, ..Curve::default() },
        ]
    };
    let rows = drawn.iter().zip(&times).map(|(window, t)| TraceRow {
        name: &window[0].source,
        note: Some(format!("window {}", window[0].window + 1)),
        t,
        cells: [0, 1, 2].map(|d| cell(window, d)).to_vec(),
    });
    let rows: Vec<TraceRow> = rows.collect();
    let caption = html! {
        b { "Measured (black) and simulated (blue) over time." }
        " All rows of a column share one axis."
        @if windows.len() > drawn.len() { " The first " (drawn.len()) " of " (windows.len()) " windows." }
    };
    let drawn = figures.place_wide("compared", traces(&columns, &rows), &caption);
    html! {
        (figures.interactive(interactive::over_time(&windows), &drawn))
        (sailed(&windows, figures))
    }
}

fn recordings(found: &Compared) -> Markup {
    let rows = grouped(found.models.first(), |model| &model.recordings);
    let named = HtmlTable::of(rows.iter().map(|(_, _, recording)| *recording))
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
    let of =
        |kind: ErrorKind| found.iter().filter(|correlations| correlations.of == kind).collect::<Vec<_>>();
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
    let rows: Vec<CorrelationRow> = found.iter().map(|correlations| row(correlations, shown)).collect();
    let caption = html! {
        (caption) " " (band(first))
        @if shown.len() < inputs.len() { " The first " (shown.len()) " of " (inputs.len()) " inputs." }
    };
    figures.place_wide(name, correlations(&titles, &rows), &caption)
}

fn row<'a>(found: &'a ErrorCorrelations, shown: &[&str]) -> CorrelationRow<'a> {
    let crossed = |name: &&str| match found.inputs.iter().find(|input| input.name == *name) {
        Some(input) => cell(-half(input.crossed.len()), &input.crossed),
        None => cell(0, &[]),
    };
    let name = DegreeOfFreedom::ALL.into_iter().find(|d| d.state() == found.state);
    let cells = std::iter::once(cell(1, &found.own)).chain(shown.iter().map(crossed));
    CorrelationRow {
        name: name.map_or("", DegreeOfFreedom::name),
        bound: found.bound,
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

/// A gapless section of a recording: the measured track, and a simulated one for every window.
#[derive(Default)]
struct Sailed<'a> {
    source: &'a str,
    /// The last row measured.
    last: Option<&'a Traced>,
    measured: Vec<Pose>,
    simulated: Vec<Vec<Pose>>,
}

/// Measured and simulated tracks of every recording, whose rows are grouped by `windows`.
fn sailed(windows: &[&[Traced]], figures: &mut Figures) -> Markup {
    let mut all: Vec<Sailed> = Vec::new();
    for window in windows {
        if !all.last().is_some_and(|sailed| sailed.continues_with(window)) {
            all.push(Sailed { source: &window[0].source, ..Sailed::default() });
        }
        all.last_mut().into_iter().for_each(|sailed| sailed.add(window));
    }
    let drawn = &all[..all.len().min(MOST)];
    let axes: Vec<Vec<[Vec<f64>; 2]>> = drawn.iter().map(Sailed::axes).collect();
    let colour = |i: usize| (i > 0).then_some(palette::BLUE);
    let cells = drawn.iter().zip(&axes).map(|(sailed, axes)| {
        let lines = axes.iter().enumerate().map(|(i, [x, y])| TrackLine { x, y, colour: colour(i) });
        TrackCell { name: sailed.source, lines: lines.collect() }
    });
    let cells: Vec<TrackCell> = cells.collect();
    let caption = html! {
        b { "Tracks as measured (black) and simulated (blue), seen from above." }
        " All at one scale, both axes alike; up is the heading at the start (the dot), right is starboard. No positions are \
         compared: both tracks follow from speeds and yaw rate, summed up from the same start, each window's simulated one \
         from where the measured one then was."
        @if drawn.len() < all.len() { " The first " (drawn.len()) " of " (all.len()) "." }
    };
    figures.place_wide("compared-tracks", tracks(&cells), &caption)
}

impl<'a> Sailed<'a> {
    /// Whether `window` continues this section.
    fn continues_with(&self, window: &[Traced]) -> bool {
        let last = self.last.map(|row| row.measured);
        self.source == window[0].source && last == Some(window[0].measured)
    }

    fn add(&mut self, window: &'a [Traced]) {
        let start = self.measured.pop().unwrap_or_default();
        self.measured.extend(followed(start, window, |row| row.measured));
        self.simulated.push(followed(start, window, |row| row.simulated));
        self.last = window.last();
    }

    /// x and y of the measured track, then of the simulated ones.
    fn axes(&self) -> Vec<[Vec<f64>; 2]> {
        let axes = |poses: &Vec<Pose>| {
            [poses.iter().map(|pose| pose.x).collect(), poses.iter().map(|pose| pose.y).collect()]
        };
        std::iter::once(&self.measured).chain(&self.simulated).map(axes).collect()
    }
}

/// Poses over `window` from `start`, with these velocities.
fn followed(start: Pose, window: &[Traced], velocities: impl Fn(&Traced) -> [f64; 3]) -> Vec<Pose> {
    let states: Vec<f64> = window.iter().flat_map(velocities).collect();
    let step = window.get(1).map_or(1.0, |row| row.t - window[0].t);
    let (sin, cos) = libm::sincos(start.psi);
    let placed = |pose: Pose| Pose {
        x: start.x + cos * pose.x - sin * pose.y,
        y: start.y + sin * pose.x + cos * pose.y,
        psi: start.psi + pose.psi,
    };
    track(&states, 1.0 / step).into_iter().map(placed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(window: i32, from: usize, samples: usize) -> Vec<Traced> {
        let row = |k: usize| Traced {
            source: "turn".to_owned(),
            window,
            t: 0.5 * (k - from) as f64,
            measured: [1.0 + 0.01 * k as f64, 0.1, 0.2],
            simulated: [1.0 + 0.01 * k as f64, 0.1, 0.2],
            half: [None; 3],
        };
        (from..=from + samples).map(row).collect()
    }

    #[test]
    fn law_windows_that_follow_each_other_give_the_track_of_the_whole() {
        let (whole, first, second) = (rows(0, 0, 40), rows(0, 0, 25), rows(1, 25, 15));
        let mut joined = Sailed { source: "turn", ..Sailed::default() };
        joined.add(&first);
        assert!(joined.continues_with(&second) && !joined.continues_with(&whole));
        joined.add(&second);
        let alone = followed(Pose::default(), &whole, |row| row.measured);
        assert_eq!(joined.measured.len(), alone.len());
        for (a, b) in joined.measured.iter().zip(&alone) {
            assert!((a.x - b.x).abs() < 1e-12 && (a.y - b.y).abs() < 1e-12, "{a:?} {b:?}");
        }
        // A model without error follows the measured track.
        let end = joined.simulated[1].last().unwrap();
        assert!((end.x - alone[40].x).abs() < 1e-12 && (end.psi - alone[40].psi).abs() < 1e-12);
    }
}
