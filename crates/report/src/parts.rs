//! Building blocks of sections.

use maud::{Markup, PreEscaped, Render, html};

/// Name of the page to explore, beside the report.
pub const EXPLORE: &str = "explore.html";

/// A section of the page.
pub(super) struct Section {
    pub(super) id: &'static str,
    /// The title in the table of contents.
    pub(super) title: &'static str,
    pub(super) content: Markup,
}

impl Section {
    pub(super) fn new(id: &'static str, title: &'static str, heading: &str, body: impl Render) -> Self {
        Self { id, title, content: section(id, heading, body) }
    }
}

/// A subsection of a [`Section`].
pub(super) fn section(id: &str, heading: &str, body: impl Render) -> Markup {
    html! { section id=(id) { h2 { (heading) } (body) } }
}

/// Says which file is missing and which stage writes it.
pub(super) fn missing(what: &str, file: &str, stage: &str) -> Markup {
    html! {
        p.missing {
            (what) " not shown: there is no " code { (file) } "; the stage " code { (stage) } " writes it."
        }
    }
}

/// A term of a list with its meaning.
pub(super) fn entry(term: impl Render, meaning: impl Render) -> Markup {
    html! { div { dt { (term) } dd { (meaning) } } }
}

/// Statements with names in backticks.
pub(super) fn statements(said: &[String]) -> Markup {
    html! { @for statement in said { p.note { (coded(statement)) } } }
}

/// Warns of maneuvers that leave the range of the model's logs.
pub(super) fn beyond(said: &[String]) -> Markup {
    html! {
        @if !said.is_empty() {
            p.caution { b { "Beyond the model's logs." } " " (said.join("; ")) ". There the model is not known to hold." }
        }
    }
}

/// Warns of parameters that are held, since no maneuver excites them.
pub(super) fn held(words: Option<&String>) -> Markup {
    html! { @if let Some(words) = words { p.caution { b { "Held." } " " (coded(words)) "." } } }
}

/// Text with names in backticks.
pub(super) fn coded(text: &str) -> Markup {
    html! { @for (i, piece) in text.split('`').enumerate() { @if i % 2 == 1 { code { (piece) } } @else { (piece) } } }
}

/// The figures made so far, under the names of their files.
#[derive(Debug, Default)]
pub(super) struct Figures {
    pub(super) files: Vec<(String, String)>,
}

impl Figures {
    /// Keeps the drawing as `<name>.svg` and places it on the page with its caption.
    pub(super) fn place(&mut self, name: &str, svg: String, caption: &Markup) -> Markup {
        self.placed(name, svg, caption, "figure")
    }

    /// As [`Figures::place`], for a drawing too wide for a phone: it scrolls there.
    pub(super) fn place_wide(&mut self, name: &str, svg: String, caption: &Markup) -> Markup {
        self.placed(name, svg, caption, "figure wide")
    }

    /// As [`Figures::place`], also for a drawing in parts, which are side by side if the page is wide enough.
    pub(super) fn place_parted(
        &mut self,
        name: &str,
        svg: String,
        parts: Option<[String; 2]>,
        caption: &Markup,
    ) -> Markup {
        let Some([first, second]) = parts else { return self.place(name, svg, caption) };
        self.files.push((format!("{name}.svg"), svg));
        html! {
            figure.figure {
                div.parted { div { (PreEscaped(first)) } div { (PreEscaped(second)) } }
                figcaption { (caption) }
            }
        }
    }

    fn placed(&mut self, name: &str, svg: String, caption: &Markup, class: &str) -> Markup {
        self.files.push((format!("{name}.svg"), svg.clone()));
        html! {
            figure class=(class) {
                div.scroll { (PreEscaped(svg)) }
                figcaption { (caption) }
            }
        }
    }
}
