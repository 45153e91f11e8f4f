use identification::Estimator;
use maud::{Markup, html};

use super::number::{percent, three_or_dash, three_within};
use super::sample::{INTERVALS, drawn_from};
use super::study::{Scenario, Study, optimized_first};
use study::documents::{
    DesignScores, DesignSummary, EstimateDocument, EstimatorRecommendation, EstimatorScores,
    EstimatorSummary, ParameterSummary, ValidationDocument,
};

/// Every estimator on the same runs, where they were compared.
pub(super) fn estimators(study: &Study) -> Markup {
    let both = study.estimate.as_ref().zip(study.validation.as_ref());
    let compared = both.and_then(|(e, v)| Some((e, e.compared.as_deref()?, v, v.compared.as_deref()?)));
    html! {
        @if let Some((estimate, estimates, validation, scores)) = compared {
            section #estimators {
                h2 { "Estimators on the same runs" }
                (recommended(validation))
                @for design in designs(scores) { (table(design, estimates, scores)) (trust(design, estimate)) }
                p.note { (drawn_from(validation)) ". " (INTERVALS) }
                p.note {
                    "Bias and spread: 2-norms over the parameters of (mean − truth)/truth and of the standard deviation over the truth's \
                     modulus, over the runs with an estimate. Parameter and simulation errors count a run without an estimate as infinite. \
                     Kept: the last estimate before a simulation with refined instruments diverged."
                }
            }
        }
        @if !study.scenarios.is_empty() { (scenarios(&study.scenarios)) }
    }
}

/// Whether there is anything to show.
pub(super) fn shown(study: &Study) -> bool {
    study.validation.as_ref().is_some_and(|v| v.compared.is_some()) || !study.scenarios.is_empty()
}

fn designs(scores: &[EstimatorScores]) -> Vec<&str> {
    let first = scores.first().map_or(&[][..], |s| &s.designs);
    optimized_first(first, |d| &d.design).into_iter().map(|d| d.design.as_str()).collect()
}

/// What the validation recommends for the design that is shown first.
fn recommended(validation: &ValidationDocument) -> Markup {
    match recommendation(validation) {
        Some(found) if found.candidates.is_empty() => html! { p.missing { (found.statement) } },
        Some(found) => html! { p { (found.statement) } },
        None => html! {},
    }
}

fn recommendation(validation: &ValidationDocument) -> Option<&EstimatorRecommendation> {
    let all = validation.recommendations.as_deref().unwrap_or(&[]);
    optimized_first(all, |found| &found.design).into_iter().next()
}

fn of_design<'a>(designs: &'a [DesignScores], name: &str) -> Option<&'a DesignScores> {
    designs.iter().find(|d| d.design == name)
}

fn table(design: &str, estimates: &[EstimatorSummary], scores: &[EstimatorScores]) -> Markup {
    let heads = [
        "Parameter error, median",
        "90 %",
        "RMS",
        "Bias",
        "Spread",
        "Predicted / spread",
        "Simulation error, median",
        "Diverged",
        "Not identifiable",
        "Not converged",
        "Kept",
    ];
    html! {
        h3 { "Estimators, " (design) }
        div.scroll { table {
            thead { tr { th scope="col" { "Estimator" } @for head in heads { th.number scope="col" { (head) } } } }
            tbody {
                @for score in scores {
                    @if let (Some(d), Some(e)) = (of_design(&score.designs, design), summary(estimates, score.estimator, design)) {
                        tr { th scope="row" { (score.estimator) } @for cell in cells(d, e) { td.number { (cell) } } }
                    }
                }
            }
        } }
    }
}

fn summary<'a>(
    estimates: &'a [EstimatorSummary],
    estimator: Estimator,
    design: &str,
) -> Option<&'a DesignSummary> {
    estimates.iter().find(|e| e.estimator == estimator)?.designs.iter().find(|d| d.design == design)
}

fn cells(scores: &DesignScores, estimates: &DesignSummary) -> [String; 11] {
    let count = |count: Option<u64>| count.map_or("–".to_owned(), |c| c.to_string());
    let (least, most) = (estimates.se_ratio_min, estimates.se_ratio_max);
    [
        three_within(scores.parameter_error.median, scores.parameter_error.median_interval),
        three_within(scores.parameter_error.q90, scores.parameter_error.q90_interval),
        three_or_dash(estimates.relative_rms),
        three_or_dash(estimates.relative_bias),
        three_or_dash(estimates.relative_spread),
        format!("{} to {}", three_or_dash(least), three_or_dash(most)),
        three_within(scores.simulation_error.median, scores.simulation_error.median_interval),
        scores.diverged.to_string(),
        scores.not_identifiable.to_string(),
        count(scores.not_converged),
        count(estimates.kept),
    ]
}

/// Predicted over observed standard errors, parameter by parameter.
fn trust(design: &str, document: &EstimateDocument) -> Markup {
    let compared = document.compared.as_deref().unwrap_or(&[]);
    let of = |e: &EstimatorSummary| e.designs.iter().find(|d| d.design == design).cloned();
    let rows: Vec<(Estimator, DesignSummary)> =
        compared.iter().filter_map(|e| Some((e.estimator, of(e)?))).collect();
    let Some((_, first)) = rows.first() else { return html! {} };
    let wrong: Vec<String> = rows
        .iter()
        .filter_map(|(estimator, d)| {
            let names: Vec<&str> = d.parameters.iter().filter(|p| off(p)).map(|p| p.name.as_str()).collect();
            (!names.is_empty()).then(|| format!("{estimator}: {}", names.join(", ")))
        })
        .collect();
    let within = percent(document.trusted_within.unwrap_or(f64::NAN));
    html! {
        div.scroll { table.compact {
            thead { tr {
                th scope="col" { "Predicted / observed standard error" }
                @for p in &first.parameters { th.number scope="col" { (p.name) } }
            } }
            tbody { @for (estimator, d) in &rows {
                tr { th scope="row" { (estimator) } @for p in &d.parameters { td.number { (cell(p)) } } }
            } }
        } }
        @if wrong.is_empty() {
            p.note { "All within " (within) " of 1." }
        } @else {
            p.note { "More than " (within) " off (bold): " (wrong.join("; ")) ". " (reason()) }
        }
    }
}

/// Whether standard errors are not to be trusted.
fn off(parameter: &ParameterSummary) -> bool {
    parameter.se_trusted == Some(false)
}

fn cell(parameter: &ParameterSummary) -> Markup {
    let ratio = three_or_dash(parameter.se_ratio);
    html! { @if off(parameter) { b { (ratio) } } @else { (ratio) } }
}

fn reason() -> &'static str {
    "Standard errors hold to first order around the truth: where a few runs are far off, the runs of a design are different \
     experiments, or errors exceed the parameters themselves, the spread is larger. Those of ls and iv take the \
     residual for a moving average of order one, which a lasting current or gusts are not; least squares is biased besides. \
     Where the \
     disturbances last, those of refined-iv are made of residuals, which the estimate itself has fitted."
}

fn scenarios(scenarios: &[Scenario]) -> Markup {
    html! {
        section #scenarios {
            h2 { "Which estimator for which disturbances" }
            div.scroll { table {
                thead { tr {
                    th scope="col" { "Scenario" } th scope="col" { "Estimator" } th.number scope="col" { "Parameter error, median" }
                    th.number scope="col" { "RMS" } th.number scope="col" { "Bias" } th.number scope="col" { "Simulation error, median" }
                    th.number scope="col" { "No estimate" } th scope="col" { "Recommended" }
                } }
                tbody { @for scenario in scenarios { (scenario_rows(&scenario.name, &scenario.estimate, &scenario.validation)) } }
            } }
            p.note {
                "Of the first design of each scenario. Recommended: the estimator of least median error among those that estimate nearly \
                 every run, where paired differences from all others are larger than chance; else all that the runs cannot tell apart. "
                (INTERVALS)
            }
        }
    }
}

fn verdict(found: Option<&EstimatorRecommendation>, estimator: Estimator) -> Markup {
    let Some(found) = found.filter(|found| found.candidates.contains(&estimator)) else { return html! {} };
    match found.estimator {
        Some(_) => html! { b { "recommended" } },
        None => html! { "no difference that " (found.runs) " runs can tell" },
    }
}

fn scenario_rows(name: &str, estimate: &EstimateDocument, validation: &ValidationDocument) -> Markup {
    let (estimates, scores) =
        (estimate.compared.as_deref().unwrap_or(&[]), validation.compared.as_deref().unwrap_or(&[]));
    let design = designs(scores).first().copied().unwrap_or("");
    let found = recommendation(validation);
    html! {
        @for (i, score) in scores.iter().enumerate() {
            @if let (Some(d), Some(e)) = (of_design(&score.designs, design), summary(estimates, score.estimator, design)) {
                tr {
                    th scope="row" { @if i == 0 { (name) ", " (drawn_from(validation)) } }
                    td { (score.estimator) }
                    td.number { (three_within(d.parameter_error.median, d.parameter_error.median_interval)) }
                    td.number { (three_or_dash(e.relative_rms)) }
                    td.number { (three_or_dash(e.relative_bias)) }
                    td.number { (three_within(d.simulation_error.median, d.simulation_error.median_interval)) }
                    td.number { (percent(d.without_estimate_share.unwrap_or(f64::NAN))) }
                    td { (verdict(found, score.estimator)) }
                }
            }
        }
    }
}
