use files::{Document, Units};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::Source;
use trial::rounds::{ArmSummary, RoundGain, Stopping};

/// `sequential.json`: trials designed in rounds against trials designed once.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SequentialDocument {
    /// Realizations per arm.
    pub realizations: u64,
    /// Rounds.
    pub rounds: u64,
    /// Sea time in all.
    pub duration_s: f64,
    /// What crude models are drawn about.
    pub crude_about: Source,
    /// Standard deviation of the logarithm of crude over these parameters.
    pub nominal_spread: f64,
    /// Predicted error at which a trial may stop.
    pub accuracy: f64,
    /// Maneuvers to design with.
    pub maneuvers: u64,
    /// The result in words.
    pub statements: Vec<String>,
    /// In the order `sequential`, `one-shot`, `informed`, `random`.
    pub arms: Vec<ArmSummary>,
    /// The trial in rounds over the one-shot trial, at the end of every round.
    pub gains: Vec<RoundGain>,
    /// `sequential`, `one-shot`.
    pub stopping: Vec<Stopping>,
}

impl Document for SequentialDocument {
    const ID: &'static str = "sequential";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("1", "realizations rounds nominal_spread accuracy maneuvers median q90 predicted within"),
        ("1", "not_identifiable not_converged diverged undesigned pairs ratio low high stopped"),
        ("1", "median_error within_stopped rms_over_accuracy without_estimate"),
        ("1", "median_interval q90_interval within_interval median_error_interval"),
        ("1", "within_stopped_interval rms_over_accuracy_interval"),
        ("s", "duration_s time_s mean_time_s mean_time_interval_s"),
    ];
}
