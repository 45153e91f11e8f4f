//! seatrial in memory: plan a trial, simulate it, identify a ship's model.
//!
//! - [`Study`] is a simulation study: the information of a dictionary's maneuvers about a vessel's parameters, the best trial
//!   of them, disturbed realizations of it, their estimates and scores. [`MonteCarlo`] repeats the last three.
//! - [`Logs`] become runs, [`Pooling`] makes one model of them, [`StructureSearch`] finds its structure, and [`Comparison`]
//!   validates it on other recordings.
//! - [`ForceFit`] fits the forces of a ship to runs.
//! - [`ChartedTrial`] is planned as one walk over a chart, proved to be the cheapest and checked in simulation.
//! - [`Designing`] finds the shares of a trial by any criterion, and the shortest trial of an accuracy.
//! - [`Updating`] states the promise of a design anew from an estimate of its trial.
//! - [`Merits`] are the figures by which standard maneuvers are judged.
//!
//! The programs call the same functions, from file to file. Nothing here reads a command line, prints or starts threads:
//! parallel work runs on rayon's global pool. `examples/` has a program of each kind.
//!
//! Types of the crates below are re-exported under their own names; types of their fields are found in these crates.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod charted;
mod criticism;
mod designing;
pub mod export;
mod force_fit;
mod former;
mod measured;
mod simulation;
mod structure;
mod updating;

pub use charted::{ChartedTrial, PlanError, Planned};
pub use criticism::check_captive;
pub use designing::{Designing, Merits, Wish, sampled_ships};
pub use force_fit::{ForceFit, ForceFitError};
pub use former::former;
pub use measured::{Comparison, ComparisonError, Ingested, Logs, Pooling, channels_within, widest};
pub use simulation::{MonteCarlo, Optimum, Realized, Study, StudyError, undisturbed};
pub use structure::{AveragedSearch, FoundStructure, StructureSearch, core_of};
pub use updating::{UpdateError, Updating};
pub use validation::merit::Unsimulated;

pub use {
    chart, design, estimation, files, logs, maneuver, plan, refusal, regression, ship, study, trial,
    validation,
};

pub use design::{
    Accuracy, Bounds, Criterion, CriterionName, Design, Dictionary, NoDesign, Options, Restricted, Stock,
    Wanted,
};
pub use estimation::fitting::{Settings, Starts, Unfit};
pub use estimation::pooled::{Covariance, Judgement, Pool, PoolError, Resampling};
pub use estimation::runs::{RunError, RunEstimators};
pub use estimation::search::{SearchError, SearchOptions};
pub use estimation::{Estimator, RunEstimate, RunScore, ValidationRuns};
pub use files::{Budget, Error, Provenance};
pub use logs::{Plan as LogsPlan, Source as LogsSource, Totals};
pub use maneuver::{DictionaryFile, Generator};
pub use plan::voyage::{Brief, Check, Prepared, Sailing, Search, Shares, Solved, VoyageError};
pub use refusal::Invalid;
pub use regression::MeanRemoval;
pub use regression::pooled::{NominalSource, PooledRuns, Recorded};
pub use regression::runs::NominalDiverged;
pub use ship::engine::Run;
pub use ship::model::{Model, Source, Vessel};
pub use study::Tried;
pub use study::campaign_file::CampaignFile;
pub use study::design_files::Promised;
pub use study::documents::{
    Compared, DesignDocument, DesignScores, IngestDocument, MapDocument, MeritDocument, MeritTableRow,
    ModelDocument, PlanChart, PlanDocument, PromiseUpdate, RecordingSummary, Reference, SearchSummary,
    SolvedFigures, Trust,
};
pub use study::figure_goals::FigureGoals;
pub use study::ingest_file::IngestFile;
pub use study::plan::{FollowError, FollowFiles, FollowedPlan, PlanFile, Routes};
pub use study::pooled_set::PooledSet;
pub use study::trajectories::{DataLabel, TrajectoryReader};
pub use trial::campaign::{Campaign, Designed, Refusal, SimulatedRun};
pub use trial::moments::{Estimated, Moments, NoCriterion, SampledShips};
pub use validation::comparison::Traced;
pub use validation::crossval::{CrossError, CrossValidation};
