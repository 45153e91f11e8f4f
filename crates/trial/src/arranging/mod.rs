//! The order and lengths of a design's maneuvers, evaluated with the state carried over between them.

mod foretold;
mod search;
mod whole;

use design::{Criterion, Dictionary};
use maneuver::{Exceeded, Generator, Limits};
use ship::model::Vessel;

use crate::moments::{Estimated, Moments};

pub use foretold::Foretold;
pub use search::merged;

/// The data for evaluating a sequence of maneuvers.
pub struct Arranging<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// The maneuvers.
    pub generator: &'a Generator,
    /// The moments of the same maneuvers.
    pub moments: &'a Moments,
    /// The moments as a dictionary.
    pub dictionary: &'a Dictionary,
    /// The criterion.
    pub criterion: &'a Criterion,
    /// The estimate that the criterion is for.
    pub estimated: Estimated,
    /// Shortest piece of a maneuver \[s\], if it is to be longer than 15 % of the maneuver.
    pub minimal_s: Option<f64>,
    /// Seed of the search.
    pub seed: u64,
}

/// The result of the search.
#[derive(Clone, Debug, PartialEq)]
pub struct Arranged {
    /// Maneuvers and samples, in order.
    pub parts: Vec<(String, usize)>,
    /// Value of the criterion with the state carried over.
    pub value: f64,
    /// By what fraction of the time its efficiency exceeds that of the same shares in the dictionary's order.
    pub gain: f64,
    /// Number of sequences evaluated.
    pub tried: usize,
    /// Whether the motion keeps the limits of generated maneuvers.
    pub limits: Kept,
    /// The errors that its output-error estimate is to have; none of other estimates, or in a current that lasts.
    pub foretold: Option<Foretold>,
}

/// Whether the limits are kept between maneuvers.
#[derive(Clone, Debug, PartialEq)]
pub enum Kept {
    /// There are no limits.
    Unlimited,
    /// They are kept.
    Within,
    /// They are exceeded.
    Beyond(Exceeded),
}

/// The limits of generated maneuvers, if any.
pub(crate) fn generated_limits(generator: &Generator) -> Option<&Limits> {
    (0..generator.maneuvers().len()).rev().find_map(|q| generator.limits(q))
}
