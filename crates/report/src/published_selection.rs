use maud::{Markup, Render, html};

use super::comparison::use_of_published;
use super::number::{exact, or_dash, percent_within, published, three};
use super::parts::{Figures, Section, Table};
use super::selection::{ErrorFigure, SelectionStudy};
use super::study::Study;
use study::documents::{
    PublishedLimits, PublishedPicks, PublishedSelection, Quantiles, SelectionScores, Share, SharesBeyond,
};
use study::selection::Row;

/// The selection study compared with a published one: a table, and figures with the published limits. `None` unless
/// there are both.
pub(super) fn published_selection(study: &Study, figures: &mut Figures) -> Option<Section> {
    let (found, reference) = (study.selection.as_ref()?, study.reference.as_ref()?);
    let limits = reference.selection.as_ref()?;
    let whole = ErrorFigure::half("published-norm", "norm of RMSE", limits.limit_norm);
    let files = ["published-surge", "published-sway", "published-yaw"];
    let degrees = ErrorFigure::thirds(files, [limits.limit_u, limits.limit_v, limits.limit_r]);
    let body = html! {
        @if let Some(label) = &study.data {
            p.note { b { "Ours: " (label) "." } " The published study used logs of a real ship that were never published." }
        }
        (table(found, limits))
        @for statement in &limits.statements { p.note { "Published: “" (statement) "”" } }
        p.note { "Source: " (reference.source) ". " (use_of_published(reference)) }
        div.pair { (whole.place(&found.errors(norm), figures)) }
        div.triple {
            @for (d, figure) in degrees.iter().enumerate() { (figure.place(&found.rmse(d), figures)) }
        }
    };
    Some(Section::new("published", "Published", "Selection beside the published one", body))
}

/// Norm of the three RMSE as numbers, as published.
fn norm(row: &Row) -> Option<f64> {
    row.rmse.map(|errors| errors.iter().map(|e| e * e).sum::<f64>().sqrt())
}

/// A row's value for a design, and the published one.
type Line<'a> =
    (&'a str, &'a dyn Fn(&SelectionScores) -> String, Option<fn(&PublishedPicks) -> Option<String>>);

fn table(found: &SelectionStudy, limits: &PublishedSelection) -> Markup {
    let at = found.summary.published_limits.unwrap_or(PublishedLimits::from(limits));
    let labels = [
        format!("At or above {} (published as degenerate)", exact(at.rmse_norm)),
        format!("Surge at or above {} m/s", exact(at.rmse_u)),
        format!("Sway at or above {} m/s", exact(at.rmse_v)),
        format!("Yaw rate at or above {} rad/s", exact(at.rmse_r)),
    ];
    let norm = |d: &SelectionScores, value: fn(&Quantiles) -> Option<f64>| {
        value(&d.overlapping.rmse_norm).map_or("∞".to_owned(), three)
    };
    let beyond = |d: &SelectionScores, share: fn(&SharesBeyond) -> Share| {
        let own = d.beyond_published.as_ref().map(share);
        or_dash(own.map(|own| percent_within(own.share, own.interval)))
    };
    let lines: [Line<'_>; 8] = [
        (&labels[0], &|d| beyond(d, |b| b.norm), Some(|p| p.degenerate_share.map(published))),
        ("Best", &|d| norm(d, |q| q.min), Some(|p| p.best.clone())),
        ("Median", &|d| norm(d, |q| q.median), None),
        ("90 % quantile", &|d| norm(d, |q| q.q90), None),
        ("Worst", &|d| norm(d, |q| q.max), Some(|p| p.worst.clone())),
        (&labels[1], &|d| beyond(d, |b| b.surge), None),
        (&labels[2], &|d| beyond(d, |b| b.sway), None),
        (&labels[3], &|d| beyond(d, |b| b.yaw), None),
    ];
    let labelled = Table::of(lines).name("norm of RMSE", |(label, ..)| label);
    let table = found.summary.designs.iter().fold(labelled, |table, d| {
        let published = if d.design == "optimized" { &limits.optimized } else { &limits.random };
        table.number(&d.design, |(_, ours, _)| ours(d)).classed(
            "number published",
            "published",
            |(.., theirs)| or_dash(theirs.and_then(|theirs| theirs(published))),
        )
    });
    table.render()
}
