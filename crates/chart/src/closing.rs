//! What closes places to a ship in transit: for the refusal of an area in which she has no room.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::enc::class;

use crate::classes::{Judged, judged};
use crate::dangers::{Gap, gap_to, is_inside};
use crate::{Called, Causes, Dangers, Uncharted};

/// Dangers of one class and name that close places.
#[derive(Clone, Debug, PartialEq)]
pub struct Closing {
    /// Their class and name, and the greatest of their depths.
    pub called: Called,
    /// What they are closed for: land, no-go, too shoal, uncharted.
    pub cause: Causes,
    /// How many of the places they close.
    pub places: usize,
}

impl Closing {
    /// Their class, where `rules` of `plan.toml` may open it.
    pub fn rule(&self) -> Option<&'static str> {
        let of = |code: &u16| !matches!(judged(*code), Judged::Depth | Judged::Coverage);
        class(self.called.what).filter(of).map(|_| self.called.what)
    }
}

/// Class, name and cause by which dangers are counted together.
type Kind = (&'static str, Option<Arc<str>>, u8);

/// The greatest depth of a kind \[m\], and whether it closes each place.
struct Counted {
    called: Called,
    cause: Causes,
    closes: Vec<bool>,
}

impl Dangers<'_> {
    /// What comes within `within_m` of each of `places` (east and north \[m\]), with how many of them: the kinds that
    /// close most places first. A place may be closed by several.
    pub fn closing(&self, places: &[[f64; 2]], within_m: f64) -> Vec<Closing> {
        let mut kinds: BTreeMap<Kind, Counted> = BTreeMap::new();
        for (polygon, cause) in &self.polygons {
            let is_near = |place: &[f64; 2]| gap_to(polygon, &[*place], within_m).distance_m < within_m;
            count(&mut kinds, &polygon.called, *cause, places, is_near);
        }
        if self.chart.uncharted() == Uncharted::Obstacle {
            let charted = &self.chart.charted().polygons;
            let is_near = |place: &[f64; 2]| {
                !charted.iter().any(|polygon| is_inside(polygon, *place))
                    || self.edge(*place, Gap::NONE).distance_m < within_m
            };
            count(&mut kinds, &Called::plain("uncharted water"), Causes::UNCHARTED, places, is_near);
        }
        let mut all: Vec<Closing> = kinds.into_values().map(Closing::from).collect();
        all.sort_by_key(|own| std::cmp::Reverse(own.places));
        all
    }
}

/// Adds the places that a danger closes to those of its kind.
fn count(
    kinds: &mut BTreeMap<Kind, Counted>,
    called: &Called,
    cause: Causes,
    places: &[[f64; 2]],
    is_near: impl Fn(&[f64; 2]) -> bool,
) {
    let near: Vec<bool> = places.iter().map(is_near).collect();
    if !near.contains(&true) {
        return;
    }
    let new = || Counted { called: called.clone(), cause, closes: vec![false; places.len()] };
    let own = kinds.entry((called.what, called.name.clone(), cause.bits())).or_insert_with(new);
    own.closes.iter_mut().zip(near).for_each(|(closes, near)| *closes |= near);
    own.called.depth_m = own.called.depth_m.into_iter().chain(called.depth_m).reduce(f64::max);
}

impl From<Counted> for Closing {
    fn from(Counted { called, cause, closes }: Counted) -> Self {
        Self { called, cause, places: closes.iter().filter(|closes| **closes).count() }
    }
}
