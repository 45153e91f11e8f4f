//! The input signals of a designed experiment themselves, made better within limits.

mod limits;
mod start;

use identification::refine::{Effort, Refined, refine};
use thiserror::Error;
use vessel::{Invalid, Vessel};

pub use limits::{Limits, STATES, StatedLimits};
pub use start::Start;

/// Why an experiment cannot be refined, by what is at fault.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Refusal {
    /// The vessel: parameters that are missing or zero, a motion that leaves every bound.
    #[error("vessel: {0}")]
    Vessel(Invalid),
    /// The dictionary: a motion that the model cannot hold.
    #[error("dictionary: {0}")]
    Dictionary(Invalid),
    /// The design: an experiment that never moves what is not limited.
    #[error("design: {0}")]
    Design(Invalid),
    /// A limit that the start breaks.
    #[error("limits: {0}")]
    Limits(Invalid),
    /// A start that tells nothing of a parameter.
    #[error("the start does not tell `{parameter}` from the other parameters")]
    NotIdentifiable {
        /// Its name, or an intercept's.
        parameter: String,
    },
}

/// A refined experiment with all that it was made from.
#[derive(Clone, Debug)]
pub struct Refinement {
    /// The experiment at the start.
    pub start: Start,
    /// The limits.
    pub limits: Limits,
    /// Samples between the knots of what is added to the start's inputs.
    pub knot: usize,
    /// What was found.
    pub refined: Refined,
}

impl Refinement {
    /// Follows the gradient of the criterion from `start` within `limits`.
    ///
    /// # Errors
    /// [`Refusal::NotIdentifiable`].
    pub fn search(vessel: &Vessel, start: Start, limits: Limits, effort: &Effort) -> Result<Self, Refusal> {
        match refine(&start.criterion(vessel), &start.inputs, &limits.signal, effort) {
            Some(refined) => Ok(Self { start, limits, knot: effort.knot, refined }),
            None => Err(Refusal::NotIdentifiable { parameter: start.weakest(vessel) }),
        }
    }

    /// How many times the start's time the refined experiment is worth: value before over value after.
    pub fn efficiency(&self) -> f64 {
        self.refined.before.value / self.refined.after.value
    }

    /// Whether nothing better was found.
    pub fn unchanged(&self) -> bool {
        self.refined.inputs == self.start.inputs
    }
}
