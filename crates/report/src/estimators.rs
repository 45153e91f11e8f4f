use identification::Estimator;
use maud::{Markup, html};

use super::number::{percent, three, three_or_dash};
use super::study::{Scenario, Study, optimized_first};
use study::documents::{
    DesignScores, DesignSummary, EstimateDocument, EstimatorScores, EstimatorSummary, ParameterSummary,
    ValidationDocument,
};

/// How far predicted standard errors may be from the spread before the table marks them.
const TRUSTED: f64 = 0.15;
/// Share of runs without an estimate beyond which an estimator is not recommended.
const FEW: f64 = 0.01;

/// Every estimator on the same runs, where they were compared.
pub(super) fn estimators(study: &Study) -> Markup {
    let both = study.estimate.as_ref().zip(study.validation.as_ref());
    let compared = both.and_then(|(e, v)| Some((e.compared.as_deref()?, v.compared.as_deref()?)));
    html! {
        @if let Some((estimates, scores)) = compared {
            section #estimators {
                h2 { "Estimators on the same runs" }
                (recommended(scores))
                @for design in designs(scores) { (table(design, estimates, scores)) (trust(design, estimates)) }
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

fn recommended(scores: &[EstimatorScores]) -> Markup {
    let design = designs(scores).first().copied().unwrap_or("");
    match best(scores, design) {
        Some((name, own)) => html! { p {
            "For these disturbances and the " (design) " design: " b { (name) } ", with the smallest median parameter error ("
            (three_or_dash(own.parameter_error.median)) ") of those that leave at most " (percent(FEW)) " of the runs without an estimate."
        } },
        None => {
            html! { p.missing { "No estimator can be recommended: each leaves too many runs without an estimate." } }
        }
    }
}

/// The estimator with the smallest median parameter error, or simulation error where the truth is not known.
fn best<'a>(scores: &'a [EstimatorScores], design: &str) -> Option<(Estimator, &'a DesignScores)> {
    let own = |s: &'a EstimatorScores| Some((s.estimator, of_design(&s.designs, design)?));
    let error =
        |d: &DesignScores| d.parameter_error.median.or(d.simulation_error.median).unwrap_or(f64::INFINITY);
    let good = scores.iter().filter_map(own).filter(|(_, d)| lost(d) <= FEW && error(d).is_finite());
    good.min_by(|a, b| error(a.1).total_cmp(&error(b.1)))
}

fn of_design<'a>(designs: &'a [DesignScores], name: &str) -> Option<&'a DesignScores> {
    designs.iter().find(|d| d.design == name)
}

/// Share of runs without an estimate.
fn lost(d: &DesignScores) -> f64 {
    (d.not_identifiable + d.not_converged.unwrap_or(0)) as f64 / d.runs.max(1) as f64
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
    let (bias, spread) = norms(&estimates.parameters);
    let ratios: Vec<f64> = estimates.parameters.iter().filter_map(ratio).collect();
    let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let most = ratios.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let count = |count: Option<u64>| count.map_or("–".to_owned(), |c| c.to_string());
    [
        three_or_dash(scores.parameter_error.median),
        three_or_dash(scores.parameter_error.q90),
        three(bias.hypot(spread)),
        three(bias),
        three(spread),
        format!("{} to {}", three(least), three(most)),
        three_or_dash(scores.simulation_error.median),
        scores.diverged.to_string(),
        scores.not_identifiable.to_string(),
        count(scores.not_converged),
        count(estimates.kept),
    ]
}

/// Relative bias and spread over the parameters with a known truth.
fn norms(parameters: &[ParameterSummary]) -> (f64, f64) {
    let relative = |p: &ParameterSummary| {
        let truth = p.truth.filter(|truth| *truth != 0.0)?;
        Some([(p.mean? - truth) / truth, p.spread? / truth])
    };
    let all: Vec<[f64; 2]> = parameters.iter().filter_map(relative).collect();
    let norm = |i: usize| match all.is_empty() {
        true => f64::NAN,
        false => all.iter().map(|x| x[i] * x[i]).sum::<f64>().sqrt(),
    };
    (norm(0), norm(1))
}

fn ratio(parameter: &ParameterSummary) -> Option<f64> {
    let spread = parameter.spread.filter(|spread| *spread > 0.0)?;
    Some(parameter.predicted_se? / spread)
}

/// Predicted over observed standard errors, parameter by parameter.
fn trust(design: &str, estimates: &[EstimatorSummary]) -> Markup {
    let of = |e: &EstimatorSummary| e.designs.iter().find(|d| d.design == design).cloned();
    let rows: Vec<(Estimator, DesignSummary)> =
        estimates.iter().filter_map(|e| Some((e.estimator, of(e)?))).collect();
    let Some((_, first)) = rows.first() else { return html! {} };
    let off = |p: &ParameterSummary| ratio(p).is_none_or(|r| (r - 1.0).abs() > TRUSTED);
    let wrong: Vec<String> = rows
        .iter()
        .filter_map(|(name, d)| {
            let names: Vec<&str> = d.parameters.iter().filter(|p| off(p)).map(|p| p.name.as_str()).collect();
            (!names.is_empty()).then(|| format!("{name}: {}", names.join(", ")))
        })
        .collect();
    html! {
        div.scroll { table.compact {
            thead { tr {
                th scope="col" { "Predicted / observed standard error" }
                @for p in &first.parameters { th.number scope="col" { (p.name) } }
            } }
            tbody { @for (name, d) in &rows {
                tr { th scope="row" { (name) } @for p in &d.parameters { td.number { (cell(p, off(p))) } } }
            } }
        } }
        @if wrong.is_empty() {
            p.note { "All within " (percent(TRUSTED)) " of 1." }
        } @else {
            p.note {
                "More than " (percent(TRUSTED)) " off (bold): " (wrong.join("; ")) ". " (reason())
            }
        }
    }
}

fn cell(parameter: &ParameterSummary, off: bool) -> Markup {
    let ratio = three_or_dash(ratio(parameter));
    html! { @if off { b { (ratio) } } @else { (ratio) } }
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
            p.note { "Of the first design of each scenario. Recommended: the smallest median parameter error of those that leave at most " (percent(FEW)) " of the runs without an estimate." }
        }
    }
}

fn scenario_rows(name: &str, estimate: &EstimateDocument, validation: &ValidationDocument) -> Markup {
    let (estimates, scores) =
        (estimate.compared.as_deref().unwrap_or(&[]), validation.compared.as_deref().unwrap_or(&[]));
    let design = designs(scores).first().copied().unwrap_or("");
    let first = best(scores, design).map(|(estimator, _)| estimator);
    html! {
        @for (i, score) in scores.iter().enumerate() {
            @if let (Some(d), Some(e)) = (of_design(&score.designs, design), summary(estimates, score.estimator, design)) {
                tr {
                    th scope="row" { @if i == 0 { (name) } }
                    td { (score.estimator) }
                    td.number { (three_or_dash(d.parameter_error.median)) }
                    td.number { (three(norms(&e.parameters).0.hypot(norms(&e.parameters).1))) }
                    td.number { (three(norms(&e.parameters).0)) }
                    td.number { (three_or_dash(d.simulation_error.median)) }
                    td.number { (percent(lost(d))) }
                    td { @if Some(score.estimator) == first { b { "recommended" } } }
                }
            }
        }
    }
}
