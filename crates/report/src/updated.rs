use maud::{Markup, html};

use super::number::{or_dash, three};
use super::parts::Table;
use study::documents::{DesignUpdateDocument, UpdatedParameter};

/// What became of the promise of a design; nothing before its trial.
pub(super) fn updated(found: Option<&DesignUpdateDocument>) -> Markup {
    let Some(found) = found else { return html! {} };
    html! {
        h3 { "What became of the promise?" }
        p { (found.statement) }
        (table(&found.parameters))
        p.note {
            "Standard errors as promised for a trial of this length, and from the covariance of its estimate. Scales are what errors \
             are relative to, before and after."
        }
        @for said in &found.statements { p.note { (said) } }
    }
}

fn table(parameters: &[UpdatedParameter]) -> Table<&UpdatedParameter> {
    Table::of(parameters)
        .compact()
        .name("Parameter", |own| own.name.as_str())
        .number("Estimate", |own| three(own.estimate))
        .number("Scale", |own| or_dash(own.scale.map(three)))
        .number("Promised", |own| three(own.standard_error.promised))
        .number("Now", |own| three(own.standard_error.now))
        .number("Promised/now", |own| or_dash(own.standard_error.ratio.map(three)))
}
