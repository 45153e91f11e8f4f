use study::documents::{
    DesignDocument, DesignScores, DesignUpdateDocument, EstimateDocument, MeritDocument, MomentsDocument,
    Reference, SequentialDocument, TallyDocument, ValidationDocument,
};
use study::files::{Variable, Vessel};
use study::scores;

use super::planned_trial::PlannedTrial;

/// Everything that the page can show. Absent results are reported as missing.
#[derive(Clone, Debug, Default)]
pub struct Study {
    /// Name of the study: `paper`.
    pub name: String,
    /// Length of one experiment \[s\].
    pub experiment_s: Option<f64>,
    /// The model structure.
    pub vessel: Option<Vessel>,
    /// Every maneuver of the dictionary, in its order.
    pub dictionary: Option<Vec<ManeuverTrace>>,
    /// `moments.json`.
    pub moments: Option<MomentsDocument>,
    /// `design.json`.
    pub design: Option<DesignDocument>,
    /// `design-update.json`; absent before the trial.
    pub update: Option<DesignUpdateDocument>,
    /// `estimate.json`.
    pub estimate: Option<EstimateDocument>,
    /// `validation.json`.
    pub validation: Option<ValidationDocument>,
    /// `tally.json`.
    pub tally: Option<TallyDocument>,
    /// The errors of every run by one estimator.
    pub scores: Option<Vec<scores::Row>>,
    /// The input that the estimated models were validated on.
    pub validation_trace: Option<ManeuverTrace>,
    /// Published results to compare with.
    pub reference: Option<Reference>,
    /// Figures of merit of standard maneuvers; absent in a study without.
    pub merit: Option<MeritDocument>,
    /// Models from picked sub-experiments; absent in a study without.
    pub selection: Option<super::SelectionStudy>,
    /// Results from measured logs; absent in a study of simulated trials.
    pub measured: Option<super::Measured>,
    /// Trials designed in rounds against trials designed once.
    pub sequential: Option<SequentialDocument>,
    /// Other studies' comparisons of estimators, to be shown side by side.
    pub scenarios: Vec<Scenario>,
    /// The planned trajectory; absent in a study that plans none.
    pub trajectory: Option<Trajectory>,
    /// The label of the data: `simulated logs`; absent for those of real ships and for simulation studies.
    pub data: Option<String>,
    /// The roles of files from different studies, if those were allowed.
    pub mixed: Vec<String>,
    /// Name of a file, what it is, its digest.
    pub files: Vec<(String, String, String)>,
}

/// Estimators compared under one kind of disturbance.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Name of its folder.
    pub name: String,
    /// Its `estimate.json`.
    pub estimate: EstimateDocument,
    /// Its `validation.json`.
    pub validation: ValidationDocument,
}

/// The results for a planned trajectory.
#[derive(Clone, Debug, Default)]
pub struct Trajectory {
    /// `plan.json`; absent if only `plan.toml` exists.
    pub main: Option<PlannedTrial>,
    /// `plan-*/plan.json`: variants of the plan.
    pub variants: Vec<PlannedTrial>,
    /// `planned/estimate.json`: estimates from simulated trials of the plan.
    pub estimate: Option<EstimateDocument>,
    /// `planned/validation.json`: errors of those estimates.
    pub validation: Option<ValidationDocument>,
}

/// One maneuver over time. All vectors are as long as `t`; a value that is not finite is left out of the figures.
#[derive(Clone, Debug, Default)]
pub struct ManeuverTrace {
    /// Name in the dictionary.
    pub name: String,
    /// Its description in the dictionary; may be empty.
    pub description: String,
    /// What it was to reach, and did; may be empty.
    pub reached: String,
    /// Times \[s\].
    pub t: Vec<f64>,
    /// Name, unit and values of every input.
    pub inputs: Vec<(String, String, Vec<f64>)>,
    /// What was commanded of inputs whose actuators follow it, by their names.
    pub commands: Vec<(String, Vec<f64>)>,
    /// Surge speed \[m/s\].
    pub u: Vec<f64>,
    /// Sway speed \[m/s\].
    pub v: Vec<f64>,
    /// Yaw rate \[rad/s\].
    pub r: Vec<f64>,
    /// Position along the initial heading \[m\].
    pub x: Vec<f64>,
    /// Position to starboard of it \[m\].
    pub y: Vec<f64>,
}

/// The design that is shown first wherever designs are compared.
const FIRST: &str = "optimized";

/// `designs` in their order, except that the optimized one comes first.
pub(super) fn optimized_first<T>(designs: &[T], name: impl Fn(&T) -> &str) -> Vec<&T> {
    let mut ordered: Vec<&T> = designs.iter().collect();
    ordered.sort_by_key(|design| name(design) != FIRST);
    ordered
}

impl Study {
    /// The inputs that the vessel declares.
    pub(super) fn inputs(&self) -> &[Variable] {
        self.vessel.as_ref().map_or(&[], |Vessel { model, .. }| model.input_variables())
    }

    /// The designs of the validation, the optimized one first.
    pub(super) fn scored(&self) -> Vec<&DesignScores> {
        self.validation.iter().flat_map(|v| optimized_first(&v.designs, |d| &d.design)).collect()
    }
}
