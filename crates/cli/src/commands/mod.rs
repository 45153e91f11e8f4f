//! The stages as programs: their flags, inputs, calls and outputs.

mod compare;
pub mod counts;
mod cross;
mod estimate;
mod estimate_pool;
mod export;
mod ingest;
mod merit;
mod moments;
mod monte_carlo;
mod plan;
mod plan_begun;
mod report;
mod search;
mod selection;
mod sequential;
mod simulate;
mod validate;

use crate::stage::Stage;

/// Trajectories from a vessel and its maneuvers.
pub const SIMULATE: Stage = Stage::group::<simulate::Arguments>(&[
    Stage::of::<simulate::Dictionary>(),
    Stage::of::<simulate::Campaign>(),
    Stage::of::<simulate::Validation>(),
    Stage::of::<simulate::Plan>(),
    Stage::of::<simulate::Logs>(),
]);
/// Measured logs to trajectories.
pub const INGEST: Stage = Stage::of::<ingest::Arguments>();
/// The information of each maneuver about the parameters.
pub const MOMENTS: Stage = Stage::of::<moments::Arguments>();
/// The time of each maneuver, and its inputs.
pub const DESIGN: Stage = Stage::of::<crate::design::Arguments>()
    .with(&[Stage::of::<crate::design::refine::Refine>(), Stage::of::<crate::design::update::Update>()]);
/// Parameters of every run, or of all runs together.
pub const ESTIMATE: Stage = Stage::of::<estimate::Arguments>()
    .with(&[Stage::of::<estimate_pool::Arguments>(), Stage::of::<search::Arguments>()]);
/// A campaign's runs, estimated and scored in memory.
pub const MONTE_CARLO: Stage = Stage::of::<monte_carlo::Arguments>();
/// Validation of the estimated models.
pub const VALIDATE: Stage = Stage::of::<validate::Arguments>().with(&[
    Stage::of::<compare::Arguments>(),
    Stage::of::<cross::Arguments>(),
    Stage::of::<merit::Arguments>(),
    Stage::of::<selection::Arguments>(),
]);
/// One trajectory with every maneuver as often as the design requires.
pub const PLAN: Stage = Stage::of::<plan::Arguments>()
    .with(&[Stage::of::<plan_begun::Resume>(), Stage::of::<plan_begun::Follow>()]);
/// Trials designed in rounds.
pub const SEQUENTIAL: Stage = Stage::of::<sequential::Arguments>();
/// A model for other tools.
pub const EXPORT: Stage = Stage::of::<export::Arguments>();
/// A study on one page, many in tables, a picture of one.
pub const REPORT: Stage =
    Stage::of::<report::Arguments>().with(&[Stage::of::<report::Results>(), Stage::of::<report::Picture>()]);

/// Every stage, in the order in which a study runs them.
pub const STAGES: [&Stage; 11] = [
    &SIMULATE,
    &INGEST,
    &MOMENTS,
    &DESIGN,
    &ESTIMATE,
    &VALIDATE,
    &MONTE_CARLO,
    &PLAN,
    &SEQUENTIAL,
    &EXPORT,
    &REPORT,
];
