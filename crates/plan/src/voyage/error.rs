use crate::lattice::NoPlan;
use refusal::Invalid;
use thiserror::Error;

use super::footing::Footing;

/// Why a trial on a chart cannot be planned.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum VoyageError {
    /// A value of the task makes no sense for this vessel, dictionary or chart.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The task names a maneuver that the dictionary lacks.
    #[error("maneuver `{name}`: found none of that name, expected one of {}", known.join(", "))]
    UnknownManeuver {
        /// The name.
        name: String,
        /// Names of the dictionary.
        known: Vec<String>,
    },
    /// A maneuver without a count has no share in the design.
    #[error("maneuver `{maneuver}`: found no share of it, expected one; the design has {}", known.join(", "))]
    NoShare {
        /// The maneuver.
        maneuver: String,
        /// Maneuvers of the design.
        known: Vec<String>,
    },
    /// The task is valid but has no answer: a hull that is not clear at the start, or on the way.
    #[error("{0}")]
    NoAnswer(Invalid),
    /// Proved that no walk over the lattice fulfils the task; the reason, in terms of the chart.
    #[error("no feasible plan (proved): {0}")]
    Infeasible(String),
    /// The time limit was reached before a plan was found and checked: in which phase.
    #[error("no plan: out of time in {0}")]
    OutOfTime(&'static str),
    /// The lattice and the chart's rasters alone exceed the memory.
    #[error("no plan: {0}")]
    TooLarge(Footing),
    /// The search ended before it found a plan.
    #[error("no plan: {0:?}")]
    NoPlan(NoPlan),
}

impl VoyageError {
    /// The same error, where no plan is left because of `why`: after so many checks of plans that failed, if any.
    #[must_use]
    pub(super) fn because(self, rounds: u32, why: Option<String>) -> Self {
        let Self::Infeasible(reason) = self else { return self };
        let checks = match rounds {
            0 => String::new(),
            1 => "; a check showed that plans with less room cannot be sailed".to_owned(),
            _ => format!("; {rounds} checks showed that plans with less room cannot be sailed"),
        };
        let why = why.map_or(String::new(), |why| format!("; {why}"));
        Self::Infeasible(format!("{reason}{checks}{why}"))
    }
}
