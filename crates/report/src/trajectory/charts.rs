//! The treatment of the objects of electronic charts, folded.

use maud::{Markup, html};
use study::documents::{LeftOut, PlanChart};

use crate::table::Table;

/// The electronic charts of the plan, remarks on their files, and the objects that were omitted, with reasons.
pub(super) fn charts(charts: &[PlanChart]) -> Markup {
    let rows = || charts.iter().flat_map(|chart| chart.left_out().map(move |left_out| (chart, left_out)));
    html! {
        @if !charts.is_empty() {
            details {
                summary { "Electronic charts, and what of them was left out" }
                @for chart in charts {
                    p.note { (chart.named()) @for note in &chart.notes { "; " (note) } "." }
                }
                @if rows().next().is_some() { (table(rows())) } @else { p.note { "No object was left out." } }
            }
        }
    }
}

fn table<'a>(
    rows: impl Iterator<Item = (&'a PlanChart, LeftOut<'a>)>,
) -> Table<(&'a PlanChart, LeftOut<'a>)> {
    Table::of(rows)
        .compact()
        .name("Chart", |(chart, _)| &chart.file)
        .text("Class", |(_, own)| own.class)
        .number("Objects", |(_, own)| own.objects)
        .text("Why", |(_, own)| own.why)
}
