use maud::{Markup, Render, html};
use study::documents::{
    DesignScores, Published, PublishedLimits, PublishedPicks, PublishedSelection, PublishedShare, Quantiles,
    Reference, ScoredEstimates, SelectionScores, Share, SharesBeyond,
};
use study::estimates::distinct;
use study::scores::Row;
use study::selection::Row as SelectionRow;

use crate::dictionary::validation_input;
use crate::figures::HistogramPanel;
use crate::interactive;
use crate::number::{
    exact, median, or_dash, parameter_share, percent, percent_within, published, q90, simulation_share, three,
};
use crate::parts::{Figures, HtmlTable, INTERVALS, Section, drawn_from, missing};
use crate::selection::{ErrorFigure, SelectionStudy};
use crate::study::{Study, optimized_first};

/// Our shares under the bounds, quantiles and failures per design, next to the published shares.
pub(super) fn comparison(study: &Study) -> Section {
    let heading = if study.reference.is_some() { "Result beside the published one" } else { "Result" };
    let body = html! {
        @match &study.validation {
            Some(validation) => (table(study, validation)),
            None => (missing("The comparison of designs is", "validation.json", "validate")),
        }
        @if let Some(reference) = &study.reference {
            p.note { "Published: " (reference.source) ". " (use_of_published(reference)) }
        }
    };
    Section::new("comparison", "Result", heading, body)
}

/// The use of the published numbers.
fn use_of_published(reference: &Reference) -> &str {
    let none = "Published numbers are shown for comparison and used for nothing else.";
    reference.used.as_deref().unwrap_or(none)
}

/// A row's value for a design, and the published one.
type ScoreLine<'a> = (&'a str, fn(&DesignScores) -> String, Option<fn(&Published) -> PublishedShare>);

fn table(study: &Study, validation: &ScoredEstimates) -> Markup {
    let (scored, reference) = (study.scored(), study.reference.as_ref());
    let bounds = validation.bounds;
    let parameter = format!("Runs with parameter error below {}", exact(bounds.parameter_error));
    let simulation = format!("Runs with simulation error below {}", exact(bounds.simulation_error));
    let lines: [ScoreLine<'_>; 12] = [
        (&parameter, parameter_share, Some(|p| p.parameter_error_share)),
        (&simulation, simulation_share, Some(|p| p.simulation_error_share)),
        ("Parameter error, median", |d| median(&d.parameter_error), None),
        ("Parameter error, 90 % quantile", |d| q90(&d.parameter_error), None),
        ("Simulation error, median", |d| median(&d.simulation_error), None),
        ("Simulation error, 90 % quantile", |d| q90(&d.simulation_error), None),
        ("RMSE in surge, median [m/s]", |d| median(&d.rmse_u), None),
        ("RMSE in sway, median [m/s]", |d| median(&d.rmse_v), None),
        ("RMSE in yaw rate, median [rad/s]", |d| median(&d.rmse_r), None),
        ("Runs", |d| d.runs.to_string(), None),
        ("Free simulation diverged", |d| d.diverged.to_string(), None),
        ("Not identifiable", |d| d.not_identifiable.to_string(), None),
    ];
    let labelled =
        HtmlTable::of(lines).set_off("main", |(.., theirs)| theirs.is_some()).name("", |(label, ..)| label);
    let table = scored.iter().fold(labelled, |table, d| {
        let table = table.number(&d.design, |(_, ours, _)| ours(d));
        let Some(reference) = reference else { return table };
        let published = reference.designs.get(&d.design);
        table.classed("number published", "published", |(.., theirs)| {
            printed(published.zip(theirs).map(|(published, share)| share(published)))
        })
    });
    html! {
        (table)
        @if let Some(foretold) = foretold(study) { p { (foretold) } }
        p.note { "A run without an estimate, or whose free simulation diverged, counts as above every bound and as infinite in the quantiles (a dash). " (drawn_from(validation)) ". " (INTERVALS) }
    }
}

/// What the design foretold of the trial, beside what its simulations found.
fn foretold(study: &Study) -> Option<String> {
    let foretold = study.design.as_ref()?.sequence.as_ref()?.foretold?;
    let first = *study.scored().first()?;
    let (parameters, simulations) = (first.parameter_error.median?, first.simulation_error.median?);
    let (parameter, simulation) = (foretold.parameter_error, foretold.simulation_error?);
    Some(format!(
        "Before the trial the design foretold, as medians, a parameter error of {} and a simulation error of {}; found were {} and {}, \
         {:.2} and {:.2} times as much.",
        three(parameter),
        three(simulation),
        three(parameters),
        three(simulations),
        parameters / parameter,
        simulations / simulation,
    ))
}

fn printed(share: Option<PublishedShare>) -> String {
    match share {
        Some(PublishedShare::Value(share)) => published(share),
        Some(PublishedShare::Above { above }) => format!(">\u{a0}{}", published(above)),
        None => "–".to_owned(),
    }
}

const PARAMETER: ErrorFigure<'_> = ErrorFigure::half("parameter-error", "parameter error [1]", 25.0)
    .captioned("Norm of the relative parameter errors; of true values of 0 that of the estimates.");
const SIMULATION: ErrorFigure<'_> =
    ErrorFigure::half("simulation-error", "norm of the simulation RMSE [m/s, m/s, rad/s]", 0.5)
        .captioned("Norm of the simulation errors.");
const CAPTIONS: [&str; 3] =
    ["Simulation error in surge.", "Simulation error in sway.", "Simulation error in yaw."];

/// The histograms of all errors over the runs, and the input of the validation.
pub(super) fn errors(study: &Study, figures: &mut Figures) -> Section {
    let body = match study.scores.as_deref() {
        Some(scores) if !scores.is_empty() => drawn(study, scores, figures),
        _ => missing("The histograms are", "scores.parquet", "validate"),
    };
    let input = match &study.validation_trace {
        Some(trace) => validation_input(trace, figures),
        None => missing("The validation input is", "validation.parquet", "simulate validation"),
    };
    Section::new("errors", "Errors", "Errors of the estimated models", html! { (body) (input) })
}

/// The bound below which a run counts as good, and the share of runs that do.
type Good = (f64, fn(&DesignScores) -> f64);

fn drawn(study: &Study, scores: &[Row], figures: &mut Figures) -> Markup {
    let designs = distinct(scores.iter().map(|row| row.design.as_str()));
    let designs: Vec<&str> = optimized_first(&designs, |design| design).into_iter().copied().collect();
    let scored = study.scored();
    let panels = |value: &dyn Fn(&Row) -> Option<f64>, good: Option<Good>| -> Vec<HistogramPanel<'_>> {
        let values = |design: &str| scores.iter().filter(|row| row.design == design).map(value).collect();
        let note = |design: &str| {
            let ((bound, share), scores) = (good?, scored.iter().find(|d| d.design == design)?);
            Some(format!("{} below {}", percent(share(scores)), exact(bound)))
        };
        let all = designs.iter();
        all.map(|design| HistogramPanel { label: design, values: values(design), note: note(design) })
            .collect()
    };
    let bounds = study.validation.as_ref().map(|v| v.bounds);
    let parameter = bounds.map(|b| -> Good { (b.parameter_error, |d| d.parameter_error_share) });
    let simulation = bounds.map(|b| -> Good { (b.simulation_error, |d| d.simulation_error_share) });
    let degrees = ErrorFigure::thirds(["rmse-surge", "rmse-sway", "rmse-yaw"], [1.0, 0.25, 0.15]);
    let histograms = html! {
        div.pair {
            (PARAMETER.bounded(parameter.map(|p| p.0)).place(&panels(&|r| r.parameter_error, parameter), figures))
            (SIMULATION.bounded(simulation.map(|s| s.0)).place(&panels(&|r| r.simulation_error, simulation), figures))
        }
        div.triple {
            @for (d, figure) in degrees.iter().enumerate() {
                (figure.captioned(CAPTIONS[d]).place(&panels(&|r| r.rmse[d], None), figures))
            }
        }
    };
    figures.interactive(interactive::scored(scores), &histograms)
}

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
        (published_table(found, limits))
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
fn norm(row: &SelectionRow) -> Option<f64> {
    row.rmse.map(|errors| errors.iter().map(|e| e * e).sum::<f64>().sqrt())
}

/// A row's value for a design, and the published one.
type PublishedScoreLine<'a> =
    (&'a str, &'a dyn Fn(&SelectionScores) -> String, Option<fn(&PublishedPicks) -> Option<String>>);

fn published_table(found: &SelectionStudy, limits: &PublishedSelection) -> Markup {
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
        let share = d.beyond_published.as_ref().map(share);
        or_dash(share.map(|share| percent_within(share.share, share.interval)))
    };
    let lines: [PublishedScoreLine<'_>; 8] = [
        (&labels[0], &|d| beyond(d, |b| b.norm), Some(|p| p.degenerate_share.map(published))),
        ("Best", &|d| norm(d, |q| q.min), Some(|p| p.best.clone())),
        ("Median", &|d| norm(d, |q| q.median), None),
        ("90 % quantile", &|d| norm(d, |q| q.q90), None),
        ("Worst", &|d| norm(d, |q| q.max), Some(|p| p.worst.clone())),
        (&labels[1], &|d| beyond(d, |b| b.surge), None),
        (&labels[2], &|d| beyond(d, |b| b.sway), None),
        (&labels[3], &|d| beyond(d, |b| b.yaw), None),
    ];
    let labelled = HtmlTable::of(lines).name("norm of RMSE", |(label, ..)| label);
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
