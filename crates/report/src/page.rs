use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::allocation::allocation;
use super::certificate::certificate;
use super::comparison::comparison;
use super::crossval::cross_validation;
use super::dictionary::dictionary;
use super::errors::errors;
use super::estimators::{self, estimators};
use super::excitation::excitation;
use super::headline::{headline, kind};
use super::logs::logs;
use super::measured::Measured;
use super::notes::{files, notation};
use super::parameters::parameters;
use super::placed::{Figures, Section};
use super::published_selection::published_selection;
use super::selection::selection;
use super::sequential::sequential;
use super::study::Study;
use super::trajectory::{self, trajectory};
use super::trust::trust;

/// The page and its figures.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// One self-contained HTML document.
    pub html: String,
    /// File name (`shares.svg`) and SVG text of every figure, in the order of the page.
    pub figures: Vec<(String, String)>,
}

const STYLE: &str = include_str!("style.css");

/// Renders the page. What `study` lacks is named on it.
pub fn render(study: &Study) -> Rendered {
    let mut figures = Figures::default();
    let mut sections = match (&study.measured, &study.sequential, &study.design) {
        (Some(measured), ..) => of_logs(study, measured, &mut figures),
        (None, Some(found), None) => sequential(found, &mut figures),
        _ => of_trials(study, &mut figures),
    };
    sections.push(("notation", "Notation", notation(study)));
    sections.push(("files", "Files", files(study)));
    let html = document(study, &sections).into_string();
    Rendered { html, figures: figures.files }
}

/// The sections of a study of simulated trials.
fn of_trials(study: &Study, figures: &mut Figures) -> Vec<Section> {
    let mut sections = vec![("comparison", "Result", comparison(study))];
    if estimators::shown(study) {
        sections.push(("estimators", "Estimators", estimators(study)));
    }
    sections.extend([
        ("shares", "Shares", allocation(study, figures)),
        ("certificate", "Certificate", certificate(study)),
        ("dictionary", "Dictionary", dictionary(study, figures)),
    ]);
    if study.trajectory.is_some() {
        sections.push(("trajectory", "Trajectory", trajectory(study, figures)));
    }
    if study.selection.is_some() {
        sections.push(("selection", "Selection", selection(study, figures)));
    }
    if study.published_selection().is_some() {
        sections.push(("published", "Published", published_selection(study, figures)));
    }
    sections.push(("errors", "Errors", errors(study, figures)));
    sections.push(("parameters", "Parameters", parameters(study, figures)));
    sections.push(("excitation", "Excitation", excitation(study)));
    sections
}

/// The sections of a study of measured logs.
fn of_logs(study: &Study, measured: &Measured, figures: &mut Figures) -> Vec<Section> {
    let mut sections = vec![
        ("cross-validation", "Cross-validation", cross_validation(measured)),
        ("trust", "Trust", trust(measured)),
    ];
    if study.selection.is_some() {
        sections.push(("selection", "Selection", selection(study, figures)));
    }
    if study.published_selection().is_some() {
        sections.push(("published", "Published", published_selection(study, figures)));
    }
    if study.design.is_some() {
        sections.push(("shares", "Shares", allocation(study, figures)));
        sections.push(("certificate", "Certificate", certificate(study)));
    }
    if study.dictionary.is_some() {
        sections.push(("dictionary", "Dictionary", dictionary(study, figures)));
    }
    sections.push(("logs", "Logs", logs(measured)));
    sections
}

fn document(study: &Study, sections: &[Section]) -> Markup {
    let planned = study.trajectory.is_some();
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (study.name) " – " (kind(study)) }
                style { (PreEscaped(STYLE)) @if planned { (PreEscaped(trajectory::STYLE)) } }
            }
            body {
                main {
                    (headline(study))
                    nav aria-label="Contents" { @for (id, title, _) in sections { a href={ "#" (id) } { (title) } } }
                    @for (_, _, section) in sections { (section) }
                }
            }
        }
    }
}
