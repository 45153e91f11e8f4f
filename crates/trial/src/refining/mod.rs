//! Refines the input signals of a designed experiment within limits.

mod limits;
mod start;

use estimation::refine::{Effort, Refined, refine};
pub use limits::{Limits, STATES, StatedLimits};
use numerics::Watch;
use refusal::Invalid;
use ship::model::Vessel;
pub use start::Start;
use thiserror::Error;

use crate::campaign;

/// Time between the knots of the piecewise linear change of the start's inputs \[s\].
const KNOT_S: f64 = 1.0;

/// Why an experiment cannot be refined, by the part at fault.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Refusal {
    /// The experiment: zero parameters of the vessel, a motion that diverges or that the model cannot hold, a
    /// quantity without a limit that is constant.
    #[error(transparent)]
    Trial(#[from] campaign::Refusal),
    /// A limit that the start exceeds.
    #[error("limits: {0}")]
    Limits(Invalid),
    /// A start without information about a parameter.
    #[error("the start does not distinguish `{parameter}` from the other parameters")]
    NotIdentifiable {
        /// Its name, or an intercept's.
        parameter: String,
    },
}

/// A refined experiment with its inputs.
#[derive(Clone, Debug)]
pub struct Refinement {
    /// The experiment at the start.
    pub start: Start,
    /// The limits.
    pub limits: Limits,
    /// Samples between the knots of the change of the start's inputs.
    pub knot: usize,
    /// The result.
    pub refined: Refined,
}

impl Refinement {
    /// Follows the gradient of the criterion from `start` within `limits`, in at most `iterations`
    /// iterations; `watch` may end it sooner.
    ///
    /// # Errors
    /// [`Refusal::NotIdentifiable`].
    pub fn search(
        vessel: &Vessel,
        start: Start,
        limits: Limits,
        iterations: usize,
        watch: &Watch,
    ) -> Result<Self, Refusal> {
        let knot = ((KNOT_S * vessel.sample_rate_hz).round() as usize).max(1);
        let effort = Effort { knot, iterations };
        match refine(&start.criterion(vessel), &start.inputs, &limits.signal, &effort, watch) {
            Some(refined) => Ok(Self { start, limits, knot, refined }),
            None => Err(Refusal::NotIdentifiable { parameter: start.weakest(vessel) }),
        }
    }

    /// The efficiency relative to the start: value before over value after, the factor by which time is
    /// saved.
    pub fn efficiency(&self) -> f64 {
        self.refined.before.value / self.refined.after.value
    }

    /// Whether nothing better was found.
    pub fn unchanged(&self) -> bool {
        self.refined.inputs == self.start.inputs
    }
}
