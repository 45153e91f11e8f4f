use maud::{Markup, html};

use super::number::three;
use super::parts::Table;
use study::documents::{AverageSummary, AverageTerm};

/// Terms beyond this many are not listed.
const MOST_TERMS: usize = 120;

/// The terms of the models of an average, with how often each was chosen.
pub(super) fn averaged(found: &AverageSummary) -> Markup {
    let of_library: Vec<&AverageTerm> = found.terms.iter().filter(|term| !term.base).collect();
    let counts: Vec<(u64, usize)> = (1..=found.models)
        .rev()
        .map(|models| (models, of_library.iter().filter(|term| term.chosen == models).count()))
        .collect();
    let agreed = Table::of(&counts)
        .name("In so many models", |(models, _)| models.to_string())
        .number("Terms of the library", |(_, terms)| terms);
    let listed = &of_library[..of_library.len().min(MOST_TERMS)];
    let table = Table::of(listed.iter().copied())
        .compact()
        .name("Term", |t| t.term.as_str())
        .text("Of", |t| t.degree.as_str())
        .text("Parameter", |t| t.name.as_str())
        .number("In models", |t| format!("{} of {}", t.chosen, found.models))
        .number("Least value", |t| three(t.lowest))
        .number("Mean", |t| three(t.mean))
        .number("Largest", |t| three(t.highest));
    html! {
        h3 { "The average" }
        p {
            (found.models) " models of few terms are averaged. The structure of each was found on " (found.recordings_each)
            " recordings drawn at random, of each kind about as large a share (seed " (found.seed) "); then it was fitted to all. \
             Terms that few models have are those that the recordings leave open."
        }
        (agreed)
        (table)
        @if of_library.len() > listed.len() {
            p.note { "The first " (listed.len()) " of " (of_library.len()) "; all are in `search.json`." }
        }
    }
}
