use crate::figures::{Histogram, HistogramAxis, HistogramPanel, histogram_pair};
use artifact::TableReader;
use maud::{Markup, html};

use super::caption::truncation;
use super::coded::coded;
use super::loader::Loader;
use super::number::{percent_within, three_within};
use super::placed::Figures;
use super::sample::INTERVALS;
use super::study::Study;
use artifact::Error;
use study::documents::{Quantiles, SelectionDocument, SelectionScores};
use study::listed;
use study::selection::{self, Row};

/// What there is about a selection study.
#[derive(Clone, Debug)]
pub struct SelectionStudy {
    /// `selection.json`.
    pub summary: SelectionDocument,
    /// `selection.parquet`.
    pub rows: Vec<Row>,
}

const BINS: usize = 50;
/// The figures end at this many standard deviations of a state.
const LIMIT: f64 = 3.0;

/// Reads `selection.json` and `selection.parquet`, where both exist.
pub(super) fn load(loader: &mut Loader) -> Result<Option<SelectionStudy>, Error> {
    let path = loader.sources.results.join("selection.parquet");
    if !path.exists() {
        return Ok(None);
    }
    let summary = loader.document("selection.json", "picked sub-experiments against random ones")?;
    let Some(summary) = summary else { return Ok(None) };
    let reader = TableReader::open(&path, selection::ID, selection::VERSION)?;
    loader.note("selection.parquet", "errors of every realization", reader.digest());
    Ok(Some(SelectionStudy { summary, rows: selection::rows(&reader)? }))
}

/// The section: what was picked, quantiles, histograms with the optimized selection above the random one.
pub(super) fn selection(study: &Study, figures: &mut Figures) -> Markup {
    let Some(found) = &study.selection else { return html! {} };
    let summary = &found.summary;
    let norm = figure(
        found,
        figures,
        "selection-error",
        "norm of RMSE over standard deviation [1]",
        LIMIT,
        460.0,
        |r| r.error_norm,
    );
    let degrees = [
        figure(
            found,
            figures,
            "selection-surge",
            "RMSE in surge [m/s]",
            round_limit(summary.std_u),
            360.0,
            |r| r.rmse.map(|e| e[0]),
        ),
        figure(
            found,
            figures,
            "selection-sway",
            "RMSE in sway [m/s]",
            round_limit(summary.std_v),
            360.0,
            |r| r.rmse.map(|e| e[1]),
        ),
        figure(
            found,
            figures,
            "selection-yaw",
            "RMSE in yaw rate [rad/s]",
            round_limit(summary.std_r),
            360.0,
            |r| r.rmse.map(|e| e[2]),
        ),
    ];
    let picked: Vec<String> =
        summary.counts.iter().map(|(name, count)| format!("{count} × {name}")).collect();
    html! {
        section #selection {
            h2 { "Selection of sub-experiments" }
            p {
                "Models from " (summary.picks) " of " (summary.parts) " sub-experiments, simulated over all of them: "
                (picked.join(", ")) " against as many at random. Estimator " (summary.estimator) "."
            }
            @for statement in &summary.statements { p.note { (coded(statement)) } }
            div.scroll { (table(summary)) }
            p.note { (sample(summary)) ". " (INTERVALS) }
            div.pair { (norm) }
            div.triple { @for degree in degrees { (degree) } }
        }
    }
}

/// How many realizations the numbers are drawn from, and what counts as degenerate.
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

fn table(summary: &SelectionDocument) -> Markup {
    let told = |value: Option<f64>, interval| match value {
        None => "∞".to_owned(),
        value => three_within(value, interval),
    };
    let median = |q: &Quantiles| told(q.median, q.median_interval);
    let q90 = |q: &Quantiles| told(q.q90, q.q90_interval);
    let row = |d: &SelectionScores| {
        html! {
            tr {
                th scope="row" { (d.design) }
                td.number { (median(&d.overlapping.error_norm)) }
                td.number { (q90(&d.overlapping.error_norm)) }
                td.number { (median(&d.left_out.error_norm)) }
                td.number { (q90(&d.left_out.error_norm)) }
                td.number { (percent_within(d.degenerate_share, d.degenerate_share_interval)) }
            }
        }
    };
    html! {
        table {
            thead {
                tr {
                    th scope="col" { "norm of RMSE/std" }
                    th scope="col" { "median" }
                    th scope="col" { "90 %" }
                    th scope="col" { "median, picked left out" }
                    th scope="col" { "90 %, picked left out" }
                    th scope="col" { "degenerate" }
                }
            }
            tbody { @for design in &summary.designs { (row(design)) } }
        }
    }
}

/// Errors of all realizations by design, optimized above random; cut at `limit`.
pub(super) fn figure(
    found: &SelectionStudy,
    figures: &mut Figures,
    file: &str,
    title: &str,
    limit: f64,
    width: f64,
    value: fn(&Row) -> Option<f64>,
) -> Markup {
    let axis = HistogramAxis { title, limit, bins: BINS, bound: None, width };
    let own = |design: &str| -> Vec<Option<f64>> {
        found.rows.iter().filter(|r| r.design == design).map(value).collect()
    };
    let names: Vec<&str> = found.summary.designs.iter().map(|d| d.design.as_str()).collect();
    let values: Vec<Vec<Option<f64>>> = names.iter().map(|name| own(name)).collect();
    let panels: Vec<HistogramPanel<'_>> = (0..names.len())
        .map(|i| HistogramPanel { label: names[i], values: &values[i], note: None, colour: i })
        .collect();
    let counted: Vec<Histogram> = values.iter().map(|v| Histogram::new(v, limit, BINS)).collect();
    let named: Vec<(&str, &Histogram)> = names.into_iter().zip(&counted).collect();
    let caption = html! { b { (title) } " " (truncation(&named, limit)) };
    figures.place(file, histogram_pair(&axis, &panels), &caption)
}
