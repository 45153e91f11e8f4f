use artifact::Document;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
    /// What crude models are drawn about: `value` or `nominal`.
    pub crude_about: String,
    /// Standard deviation of the logarithm of crude over these parameters.
    pub nominal_spread: f64,
    /// Predicted error at which a trial may stop.
    pub accuracy: f64,
    /// Maneuvers to design with.
    pub maneuvers: u64,
    /// The result in words.
    pub statements: Vec<String>,
    /// `sequential`, `one-shot`, `informed`, `random`.
    pub arms: Vec<ArmSummary>,
    /// The trial in rounds over the one-shot trial, at the end of every round.
    pub gains: Vec<RoundGain>,
    /// `sequential`, `one-shot`.
    pub stopping: Vec<Stopping>,
}

/// One way to spend the sea time.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ArmSummary {
    /// Its name.
    pub name: String,
    /// One per round.
    pub points: Vec<ArmPoint>,
}

/// An arm after a time at sea, over the realizations; those without an estimate count as infinite errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ArmPoint {
    /// Time at sea.
    pub time_s: f64,
    /// Median of the parameter error.
    pub median: Option<f64>,
    /// Its 90 % quantile.
    pub q90: Option<f64>,
    /// Median of the error that estimates predict of themselves.
    pub predicted: Option<f64>,
    /// Share of the realizations whose parameter error is within the accuracy.
    pub within: f64,
    /// Realizations with a direction that is not excited.
    pub not_identifiable: u64,
    /// Realizations whose search for an estimate ended nowhere.
    pub not_converged: u64,
    /// Realizations in which the nominal model diverges.
    pub diverged: u64,
    /// Realizations whose model allowed no design for the last round: all maneuvers shared it.
    pub undesigned: u64,
}

/// Errors of the trial in rounds over those of the one-shot trial after the same time in the same realization.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RoundGain {
    /// Time at sea.
    pub time_s: f64,
    /// Realizations in which both have an estimate.
    pub pairs: u64,
    /// Geometric mean of the ratio; below 1 rounds are better.
    pub ratio: Option<f64>,
    /// Lower end of its 95 % interval.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

/// Trials that end with the first round after which the error is said to be within the accuracy, or else after the whole
/// time: in rounds by the estimate's own word, one-shot by the crude model's, before sailing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stopping {
    /// `sequential` or `one-shot`.
    pub arm: String,
    /// Trials that end because the accuracy is promised.
    pub stopped: u64,
    /// Mean time at sea of all trials.
    pub mean_time_s: f64,
    /// Median parameter error of all trials at their end.
    pub median_error: Option<f64>,
    /// Share of all trials whose error at their end is within the accuracy.
    pub within: f64,
    /// The same of those that were promised it.
    pub within_stopped: Option<f64>,
    /// Root mean square error over accuracy of those that were promised it: at most 1 where promises are kept.
    pub rms_over_accuracy: Option<f64>,
    /// Of those that were promised it, how many have no estimate and are in no mean square.
    pub without_estimate: u64,
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
    ];
}
