//! The stages as programs: their flags, inputs, calls and outputs.

mod compare;
mod estimate;
mod estimate_forces;
mod estimate_pool;
mod ingest;
mod moments;
mod monte_carlo;
mod outputs;
mod plan;
mod search;
mod simulate;
mod validate;

pub(crate) use estimate::{SEARCHED, usual_structure};
pub(crate) use moments::MomentsArguments;
pub(crate) use monte_carlo::MonteCarloArguments;
pub(crate) use plan::PlanArguments;
pub(crate) use validate::{MeritArguments, ValidateArguments};

use crate::stage::Stage;

/// Trajectories from a vessel and its maneuvers.
pub const SIMULATE: Stage = Stage::group::<simulate::SimulateArguments>(&[
    Stage::of::<simulate::Dictionary>(),
    Stage::of::<simulate::Campaign>(),
    Stage::of::<simulate::Validation>(),
    Stage::of::<simulate::PlanTrials>(),
    Stage::of::<simulate::Logs>(),
]);
/// Measured logs to trajectories.
pub const INGEST: Stage = Stage::of::<ingest::IngestArguments>();
/// The information of each maneuver about the parameters.
pub const MOMENTS: Stage = Stage::of::<moments::MomentsArguments>();
/// The time of each maneuver, and its inputs.
pub const DESIGN: Stage = Stage::of::<crate::design::DesignArguments>();
/// Parameters of every run, or of all runs together.
pub const ESTIMATE: Stage = Stage::of::<crate::pool::EstimateArguments>();
/// A campaign's runs, estimated and scored in memory.
pub const MONTE_CARLO: Stage = Stage::of::<monte_carlo::MonteCarloArguments>();
/// How good models are.
pub const VALIDATE: Stage =
    Stage::of::<validate::ValidateArguments>().with(&[Stage::of::<validate::MeritArguments>()]);
/// One trajectory with every maneuver as often as the design requires.
pub const PLAN: Stage = Stage::of::<plan::PlanArguments>();
/// A model for other tools.
pub const EXPORT: Stage = Stage::of::<outputs::ExportArguments>();
/// A study on one page.
pub const REPORT: Stage = Stage::of::<outputs::ReportArguments>();

/// Every stage, in the order in which a study runs them.
pub const STAGES: [&Stage; 10] =
    [&SIMULATE, &INGEST, &MOMENTS, &DESIGN, &ESTIMATE, &VALIDATE, &MONTE_CARLO, &PLAN, &EXPORT, &REPORT];
