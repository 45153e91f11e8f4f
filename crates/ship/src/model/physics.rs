//! Vessels whose model is made of forces.

use std::collections::BTreeMap;
use std::str::FromStr;
use std::sync::Arc;

use refusal::{Invalid, check_ranges, choices, strictly};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::equation::Parts;
use super::structure::ForceModel;
use crate::forces::{
    Channel, CrossflowSpec, Description, Forces, PropellerSpec, RudderSpec, ShipSpec, TermSpec, ThrusterSpec,
    WindSpec,
};
use crate::model::{Actuator, ChannelRole, DerivedSpec, InputSpec, Variable};

/// Most steps of the integration in a sample.
const MOST_STEPS: f64 = 1e4;

/// Whether a file has keys of forces.
fn has_forces(file: &VesselFile) -> bool {
    first_key(file).is_some()
}

/// The first key of forces in a file.
fn first_key(file: &VesselFile) -> Option<&'static str> {
    let keys = [
        ("density_kg_m3", file.density_kg_m3.is_some()),
        ("step_s", file.step_s.is_some()),
        ("[ship]", file.ship.is_some()),
        ("[[propeller]]", !file.propeller.is_empty()),
        ("[[rudder]]", !file.rudder.is_empty()),
        ("[[thruster]]", !file.thruster.is_empty()),
        ("[[wind]]", !file.wind.is_empty()),
        ("[[crossflow]]", !file.crossflow.is_empty()),
    ];
    keys.into_iter().find_map(|(key, given)| given.then_some(key))
}

/// Refuses keys of forces beside terms per sample.
pub(crate) fn check_absent(file: &VesselFile) -> Result<(), Invalid> {
    let remedy = "write `model = \"forces\"`, or remove it";
    let expected = "terms per sample alone, without `model = \"forces\"`";
    if let Some(key) = first_key(file) {
        return Err(Invalid::new(format!("`{key}`"), "a key of forces", expected, remedy));
    }
    let terms = [&file.surge, &file.sway, &file.yaw].into_iter().flatten();
    match terms.into_iter().find(|spec| spec.prime.is_some() || spec.prior.is_some()) {
        Some(spec) => {
            let given = if spec.prime.is_some() { "`prime`" } else { "`prior`" };
            Err(Invalid::new(format!("parameter `{}`", spec.parameter), given, expected, remedy))
        }
        None => Ok(()),
    }
}

/// The forces of `file`, whose thrusters may give `actuators` their lags.
pub(crate) fn moved(
    file: &VesselFile,
    variables: &[Variable],
    actuators: &mut [Actuator],
) -> Result<(Arc<ForceModel>, Parts), Invalid> {
    if file.constant != [0.0; 3] {
        let expected = "none: increments per sample are no forces";
        return Err(Invalid::new("`constant`", "increments", expected, "remove it, or add a term `1`"));
    }
    let description = description(file)?;
    let range = |i: usize| actuators.get(i).and_then(|actuator| actuator.range);
    let channel = |(i, variable): (usize, &Variable)| Channel {
        name: variable.name.clone(),
        unit: variable.unit.clone(),
        range: range(i),
    };
    let channels: Vec<Channel> = variables[3..].iter().enumerate().map(channel).collect();
    let forces = Forces::new(&description, &channels)?;
    let mut parts = Parts {
        nominal: forces.nominal(),
        value: forces.parameters().iter().map(|parameter| parameter.value).collect(),
        ..Parts::default()
    };
    replace(file, &forces, &mut parts)?;
    forces.check(&parts.nominal)?;
    let true_ones: Vec<f64> =
        parts.value.iter().zip(&parts.nominal).map(|(value, nominal)| value.unwrap_or(*nominal)).collect();
    forces.check(&true_ones)?;
    for theta in [&parts.nominal, &true_ones].into_iter().filter(|_| !file.fitted) {
        forces.gate(theta, file.unusual.is_some())?;
    }
    for (i, lag_s) in forces.lags(&parts.nominal) {
        let Some(actuator) = actuators.get_mut(i) else { continue };
        if actuator.lag_s > 0.0 {
            let thing = format!("`lag_s` of input `{}`", variables[3 + i].name);
            let expected = "the lag of the input, or that of its thruster";
            return Err(Invalid::new(thing, "both", expected, "remove one of them"));
        }
        actuator.lag_s = lag_s;
    }
    let sample_s = 1.0 / file.sample_rate_hz.unwrap_or(1.0);
    let steps =
        description.step_s.map(|step_s| ("step_s", sample_s / step_s, 0.0..=MOST_STEPS, "steps in a sample"));
    check_ranges(steps)?;
    Ok((Arc::new(ForceModel { forces, sample_s }), parts))
}

impl VesselFile {
    /// The keys of forces as `own` has them, and no others.
    pub fn of_forces(description: Description) -> Self {
        Self {
            model: Some(Kind::Forces),
            density_kg_m3: Some(description.density_kg_m3),
            step_s: description.step_s,
            ship: Some(description.ship),
            surge: description.surge,
            sway: description.sway,
            yaw: description.yaw,
            propeller: description.propeller,
            rudder: description.rudder,
            thruster: description.thruster,
            wind: description.wind,
            crossflow: description.crossflow,
            ..Self::default()
        }
    }
}

/// The forces that `file` describes.
pub(crate) fn described(file: &VesselFile) -> Result<Description, Invalid> {
    if file.model != Some(Kind::Forces) {
        let expected = "`model = \"forces\"`: terms per sample hold for one ship at one rate";
        let remedy = "describe her as forces, or take a preset such as `kvlcc2-l7`";
        return Err(Invalid::new("`model`", "terms per sample", expected, remedy));
    }
    description(file)
}

fn description(file: &VesselFile) -> Result<Description, Invalid> {
    let [surge, sway, yaw] = [&file.surge, &file.sway, &file.yaw].map(Vec::clone);
    Ok(Description {
        density_kg_m3: file.density_kg_m3.ok_or_else(|| missing("density_kg_m3"))?,
        step_s: file.step_s,
        ship: file.ship.clone().ok_or_else(|| missing("ship"))?,
        surge,
        sway,
        yaw,
        propeller: file.propeller.clone(),
        rudder: file.rudder.clone(),
        thruster: file.thruster.clone(),
        wind: file.wind.clone(),
        crossflow: file.crossflow.clone(),
    })
}

/// Puts in the numbers of [value] and [nominal], in the system of each parameter.
fn replace(file: &VesselFile, forces: &Forces, parts: &mut Parts) -> Result<(), Invalid> {
    let names = || forces.parameters().iter().map(|parameter| parameter.name.as_str());
    let both =
        file.value.iter().map(|entry| (entry, true)).chain(file.nominal.iter().map(|entry| (entry, false)));
    for ((name, value), truth) in both {
        let Some(i) = names().position(|parameter| parameter == name) else {
            let unknown = Invalid::unknown(format!("parameter `{name}`"), name, names());
            return Err(Invalid { found: "a name that no free parameter has".to_owned(), ..unknown });
        };
        let [low, high] = forces.parameters()[i].bounds;
        if !value.is_finite() || !(low..=high).contains(value) {
            let expected = "a finite number within its bounds";
            return Err(Invalid::new(
                format!("parameter `{name}`"),
                value.to_string(),
                expected,
                "correct it",
            ));
        }
        match truth {
            true => parts.value[i] = Some(*value),
            false => parts.nominal[i] = *value,
        }
    }
    Ok(())
}

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
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VesselFile {
    /// A built-in vessel to start from; it replaces everything below but `name`, `value`, `nominal` and
    /// `candidates`, and the sampling rate of one with forces.
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
    #[schemars(range(min = 1e-6, max = 1e6))]
    pub sample_rate_hz: Option<f64>,
    /// Inputs, in order.
    #[serde(default)]
    #[schemars(length(max = 200))]
    pub input: Vec<InputSpec>,
    /// Measured disturbances, in order.
    #[serde(default)]
    #[schemars(length(max = 200))]
    pub measured: Vec<MeasuredSpec>,
    /// Channels that are computed from inputs, measured disturbances and each other.
    #[serde(default)]
    #[schemars(length(max = 200))]
    pub derived: Vec<DerivedSpec>,
    /// Terms of the surge equation.
    #[serde(default)]
    #[schemars(length(max = 2000))]
    pub surge: Vec<TermSpec>,
    /// Terms of the sway equation.
    #[serde(default)]
    #[schemars(length(max = 2000))]
    pub sway: Vec<TermSpec>,
    /// Terms of the yaw equation.
    #[serde(default)]
    #[schemars(length(max = 2000))]
    pub yaw: Vec<TermSpec>,
    /// True values that replace those of the terms, by parameter.
    #[serde(default)]
    pub value: BTreeMap<String, f64>,
    /// Nominal values that replace those of the terms, by parameter.
    #[serde(default)]
    pub nominal: BTreeMap<String, f64>,
    /// Known increments of u, v \[m/s\] and r \[rad/s\] per sample that do not depend on the vessel.
    #[serde(default)]
    #[schemars(inner(range(min = -10.0, max = 10.0)))]
    pub constant: [f64; 3],
    /// Of `model = "forces"`: density of the water \[kg/m³\].
    #[schemars(range(min = 100.0, max = 1e4))]
    pub density_kg_m3: Option<f64>,
    /// Longest step of the integration of forces \[s\]; one step per sample without it.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
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
    /// What a search tries, in place of a library of terms, or of the products that a ship with forces may lack.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub candidates: Option<CandidateTerms>,
}

/// Terms that a search may add to the structure of `vessel.toml`, as they are written there.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CandidateTerms {
    /// Of the surge equation.
    pub surge: Vec<String>,
    /// Of the sway equation.
    pub sway: Vec<String>,
    /// Of the yaw equation.
    pub yaw: Vec<String>,
}

/// From the text of `vessel.toml`, compiled here alone: others would have code of their own for every type in it.
impl FromStr for VesselFile {
    type Err = toml::de::Error;

    fn from_str(text: &str) -> Result<Self, toml::de::Error> {
        strictly(toml::Deserializer::parse(text)?)
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
    /// What it is to a search for terms; found by unit and name without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<ChannelRole>,
}

/// The refusal of a file without `key`.
pub(crate) fn missing(key: &str) -> Invalid {
    Invalid::new(format!("key `{key}`"), "none", format!("`{key}`"), "add it, or name a `preset`")
}

/// The built-in vessels: name and `vessel.toml`.
const PRESETS: [(&str, &str); 5] = [
    ("ljungberg-model-ship", include_str!("../../presets/ljungberg-model-ship.toml")),
    ("mariner", include_str!("../../presets/mariner.toml")),
    ("kvlcc2-l7", include_str!("../../presets/kvlcc2-l7.toml")),
    ("esso-osaka-3m", include_str!("../../presets/esso-osaka-3m.toml")),
    ("otter", include_str!("../../presets/otter.toml")),
];

/// The preset that `file` names, with the values and the name of `file`.
pub(crate) fn preset(file: VesselFile) -> Result<VesselFile, Invalid> {
    let name = file.preset.as_deref().unwrap_or_default();
    let Some((_, text)) = PRESETS.iter().find(|(preset, _)| *preset == name) else {
        return Err(Invalid::unknown("`preset`", name, PRESETS.iter().map(|(name, _)| *name)));
    };
    let mut base: VesselFile = text.parse().map_err(|e: toml::de::Error| {
        Invalid::new("`preset`", e.message().to_owned(), "a vessel", "report this as a defect")
    })?;
    let any_rate = base.model == Some(Kind::Forces);
    if has_structure(&file) || (file.sample_rate_hz.is_some() && !any_rate) {
        return Err(Invalid::new(
            "`preset`",
            "a structure of the file's own in addition",
            "a preset with `name`, [value] and [nominal] only, and `sample_rate_hz` where it has forces",
            "remove `preset`, or the terms, inputs and `sample_rate_hz`",
        ));
    }
    base.name = file.name.or(base.name);
    base.unusual = file.unusual.or(base.unusual);
    base.sample_rate_hz = file.sample_rate_hz.or(base.sample_rate_hz);
    base.value.extend(file.value);
    base.nominal.extend(file.nominal);
    base.constant = file.constant;
    base.candidates = file.candidates;
    Ok(base)
}

/// Whether a file has more than names, numbers and a rate.
fn has_structure(file: &VesselFile) -> bool {
    let terms = [&file.surge, &file.sway, &file.yaw].iter().any(|terms| !terms.is_empty());
    let channels = !(file.input.is_empty() && file.measured.is_empty() && file.derived.is_empty());
    terms || channels || file.model.is_some() || has_forces(file)
}
