use maud::{DOCTYPE, Markup, PreEscaped, html};
use report_figures::FigureError;

use super::allocation::allocation;
use super::certificate::certificate;
use super::comparison::comparison;
use super::dictionary::dictionary;
use super::errors::errors;
use super::estimators::{self, estimators};
use super::excitation::excitation;
use super::figures::Figures;
use super::headline::headline;
use super::notes::{files, notation};
use super::parameters::parameters;
use super::selection::selection;
use super::study::Study;
use super::trajectory::{self, trajectory};

/// The page and its figures.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// One self-contained HTML document.
    pub html: String,
    /// File name (`shares.svg`) and SVG text of every figure, in the order of the page.
    pub figures: Vec<(String, String)>,
}

const STYLE: &str = include_str!("style.css");

const CONTENTS: [(&str, &str); 12] = [
    ("comparison", "Result"),
    ("estimators", "Estimators"),
    ("shares", "Shares"),
    ("certificate", "Certificate"),
    ("dictionary", "Dictionary"),
    ("trajectory", "Trajectory"),
    ("selection", "Selection"),
    ("errors", "Errors"),
    ("parameters", "Parameters"),
    ("excitation", "Excitation"),
    ("notation", "Notation"),
    ("files", "Files"),
];

/// Renders the page. What `study` lacks is named on it.
///
/// # Errors
/// A figure cannot be drawn.
pub fn render(study: &Study) -> Result<Rendered, FigureError> {
    let mut figures = Figures::default();
    let sections = [
        comparison(study),
        estimators(study),
        allocation(study, &mut figures)?,
        certificate(study),
        dictionary(study, &mut figures)?,
        trajectory(study, &mut figures)?,
        selection(study, &mut figures)?,
        errors(study, &mut figures)?,
        parameters(study, &mut figures)?,
        excitation(study),
        notation(),
        files(study),
    ];
    let html = document(study, &sections).into_string();
    Ok(Rendered { html, figures: figures.files })
}

fn document(study: &Study, sections: &[Markup]) -> Markup {
    let planned = study.trajectory.is_some();
    let shown = |id: &str| match id {
        "trajectory" => planned,
        "selection" => study.selection.is_some(),
        "estimators" => estimators::shown(study),
        _ => true,
    };
    let contents = CONTENTS.iter().filter(|(id, _)| shown(id));
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (study.name) " – experiment design report" }
                style { (PreEscaped(STYLE)) @if planned { (PreEscaped(trajectory::STYLE)) } }
            }
            body {
                main {
                    (headline(study))
                    nav aria-label="Contents" { @for (id, title) in contents { a href={ "#" (id) } { (title) } } }
                    @for section in sections { (section) }
                }
            }
        }
    }
}
