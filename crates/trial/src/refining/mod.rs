//! The input signals of a designed experiment themselves, made better within limits.

mod limits;
mod start;

use identification::refine::{Effort, Refined, refine};
pub use limits::{Limits, STATES, StatedLimits};
use model::Vessel;
use refusal::Invalid;
pub use start::Start;
use thiserror::Error;

use crate::campaign;

/// Time between the knots of what is added to the start's inputs, straight between them \[s\].
const KNOT_S: f64 = 1.0;

/// Why an experiment cannot be refined, by what is at fault.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Refusal {
    /// The experiment: zero parameters of the vessel, a motion that diverges or that the model cannot hold, one that never
    /// moves what is not limited.
    #[error(transparent)]
    Trial(#[from] campaign::Refusal),
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
    /// Follows the gradient of the criterion from `start` within `limits`, in so many iterations at most.
    ///
    /// # Errors
    /// [`Refusal::NotIdentifiable`].
    pub fn search(vessel: &Vessel, start: Start, limits: Limits, iterations: usize) -> Result<Self, Refusal> {
        let knot = ((KNOT_S * vessel.sample_rate_hz).round() as usize).max(1);
        match refine(&start.criterion(vessel), &start.inputs, &limits.signal, &Effort { knot, iterations }) {
            Some(refined) => Ok(Self { start, limits, knot, refined }),
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
