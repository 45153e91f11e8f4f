use std::cmp::Ordering;

use maud::{Markup, html};

use study::documents::DesignDocument;

/// A dictionary with more maneuvers is not shown completely.
const MOST: usize = 40;
/// A maneuver with a smaller share counts as not used.
const LEAST: f64 = 5e-4;

/// Whether the design spends time on maneuver `name`.
pub(super) fn used(design: &DesignDocument, name: &str) -> bool {
    design.shares.get(name).is_some_and(|share| *share > LEAST)
}

/// The names that the page shows, in their order: all of a small dictionary; of a large one those in use and those
/// with the highest efficiency, or just the first without a design.
pub(super) fn shown<'a>(
    names: impl Iterator<Item = &'a str>,
    design: Option<&DesignDocument>,
) -> Vec<&'a str> {
    let names: Vec<&str> = names.collect();
    let mut ranked: Vec<usize> = (0..names.len()).collect();
    let mut most = MOST;
    if let Some(design) = design {
        ranked.sort_by(|a, b| rank(design, names[*a], names[*b]));
        most = most.max(names.iter().filter(|name| used(design, name)).count());
    }
    ranked.truncate(most);
    ranked.sort_unstable();
    ranked.into_iter().map(|index| names[index]).collect()
}

/// Says that a large dictionary is not shown completely.
pub(super) fn omission(all: usize, shown: usize) -> Markup {
    html! {
        @if shown < all {
            p.note {
                (shown) " of " (all) " maneuvers are shown: those in use and those closest to being worth their time."
            }
        }
    }
}

fn rank(design: &DesignDocument, a: &str, b: &str) -> Ordering {
    let sensitivity = |name| design.sensitivities.get(name).copied().unwrap_or(f64::NEG_INFINITY);
    let by_use = used(design, b).cmp(&used(design, a));
    by_use.then(sensitivity(b).total_cmp(&sensitivity(a)))
}
