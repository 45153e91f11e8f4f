use artifact::Document;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trial::rounds::{ArmSummary, RoundGain, Stopping};
use vessel::Source;

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
    const UNITS: &'static [(&'static str, &'static str)] = &[
        ("realizations", "1"),
        ("rounds", "1"),
        ("duration_s", "s"),
        ("nominal_spread", "1"),
        ("accuracy", "1"),
        ("maneuvers", "1"),
        ("time_s", "s"),
        ("median", "1"),
        ("q90", "1"),
        ("predicted", "1"),
        ("within", "1"),
        ("not_identifiable", "1"),
        ("not_converged", "1"),
        ("diverged", "1"),
        ("undesigned", "1"),
        ("pairs", "1"),
        ("ratio", "1"),
        ("low", "1"),
        ("high", "1"),
        ("stopped", "1"),
        ("mean_time_s", "s"),
        ("median_error", "1"),
        ("within_stopped", "1"),
        ("rms_over_accuracy", "1"),
        ("without_estimate", "1"),
        ("median_interval", "1"),
        ("q90_interval", "1"),
        ("within_interval", "1"),
        ("mean_time_interval_s", "s"),
        ("median_error_interval", "1"),
        ("within_stopped_interval", "1"),
        ("rms_over_accuracy_interval", "1"),
    ];
}
