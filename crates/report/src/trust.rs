use maud::{Markup, html};

use super::coded::coded;
use super::measured::{Measured, fit};
use super::missing::missing;
use super::number::{percent, three, three_or_dash, unit};
use study::documents::{DegreeTrust, ParameterTrust, SourceErrors, TrustDocument};

/// How far the pooled estimate can be trusted.
pub(super) fn trust(measured: &Measured) -> Markup {
    html! {
        section #trust {
            h2 { "Trust in the estimate from all recordings" }
            @match &measured.trust {
                None => (missing("Trust is", "trust.json", "estimate pool")),
                Some(found) => {
                    (about(found))
                    @for statement in &found.statements { p.note { (coded(statement)) } }
                    (tests(found))
                    @for degree in &found.degrees { (parameters(degree)) }
                    (runs(&found.runs))
                }
            }
        }
    }
}

fn about(found: &TrustDocument) -> Markup {
    html! {
        p {
            "Estimator " (found.estimator) ", " (found.parts) " sub-experiments of " (found.sources) " recordings, "
            (found.samples) " samples; nominal model: " (found.nominal) "; mean removed: " (found.mean_removal)
            @if found.prior > 0.0 { "; prior of strength " (three(found.prior)) }
            "; standard errors with " (found.bandwidth) " lags"
            @if found.replicates > 0 { "; bootstrap of " (found.replicates) " resamples" }
            "."
        }
    }
}

/// A probability: `0.043`, `< 0.001`.
fn probability(p: f64) -> String {
    if p < 0.001 { "< 0.001".to_owned() } else { format!("{p:.3}") }
}

fn tests(found: &TrustDocument) -> Markup {
    html! {
        div.scroll { table.compact {
            thead { tr {
                th scope="col" { "Degree" } th scope="col" { "Status" } th scope="col" { "By" }
                th.number scope="col" { "Condition" } th.number scope="col" { "Condition index" }
                th.number scope="col" { "Instruments follow" }
                th.number scope="col" { "Neighbouring residuals" } th.number scope="col" { "White, p" }
                th scope="col" { "Residual and instrument" }
            } }
            tbody { @for d in &found.degrees { tr {
                th scope="row" { (d.name) } td { (d.status) } td { (d.estimator) }
                td.number { (three_or_dash(d.condition)) } td.number { (three_or_dash(d.condition_index)) }
                td.number { (fit(d.instrument_fit)) }
                @match &d.whiteness {
                    Some(w) => { td.number { (three(w.first_autocorrelation)) } td.number { (probability(w.p_value)) } }
                    None => { td.number { "–" } td.number { "–" } }
                }
                @match &d.instrument_residual {
                    Some(c) => td.wrap { (three(c.strongest)) " with " (c.instrument) " at lag " (c.lag) ", p " (probability(c.p_value)) },
                    None => td { "–" },
                }
            } } }
        } }
        h3 { "Weakest directions" }
        ul { @for d in &found.degrees { li { (coded(&d.weakest)) } } }
    }
}

fn parameters(degree: &DegreeTrust) -> Markup {
    let resampled = degree.parameters.iter().any(|p| p.bootstrap_std.is_some());
    html! {
        h3 { "Parameters of " (degree.name) @if degree.reason.is_some() { ": not identifiable" } }
        div.scroll { table.compact {
            thead { tr {
                th scope="col" { "Parameter" } th scope="col" { "Term" } th scope="col" { "Unit" }
                th.number scope="col" { "Estimate" } th.number scope="col" { "Standard error" }
                @if resampled {
                    th.number scope="col" { "Bootstrap" } th.number scope="col" { "2.5 %" } th.number scope="col" { "97.5 %" }
                }
                th.number scope="col" { "Term varies" } th.number scope="col" { "Partial R²" }
            } }
            tbody { @for p in &degree.parameters { (parameter(p, resampled)) } }
        } }
        @if let Some(entries) = &degree.correlation { (correlation(degree, entries)) }
    }
}

fn parameter(p: &ParameterTrust, resampled: bool) -> Markup {
    html! {
        tr {
            th scope="row" { (p.name) } td { (p.term) } td { (unit(&p.unit)) }
            td.number { (three_or_dash(p.estimate)) } td.number { (three_or_dash(p.standard_error)) }
            @if resampled {
                @for x in [p.bootstrap_std, p.bootstrap_low, p.bootstrap_high] { td.number { (three_or_dash(x)) } }
            }
            td.number { (percent(p.variation)) } td.number { (three_or_dash(p.instrument_strength)) }
        }
    }
}

/// Rows of `entries`, as many as parameters.
fn correlation(degree: &DegreeTrust, entries: &[f64]) -> Markup {
    let rows = degree.parameters.iter().zip(entries.chunks(degree.parameters.len().max(1)));
    html! {
        div.scroll { table.compact {
            thead { tr {
                th scope="col" { "Correlation" } @for p in &degree.parameters { th.number scope="col" { (p.name) } }
            } }
            tbody { @for (p, row) in rows { tr {
                th scope="row" { (p.name) }
                @for x in row { td.number { (format!("{x:.2}").replace('-', "−")) } }
            } } }
        } }
    }
}

fn runs(runs: &[SourceErrors]) -> Markup {
    html! {
        h3 { "Free simulation over every recording, itself part of the estimate" }
        div.scroll { table.compact {
            thead { tr {
                th scope="col" { "Recording" } th.number scope="col" { "Samples" }
                @for title in ["Fit u", "Fit v", "Fit r", "RMSE u [m/s]", "RMSE v [m/s]", "RMSE r [rad/s]"] {
                    th.number scope="col" { (title) }
                }
            } }
            tbody { @for run in runs { tr {
                th scope="row" { (run.source) } td.number { (run.samples) }
                @for d in 0..3 { td.number { (fit(run.errors.and_then(|x| x.fits()[d]))) } }
                td.number { (three_or_dash(run.errors.map(|x| x.rmse_u))) }
                td.number { (three_or_dash(run.errors.map(|x| x.rmse_v))) }
                td.number { (three_or_dash(run.errors.map(|x| x.rmse_r))) }
            } } }
        } }
        @if runs.iter().any(|run| run.errors.is_none()) {
            p.note { "A dash: no whole model, or its simulation diverged." }
        }
    }
}
