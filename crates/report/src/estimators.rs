use maud::{Markup, Render, display, html};
use study::documents::{
    DegreeOfFreedom, DesignScores, DesignSummary, EstimateDocument, Estimator, EstimatorRecommendation,
    EstimatorScores, EstimatorSummary, MeanRemoval, ParameterSummary, ScoredEstimates,
};
use study::files::Vessel;

use crate::figures::{ErrorRow, relative_errors};
use crate::number::{median, or_dash, percent, q90, three, three_or_dash, unit};
use crate::parts::{Figures, HtmlTable, INTERVALS, Section, drawn_from, entry, missing, section};
use crate::study::{Scenario, Study, optimized_first};

/// Every estimator on the same runs, if they were compared; then other studies' comparisons.
pub(super) fn estimators(study: &Study) -> Option<Section> {
    let is_compared = study.validation.as_ref().is_some_and(|v| v.compared.is_some());
    if !is_compared && study.scenarios.is_empty() {
        return None;
    }
    let both = study.estimate.as_ref().zip(study.validation.as_ref());
    let compared = both.and_then(|(e, v)| Some((e, e.compared.as_deref()?, v, v.compared.as_deref()?)));
    let content = html! {
        @if let Some((estimate, estimates, validation, scores)) = compared {
            (section("estimators", "Estimators on the same runs", html! {
                (recommended(validation))
                @for design in designs(scores) { (table(design, estimates, scores)) (trust(design, estimate)) }
                p.note { (drawn_from(validation)) ". " (INTERVALS) }
                p.note {
                    "Bias and spread: 2-norms over the parameters of (mean − truth)/truth and of the standard deviation over the truth's \
                     modulus, over the runs with an estimate. Parameter and simulation errors count a run without an estimate as infinite. \
                     Identified, instruments by output error: the nominal model diverges over the run, so the instruments of iv are \
                     simulated by the run's own model of least output error; it counts as a run with an estimate."
                }
            }))
        }
        @if !study.scenarios.is_empty() { (scenarios(&study.scenarios)) }
    };
    Some(Section { id: "estimators", title: "Estimators", content })
}

fn designs(scores: &[EstimatorScores]) -> Vec<&str> {
    let first = scores.first().map_or(&[][..], |s| &s.designs);
    optimized_first(first, |d| &d.design).into_iter().map(|d| d.design.as_str()).collect()
}

/// The recommendation of the validation for the design that is shown first.
fn recommended(validation: &ScoredEstimates) -> Markup {
    match recommendation(validation) {
        Some(advice) if advice.candidates.is_empty() => html! { p.missing { (advice.statement) } },
        Some(advice) => html! { p { (advice.statement) } },
        None => html! {},
    }
}

/// The recommendation for the design that is shown first.
fn recommendation(validation: &ScoredEstimates) -> Option<&EstimatorRecommendation> {
    let all = validation.recommendations.as_deref().unwrap_or(&[]);
    optimized_first(all, |advice| &advice.design).into_iter().next()
}

/// Scores and estimates of one estimator.
type Both<'a> = (Estimator, &'a DesignScores, &'a DesignSummary);

/// The estimators with scores and estimates of a design.
fn of_both<'a>(
    design: &str,
    estimates: &'a [EstimatorSummary],
    scores: &'a [EstimatorScores],
) -> Vec<Both<'a>> {
    let both = |score: &'a EstimatorScores| {
        let scored = score.designs.iter().find(|d| d.design == design)?;
        let estimated = estimates.iter().find(|e| e.estimator == score.estimator)?;
        Some((score.estimator, scored, estimated.designs.iter().find(|d| d.design == design)?))
    };
    scores.iter().filter_map(both).collect()
}

fn table(design: &str, estimates: &[EstimatorSummary], scores: &[EstimatorScores]) -> Markup {
    let table = HtmlTable::of(of_both(design, estimates, scores))
        .name("Estimator", |(estimator, ..)| display(estimator))
        .number("Parameter error, median", |(_, d, _)| median(&d.parameter_error))
        .number("90 %", |(_, d, _)| q90(&d.parameter_error))
        .number("RMS", |(.., e)| three_or_dash(e.relative_rms))
        .number("Bias", |(.., e)| three_or_dash(e.relative_bias))
        .number("Spread", |(.., e)| three_or_dash(e.relative_spread))
        .number("Predicted / spread", |(.., e)| {
            format!("{} to {}", three_or_dash(e.se_ratio_min), three_or_dash(e.se_ratio_max))
        })
        .number("Simulation error, median", |(_, d, _)| median(&d.simulation_error))
        .number("Diverged", |(_, d, _)| d.diverged)
        .number("Not identifiable", |(_, d, _)| d.not_identifiable)
        .number("Not converged", |(_, d, _)| or_dash(d.not_converged))
        .number("Model rejected", |(.., e)| or_dash(e.rejected));
    html! { h3 { "Estimators, " (design) } (table) }
}

/// Predicted over observed standard errors, parameter by parameter.
fn trust(design: &str, document: &EstimateDocument) -> Markup {
    let compared = document.compared.as_deref().unwrap_or(&[]);
    let all = compared.iter().flat_map(|e| e.designs.iter().map(move |d| (e.estimator, d)));
    let rows: Vec<(Estimator, &DesignSummary)> = all.filter(|(_, d)| d.design == design).collect();
    let Some((_, first)) = rows.first() else { return html! {} };
    // Whether standard errors cannot be trusted.
    let off = |parameter: &ParameterSummary| parameter.se_trusted == Some(false);
    let wrong: Vec<String> = rows
        .iter()
        .filter_map(|(estimator, d)| {
            let names: Vec<&str> = d.parameters.iter().filter(|p| off(p)).map(|p| p.name.as_str()).collect();
            (!names.is_empty()).then(|| format!("{estimator}: {}", names.join(", ")))
        })
        .collect();
    let within = percent(document.trusted_within.unwrap_or(f64::NAN));
    let cell = |parameter: &ParameterSummary| {
        let ratio = three_or_dash(parameter.se_ratio);
        html! { @if off(parameter) { b { (ratio) } } @else { (ratio) } }
    };
    let named = HtmlTable::of(rows.iter().copied())
        .compact()
        .name("Predicted / observed standard error", |(estimator, _)| display(estimator));
    let table = first.parameters.iter().enumerate().fold(named, |table, (i, p)| {
        table.number(&p.name, |(_, d)| d.parameters.get(i).map(cell).unwrap_or_default())
    });
    html! {
        (table)
        @if wrong.is_empty() {
            p.note { "All within " (within) " of 1." }
        } @else {
            p.note { "More than " (within) " off (bold): " (wrong.join("; ")) ". " (REASON) }
        }
    }
}

const REASON: &str = "Standard errors hold to first order around the truth: where a few runs are far off, the runs of a design are different \
     experiments, or errors exceed the parameters themselves, the spread is larger. Those of ls and iv take the \
     residual for a moving average of order one, which a lasting current or gusts are not; least squares is biased besides.";

/// A row per scenario and estimator.
fn scenarios(scenarios: &[Scenario]) -> Markup {
    let rows: Vec<(bool, &Scenario, Both<'_>)> = scenarios.iter().flat_map(of_first_design).collect();
    let table = HtmlTable::of(rows)
        .name("Scenario", |(first, s, _)| {
            html! { @if first { (s.name) ", " (drawn_from(&s.validation)) } }
        })
        .text("Estimator", |(.., (estimator, ..))| display(estimator))
        .number("Parameter error, median", |(.., (_, d, _))| median(&d.parameter_error))
        .number("RMS", |(.., (.., e))| three_or_dash(e.relative_rms))
        .number("Bias", |(.., (.., e))| three_or_dash(e.relative_bias))
        .number("Simulation error, median", |(.., (_, d, _))| median(&d.simulation_error))
        .number("No estimate", |(.., (_, d, _))| percent(d.without_estimate_share.unwrap_or(f64::NAN)))
        .text("Recommended", |(_, s, (estimator, ..))| verdict(recommendation(&s.validation), estimator));
    let body = html! {
        (table)
        p.note {
            "Of the first design of each scenario. Recommended: the estimator of least median error among those that estimate nearly \
             every run, where paired differences from all others are larger than chance; else all that the runs cannot tell apart. "
            (INTERVALS)
        }
    };
    section("scenarios", "Which estimator for which disturbances", body)
}

/// The estimators of a scenario, and whether each is the first that was compared.
fn of_first_design(scenario: &Scenario) -> impl Iterator<Item = (bool, &Scenario, Both<'_>)> {
    let estimates = scenario.estimate.compared.as_deref().unwrap_or(&[]);
    let scores = scenario.validation.compared.as_deref().unwrap_or(&[]);
    let design = designs(scores).first().copied().unwrap_or("");
    let first = scores.first().map(|score| score.estimator);
    of_both(design, estimates, scores).into_iter().map(move |both| (first == Some(both.0), scenario, both))
}

fn verdict(advice: Option<&EstimatorRecommendation>, estimator: Estimator) -> Markup {
    let Some(advice) = advice.filter(|advice| advice.candidates.contains(&estimator)) else {
        return html! {};
    };
    match advice.estimator {
        Some(_) => html! { b { "recommended" } },
        None => html! { "no difference that " (advice.runs) " runs can tell" },
    }
}

/// The estimates of every parameter.
pub(super) fn parameters(study: &Study, figures: &mut Figures) -> Section {
    let body = match (&study.estimate, &study.vessel) {
        (Some(estimate), vessel) => estimated(&Shown::of(estimate, study), vessel.as_ref(), figures),
        (None, Some(vessel)) => html! {
            (missing("The estimates are", "estimate.json", "estimate"))
            (structure(vessel))
        },
        (None, None) => missing("The parameters are", "estimate.json", "estimate"),
    };
    Section::new("parameters", "Parameters", "Parameters", body)
}

/// The estimates that are shown.
struct Shown<'a> {
    estimator: Estimator,
    mean_removal: MeanRemoval,
    designs: &'a [DesignSummary],
    /// The reason for these, if several estimators were compared.
    why: Option<String>,
    /// Whether all runs were pooled: then the section on trust says what the model lacks.
    pooled: bool,
}

impl<'a> Shown<'a> {
    /// The estimates by the recommended estimator; else by the best one.
    fn of(estimate: &'a EstimateDocument, study: &Study) -> Self {
        let best = study.validation.as_ref().and_then(recommendation).and_then(|advice| advice.estimator);
        let compared = estimate.compared.as_deref().unwrap_or(&[]);
        let recommended = compared.iter().find(|summary| Some(summary.estimator) == best);
        let (estimator, designs) = match recommended {
            Some(summary) => (summary.estimator, &summary.designs),
            None => (estimate.estimator, &estimate.designs),
        };
        let why = match recommended {
            Some(_) => format!("Estimates by {estimator}, which the validation recommends."),
            None => format!("No estimator is recommended; these are the estimates by {estimator}."),
        };
        let why = Some(why).filter(|_| !compared.is_empty());
        let pooled = estimate.structure.is_some();
        Self { estimator, mean_removal: estimate.mean_removal, designs, why, pooled }
    }
}

fn estimated(estimate: &Shown, vessel: Option<&Vessel>, figures: &mut Figures) -> Markup {
    let designs = optimized_first(estimate.designs, |d| &d.design);
    let rows = error_rows(&designs);
    let names: Vec<&str> = designs.iter().map(|d| d.design.as_str()).collect();
    let caption = html! {
        b { "Relative error of every parameter: mean (dot) and standard deviation (bar) over the runs." }
        " The axis is linear within ±10\u{a0}% and logarithmic beyond."
    };
    html! {
        @if let Some(why) = &estimate.why { p { (why) } }
        div.pair {
            @if rows.is_empty() {
                p.missing { "Relative errors are not shown: no parameter has a known true value other than zero." }
            } @else {
                (figures.place("relative-errors", relative_errors(&names, &rows), &caption))
            }
            (facts(estimate, &designs))
        }
        @for design in designs { (parameters_table(design, vessel)) }
    }
}

fn facts(estimate: &Shown, designs: &[&DesignSummary]) -> Markup {
    html! {
        dl.facts {
            (entry("Estimator", estimator(estimate.estimator)))
            (entry("Mean of the instruments removed", display(estimate.mean_removal)))
            @for design in designs {
                (entry(format!("Identified, {}", design.design), format!("{} of {} runs", design.identified, design.runs)))
                @if !estimate.pooled { (entry(format!("Model rejected, {}", design.design), rejected(design))) }
            }
            (entry("Spread", "standard deviation of the estimates over the identified runs"))
            (entry("Predicted", "median of the standard errors that the runs report of themselves"))
            (entry("Predicted / spread", "near 1: the reported standard errors can be trusted; below 1: they promise too much, or the runs are different experiments and the worst of them make the spread"))
        }
    }
}

/// The number of runs that reject the model.
fn rejected(design: &DesignSummary) -> String {
    design.rejected.map_or("the runs were not asked what the model lacks".to_owned(), |rejected| {
        format!("by {rejected} of {} runs; by chance by 1 in 20", design.identified)
    })
}

fn estimator(estimator: Estimator) -> &'static str {
    match estimator {
        Estimator::Iv => "instrumental variables",
        Estimator::Ls => "least squares",
        Estimator::OutputError => "output error: least errors of a free simulation",
        Estimator::PredictionError => "prediction error: least errors of a Kalman filter's predictions",
        Estimator::Auto => estimator.name(),
    }
}

fn error_rows<'a>(designs: &[&'a DesignSummary]) -> Vec<ErrorRow<'a>> {
    let parameters = designs.first().map_or(&[][..], |d| &d.parameters);
    let known = parameters.iter().filter(|parameter| parameter.relative_bias.is_some());
    let relative = |design: &DesignSummary, name: &str| {
        let parameter = design.parameters.iter().find(|p| p.name == name)?;
        parameter.relative_bias.zip(parameter.relative_spread)
    };
    let errors = |name: &str| designs.iter().map(|d| relative(d, name)).collect();
    known.map(|parameter| ErrorRow { name: &parameter.name, errors: errors(&parameter.name) }).collect()
}

fn parameters_table(design: &DesignSummary, vessel: Option<&Vessel>) -> Markup {
    let table = HtmlTable::of(&design.parameters)
        .name("Parameter", |p| &p.name)
        .text("Term", |p| term(vessel, &p.name))
        .text("Unit", |p| unit(&p.unit))
        .number("True", |p| three_or_dash(p.truth))
        .number("Nominal", |p| three(p.nominal))
        .number("Mean estimate", |p| three_or_dash(p.mean))
        .number("Spread", |p| three_or_dash(p.spread))
        .number("Predicted", |p| three_or_dash(p.predicted_se))
        .number("Predicted / spread", |p| three_or_dash(p.se_ratio));
    html! { h3 { "Estimates, " (design.design) } (table) }
}

fn term(vessel: Option<&Vessel>, name: &str) -> String {
    or_dash(
        vessel
            .and_then(|v| terms(v).into_iter().find(|(_, parameter, _)| *parameter == name))
            .map(|(.., term)| term),
    )
}

/// Every parameter with its degree of freedom and its term, in the order of `vessel.toml`.
fn terms(vessel: &Vessel) -> Vec<(DegreeOfFreedom, &str, &str)> {
    let degrees = DegreeOfFreedom::ALL.into_iter().zip(&vessel.model.degrees);
    let terms = degrees.flat_map(|(d, degree)| {
        degree
            .parameters
            .iter()
            .zip(&degree.terms)
            .map(move |(name, term)| (d, name.as_str(), term.text.as_str()))
    });
    terms.collect()
}

fn structure(vessel: &Vessel) -> Markup {
    let (terms, units) = (terms(vessel), vessel.model.parameter_units());
    let names: Vec<&str> = vessel.model.parameter_names().collect();
    // Those of forces belong to no one degree of freedom.
    let table = HtmlTable::of(0..names.len())
        .name("Parameter", |i| names[i])
        .text("Degree", |i| terms.get(i).map_or("–", |(degree, ..)| degree.name()))
        .text("Term", |i| terms.get(i).map_or("–", |(.., term)| term))
        .text("Unit", |i| unit(&units[i]))
        .number("True", |i| three_or_dash(vessel.value[i]))
        .number("Nominal", |i| three(vessel.nominal[i]));
    table.render()
}
