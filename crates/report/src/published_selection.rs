use maud::{Markup, html};

use super::number::{exact, percent_within, published, three};
use super::placed::Figures;
use super::selection::{SelectionStudy, figure};
use super::study::Study;
use study::documents::{PublishedLimits, PublishedPicks, PublishedSelection, Quantiles, Share, SharesBeyond};
use study::selection::Row;

/// The selection study beside a published one: a table, and the figures cut where the published ones are.
pub(super) fn published_selection(study: &Study, figures: &mut Figures) -> Markup {
    let Some((found, reference, limits)) = study.published_selection() else { return html! {} };
    let norm = figure(found, figures, "published-norm", "norm of RMSE", limits.limit_norm, 460.0, norm);
    let degrees = [
        figure(found, figures, "published-surge", "RMSE in surge [m/s]", limits.limit_u, 360.0, |r| {
            rmse(r, 0)
        }),
        figure(found, figures, "published-sway", "RMSE in sway [m/s]", limits.limit_v, 360.0, |r| rmse(r, 1)),
        figure(found, figures, "published-yaw", "RMSE in yaw rate [rad/s]", limits.limit_r, 360.0, |r| {
            rmse(r, 2)
        }),
    ];
    html! {
        section #published {
            h2 { "Selection beside the published one" }
            @if let Some(label) = &study.data {
                p.note { b { "Ours: " (label) "." } " The published study used logs of a real ship that were never published." }
            }
            div.scroll { (table(found, limits)) }
            @for statement in &limits.statements { p.note { "Published: “" (statement) "”" } }
            p.note { "Source: " (reference.source) ". Published numbers are shown for comparison and used for nothing else." }
            div.pair { (norm) }
            div.triple { @for degree in degrees { (degree) } }
        }
    }
}

fn rmse(row: &Row, degree: usize) -> Option<f64> {
    row.rmse.map(|errors| errors[degree])
}

/// Norm of the three RMSE as numbers, as published.
fn norm(row: &Row) -> Option<f64> {
    row.rmse.map(|errors| errors.iter().map(|e| e * e).sum::<f64>().sqrt())
}

fn table(found: &SelectionStudy, limits: &PublishedSelection) -> Markup {
    let designs: Vec<&str> = found.summary.designs.iter().map(|d| d.design.as_str()).collect();
    let told = |design: &str| if design == "optimized" { &limits.optimized } else { &limits.random };
    let row =
        |label: String, ours: &dyn Fn(&str) -> String, theirs: &dyn Fn(&PublishedPicks) -> Option<String>| {
            html! {
                tr {
                    th scope="row" { (label) }
                    @for design in &designs {
                        td.number { (ours(design)) }
                        td.number.published { (theirs(told(design)).unwrap_or_else(|| "–".to_owned())) }
                    }
                }
            }
        };
    let of = |design: &str| found.summary.designs.iter().find(|d| d.design == design);
    let norm = |design: &str, value: fn(&Quantiles) -> Option<f64>| {
        of(design).and_then(|d| value(&d.overlapping.rmse_norm)).map_or("∞".to_owned(), three)
    };
    let beyond = |design: &str, share: fn(&SharesBeyond) -> Share| {
        let own = of(design).and_then(|d| d.beyond_published.as_ref()).map(share);
        own.map_or("–".to_owned(), |own| percent_within(own.share, own.interval))
    };
    let nothing = |_: &PublishedPicks| None;
    let at = found.summary.published_limits.unwrap_or(PublishedLimits::from(limits));
    html! {
        table {
            thead { tr {
                th scope="col" { "norm of RMSE" }
                @for design in &designs { th.number scope="col" { (design) } th.number.published scope="col" { "published" } }
            } }
            tbody {
                (row(format!("At or above {} (published as degenerate)", exact(at.rmse_norm)),
                    &|d| beyond(d, |b| b.norm), &|p| p.degenerate_share.map(published)))
                (row("Best".into(), &|d| norm(d, |q| q.min), &|p| p.best.clone()))
                (row("Median".into(), &|d| norm(d, |q| q.median), &nothing))
                (row("90 % quantile".into(), &|d| norm(d, |q| q.q90), &nothing))
                (row("Worst".into(), &|d| norm(d, |q| q.max), &|p| p.worst.clone()))
                (row(format!("Surge at or above {} m/s", exact(at.rmse_u)), &|d| beyond(d, |b| b.surge), &nothing))
                (row(format!("Sway at or above {} m/s", exact(at.rmse_v)), &|d| beyond(d, |b| b.sway), &nothing))
                (row(format!("Yaw rate at or above {} rad/s", exact(at.rmse_r)), &|d| beyond(d, |b| b.yaw), &nothing))
            }
        }
    }
}
