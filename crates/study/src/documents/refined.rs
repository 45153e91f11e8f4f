use std::collections::BTreeMap;

use design::CriterionName;
use files::{Document, Units};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::Source;

use super::design::DesignPromise;
use super::titles;

/// `refined.json`: an experiment whose input signals were refined, against the one that it began as.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RefinedDocument {
    /// `covariance relative A`: Σ variance/θ² of an output-error estimate.
    #[serde(with = "titles")]
    #[schemars(schema_with = "titles::schema")]
    pub criterion: CriterionName,
    /// The parameters that the experiment was simulated with.
    pub simulated_with: Source,
    /// The parameters that errors are relative to.
    pub relative_to: Source,
    /// Samples of the experiment.
    pub samples: u64,
    /// Its duration \[s\].
    pub duration_s: f64,
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
    /// What error of the parameters the refined experiment promises, where nominal parameters are a guess.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub promise: Option<DesignPromise>,
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
    /// What was found, in words.
    pub statement: String,
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
    /// As in `limits.toml`: `u_m_s`, `inputs.tau1`, `rates.tau1`.
    pub limit: String,
    /// The largest modulus allowed, in the unit of the state, the input or the input per second; none where there is no limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub allowed: Option<f64>,
    /// The largest modulus at the start.
    pub before: f64,
    /// The largest modulus of the refined experiment.
    pub after: f64,
}

impl RefinedDocument {
    /// What to print of it, with its promise.
    pub fn summary(&self) -> String {
        let promise =
            self.promise.as_ref().map_or(String::new(), |promise| format!(" {}", promise.statement));
        format!("{}{promise}", self.statement)
    }
}

impl Document for RefinedDocument {
    const ID: &'static str = "refined";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("1", "samples value measurement_value parameter_error worth iterations simulations"),
        ("1", "range"),
        ("s", "duration_s knot_s"),
        ("as the parameter", "standard_errors"),
        ("as `limit`", "allowed before after"),
    ];
}
