//! The search for forces that a ship lacks.

use maud::{Markup, html};
use study::documents::{ForcesWithoutFold, FoundForce, SearchDocument, SearchedForces, TriedForce};

use super::number::{exact, percent, three, three_or_dash, unit};
use super::parts::{Table, coded};

/// How the search was made.
pub(super) fn about(found: &SearchDocument, forces: &SearchedForces) -> Markup {
    let windows =
        found.window_s.map_or("whole recordings".to_owned(), |s| format!("windows of {} s", exact(s)));
    html! {
        p {
            "The ship is fitted, every product that her forces lack is tested by its score, and the likeliest is added where the cost \
             of recordings left out confirms it: up to " (forces.most_added) ", one after the other. The whole search is repeated \
             without each of " (found.folds) " folds of recordings and judged by it, over " (windows) ". Fits are over windows of at \
             most " (exact(found.fitted_window_s)) " s. Fit: 100 (1 − RMSE/std) over all windows together."
        }
    }
}

/// What was found.
pub(super) fn found(forces: &SearchedForces) -> Markup {
    let folds = forces.without.len();
    let rows: Vec<(usize, &FoundForce)> = (1..).zip(&forces.found).collect();
    let table = Table::of(&rows)
        .compact()
        .mark("main", |_| forces.delivered)
        .number("Order", |(order, _)| order)
        .name("Found", |(_, own)| html! { code { (own.term) } })
        .text("Degree", |(_, own)| own.degree.as_str())
        .name("Parameter", |(_, own)| html! { code { (own.parameter) } })
        .number("Value", |(_, own)| three(own.value))
        .number("Standard error", |(_, own)| three_or_dash(own.standard_error))
        .text("Unit", |(_, own)| unit(&own.unit))
        .number("Found without a fold", |(_, own)| format!("{} of {folds}", own.found_by_folds));
    html! {
        @if !rows.is_empty() {
            h3 { "Forces that were found" }
            (table)
            p.note {
                @if forces.delivered { "The delivered ship has them. " } @else { "The delivered ship is without them. " }
                "Values and standard errors are of a fit with all of them to all recordings. Its cost is " (three(forces.found_cost))
                ", that of the ship as she was " (three(forces.base_cost)) "."
            }
        }
    }
}

/// The searches without each fold.
pub(super) fn without(forces: &SearchedForces) -> Markup {
    let most = "as many were added as may be";
    let ended = |own: &ForcesWithoutFold| own.failed.clone().or(own.ended.clone()).unwrap_or(most.to_owned());
    let table = Table::of(&forces.without)
        .compact()
        .number("Fold", |own: &ForcesWithoutFold| own.fold + 1)
        .name("Tried", |own| coded(&tried(&own.tried)))
        .text("Ended", |own| coded(&ended(own)));
    html! {
        h3 { "The searches without a fold" }
        (table)
        p.note {
            "Cost: by how much that of recordings left out within the search changes with the force, with its standard error; in \
             brackets what was not added."
        }
    }
}

fn tried(all: &[TriedForce]) -> String {
    let each = |tried_force: &TriedForce| {
        let cost = tried_force
            .share_left_out
            .zip(tried_force.standard_error)
            .map_or("no fit".to_owned(), |(share, error)| {
                format!("cost {} ± {}", percent(-share), percent(error))
            });
        let said = format!("`{}` in {}, {cost}", tried_force.term, tried_force.degree);
        if tried_force.added { said } else { format!("({said})") }
    };
    if all.is_empty() { "–".to_owned() } else { all.iter().map(each).collect::<Vec<_>>().join("; ") }
}
