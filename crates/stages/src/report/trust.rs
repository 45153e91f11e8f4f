use maud::{Markup, html};

use super::measured::{Measured, fit};
use super::missing::missing;
use super::number::{percent, three, three_or_dash, unit};
use crate::documents::{TrustDegree, TrustDocument, TrustParameter, TrustRun};

/// How far the pooled estimate can be trusted.
pub(super) fn trust(measured: &Measured) -> Markup {
    html! {
        section #trust {
            h2 { "Trust in the estimate from all recordings" }
            @match &measured.trust {
                None => (missing("Trust is", "trust.json", "estimate --pool")),
                Some(found) => {
                    (about(found))
                    @for statement in &found.statements { p.note { (statement) } }
                    (tests(found))
                    @for degree in &found.degrees { (parameters(degree, found.replicates > 0)) }
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
                th scope="col" { "Residual and instrument" } th.number scope="col" { "p" }
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
                    Some(c) => { td { (three(c.strongest)) " with " (c.instrument) " at lag " (c.lag) } td.number { (probability(c.p_value)) } }
                    None => { td { "–" } td.number { "–" } }
                }
            } } }
        } }
        h3 { "Weakest directions" }
        ul { @for d in &found.degrees { li { (d.weakest) } } }
    }
}

fn parameters(degree: &TrustDegree, resampled: bool) -> Markup {
    html! {
        h3 { "Parameters of " (degree.name) @if degree.reason.is_some() { ": not identifiable" } }
        div.scroll { table.compact {
            thead { tr {
                th scope="col" { "Parameter" } th scope="col" { "Term" } th scope="col" { "Unit" }
                th.number scope="col" { "Estimate" } th.number scope="col" { "Standard error" }
                @if resampled { th.number scope="col" { "Bootstrap" } th scope="col" { "95 % of the resamples" } }
                th.number scope="col" { "Term varies" } th.number scope="col" { "Partial R²" }
                @if degree.correlation.is_some() { @for p in &degree.parameters { th.number scope="col" { (p.name) } } }
            } }
            tbody { @for (i, p) in degree.parameters.iter().enumerate() { (parameter(degree, i, p, resampled)) } }
        } }
        @if degree.correlation.is_some() { p.note { "Last columns: correlation between the estimates." } }
    }
}

fn parameter(degree: &TrustDegree, i: usize, p: &TrustParameter, resampled: bool) -> Markup {
    let width = degree.parameters.len();
    let row = degree.correlation.as_ref().and_then(|c| c.get(i * width..(i + 1) * width));
    html! {
        tr {
            th scope="row" { (p.name) } td { (p.term) } td { (unit(&p.unit)) }
            td.number { (three_or_dash(p.estimate)) } td.number { (three_or_dash(p.standard_error)) }
            @if resampled {
                td.number { (three_or_dash(p.bootstrap_std)) }
                td { (three_or_dash(p.bootstrap_low)) " to " (three_or_dash(p.bootstrap_high)) }
            }
            td.number { (percent(p.variation)) }
            td.number { (three_or_dash(p.instrument_strength)) }
            @for correlation in row.unwrap_or_default() { td.number { (format!("{correlation:.2}").replace('-', "−")) } }
        }
    }
}

fn runs(runs: &[TrustRun]) -> Markup {
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
