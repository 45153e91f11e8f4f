use maud::{Markup, PreEscaped, html};

/// Id, title and content of a section.
pub(super) type Section = (&'static str, &'static str, Markup);

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
