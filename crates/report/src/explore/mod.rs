//! `explore.html`: the trials, the model over time and the plans of a study, to be zoomed, filtered and sorted.

mod assets;
mod comparison;
mod embedded;
mod panel;
mod plans;
mod steps;
mod trials;

use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::{Value, json};

use crate::headline::kind;
use crate::page::STYLE;
use crate::parts::missing;
use crate::study::Study;
use assets::Library;
use panel::Panel;

/// No request leaves the page: the browser refuses all but what stands in it.
const POLICY: &str =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:";

/// The interactive page beside the report, whose file is called `report`. The same study gives the same bytes.
pub fn explore(study: &Study, report: &str) -> String {
    let mut panels = trials::panels(study);
    panels.extend(comparison::panel(study));
    panels.extend(plans::panels(study));
    page(study, report, &panels).into_string()
}

fn page(study: &Study, report: &str, panels: &[Panel]) -> Markup {
    let of = |library: Library| panels.iter().any(|panel| panel.library == library).then_some(library);
    let libraries: Vec<Library> = [Library::Plots, Library::Maps].into_iter().filter_map(of).collect();
    let data: Vec<Value> = panels.iter().map(|panel| json!({"id": panel.id, "data": panel.data})).collect();
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (study.name) " – explore" }
                style { (PreEscaped(STYLE)) @for library in &libraries { (PreEscaped(library.style())) } (PreEscaped(assets::STYLE)) }
            }
            body {
                main {
                    (head(study, report))
                    nav aria-label="Contents" { @for panel in panels { a href={ "#" (panel.id) } { (panel.title) } } }
                    noscript { p.missing { "This page needs JavaScript. " (link(report, "The report")) " does without." } }
                    @for panel in panels { (section(panel)) }
                    @if panels.is_empty() { (nothing()) }
                }
                script #data type="application/json" { (PreEscaped(embedded::script(&Value::Array(data)))) }
                @for library in &libraries { script { (PreEscaped(library.script())) } }
                script { (PreEscaped(assets::SCRIPT)) }
            }
        }
    }
}

fn head(study: &Study, report: &str) -> Markup {
    html! {
        header {
            p.kicker { (kind(study)) ", to explore" }
            h1 { (study.name) }
            p.about { (link(report, "The report")) " has the results in words, and the digests of all files." }
            @if let Some(label) = &study.data {
                p.label { "Data: " b { (label) } ". No real ship was measured; the logs that everything here is made of were simulated." }
            }
            @if !study.mixed.is_empty() {
                p.label { "Mixed: files of different studies, made with more than one " (study.mixed.join(", ")) "." }
            }
        }
    }
}

/// A link to a file beside the page; `./` keeps a name with a colon from being read as another address.
fn link(file: &str, words: &str) -> Markup {
    html! { a href={ "./" (file.replace('%', "%25").replace('#', "%23").replace('?', "%3F")) } { (words) } }
}

fn section(panel: &Panel) -> Markup {
    html! {
        section id=(panel.id) {
            h2 { (panel.title) }
            (panel.about)
            div.panel {}
        }
    }
}

/// The files that a panel each would be drawn from.
fn nothing() -> Markup {
    html! {
        (missing("Trials are", "scores.parquet", "validate"))
        (missing("Measured and simulated motion is", "compare.parquet", "validate compare"))
        (missing("A plan on its map is", "map.json", "plan"))
    }
}
