use maud::{Markup, display, html};

use super::measured::{Measured, free_runs};
use super::number::{exact, or_dash, three, three_or_dash, three_within};
use super::parts::{Section, Table, missing, statements};
use study::documents::{CrossvalDocument, EstimatorScore};

/// The estimators compared on recordings that were left out, and the recommended one recording by recording.
pub(super) fn cross_validation(measured: &Measured) -> Section {
    let body = match &measured.crossval {
        None => missing("Cross-validation is", "crossval.json", "validate cross"),
        Some(found) => html! {
            (about(found))
            (statements(&found.statements))
            (estimators(found))
            @if let Some((score, _)) = measured.best() { (sources(score)) }
        },
    };
    Section::new("cross-validation", "Cross-validation", "Cross-validation", body)
}

fn about(found: &CrossvalDocument) -> Markup {
    let windows =
        found.window_s.map_or("whole recordings".to_owned(), |s| format!("windows of {} s", exact(s)));
    html! {
        p {
            "Each of " (found.folds) " folds leaves recordings out, estimates from the others and simulates over those left \
             out: " (found.windows) " " (windows) ", " (found.samples) " samples. "
            @if found.forces {
                "Forces were fitted, with priors of weight " (three(found.prior))
            } @else {
                "Mean of the instruments removed: " (found.mean_removal) "; nominal model: " (found.nominal)
                @if found.prior > 0.0 { "; prior of strength " (three(found.prior)) }
            }
            ". Standard deviations of the states: " (three(found.std_u)) " m/s, " (three(found.std_v)) " m/s, "
            (three(found.std_r)) " rad/s."
        }
    }
}

fn estimators(found: &CrossvalDocument) -> Markup {
    let recommended = |e: &EstimatorScore| found.recommended == Some(e.name);
    let named = Table::of(&found.estimators)
        .mark("main", |e| found.candidates.contains(&e.name))
        .name("Estimator", |e| html! { (e.name) @if recommended(e) { " (recommended)" } });
    let table = free_runs(named, |e| e.errors)
        .number("Error norm", |e| three_or_dash(e.error_norm))
        .number("Above the least", |e| {
            or_dash(found.difference(e.name).map(|d| three_within(d.median, Some(d.interval))))
        })
        .text("By instruments, folds", |e| e.by_instruments.map(|folds| folds.to_string()).join(", "))
        .text("Status", |e| display(e.status));
    html! {
        (table)
        p.note {
            "Above the least: how far the error norm of a recording lies above that by the estimator of least median norm, \
             median over the recordings with its 95 % interval; one that contains 0 tells no difference. "
            "By instruments: folds in which surge, sway and yaw were estimated with simulated instruments."
        }
    }
}

fn sources(score: &EstimatorScore) -> Markup {
    let (simulated, without): (Vec<_>, Vec<_>) = score.sources.iter().partition(|s| s.windows > 0);
    let named =
        Table::of(simulated).compact().name("Recording", |s| &s.source).number("Windows", |s| s.windows);
    html! {
        h3 { "Recordings left out, " (score.name) }
        (free_runs(named, |s| s.errors))
        p.note {
            "Fits of a recording are against the standard deviations of its own states: a state that hardly varies in it has \
             a low fit whatever the error."
            @if !without.is_empty() { " " (without.len()) " recordings are shorter than a window." }
        }
    }
}
