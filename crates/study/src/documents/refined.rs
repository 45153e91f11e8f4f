//! What becomes of a design: refined inputs, and its promise after a trial.

use std::collections::BTreeMap;

use design::{AccuracyOf, CriterionName};
use estimation::Estimator;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::Source;

/// An experiment whose input signals were refined, against the one that it began as.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RefinedDesign {
    /// The parameters that the experiment was simulated with, and that errors are relative to.
    pub simulated_with: Source,
    /// The design's experiment.
    pub before: RefinedExperiment,
    /// The refined one.
    pub after: RefinedExperiment,
    /// Value before over value after: how many times the time the start would need for the same errors.
    pub worth: f64,
    /// Inputs that changed faster in the design's experiment than their rates allow: `before` is of one in which they follow it
    /// as fast as they may.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub slowed: Vec<String>,
    /// Every limit with what was reached.
    pub limits: Vec<RefinedLimit>,
    /// Time between the knots of a correction \[s\].
    pub knot_s: f64,
    /// Iterations of the search.
    pub iterations: u64,
    /// Simulations of the search.
    pub simulations: u64,
    /// Whether the search ended by itself, before its iterations did.
    pub settled: bool,
}

/// What is predicted of an experiment.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RefinedExperiment {
    /// The criterion, with measurement errors and current.
    pub value: f64,
    /// Its part by measurement errors alone.
    pub measurement_value: f64,
    /// Root of the value: the root-mean-square parameter error that is predicted.
    pub parameter_error: f64,
    /// Predicted standard error of every parameter, in the parameter's unit.
    pub standard_errors: BTreeMap<String, f64>,
}

/// A limit of motion, of an input or of an input's rate.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RefinedLimit {
    /// As in the table `limits` of `dictionary.toml`: `u_m_s`, `inputs.tau1`, `rates.tau1`.
    pub limit: String,
    /// The largest modulus allowed, in the unit of the state, the input or the input per second; none where there is no limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub allowed: Option<f64>,
    /// The largest modulus at the start.
    pub before: f64,
    /// The largest modulus of the refined experiment.
    pub after: f64,
}

/// What a design promised, and what an estimate of its trial leaves uncertain.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PromiseUpdate {
    /// The update in words.
    pub statement: String,
    /// The estimator of the estimate.
    pub estimator: Estimator,
    /// Samples of the trial.
    pub samples: u64,
    /// Its duration \[s\]. All promises are for this length.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub duration_s: f64,
    /// Every parameter, in order.
    pub parameters: Vec<UpdatedParameter>,
    /// Root of Σ (standard error/scale)², with the fixed scales of `parameters`; absent where one is zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parameter_error: Option<UpdatedError>,
    /// The criterion of the design, where parameters alone tell it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub criterion: Option<UpdatedCriterion>,
    /// Figures of merit, where they were given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<UpdatedFigure>,
    /// Root of Σ (standard error/scale)² after one more trial of the same design and length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub after_another: Option<f64>,
    /// How much longer trials of the same design have to be, where an accuracy was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<UpdatedAccuracy>,
    /// What to know before using it, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub statements: Vec<String>,
}

/// An error as it was promised, and as it is now.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UpdatedError {
    /// Before the trial, for its length.
    pub promised: f64,
    /// From the covariance at the estimate.
    pub now: f64,
    /// The first over the second; absent where the second is zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ratio: Option<f64>,
}

/// A parameter, in its unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UpdatedParameter {
    /// Its name.
    pub name: String,
    /// The estimate.
    pub estimate: f64,
    /// What its error is relative to, before and after the trial: the modulus of the value that the design had.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Its standard error.
    pub standard_error: UpdatedError,
}

/// The criterion of a design as an error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UpdatedCriterion {
    /// Its name on the command line.
    pub name: CriterionName,
    /// a, a-relative: root of Σ weight × variance, with the weights of the design; d: |covariance|^(1/(2 × parameters)), by degree
    /// of freedom where each is estimated by itself.
    pub error: UpdatedError,
}

/// A figure of merit, in its unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UpdatedFigure {
    /// The maneuver.
    pub maneuver: String,
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Its standard error.
    pub standard_error: UpdatedError,
}

/// The time that an accuracy takes, from the covariance after the trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UpdatedAccuracy {
    /// The standard error that the design was asked for.
    pub wanted: f64,
    /// Which one.
    pub of: AccuracyOf,
    /// What the trial reached.
    pub reached: f64,
    /// Time of this design in all \[s\].
    pub needed_s: f64,
    /// What is left of it; 0 where the accuracy is reached \[s\].
    pub remaining_s: f64,
}

impl PromiseUpdate {
    /// What to print of it.
    pub fn summary(&self) -> String {
        std::iter::once(&self.statement).chain(&self.statements).cloned().collect::<Vec<_>>().join(" ")
    }
}

impl UpdatedError {
    /// Of both errors.
    pub fn of(promised: f64, now: f64) -> Self {
        Self { promised, now, ratio: (now > 0.0).then(|| promised / now) }
    }
}
