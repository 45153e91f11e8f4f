//! Tables of the page.

use maud::{Markup, PreEscaped, Render, html};

/// A table that is written column by column: each has a head and a function for its cells.
pub(super) struct Table<R> {
    class: Option<&'static str>,
    head: String,
    rows: Vec<Row<R>>,
}

struct Row<R> {
    of: R,
    classes: Option<Vec<&'static str>>,
    cells: String,
}

impl<R: Copy> Table<R> {
    /// A row for each of `rows`.
    pub(super) fn of(rows: impl IntoIterator<Item = R>) -> Self {
        let row = |of| Row { of, classes: None, cells: String::new() };
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

impl<R> Render for Table<R> {
    fn render(&self) -> Markup {
        let classes = |row: &Row<R>| row.classes.as_ref().map(|classes| classes.join(" "));
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
    let own = |a| inner(a).iter().enumerate().map(move |(i, b)| (i == 0, a, b));
    outer.into_iter().flat_map(own).collect()
}
