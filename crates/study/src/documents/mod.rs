//! The documents that the stages exchange, as in the files.

mod average;
mod compare;
mod design;
mod estimate;
mod forces;
mod ingest;
mod map;
mod model;
mod plan;
mod refined;
mod search;
mod solved;
mod statements;
mod validation;

use std::collections::BTreeMap;

use files::{Digest, Document, Units, json_schema};
use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trial::moments::malformed;

// Types of the scientific crates that documents use.
pub use ::design::{AccuracyOf, CriterionName, Degree};
pub use ::plan::voyage::{
    AbortMove, AbortTrack, Check, Departures, FrontPoint, Gathered, GatheredManeuver, Information, LegDrift,
    NearestDanger, Passage, PassageLeg, Primitive, RestartPoint, Secondary, StepState, Tide, VoyageLeg,
    WaitingPlace, WheelOver, WorstVessel, WorstVessels,
};
pub use ::plan::{Ability, DerivedHandling, Handling, Side};
pub use ::validation::comparison::{Compared, ComparedErrors, ErrorCorrelations, ErrorKind, Traced};
pub use ::validation::crossval::{EstimatorScore, SourceScore};
pub use ::validation::merit::{FigureMerit, ManeuverMerit};
pub use ::validation::selection::{
    PublishedLimits, Selection, SelectionErrors, SelectionScores, SharesBeyond,
};
pub use ::validation::tally::Bounds;
pub use estimation::criticism::{Absent, Criticism, FoundNoise, Suspect, Verdict};
pub use estimation::pooled::{DegreeTrust, FreeRunErrors, ParameterTrust, SourceErrors};
pub use estimation::search::{Candidate, NestedAverage, NestedRecording, SizeScore};
pub use estimation::{Estimator, Quantiles, ScoreStatus, Share};
pub use regression::pooled::COLLINEAR;
pub use regression::{InstrumentKind, MeanRemoval};
pub use ship::model::{DegreeOfFreedom, Source};
pub use trial::moments::{DegreeMoments, ManeuverMoments, Moments, SampledFrom, UnreachedMotion};
pub use trial::rounds::{Arm, ArmSummary, RoundGain, Stopping};

pub use crate::written::reference::{
    Published, PublishedPicks, PublishedSelection, PublishedShare, Reference,
};
pub use average::{AverageSummary, AverageTerm};
pub use compare::{LeftOutScores, MeritDocument, MeritTableRow, SlopesAt, merit_rows, traces};
pub use design::{
    Accuracy, AccuracyPoint, Counts, CovarianceCriterion, DesignDocument, DesignFigure, DesignFigures,
    DesignPromise, DesignStatus, Efficiency, Restricted, Sequence, SequencePart, SolvedFigures, Unreached,
};
pub(crate) use estimate::bounded;
pub use estimate::{
    ChosenStructure, ConstrainedParameter, DegreeSummary, DesignSummary, EstimateDocument, EstimatorSummary,
    ModelStructure, ParameterSummary, Trust,
};
pub use forces::{CaptiveValue, FittedForces, FittedParameter, SailedSum, SailedSums};
pub use ingest::{
    ChannelSummary, IngestDocument, ManeuverCount, MotionSummary, RecordingSummary, RowSummary,
    SIMULATED_FILE, SimulatedLogsDocument, SimulatedRecording, State, WarningKind, WarningSummary,
};
pub use map::{
    MapArea, MapCellClass, MapCells, MapClass, MapContour, MapDocument, MapFrame, MapLine, MapMargin,
    MapMeridian, MapName, MapParallel, MapPlace, MapPurpose, MapRaster, MapRuns, MapSpot, MapSwept,
    MapSymbol, MapTrack, MapTrackKind,
};
pub use model::{AverageMember, ModelDegree, ModelDocument, ModelParameter};
pub use plan::{
    BegunPlan, CostUnit, DroppedMove, FollowStatus, FollowedStep, LeftOut, PlanChart, PlanChartClass,
    PlanDepths, PlanDocument, PlanHandling, PlanLattice, PlanPose, PlanStatus, PlanStep, PlanUnitFrom,
    SecondaryCost, Voyage,
};
pub use refined::{
    PromiseUpdate, RefinedDesign, RefinedExperiment, RefinedLimit, UpdatedAccuracy, UpdatedCriterion,
    UpdatedError, UpdatedFigure, UpdatedParameter,
};
pub use search::{BesideForces, DeliveredKind, SearchSummary, SearchTerm, TriedFit};
pub use solved::{RefinedFiles, Solved};
pub use validation::{
    ComparedError, CountedRuns, DesignScores, EstimatorRecommendation, EstimatorScores, PairedRatio,
    ScoredEstimates, TrialsInRounds, ValidationDocument,
};

/// JSON Schema of every document that a stage writes, by the document's id.
pub fn schemas() -> Vec<(&'static str, serde_json::Value)> {
    vec![
        (MomentsDocument::ID, json_schema::<MomentsDocument>()),
        (DesignDocument::ID, json_schema::<DesignDocument>()),
        (EstimateDocument::ID, json_schema::<EstimateDocument>()),
        (IngestDocument::ID, json_schema::<IngestDocument>()),
        (ValidationDocument::ID, json_schema::<ValidationDocument>()),
        (MeritDocument::ID, json_schema::<MeritDocument>()),
        (PlanDocument::ID, json_schema::<PlanDocument>()),
        (MapDocument::ID, json_schema::<MapDocument>()),
        (ModelDocument::ID, json_schema::<ModelDocument>()),
        (SimulatedLogsDocument::ID, json_schema::<SimulatedLogsDocument>()),
        (RunDocument::ID, json_schema::<RunDocument>()),
    ]
}

/// `run.json`: the stages that a study's results were made by, each with what it read and wrote.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunDocument {
    /// Digest of the way from the results to the study's folder, by which results of another study are known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub study: Option<Digest>,
    /// The stages by their names in `run --stage`.
    pub stages: BTreeMap<String, RunStage>,
}

/// A stage as it ran. `{study}` and `{out}` stand for the study's folder and its results; a brace of a name is written twice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunStage {
    /// The program and its version.
    pub program: String,
    /// Digest of the program's file.
    pub digest: Option<Digest>,
    /// Its command line.
    pub command: Vec<String>,
    /// Digests of what it read: files; names that fit a pattern in a folder (`names *.csv in {study}/logs`; a digit is `#`); the path
    /// of a folder without links (`place of {study}/cells`). None where there was no such file or folder.
    pub inputs: BTreeMap<String, Option<Digest>>,
    /// Digests of the files that it wrote.
    pub outputs: BTreeMap<String, Digest>,
}

impl Document for RunDocument {
    const ID: &'static str = "run";
    const VERSION: u32 = 2;
    const UNITS: Units = &[];
}

/// `moments.json`: the lifted moment matrices of every maneuver.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct MomentsDocument(pub Moments);

impl Document for MomentsDocument {
    const ID: &'static str = "moments";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("Hz", "sample_rate_hz"),
        ("1", "samples shape nonstationarity ships"),
        ("unit of regressor i times unit of instrument j", "M"),
    ];
}

impl MomentsDocument {
    /// The moments of the document.
    ///
    /// # Errors
    /// A matrix with another shape than its degree of freedom.
    pub fn moments(self) -> Result<Moments, Invalid> {
        for maneuver in &self.0.maneuvers {
            for degree in &maneuver.degrees {
                let [rows, columns] = degree.shape;
                if rows != columns || rows.checked_mul(columns) != Some(degree.m.len() as u64) {
                    let found = format!("{} entries in {}", degree.m.len(), degree.name);
                    return Err(malformed(&maneuver.name, &found));
                }
            }
        }
        Ok(self.0)
    }
}
