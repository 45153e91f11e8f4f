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
    /// Standard deviation of the logarithm of crude over nominal parameters.
    pub nominal_spread: f64,
    /// Predicted error at which a trial may stop.
    pub accuracy: f64,
    /// The result in words.
    pub statements: Vec<String>,
    /// `sequential`, `one-shot`, `informed`, `random`.
    pub arms: Vec<ArmSummary>,
    /// Where the sequential trials would have stopped.
    pub stopping: Stopping,
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
    /// Median of the predicted error.
    pub predicted: Option<f64>,
    /// Share of the realizations whose parameter error is within the accuracy.
    pub within: f64,
    /// Realizations without an estimate.
    pub failed: u64,
    /// Realizations whose model allowed no design: all maneuvers shared the time.
    pub undesigned: u64,
}

/// Where sequential trials reach the accuracy by their own prediction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stopping {
    /// How many do.
    pub reached: u64,
    /// When, on average over these.
    pub mean_time_s: Option<f64>,
    /// Median of their parameter error then.
    pub median_error: Option<f64>,
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
        ("time_s", "s"),
        ("median", "1"),
        ("q90", "1"),
        ("predicted", "1"),
        ("within", "1"),
        ("failed", "1"),
        ("undesigned", "1"),
        ("reached", "1"),
        ("mean_time_s", "s"),
        ("median_error", "1"),
    ];
}
