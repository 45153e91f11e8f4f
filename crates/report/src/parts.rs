//! Building blocks of sections.

use maud::{Markup, PreEscaped, Render, html};
use refusal::listed;
use study::documents::ScoredEstimates;

use crate::figures::map::parted;
use crate::interactive::Panel;

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
#[derive(Default)]
pub(super) struct Figures {
    pub(super) files: Vec<(String, String)>,
    /// What takes the places of some of them where scripts run.
    pub(super) panels: Vec<Panel>,
}

impl Figures {
    /// Places figures on the page, and a panel in their place on a screen where scripts run.
    pub(super) fn interactive(&mut self, panel: Panel, figures: &Markup) -> Markup {
        let both = html! { div { (figures) } div.live id=(panel.id) hidden { (panel.about) } };
        self.panels.push(panel);
        both
    }

    /// Keeps the drawing as `<name>.svg` and places it on the page with its caption.
    pub(super) fn place(&mut self, name: &str, svg: String, caption: &Markup) -> Markup {
        self.placed(name, svg, caption, "figure")
    }

    /// As [`Figures::place`], for a drawing too wide for a phone: it scrolls there.
    pub(super) fn place_wide(&mut self, name: &str, svg: String, caption: &Markup) -> Markup {
        self.placed(name, svg, caption, "figure wide")
    }

    /// As [`Figures::place`], for a map: its legend is beside it if the page is wide enough, and a panel in its place.
    pub(super) fn place_map(
        &mut self,
        name: &str,
        svg: &str,
        panel: Option<Panel>,
        caption: &Markup,
    ) -> Markup {
        self.files.push((format!("{name}.svg"), svg.to_owned()));
        let (map, legend) = parted(svg).map_or((svg.to_owned(), None), |[map, legend]| (map, Some(legend)));
        let mut map = html! { figure { (PreEscaped(map)) } };
        if let Some(panel) = panel {
            map = self.interactive(panel, &map);
        }
        html! {
            div.map {
                div.parted { div { (map) } @if let Some(legend) = legend { figure { (PreEscaped(legend)) } } }
                p.note { (caption) }
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

/// A table that is written column by column: each has a head and a function for its cells.
pub(super) struct HtmlTable<R> {
    class: Option<&'static str>,
    head: String,
    rows: Vec<TableRow<R>>,
}

/// A row: what it is of, its classes and its cells.
struct TableRow<R> {
    of: R,
    classes: Option<Vec<&'static str>>,
    cells: String,
}

impl<R: Copy> HtmlTable<R> {
    /// A row for each of `rows`.
    pub(super) fn of(rows: impl IntoIterator<Item = R>) -> Self {
        let row = |of| TableRow { of, classes: None, cells: String::new() };
        Self { class: None, head: String::new(), rows: rows.into_iter().map(row).collect() }
    }

    /// In small letters.
    pub(super) fn compact(self) -> Self {
        self.class("compact")
    }

    pub(super) fn class(self, class: &'static str) -> Self {
        Self { class: Some(class), ..self }
    }

    /// Marks the rows for which `holds` is true with this class.
    pub(super) fn mark(mut self, class: &'static str, holds: impl Fn(R) -> bool) -> Self {
        self.rows.iter_mut().for_each(|row| _ = row.classes.get_or_insert_default());
        self.set_off(class, holds)
    }

    /// Gives this class to the rows for which `holds` is true, and none to the others.
    pub(super) fn set_off(mut self, class: &'static str, holds: impl Fn(R) -> bool) -> Self {
        for row in self.rows.iter_mut().filter(|row| holds(row.of)) {
            row.classes.get_or_insert_default().push(class);
        }
        self
    }

    /// A column with the names of the rows.
    pub(super) fn name<C: Render>(self, head: impl Render, cell: impl Fn(R) -> C) -> Self {
        let name = |row| html! { th scope="row" { (cell(row)) } };
        self.with(html! { th scope="col" { (head) } }, name)
    }

    /// A column of text.
    pub(super) fn text<C: Render>(self, head: impl Render, cell: impl Fn(R) -> C) -> Self {
        let text = |row| html! { td { (cell(row)) } };
        self.with(html! { th scope="col" { (head) } }, text)
    }

    /// A column of numbers.
    pub(super) fn number<C: Render>(self, head: impl Render, cell: impl Fn(R) -> C) -> Self {
        self.classed("number", head, cell)
    }

    /// A column whose head and cells have a class.
    pub(super) fn classed<C: Render>(
        self,
        class: &'static str,
        head: impl Render,
        cell: impl Fn(R) -> C,
    ) -> Self {
        let classed = |row| html! { td class=(class) { (cell(row)) } };
        self.with(html! { th class=(class) scope="col" { (head) } }, classed)
    }

    /// A column with this head and these cells, whole elements.
    pub(super) fn with(mut self, head: Markup, cell: impl Fn(R) -> Markup) -> Self {
        self.head += &head.into_string();
        for row in &mut self.rows {
            row.cells += &cell(row.of).into_string();
        }
        self
    }
}

impl<R> Render for HtmlTable<R> {
    fn render(&self) -> Markup {
        let classes = |row: &TableRow<R>| row.classes.as_ref().map(|classes| classes.join(" "));
        html! {
            div.scroll { table class=[self.class] {
                thead { tr { (PreEscaped(&self.head)) } }
                tbody { @for row in &self.rows { tr class=[classes(row)] { (PreEscaped(&row.cells)) } } }
            } }
        }
    }
}

/// The elements within each of `outer`: with it, and whether it is the first there.
pub(super) fn grouped<'a, A, B>(
    outer: impl IntoIterator<Item = &'a A>,
    inner: impl Fn(&'a A) -> &'a [B],
) -> Vec<(bool, &'a A, &'a B)> {
    let within = |a| inner(a).iter().enumerate().map(move |(i, b)| (i == 0, a, b));
    outer.into_iter().flat_map(within).collect()
}

/// Explains the brackets after numbers.
pub(super) const INTERVALS: &str = "In brackets: 95 % confidence intervals of what endless runs would give, of shares by Wilson's score, of quantiles by \
     ranks. A repeated study's value falls into them less often, some 83 times of 100.";

/// The number of runs of a validation, and their seed: `500 runs per design, seed 1`.
pub(super) fn drawn_from(validation: &ScoredEstimates) -> String {
    let counts: Vec<u64> = validation.designs.iter().map(|d| d.runs).collect();
    let runs = match counts.split_first() {
        Some((first, others)) if others.iter().all(|count| count == first) => {
            format!("{first} runs per design")
        }
        _ => format!("{} runs", listed(&counts.iter().map(u64::to_string).collect::<Vec<_>>())),
    };
    let seed = validation.seed.map_or(String::new(), |seed| format!(", seed {seed}"));
    format!("{runs}{seed}")
}

/// A key figure with its caption, and lines below it.
pub(super) fn card(what: &str, figure: impl Render, of: impl Render, others: &[String]) -> Markup {
    html! {
        div.card {
            p.what { (what) }
            p.figure-line { span.big { (figure) } " " span.who { (of) } }
            @for other in others { p.other { (other) } }
        }
    }
}
