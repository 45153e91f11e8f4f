//! The documents that the stages exchange, as in the files.

mod average;
mod beside;
mod compare;
mod constrained;
mod crossval;
mod design;
mod design_figures;
mod design_status;
mod design_update;
mod estimate;
mod follow;
mod force_criticism;
mod force_search;
mod forces;
mod found;
mod found_forces;
mod ingest;
mod map;
mod merit;
mod model;
mod moments;
mod plan;
mod plan_depths;
mod reference;
mod refined;
mod refinement;
mod run;
mod search;
mod selection;
mod sequential;
mod simulated;
mod solved;
mod statements;
mod tally;
mod titles;
mod trust;
mod validation;

use files::{Document, json_schema};

// Types of the scientific crates that documents use.
pub use ::design::{AccuracyOf, CriterionName, Degree};
pub use ::plan::voyage::{
    Check, FrontPoint, Gathered, GatheredManeuver, Information, NearestDanger, Passage, PassageLeg,
    Primitive, RestartPoint, Secondary, StepState, Tide, VoyageLeg, WorstVessel, WorstVessels,
};
pub use ::plan::{Ability, DerivedHandling, Handling, Side};
pub use ::validation::comparison::{ComparedErrors, ErrorCorrelations, ErrorKind, Traced};
pub use ::validation::crossval::{EstimatorScore, SourceScore};
pub use ::validation::merit::{FigureMerit, ManeuverMerit};
pub use ::validation::selection::{PublishedLimits, SelectionErrors, SelectionScores, SharesBeyond};
pub use ::validation::tally::Bounds;
pub use estimation::criticism::{Absent, Criticism, FoundNoise, Verdict};
pub use estimation::pooled::{DegreeTrust, FreeRunErrors, ParameterTrust, SourceErrors};
pub use estimation::search::{Candidate, NestedAverage, NestedRecording, SizeScore};
pub use estimation::{Estimator, Quantiles, ScoreStatus, Share};
pub use regression::pooled::COLLINEAR;
pub use regression::{InstrumentKind, MeanRemoval};
pub use ship::model::{DegreeOfFreedom, Source};
pub use trial::moments::{DegreeMoments, ManeuverMoments, Moments, SampledFrom, UnreachedMotion};
pub use trial::rounds::{Arm, ArmSummary, RoundGain, Stopping};

pub use average::{AverageDocument, AverageMember, AverageSummary, AverageTerm};
pub use beside::{BesideForces, DeliveredKind, TriedFit};
pub use compare::{CompareDocument, traces};
pub use constrained::ConstrainedParameter;
pub use crossval::CrossvalDocument;
pub use design::{
    Accuracy, AccuracyPoint, Counts, CovarianceCriterion, DesignDocument, DesignPromise, Efficiency,
    Restricted, Sequence, SequencePart, Start, Unreached,
};
pub use design_figures::{DesignFigure, DesignFigures, SolvedFigures};
pub use design_status::DesignStatus;
pub use design_update::{
    DesignUpdateDocument, UpdatedAccuracy, UpdatedCriterion, UpdatedError, UpdatedFigure, UpdatedParameter,
};
pub(crate) use estimate::bounded;
pub use estimate::{DegreeSummary, DesignSummary, EstimateDocument, EstimatorSummary, ParameterSummary};
pub use follow::{FollowDocument, FollowStatus, FollowedStep};
pub use force_criticism::{AbsentForce, ForceCriticism, LateActuator, TriedForce, TriedSign};
pub use force_search::{ForcesWithoutFold, FoundForce, SearchedForces};
pub use forces::{CaptiveValue, FittedForces, FittedParameter, SailedSum, SailedSums};
pub use found_forces::ForceScores;
pub use ingest::{
    ChannelSummary, IngestDocument, ManeuverCount, MotionSummary, RecordingSummary, RowSummary, State,
    WarningKind, WarningSummary,
};
pub use map::{
    MapArea, MapCellClass, MapCells, MapClass, MapContour, MapDocument, MapFrame, MapLine, MapMargin,
    MapMeridian, MapName, MapParallel, MapPlace, MapPurpose, MapRaster, MapRuns, MapSpot, MapSwept,
    MapSymbol, MapTrack, MapTrackKind,
};
pub use merit::{MeritDocument, MeritTableRow, SlopesAt, merit_rows};
pub use model::{ModelDegree, ModelDocument, ModelParameter};
pub use moments::MomentsDocument;
pub use plan::{
    CostUnit, DroppedMove, LeftOut, PlanChart, PlanChartClass, PlanDocument, PlanHandling, PlanLattice,
    PlanPose, PlanStatus, PlanStep, SecondaryCost, Voyage,
};
pub use plan_depths::{PlanDepths, PlanUnitFrom};
pub use reference::{Published, PublishedPicks, PublishedSelection, PublishedShare, Reference};
pub use refined::{RefinedDocument, RefinedExperiment, RefinedLimit};
pub use refinement::RefinedFiles;
pub use run::{RunDocument, RunStage};
pub use search::{SearchDocument, SearchTerm};
pub use selection::SelectionDocument;
pub use sequential::SequentialDocument;
pub use simulated::{SIMULATED_FILE, SimulatedLogsDocument, SimulatedRecording};
pub use solved::{Few, Solved};
pub use tally::{PairedRatio, TallyDocument};
pub use trust::TrustDocument;
pub use validation::{
    ComparedError, DesignScores, EstimatorRecommendation, EstimatorScores, ValidationDocument,
};

/// JSON Schema of every document that a stage writes, by the document's id.
pub fn schemas() -> Vec<(&'static str, serde_json::Value)> {
    vec![
        (MomentsDocument::ID, json_schema::<MomentsDocument>()),
        (DesignDocument::ID, json_schema::<DesignDocument>()),
        (DesignUpdateDocument::ID, json_schema::<DesignUpdateDocument>()),
        (RefinedDocument::ID, json_schema::<RefinedDocument>()),
        (EstimateDocument::ID, json_schema::<EstimateDocument>()),
        (FollowDocument::ID, json_schema::<FollowDocument>()),
        (IngestDocument::ID, json_schema::<IngestDocument>()),
        (ValidationDocument::ID, json_schema::<ValidationDocument>()),
        (TallyDocument::ID, json_schema::<TallyDocument>()),
        (MeritDocument::ID, json_schema::<MeritDocument>()),
        (PlanDocument::ID, json_schema::<PlanDocument>()),
        (MapDocument::ID, json_schema::<MapDocument>()),
        (ModelDocument::ID, json_schema::<ModelDocument>()),
        (AverageDocument::ID, json_schema::<AverageDocument>()),
        (TrustDocument::ID, json_schema::<TrustDocument>()),
        (CompareDocument::ID, json_schema::<CompareDocument>()),
        (CrossvalDocument::ID, json_schema::<CrossvalDocument>()),
        (SearchDocument::ID, json_schema::<SearchDocument>()),
        (SelectionDocument::ID, json_schema::<SelectionDocument>()),
        (SequentialDocument::ID, json_schema::<SequentialDocument>()),
        (SimulatedLogsDocument::ID, json_schema::<SimulatedLogsDocument>()),
        (RunDocument::ID, json_schema::<RunDocument>()),
    ]
}
