use estimation::EstimateStatus;
use serde::{Deserialize, Serialize};

refusal::choices! {
    /// A way to spend the time of a trial.
    pub enum Arm {
        /// Designed anew for every round, with what the rounds before have told.
        Sequential = "sequential",
        /// Designed once, from the crude model.
        OneShot = "one-shot",
        /// Designed once, from the true parameters: what nobody can do.
        Informed = "informed",
        /// Maneuvers drawn at random.
        Random = "random",
    }
}

/// How the time of a plan was shared out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shared {
    /// By a design.
    Designed,
    /// Evenly: no design could be made with the model.
    Even,
    /// At random, as asked for.
    Drawn,
}

/// What became of an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// There is one.
    Identified,
    /// A direction is not excited.
    #[serde(rename = "not identifiable")]
    NotIdentifiable,
    /// The search did not converge.
    #[serde(rename = "not converged")]
    NotConverged,
    /// The nominal model diverges, with which the search begins.
    Diverged,
}

impl From<EstimateStatus> for Outcome {
    fn from(status: EstimateStatus) -> Self {
        match status {
            EstimateStatus::Identified
            | EstimateStatus::Rejected
            | EstimateStatus::Approximate
            | EstimateStatus::Waves
            | EstimateStatus::Diverges
            | EstimateStatus::OwnInstruments => Self::Identified,
            EstimateStatus::NotIdentifiable => Self::NotIdentifiable,
            EstimateStatus::NotConverged => Self::NotConverged,
        }
    }
}

/// An arm of a realization at the end of a round.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// How the time was spent.
    pub arm: Arm,
    /// Number of the realization.
    pub realization: u32,
    /// Round, from 0.
    pub round: u32,
    /// Samples so far.
    pub samples: usize,
    /// How the round's time was shared out.
    pub shared: Shared,
    /// What became of the estimate.
    pub outcome: Outcome,
    /// 2-norm over the parameters of (estimate − truth)/truth; `None` without an estimate.
    pub parameter_error: Option<f64>,
    /// What the estimate says of its own error: 2-norm of standard error over the parameter known by then.
    pub predicted_error: Option<f64>,
    /// What the crude model says of a one-shot trial beforehand; `None` for others and where that model diverges.
    pub expected_error: Option<f64>,
}
