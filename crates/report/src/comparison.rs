use maud::{Markup, html};

use super::number::{exact, median, parameter_share, published, q90, simulation_share, three};
use super::parts::{Section, missing};
use super::sample::{INTERVALS, drawn_from};
use super::study::Study;
use super::table::Table;
use study::documents::{DesignScores, Published, PublishedShare, Reference, ValidationDocument};

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
pub(super) fn use_of_published(reference: &Reference) -> &str {
    let none = "Published numbers are shown for comparison and used for nothing else.";
    reference.used.as_deref().unwrap_or(none)
}

/// A row's value for a design, and the published one.
type Line<'a> = (&'a str, fn(&DesignScores) -> String, Option<fn(&Published) -> PublishedShare>);

fn table(study: &Study, validation: &ValidationDocument) -> Markup {
    let (scored, reference) = (study.scored(), study.reference.as_ref());
    let bounds = validation.bounds;
    let parameter = format!("Runs with parameter error below {}", exact(bounds.parameter_error));
    let simulation = format!("Runs with simulation error below {}", exact(bounds.simulation_error));
    let lines: [Line<'_>; 12] = [
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
        Table::of(lines).set_off("main", |(.., theirs)| theirs.is_some()).name("", |(label, ..)| label);
    let table = scored.iter().fold(labelled, |table, d| {
        let table = table.number(&d.design, |(_, ours, _)| ours(d));
        let Some(reference) = reference else { return table };
        let own = reference.designs.get(&d.design);
        table.classed("number published", "published", |(.., theirs)| {
            printed(own.zip(theirs).map(|(own, share)| share(own)))
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
    let found = *study.scored().first()?;
    let (parameters, simulations) = (found.parameter_error.median?, found.simulation_error.median?);
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
