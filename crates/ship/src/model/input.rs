use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An input.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "ModelInput")]
pub struct InputSpec {
    /// Name as used in terms and as a column.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Another input that this one is coupled to …
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub follows: Option<String>,
    /// … by this factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<f64>,
    /// Between which the actuator can be set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Time constant with which the actuator follows a command \[s\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lag_s: Option<f64>,
    /// How much it changes in a second at most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_per_s: Option<f64>,
    /// How far a command has to be from the setting to move the actuator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dead_band: Option<f64>,
    /// How long the actuator follows a command before it takes the next one \[s\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hold_s: Option<f64>,
}
