//! A ship's forces as written in `vessel.toml`.

use std::fmt;

use refusal::choices;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde::{Deserialize, Serialize};

/// The forces on a ship as written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// Density of the water \[kg/m³\].
    #[schemars(range(min = 100.0, max = 1e4))]
    pub density_kg_m3: f64,
    /// Longest step of the integration \[s\]; one step per sample without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub step_s: Option<f64>,
    /// Size and mass.
    pub ship: ShipSpec,
    /// Terms of the force ahead.
    #[serde(default)]
    #[schemars(length(max = 2000))]
    pub surge: Vec<TermSpec>,
    /// Terms of the force to starboard.
    #[serde(default)]
    #[schemars(length(max = 2000))]
    pub sway: Vec<TermSpec>,
    /// Terms of the moment that turns the bow to starboard.
    #[serde(default)]
    #[schemars(length(max = 2000))]
    pub yaw: Vec<TermSpec>,
    /// Propellers.
    #[serde(default)]
    #[schemars(length(max = 2000))]
    pub propeller: Vec<PropellerSpec>,
    /// Rudders.
    #[serde(default)]
    #[schemars(length(max = 2000))]
    pub rudder: Vec<RudderSpec>,
    /// Thrusters.
    #[serde(default)]
    #[schemars(length(max = 2000))]
    pub thruster: Vec<ThrusterSpec>,
    /// Wind on the parts above water.
    #[serde(default)]
    #[schemars(length(max = 2000))]
    pub wind: Vec<WindSpec>,
    /// Cross-flow drag.
    #[serde(default)]
    #[schemars(length(max = 2000))]
    pub crossflow: Vec<CrossflowSpec>,
}

impl Description {
    /// The terms of surge, sway and yaw.
    pub fn terms(&self) -> [&Vec<TermSpec>; 3] {
        [&self.surge, &self.sway, &self.yaw]
    }

    /// The same, to change them.
    pub fn terms_mut(&mut self) -> [&mut Vec<TermSpec>; 3] {
        [&mut self.surge, &mut self.sway, &mut self.yaw]
    }
}

choices! {
    /// Which area forces in the prime system are divided by.
    pub enum Area {
        /// Length times draught.
        LengthDraught = "Ld",
        /// Length squared.
        LengthSquared = "LL",
    }
}

choices! {
    /// Which products of mass and yaw rate the equations of motion have.
    pub enum Coriolis {
        /// None: the terms have them, as Abkowitz writes.
        Absent = "none",
        /// All but the Munk moment, which the terms have.
        WithoutMunk = "without-munk",
        /// All of them.
        Full = "full",
    }
}

choices! {
    /// How a thruster's force follows from its input.
    pub enum Curve {
        /// The input is the force.
        Force = "force",
        /// The force is a coefficient times the input times its modulus.
        Square = "square",
    }
}

choices! {
    /// How the flow across a rudder follows from drift and turning.
    pub enum Inflow {
        /// By the sway speed.
        Velocity = "velocity",
        /// By the drift angle times the speed, as in the MMG standard method.
        Angle = "angle",
    }
}

/// Size and mass of a ship.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "ForceShip")]
pub struct ShipSpec {
    /// Length between perpendiculars \[m\].
    #[schemars(range(min = 1e-2, max = 1e4))]
    pub length_m: f64,
    /// Draught \[m\].
    #[schemars(range(min = 1e-3, max = 1e3))]
    pub draught_m: f64,
    /// Speed that terms in the prime system are scaled by, and that `du` counts from \[m/s\].
    #[schemars(range(min = 1e-3, max = 1e3))]
    pub speed_m_s: f64,
    /// Area of the prime system: `Ld` unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub area: Option<Area>,
    /// Mass \[kg\].
    pub mass_kg: Number,
    /// Centre of gravity ahead of the origin \[m\]; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x_g_m: Option<Number>,
    /// Radius of gyration in yaw about the centre of gravity \[m\], …
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gyration_m: Option<Number>,
    /// … or moment of inertia about the origin \[kg m²\], instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia_kg_m2: Option<Number>,
    /// Added masses. Plain numbers are in the prime system.
    pub added_mass: AddedMass,
    /// Products of mass and yaw rate: `without-munk` unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coriolis: Option<Coriolis>,
}

/// Added masses, positive where they make the ship heavier. Plain numbers are in the prime system; `nominal` is in kg,
/// kg m and kg m².
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AddedMass {
    /// Ahead: −X_u̇.
    pub surge: Number,
    /// Abeam: −Y_v̇.
    pub sway: Number,
    /// Moment of inertia: −N_ṙ.
    pub yaw: Number,
    /// Force to starboard by yaw acceleration: −Y_ṙ; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sway_yaw: Option<Number>,
    /// Moment by sway acceleration: −N_v̇; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw_sway: Option<Number>,
}

/// One term of an equation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TermSpec {
    /// Name of the parameter.
    pub parameter: String,
    /// What it multiplies.
    pub term: String,
    /// Its true value, where known: simulated trials follow it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Its crude value: instruments are made with it. Those that are fixed or tied need none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal: Option<f64>,
    /// In place of `nominal`, in the prime system, as `value`, `prior` and `bounds` then are; for `model = "forces"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prime: Option<f64>,
    /// Standard deviation of its prior; for `model = "forces"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior: Option<f64>,
    /// Whether its value (or nominal value) is known, so that it is not estimated.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub fixed: bool,
    /// Another parameter of the same degree of freedom that it equals …
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tied_to: Option<String>,
    /// … times this factor, 1 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<f64>,
    /// Between which its estimates stay.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("items" = {"type": "number", "format": "double", "x-infinite": true}))]
    pub bounds: Option<[f64; 2]>,
}

impl TermSpec {
    /// The parameter as a number. One with a `value` alone is known.
    pub(crate) fn number(&self) -> NumberSpec {
        let Self { value, nominal, prime, prior, fixed, tied_to, factor, bounds, .. } = self.clone();
        let nominal = nominal.or(value.filter(|_| fixed && prime.is_none()));
        NumberSpec { nominal, prime, value, prior, bounds, fixed, tied_to, factor }
    }
}

/// A propeller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PropellerSpec {
    /// Its name.
    pub name: String,
    /// The input with its revolutions.
    pub input: String,
    /// Diameter \[m\].
    pub diameter_m: Number,
    /// k₀, k₁, k₂ of K_T = k₀ + k₁ J + k₂ J².
    pub thrust: [Number; 3],
    /// Share of the thrust that the hull loses; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deduction: Option<Number>,
    /// Share of the speed that the wake takes, straight ahead; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wake: Option<Number>,
    /// C₁: how fast the wake changes with the drift at the propeller \[1/rad\]; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wake_change: Option<Number>,
    /// C₂: (1 − w) under great drift over that straight ahead, where the drift is positive and negative; 1 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wake_ratio: Option<[Number; 2]>,
    /// Where it is ahead of the origin \[m\]; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x_m: Option<Number>,
    /// Where it is to starboard of the origin \[m\]; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y_m: Option<Number>,
    /// Its forces at negative revolutions. Without them it is not reversed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub astern: Option<Reversed>,
}

/// Forces of a reversed propeller: the coefficients of n|n| over ρD⁴ and of n u_P over ρD³, moments also over the length.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "ReversedPropeller")]
pub struct Reversed {
    /// Force ahead.
    pub surge: [Number; 2],
    /// Force to starboard; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sway: Option<[Number; 2]>,
    /// Moment; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw: Option<[Number; 2]>,
}

/// A rudder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RudderSpec {
    /// Its name.
    pub name: String,
    /// The input with its angle, positive where it turns the bow to starboard.
    pub input: String,
    /// The propeller in front of it, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub behind: Option<String>,
    /// Area \[m²\].
    pub area_m2: Number,
    /// Height \[m\]; needed behind a propeller.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_m: Option<Number>,
    /// f_α: slope of the lift \[1/rad\].
    pub lift_slope: Number,
    /// ε: (1 − w) at the rudder over that at the propeller; 1 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epsilon: Option<Number>,
    /// κ: share of the propeller's jet at the rudder; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kappa: Option<Number>,
    /// γ_R: share of the flow across that reaches it, where that flow is positive and negative; 1 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gamma: Option<[Number; 2]>,
    /// ℓ′_R: where turning acts on its flow, in lengths ahead of the origin; −0.5 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ell: Option<Number>,
    /// t_R: share of its drag that the hull takes; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deduction: Option<Number>,
    /// a_H: force on the hull over that on the rudder; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interaction: Option<Number>,
    /// x_H: where that force acts ahead of the origin \[m\]; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interaction_x_m: Option<Number>,
    /// x_R: where the rudder is ahead of the origin \[m\].
    pub x_m: Number,
    /// Where it is to starboard of the origin \[m\]; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y_m: Option<Number>,
    /// k_R: flow at the rudder over n D of a reversed propeller; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reversed_flow: Option<Number>,
    /// The flow across it: `velocity` unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inflow: Option<Inflow>,
}

/// A thruster: fixed, azimuth or tunnel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "ForceThruster")]
pub struct ThrusterSpec {
    /// Its name.
    pub name: String,
    /// The input with its force or revolutions.
    pub input: String,
    /// Where it is ahead of the origin \[m\].
    pub x_m: Number,
    /// Where it is to starboard of the origin \[m\]; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y_m: Option<Number>,
    /// The channel with the direction that it pushes the ship in, from ahead to starboard: an azimuth thruster.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle: Option<String>,
    /// A fixed direction \[°\]: 0 ahead, which it is unless given, 90 for a tunnel thruster.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<Number>,
    /// `force` or `square`.
    pub curve: Curve,
    /// Its force over the input, or over the input squared, where that is positive; 1 for `force` unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ahead: Option<Number>,
    /// The same where it is negative; `ahead` unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub astern: Option<Number>,
    /// Force lost over |input| times the speed along the thruster \[N s/m\], of `square`; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loss: Option<Number>,
    /// Time constant with which it follows its input \[s\]; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lag_s: Option<Number>,
    /// Time after which it begins to follow its input \[s\]; 0 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dead_time_s: Option<Number>,
}

/// Wind on the parts above water, as seen from the ship.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "ForceWind")]
pub struct WindSpec {
    /// Its name.
    pub name: String,
    /// The channel with its speed.
    pub speed: String,
    /// The channel with the direction that it comes from, from ahead to starboard.
    pub direction: String,
    /// Density of the air \[kg/m³\]; 1.225 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub air_density_kg_m3: Option<Number>,
    /// Area seen from ahead \[m²\].
    pub frontal_area_m2: Number,
    /// Area seen from the side \[m²\].
    pub lateral_area_m2: Number,
    /// Coefficients of cos γ, cos 2γ, … of the force against surge.
    #[serde(default)]
    pub surge: Vec<Number>,
    /// Coefficients of sin γ, sin 2γ, … of the force to the lee side.
    #[serde(default)]
    pub sway: Vec<Number>,
    /// Coefficients of sin γ, sin 2γ, … of the moment, by the length, that turns the bow from the wind.
    #[serde(default)]
    pub yaw: Vec<Number>,
}

/// Drag of the water that flows across the hull, strip by strip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrossflowSpec {
    /// Its name.
    pub name: String,
    /// Draught of the strips \[m\].
    pub draught_m: Number,
    /// Drag coefficient.
    pub drag: Number,
    /// Number of strips, from bow to stern; 21 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 2, max = 1000))]
    pub strips: Option<u32>,
}

/// A number of a component: a plain one, which is known, or a table with a prior or constraint.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Number {
    /// Known.
    Plain(f64),
    /// Free, unless it is fixed or tied.
    Table(NumberSpec),
}

/// A number with what is known about it. It is a parameter, which is estimated, unless it is fixed or tied.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NumberSpec {
    /// Its value before any estimate, in SI units …
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal: Option<f64>,
    /// … or in the prime system, instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prime: Option<f64>,
    /// Its true value, where known, in the same system: simulated trials follow it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Standard deviation of the prior, in the same system.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior: Option<f64>,
    /// Between which its estimates stay, in the same system.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("items" = {"type": "number", "format": "double", "x-infinite": true}))]
    pub bounds: Option<[f64; 2]>,
    /// Whether it is known, so that it is not estimated.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub fixed: bool,
    /// Another parameter that it equals …
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tied_to: Option<String>,
    /// … times this factor, 1 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<f64>,
}

impl From<f64> for Number {
    fn from(value: f64) -> Self {
        Self::Plain(value)
    }
}

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NumberVisitor)
    }
}

struct NumberVisitor;

impl<'de> Visitor<'de> for NumberVisitor {
    type Value = Number;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number, or a table with `nominal` or `prime`")
    }

    fn visit_f64<E>(self, value: f64) -> Result<Number, E> {
        Ok(Number::Plain(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Number, E> {
        Ok(Number::Plain(value as f64))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Number, E> {
        Ok(Number::Plain(value as f64))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Number, A::Error> {
        NumberSpec::deserialize(MapAccessDeserializer::new(map)).map(Number::Table)
    }
}

impl JsonSchema for Number {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "ForceNumber".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let table = generator.subschema_for::<NumberSpec>();
        json_schema!({
            "description": "A known number, or a parameter with `nominal` or `prime`.",
            "anyOf": [{ "type": "number" }, table]
        })
    }
}
