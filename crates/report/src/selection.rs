use files::Error;
use maud::{Markup, html};
use refusal::listed;
use study::documents::{Quantiles, Selection, SelectionScores, ValidationDocument};
use study::scores;
use study::selection::{self, Row};

use crate::figures::{Histogram, HistogramAxis, HistogramPanel, histogram_pair};
use crate::interactive;
use crate::loader::{Loader, existing};
use crate::number::{exact, median, percent_within, q90};
use crate::parts::{Figures, HtmlTable, INTERVALS, Section, statements};

/// The results of a selection study.
#[derive(Clone, Debug)]
pub struct SelectionStudy {
    /// Of `validation.json`.
    pub summary: Selection,
    /// `scores.parquet` beside it.
    pub rows: Vec<Row>,
}

/// The figures end at this many standard deviations of a state.
const LIMIT: f64 = 3.0;

/// The folder of the picks of a study that has other scores.
const FOLDER: &str = "picks/";

/// The `picks`, or else those in the folder `picks`, with their table; `None` without either.
pub(super) fn load(loader: &mut Loader, picks: Option<Selection>) -> Result<Option<SelectionStudy>, Error> {
    let folder = if picks.is_some() { "" } else { FOLDER };
    let file = |name: &str| format!("{folder}{name}");
    if existing(loader.sources.results.join(file("scores.parquet"))).is_none() {
        return Ok(None);
    }
    let what = "picked sub-experiments against random ones";
    let picks = match picks {
        Some(picks) => Some(picks),
        None => {
            loader.document(&file("validation.json"), what)?.and_then(|below: ValidationDocument| below.picks)
        }
    };
    let Some(summary) = picks else { return Ok(None) };
    let schema = (scores::ID, scores::VERSION);
    let reader = loader.table(&file("scores.parquet"), "errors of every realization", schema)?;
    let rows = reader.map(|reader| selection::rows(&reader)).transpose()?.unwrap_or_default();
    Ok(Some(SelectionStudy { summary, rows }))
}

/// The section: what was picked, quantiles, histograms with the optimized selection above the random one.
pub(super) fn selection(study: Option<&SelectionStudy>, figures: &mut Figures) -> Option<Section> {
    let study = study?;
    let summary = &study.summary;
    let norm = ErrorFigure::half("selection-error", "norm of RMSE over standard deviation [1]", LIMIT);
    let limits = [summary.std_u, summary.std_v, summary.std_r].map(round_limit);
    let degrees = ErrorFigure::thirds(["selection-surge", "selection-sway", "selection-yaw"], limits);
    let picked: Vec<String> =
        summary.counts.iter().map(|(name, count)| format!("{count} × {name}")).collect();
    let histograms = html! {
        div.pair { (norm.place(&study.errors(|r| r.error_norm), figures)) }
        div.triple {
            @for (d, figure) in degrees.iter().enumerate() { (figure.place(&study.rmse(d), figures)) }
        }
    };
    let body = html! {
        p {
            "Models from " (summary.picks) " of " (summary.parts) " sub-experiments, simulated over all of them: "
            (picked.join(", ")) " against as many at random. Estimator " (summary.estimator) "."
        }
        (statements(&summary.statements))
        (table(summary))
        p.note { (sample(summary)) ". " (INTERVALS) }
        @if study.rows.is_empty() { (histograms) } @else { (figures.interactive(interactive::picked(&study.rows), &histograms)) }
    };
    Some(Section::new("selection", "Selection", "Selection of sub-experiments", body))
}

impl SelectionStudy {
    /// An error of all realizations by design, optimized before random.
    pub(super) fn errors<'a>(&'a self, value: impl Fn(&Row) -> Option<f64>) -> Vec<HistogramPanel<'a>> {
        let values =
            |d: &SelectionScores| self.rows.iter().filter(|r| r.design == d.design).map(&value).collect();
        let errors =
            |d: &'a SelectionScores| HistogramPanel { label: &d.design, values: values(d), note: None };
        self.summary.designs.iter().map(errors).collect()
    }

    /// The error of surge, sway or yaw.
    pub(super) fn rmse(&self, degree: usize) -> Vec<HistogramPanel<'_>> {
        self.errors(|row| row.rmse.map(|errors| errors[degree]))
    }
}

/// The number of realizations, and the definition of degenerate.
fn sample(summary: &Selection) -> String {
    let counts: Vec<String> =
        summary.designs.iter().map(|d| format!("{} {}", d.realizations, d.design)).collect();
    format!(
        "{} realizations, seed {}; degenerate: a norm of RMSE/std of {:.3} or more, or no model",
        listed(&counts),
        summary.seed,
        summary.degenerate_from
    )
}

/// [`LIMIT`] standard deviations to two digits.
fn round_limit(std: f64) -> f64 {
    format!("{:.1e}", LIMIT * std).parse().unwrap_or(LIMIT * std)
}

/// A column's cell for a design.
type Cell<'a> = &'a dyn Fn(&SelectionScores) -> String;

fn table(summary: &Selection) -> HtmlTable<&SelectionScores> {
    let or_infinite = |value: Option<f64>, printed: String| value.map_or("∞".to_owned(), |_| printed);
    let median = |errors: &Quantiles| or_infinite(errors.median, median(errors));
    let q90 = |errors: &Quantiles| or_infinite(errors.q90, q90(errors));
    let columns: [(&str, Cell<'_>); 5] = [
        ("median", &|d| median(&d.overlapping.error_norm)),
        ("90 %", &|d| q90(&d.overlapping.error_norm)),
        ("median, picked left out", &|d| median(&d.left_out.error_norm)),
        ("90 %, picked left out", &|d| q90(&d.left_out.error_norm)),
        ("degenerate", &|d| percent_within(d.degenerate_share, d.degenerate_share_interval)),
    ];
    let named = HtmlTable::of(&summary.designs).name("norm of RMSE/std", |d| &d.design);
    columns.into_iter().fold(named, |table, (head, cell)| {
        table.with(html! { th scope="col" { (head) } }, |d| html! { td.number { (cell(d)) } })
    })
}

/// A figure of histograms of one error, a panel per design.
#[derive(Clone, Copy)]
pub(super) struct ErrorFigure<'a> {
    file: &'a str,
    caption: &'a str,
    axis: HistogramAxis<'a>,
}

impl<'a> ErrorFigure<'a> {
    /// For half of the page, in `<file>.svg`: `title` has quantity and unit, and the axis ends at `limit`.
    pub(super) const fn half(file: &'a str, title: &'a str, limit: f64) -> Self {
        let axis = HistogramAxis { title, limit, bins: 50, bound: None, width: 460.0 };
        Self { file, caption: title, axis }
    }

    /// For a third of the page each: the errors in surge, sway and yaw rate.
    pub(super) fn thirds(files: [&'a str; 3], [u, v, r]: [f64; 3]) -> [Self; 3] {
        let third = |file, title, limit| {
            let half = Self::half(file, title, limit);
            Self { axis: HistogramAxis { width: 360.0, ..half.axis }, ..half }
        };
        [
            third(files[0], "RMSE in surge [m/s]", u),
            third(files[1], "RMSE in sway [m/s]", v),
            third(files[2], "RMSE in yaw rate [rad/s]", r),
        ]
    }

    /// Sets a caption.
    pub(super) const fn captioned(self, caption: &'a str) -> Self {
        Self { caption, ..self }
    }

    /// Adds a line below which a run counts as good.
    pub(super) const fn bounded(self, bound: Option<f64>) -> Self {
        Self { axis: HistogramAxis { bound, ..self.axis }, ..self }
    }

    /// Draws and places the figure; the caption accounts for runs that no bar shows.
    pub(super) fn place(&self, panels: &[HistogramPanel<'_>], figures: &mut Figures) -> Markup {
        let left_out: Vec<String> = panels.iter().map(|panel| self.left_out(panel)).collect();
        let caption = html! {
            b { (self.caption) }
            " Values at or above " (exact(self.axis.limit)) " are truncated into the last bar (" (left_out.join("; ")) ")."
        };
        figures.place(self.file, histogram_pair(&self.axis, panels), &caption)
    }

    /// The runs in the last bar and those that no bar shows: `optimized: 3 of 500 runs truncated, 0 without a value`.
    fn left_out(&self, panel: &HistogramPanel<'_>) -> String {
        let counted = Histogram::new(&panel.values, self.axis.limit, self.axis.bins);
        let (runs, Histogram { beyond, missing, .. }) = (counted.runs(), &counted);
        format!("{}: {beyond} of {runs} runs truncated, {missing} without a value", panel.label)
    }
}
