//! The order of a design's maneuvers and their lengths, judged with the state carried over from one to the next.

mod search;
mod whole;

use design::{Criterion, Dictionary};
use maneuver::{Exceeded, Generator, Limits};
use model::Vessel;

use crate::moments::{Estimated, Moments};

/// What a sequence of maneuvers is judged with.
pub struct Arranging<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// The maneuvers.
    pub generator: &'a Generator,
    /// The moments of the same maneuvers.
    pub moments: &'a Moments,
    /// These as a dictionary.
    pub dictionary: &'a Dictionary,
    /// The criterion.
    pub criterion: &'a Criterion,
    /// The estimate that it is about.
    pub estimated: Estimated,
    /// Seed of the search.
    pub seed: u64,
}

/// A sequence that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Arranged {
    /// Maneuvers and samples, one after the other.
    pub parts: Vec<(String, usize)>,
    /// Value of the criterion with the state carried over.
    pub value: f64,
    /// By what fraction of the time it is worth more than the same shares in the dictionary's order.
    pub gain: f64,
    /// Sequences that were judged.
    pub tried: usize,
    /// Whether the motion keeps the limits of generated maneuvers.
    pub limits: Kept,
}

/// Whether limits are kept between maneuvers.
#[derive(Clone, Debug, PartialEq)]
pub enum Kept {
    /// There are none.
    Unlimited,
    /// They are.
    Within,
    /// They are not.
    Beyond(Exceeded),
}

/// The limits that generated maneuvers keep, where there are any.
pub(crate) fn generated_limits(generator: &Generator) -> Option<&Limits> {
    (0..generator.maneuvers().len()).rev().find_map(|q| generator.limits(q))
}
