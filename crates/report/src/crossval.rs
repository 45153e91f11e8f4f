use maud::{Markup, html};

use super::coded::coded;
use super::measured::{Measured, fit};
use super::missing::missing;
use super::number::{exact, three, three_or_dash};
use study::documents::{CrossvalDocument, EstimatorScore};

/// The estimators beside each other on recordings that were left out, and the recommended one recording by recording.
pub(super) fn cross_validation(measured: &Measured) -> Markup {
    html! {
        section #cross-validation {
            h2 { "Cross-validation" }
            @match &measured.crossval {
                None => (missing("Cross-validation is", "crossval.json", "validate cross")),
                Some(found) => {
                    (about(found))
                    @for statement in &found.statements { p.note { (coded(statement)) } }
                    (estimators(found))
                    @if let Some((score, _)) = measured.recommended() { (sources(score)) }
                }
            }
        }
    }
}

fn about(found: &CrossvalDocument) -> Markup {
    let windows =
        found.window_s.map_or("whole recordings".to_owned(), |s| format!("windows of {} s", exact(s)));
    html! {
        p {
            "Each of " (found.folds) " folds leaves recordings out, estimates from the others and simulates over those left \
             out: " (found.windows) " " (windows) ", " (found.samples) " samples. Mean of the instruments removed: "
            (found.mean_removal) "; nominal model: " (found.nominal)
            @if found.prior > 0.0 { "; prior of strength " (three(found.prior)) }
            ". Standard deviations of the states: " (three(found.std_u)) " m/s, " (three(found.std_v)) " m/s, "
            (three(found.std_r)) " rad/s."
        }
    }
}

fn estimators(found: &CrossvalDocument) -> Markup {
    html! {
        div.scroll { table {
            thead { tr {
                th scope="col" { "Estimator" }
                @for title in ["Fit u", "Fit v", "Fit r", "RMSE u [m/s]", "RMSE v [m/s]", "RMSE r [rad/s]", "Error norm"] {
                    th.number scope="col" { (title) }
                }
                th scope="col" { "By instruments, folds" } th scope="col" { "Status" }
            } }
            tbody { @for e in &found.estimators { (estimator(e, found)) } }
        } }
        p.note { "By instruments: folds in which surge, sway and yaw were estimated with simulated instruments." }
    }
}

fn estimator(e: &EstimatorScore, found: &CrossvalDocument) -> Markup {
    let best = found.recommended == Some(e.name);
    let [u, v, r] = e.by_instruments;
    html! {
        tr.main[best] {
            th scope="row" { (e.name) @if best { " (recommended)" } }
            @for d in 0..3 { td.number { (fit(e.errors.and_then(|x| x.fits()[d]))) } }
            td.number { (three_or_dash(e.errors.map(|x| x.rmse_u))) }
            td.number { (three_or_dash(e.errors.map(|x| x.rmse_v))) }
            td.number { (three_or_dash(e.errors.map(|x| x.rmse_r))) }
            td.number { (three_or_dash(e.error_norm)) }
            td { (u) ", " (v) ", " (r) }
            td { (e.status) }
        }
    }
}

fn sources(score: &EstimatorScore) -> Markup {
    html! {
        h3 { "Recordings left out, " (score.name) }
        div.scroll { table.compact {
            thead { tr {
                th scope="col" { "Recording" }
                @for title in ["Windows", "Fit u", "Fit v", "Fit r", "RMSE u [m/s]", "RMSE v [m/s]", "RMSE r [rad/s]"] {
                    th.number scope="col" { (title) }
                }
            } }
            tbody { @for s in score.sources.iter().filter(|s| s.windows > 0) { tr {
                th scope="row" { (s.source) }
                td.number { (s.windows) }
                @for d in 0..3 { td.number { (fit(s.errors.and_then(|x| x.fits()[d]))) } }
                td.number { (three_or_dash(s.errors.map(|x| x.rmse_u))) }
                td.number { (three_or_dash(s.errors.map(|x| x.rmse_v))) }
                td.number { (three_or_dash(s.errors.map(|x| x.rmse_r))) }
            } } }
        } }
        p.note {
            "Fits of a recording are against the standard deviations of its own states: a state that hardly varies in it has \
             a low fit whatever the error."
            @let without = score.sources.iter().filter(|s| s.windows == 0).count();
            @if without > 0 { " " (without) " recordings are shorter than a window." }
        }
    }
}
