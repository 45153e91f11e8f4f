use files::Error;
use maud::html;

use super::histograms::ErrorFigure;
use super::loader::{Loader, existing};
use super::number::{median, percent_within, q90};
use super::parts::{Figures, Section, statements};
use super::sample::INTERVALS;
use super::table::Table;
use crate::figures::HistogramPanel;
use refusal::listed;
use study::documents::{Quantiles, SelectionDocument, SelectionScores};
use study::selection::{self, Row};

/// The results of a selection study.
#[derive(Clone, Debug)]
pub struct SelectionStudy {
    /// `selection.json`.
    pub summary: SelectionDocument,
    /// `selection.parquet`.
    pub rows: Vec<Row>,
}

/// The figures end at this many standard deviations of a state.
const LIMIT: f64 = 3.0;

/// Reads `selection.json` and `selection.parquet`, if both exist.
pub(super) fn load(loader: &mut Loader) -> Result<Option<SelectionStudy>, Error> {
    if existing(loader.sources.results.join("selection.parquet")).is_none() {
        return Ok(None);
    }
    let summary = loader.document("selection.json", "picked sub-experiments against random ones")?;
    let schema = (selection::ID, selection::VERSION);
    let Some(summary) = summary else { return Ok(None) };
    let reader = loader.table("selection.parquet", "errors of every realization", schema)?;
    let rows = reader.map(|reader| selection::rows(&reader)).transpose()?.unwrap_or_default();
    Ok(Some(SelectionStudy { summary, rows }))
}

/// The section: what was picked, quantiles, histograms with the optimized selection above the random one.
pub(super) fn selection(found: Option<&SelectionStudy>, figures: &mut Figures) -> Option<Section> {
    let found = found?;
    let summary = &found.summary;
    let norm = ErrorFigure::half("selection-error", "norm of RMSE over standard deviation [1]", LIMIT);
    let limits = [summary.std_u, summary.std_v, summary.std_r].map(round_limit);
    let degrees = ErrorFigure::thirds(["selection-surge", "selection-sway", "selection-yaw"], limits);
    let picked: Vec<String> =
        summary.counts.iter().map(|(name, count)| format!("{count} × {name}")).collect();
    let body = html! {
        p {
            "Models from " (summary.picks) " of " (summary.parts) " sub-experiments, simulated over all of them: "
            (picked.join(", ")) " against as many at random. Estimator " (summary.estimator) "."
        }
        (statements(&summary.statements))
        (table(summary))
        p.note { (sample(summary)) ". " (INTERVALS) }
        div.pair { (norm.place(&found.errors(|r| r.error_norm), figures)) }
        div.triple {
            @for (d, figure) in degrees.iter().enumerate() { (figure.place(&found.rmse(d), figures)) }
        }
    };
    Some(Section::new("selection", "Selection", "Selection of sub-experiments", body))
}

impl SelectionStudy {
    /// An error of all realizations by design, optimized before random.
    pub(super) fn errors<'a>(&'a self, value: impl Fn(&Row) -> Option<f64>) -> Vec<HistogramPanel<'a>> {
        let own =
            |d: &SelectionScores| self.rows.iter().filter(|r| r.design == d.design).map(&value).collect();
        let errors = |d: &'a SelectionScores| HistogramPanel { label: &d.design, values: own(d), note: None };
        self.summary.designs.iter().map(errors).collect()
    }

    /// The error of surge, sway or yaw.
    pub(super) fn rmse(&self, degree: usize) -> Vec<HistogramPanel<'_>> {
        self.errors(|row| row.rmse.map(|errors| errors[degree]))
    }
}

/// The number of realizations, and the definition of degenerate.
fn sample(summary: &SelectionDocument) -> String {
    let counts: Vec<String> =
        summary.designs.iter().map(|d| format!("{} {}", d.realizations, d.design)).collect();
    let seed = summary.seed.map_or(String::new(), |seed| format!(", seed {seed}"));
    format!(
        "{} realizations{seed}; degenerate: a norm of RMSE/std of {:.3} or more, or no model",
        listed(&counts),
        summary.degenerate_from
    )
}

/// [`LIMIT`] standard deviations to two digits.
fn round_limit(std: f64) -> f64 {
    format!("{:.1e}", LIMIT * std).parse().unwrap_or(LIMIT * std)
}

/// A column's cell for a design.
type Cell<'a> = &'a dyn Fn(&SelectionScores) -> String;

fn table(summary: &SelectionDocument) -> Table<&SelectionScores> {
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
    let named = Table::of(&summary.designs).name("norm of RMSE/std", |d| &d.design);
    columns.into_iter().fold(named, |table, (head, cell)| {
        table.with(html! { th scope="col" { (head) } }, |d| html! { td.number { (cell(d)) } })
    })
}
