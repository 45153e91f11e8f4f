//! `vessel.toml` as it is written.

use std::collections::BTreeMap;
use std::str::FromStr;

use crate::forces::{CrossflowSpec, PropellerSpec, RudderSpec, ShipSpec, TermSpec, ThrusterSpec, WindSpec};
use refusal::{Invalid, choices};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::model::{DerivedSpec, InputSpec};

choices! {
    /// Whether a ship may be unusual.
    pub enum Unusual {
        /// What is unusual of ships passes; what no ship is does not.
        Accepted = "accepted",
    }
}

choices! {
    /// What the numbers of a vessel mean.
    pub enum Kind {
        /// Changes per sample, which hold for one sampling rate.
        PerSample = "per-sample",
        /// Forces in continuous time, which hold for any.
        Forces = "forces",
    }
}

/// `vessel.toml` as written.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VesselFile {
    /// A built-in vessel to start from; it replaces everything below but `name`, `value` and `nominal`, and the sampling
    /// rate of one with forces.
    pub preset: Option<String>,
    /// What the numbers mean: changes per sample, as without it, or forces in continuous time.
    pub model: Option<Kind>,
    /// Name of the vessel.
    pub name: Option<String>,
    /// `accepted` lets numbers pass that are unusual of ships, which are refused without it; never those that no ship has.
    pub unusual: Option<Unusual>,
    /// Whether estimates stand in the file, which may be anything.
    #[serde(skip)]
    pub fitted: bool,
    /// The sampling rate that the parameters hold for \[Hz\]; forces hold for any.
    pub sample_rate_hz: Option<f64>,
    /// Inputs, in order.
    #[serde(default)]
    pub input: Vec<InputSpec>,
    /// Measured disturbances, in order.
    #[serde(default)]
    pub measured: Vec<MeasuredSpec>,
    /// Channels that are computed from inputs, measured disturbances and each other.
    #[serde(default)]
    pub derived: Vec<DerivedSpec>,
    /// Terms of the surge equation.
    #[serde(default)]
    pub surge: Vec<TermSpec>,
    /// Terms of the sway equation.
    #[serde(default)]
    pub sway: Vec<TermSpec>,
    /// Terms of the yaw equation.
    #[serde(default)]
    pub yaw: Vec<TermSpec>,
    /// True values that replace those of the terms, by parameter.
    #[serde(default)]
    pub value: BTreeMap<String, f64>,
    /// Nominal values that replace those of the terms, by parameter.
    #[serde(default)]
    pub nominal: BTreeMap<String, f64>,
    /// Known increments of u, v \[m/s\] and r \[rad/s\] per sample that do not depend on the vessel.
    #[serde(default)]
    pub constant: [f64; 3],
    /// Of `model = "forces"`: density of the water \[kg/m³\].
    pub density_kg_m3: Option<f64>,
    /// Longest step of the integration of forces \[s\]; one step per sample without it.
    pub step_s: Option<f64>,
    /// Size and mass of a ship with forces.
    pub ship: Option<ShipSpec>,
    /// Propellers of a ship with forces.
    #[serde(default)]
    pub propeller: Vec<PropellerSpec>,
    /// Rudders of a ship with forces.
    #[serde(default)]
    pub rudder: Vec<RudderSpec>,
    /// Thrusters of a ship with forces.
    #[serde(default)]
    pub thruster: Vec<ThrusterSpec>,
    /// Wind on a ship with forces.
    #[serde(default)]
    pub wind: Vec<WindSpec>,
    /// Cross-flow drag of a ship with forces.
    #[serde(default)]
    pub crossflow: Vec<CrossflowSpec>,
}

/// From the text of `vessel.toml`, compiled here alone: others would have code of their own for every type in it.
impl FromStr for VesselFile {
    type Err = toml::de::Error;

    fn from_str(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text)
    }
}

/// A measured disturbance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "ModelChannel")]
pub struct MeasuredSpec {
    /// Name as used in terms and as a column.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What it is wherever a trial is simulated, in its unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulated: Option<f64>,
}

/// The refusal of a file without `key`.
pub(crate) fn missing(key: &str) -> Invalid {
    Invalid::new(format!("key `{key}`"), "none", format!("`{key}`"), "add it, or name a `preset`")
}
