use artifact::Loaded;
use maud::{Markup, display, html};
use study::documents::{ShareDifference, SweepAxis, SweepDocument, SweptCell, SweptLine};

use super::axes::{place, written};
use super::data::downloads;
use super::figures::{against_axes, maps, name};
use crate::number::{percent, percent_within, three, three_within};
use crate::page::{Rendered, whole};
use crate::parts::{Figures, Section, statements};
use crate::table::{Table, grouped};

/// Renders the page of a sweep.
pub fn render_sweep(loaded: &Loaded<SweepDocument>) -> Rendered {
    let sweep = &loaded.data;
    let mut figures = Figures::default();
    let mut sections = vec![
        Section::new("axes", "Axes", "Against each axis", against_axes(sweep, &mut figures)),
        Section::new("maps", "Map", "Over two axes", maps(sweep, &mut figures)),
        Section::new("cells", "Cells", "Cell by cell", cells(sweep)),
    ];
    if sweep.baseline.is_some() {
        sections.push(Section::new(
            "differences",
            "Differences",
            "Differences from the baseline",
            differences(sweep),
        ));
    }
    sections.push(Section::new("refused", "Refused", "Refused cells", refused(sweep)));
    sections.push(Section::new("data", "Data", "Data", data(loaded)));
    let html = whole(&format!("{} – sweep", title(sweep)), &head(sweep), &sections, None).into_string();
    Rendered { html, figures: figures.files }
}

fn title(sweep: &SweepDocument) -> &str {
    sweep.study.trim_end_matches('/').rsplit('/').next().unwrap_or(&sweep.study)
}

fn head(sweep: &SweepDocument) -> Markup {
    let axis = |axis: &SweepAxis| {
        let values: Vec<String> = axis.values.iter().map(written).collect();
        format!("`{}`: {}", axis.key, values.join(", "))
    };
    html! {
        header {
            p.kicker { "Sweep over a grid" }
            h1 { (title(sweep)) }
            p.answer { (sweep.statements.first().map_or("", String::as_str)) }
            (statements(&sweep.axes.iter().map(axis).collect::<Vec<_>>()))
            (statements(sweep.statements.get(1..).unwrap_or_default()))
        }
    }
}

/// A row per cell and line.
fn rows(sweep: &SweepDocument) -> Vec<(bool, &SweptCell, &SweptLine)> {
    grouped(&sweep.cells, |cell| &cell.lines)
}

fn cells(sweep: &SweepDocument) -> Markup {
    let table = Table::of(rows(sweep))
        .compact()
        .set_off("first", |(first, ..)| first)
        .name("Cell", |(_, cell, _)| place(sweep, &cell.at, &[]))
        .text("Design", |(_, _, line)| line.design.clone())
        .text("Estimator", |(_, _, line)| display(line.estimator))
        .number("Runs", |(_, _, line)| line.runs)
        .number("Parameter error below its bound", |(_, _, line)| {
            percent_within(line.parameter_error_share.share, line.parameter_error_share.interval)
        })
        .number("Its median", |(_, _, line)| {
            three_within(line.parameter_error_median, Some(line.parameter_error_median_interval))
        })
        .number("Simulation error below its bound", |(_, _, line)| {
            percent_within(line.simulation_error_share.share, line.simulation_error_share.interval)
        })
        .number("Without estimate", |(_, _, line)| percent(line.without_estimate_share.share));
    html! {
        (table)
        p.note {
            "In brackets 95 % confidence intervals: Wilson's of shares, by ranks of medians, which are read from histograms, to "
            (percent(sweep.quantile_error)) ". " (bounds(sweep))
        }
    }
}

/// The bounds, if they are the same everywhere.
fn bounds(sweep: &SweepDocument) -> String {
    let Some(first) = sweep.cells.first() else { return String::new() };
    if sweep.cells.iter().any(|cell| cell.bounds != first.bounds) {
        return "The bounds differ between cells.".to_owned();
    }
    let bounds = first.bounds;
    format!(
        "Bounds: parameter error {}, simulation error {}.",
        three(bounds.parameter_error),
        three(bounds.simulation_error)
    )
}

fn differences(sweep: &SweepDocument) -> Markup {
    let rows: Vec<(&SweptCell, &SweptLine, ShareDifference)> =
        rows(sweep).into_iter().filter_map(|(_, cell, line)| Some((cell, line, line.difference?))).collect();
    let difference = |difference: &ShareDifference| {
        let [low, high] = difference.interval.map(points);
        format!("{} ({low} to {high})", points(difference.share))
    };
    let verdict = |difference: &ShareDifference| match difference.interval {
        [low, _] if low > 0.0 => "more",
        [_, high] if high < 0.0 => "fewer",
        _ => "not told apart",
    };
    let table = Table::of(rows.iter())
        .compact()
        .name("Cell", |(cell, ..)| place(sweep, &cell.at, &[]))
        .text("Design", |(_, line, _)| line.design.clone())
        .text("Estimator", |(_, line, _)| display(line.estimator))
        .number("Points more below the bound", |(.., d)| difference(d))
        .text("Runs", |(.., d)| verdict(d))
        .text("Compared", |(.., d)| if d.paired { "run by run" } else { "as samples" });
    html! {
        p {
            "The share of runs whose parameter error lies below its bound, less that of "
            @if let Some(baseline) = &sweep.baseline { b { (name(baseline)) } } " in the same cell, in percentage points."
        }
        (table)
        p.note {
            "In brackets 95 % intervals (Newcombe's). Estimators of the same design are compared run by run, by joint counts; \
             other designs sail other runs and are compared as independent samples."
        }
    }
}

/// Percentage points with their sign.
fn points(share: f64) -> String {
    format!("{:+.1}", 100.0 * share).replace('-', "−")
}

fn refused(sweep: &SweepDocument) -> Markup {
    let table = Table::of(&sweep.refused)
        .compact()
        .name("Cell", |cell| cell.cell.clone())
        .text("Where", |cell| place(sweep, &cell.at, &[]))
        .classed("wrap", "Refusal", |cell| cell.refusal.clone());
    html! { @if sweep.refused.is_empty() { p { "None." } } @else { (table) } }
}

fn data(loaded: &Loaded<SweepDocument>) -> Markup {
    html! {
        (downloads(&loaded.data))
        p.note { "Made of sweep.json, " code { (loaded.digest) } ", by " (loaded.provenance.producer) "." }
    }
}
