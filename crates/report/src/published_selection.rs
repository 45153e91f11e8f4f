use maud::{Markup, html};

use super::number::{exact, percent, published, three};
use super::placed::Figures;
use super::selection::{SelectionStudy, figure};
use super::study::Study;
use study::documents::{PublishedPicks, PublishedSelection};
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

/// Errors of one design, infinite without a model or where its simulation diverged; ascending.
fn sorted(found: &SelectionStudy, design: &str, value: impl Fn(&Row) -> Option<f64>) -> Vec<f64> {
    let own = found.rows.iter().filter(|r| r.design == design);
    let mut errors: Vec<f64> = own.map(|r| value(r).unwrap_or(f64::INFINITY)).collect();
    errors.sort_by(f64::total_cmp);
    errors
}

fn at_or_above(errors: &[f64], limit: f64) -> f64 {
    errors.iter().filter(|e| **e >= limit).count() as f64 / errors.len().max(1) as f64
}

fn quantile(errors: &[f64], q: f64) -> String {
    let place = (q * errors.len().saturating_sub(1) as f64).round() as usize;
    let value = errors.get(place).copied().unwrap_or(f64::NAN);
    if value == f64::INFINITY { "∞".to_owned() } else { three(value) }
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
    let of_norm = |design: &str| sorted(found, design, norm);
    let cut = |limit: f64, degree: usize| {
        move |design: &str| percent(at_or_above(&sorted(found, design, |r| rmse(r, degree)), limit))
    };
    let nothing = |_: &PublishedPicks| None;
    html! {
        table {
            thead { tr {
                th scope="col" { "norm of RMSE" }
                @for design in &designs { th.number scope="col" { (design) } th.number.published scope="col" { "published" } }
            } }
            tbody {
                (row(format!("Degenerate: at or above {}", exact(limits.limit_norm)),
                    &|d| percent(at_or_above(&of_norm(d), limits.limit_norm)),
                    &|p| p.degenerate_share.map(published)))
                (row("Best".into(), &|d| quantile(&of_norm(d), 0.0), &|p| p.best.clone()))
                (row("Median".into(), &|d| quantile(&of_norm(d), 0.5), &nothing))
                (row("90 % quantile".into(), &|d| quantile(&of_norm(d), 0.9), &nothing))
                (row("Worst".into(), &|d| quantile(&of_norm(d), 1.0), &|p| p.worst.clone()))
                (row(format!("Surge at or above {} m/s", exact(limits.limit_u)), &cut(limits.limit_u, 0), &nothing))
                (row(format!("Sway at or above {} m/s", exact(limits.limit_v)), &cut(limits.limit_v, 1), &nothing))
                (row(format!("Yaw rate at or above {} rad/s", exact(limits.limit_r)), &cut(limits.limit_r, 2), &nothing))
            }
        }
    }
}
