//! Standard maneuvers of IMO and ITTC, as crews carry them out: the helm goes over where the ship has turned, or the time
//! has passed, not where a model expected it.

pub(crate) mod orders;

use std::collections::BTreeMap;

use refusal::Invalid;
use schemars::JsonSchema;
use serde::Deserialize;
use ship::model::Vessel;

use crate::signal::LONGEST_S;

refusal::choices! {
    /// A side of the ship.
    pub enum Board {
        /// To the right, looking ahead.
        Starboard = "starboard",
        /// To the left.
        Port = "port",
    }
}

impl Board {
    /// 1 to starboard, −1 to port.
    pub fn sign(self) -> f64 {
        [1.0, -1.0][self as usize]
    }

    /// The refusal of a ship that was ordered to this side and whose heading changed by `other` \[rad\] to the other one, by
    /// `own` to this at the most.
    pub(crate) fn turned_away(self, ordered: f64, other: f64) -> Option<Invalid> {
        if !is_turned_away(ordered, other) {
            return None;
        }
        let back = [Self::Port, Self::Starboard][self as usize];
        let given = format!("she turned to {back} by {:.1}°, {self} was ordered", other.to_degrees());
        Some(Invalid::new("change of heading", given, format!("a turn to {self}"), WRONG_SIGN))
    }
}

/// Whether a ship whose heading changed by `own` \[rad\] to the side that was ordered, at the most, and by `other` to the other
/// one turned to that.
pub(crate) fn is_turned_away(ordered: f64, other: f64) -> bool {
    other > 2.0 * ordered && other > LEAST_TURN
}

/// The least change of heading by which a ship turned \[rad\]: 10°.
const LEAST_TURN: f64 = 0.1745;

/// What to do about a ship that turns to the other side.
pub const WRONG_SIGN: &str = "check the sign of the helm, and of the rudder's terms in the vessel's file: in many publications a \
                              positive rudder turns to port";

refusal::choices! {
    /// What a helmsman or a controller reads.
    pub enum Sensors {
        /// Sensors of its own, without noise, which no log holds.
        Own = "own",
        /// The sensors whose readings are logged, with their noise; the heading is the integral of the yaw rate.
        Logged = "logged",
    }
}

fn starboard() -> Board {
    Board::Starboard
}

fn own_sensors() -> Sensors {
    Sensors::Own
}

/// Changes of inputs, in their units, by name.
pub type Settings = BTreeMap<String, f64>;

/// A zig-zag test δ/ψ: helm to one side until the heading has changed by ψ, then to the other side until it has changed
/// by ψ to that side, and so on.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ZigZagTest {
    /// Speed of the approach \[m/s\].
    pub speed_m_s: f64,
    /// Helm to starboard: changes of inputs from those of the approach.
    pub helm: Settings,
    /// Change of heading at which the helm goes over \[rad\].
    pub heading_rad: f64,
    /// Side of the first helm.
    #[serde(default = "starboard")]
    pub to: Board,
    /// How long the approach is held first \[s\].
    #[serde(default)]
    pub hold_s: f64,
    /// Time from an order to its execution \[s\].
    #[serde(default)]
    pub delay_s: f64,
    /// Time between two looks at the compass \[s\]; by default it is watched all the time.
    pub every_s: Option<f64>,
    /// The compass.
    #[serde(default = "own_sensors")]
    pub sensors: Sensors,
}

/// A turning circle.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TurningCircle {
    /// Speed of the approach \[m/s\].
    pub speed_m_s: f64,
    /// Helm to starboard: changes of inputs from those of the approach.
    pub helm: Settings,
    /// Side of the turn.
    #[serde(default = "starboard")]
    pub to: Board,
    /// How long the approach is held first \[s\].
    #[serde(default)]
    pub hold_s: f64,
    /// Change of heading to reach \[rad\]; the helm is held to the end.
    #[serde(default = "one_and_a_half_turns")]
    pub turn_rad: f64,
}

/// IMO MSC.137(76) asks for at least 540°.
fn one_and_a_half_turns() -> f64 {
    3.0 * std::f64::consts::PI
}

/// A pull-out: a turn, then the helm amidships.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PullOut {
    /// Speed of the approach \[m/s\].
    pub speed_m_s: f64,
    /// Helm to starboard: changes of inputs from those of the approach.
    pub helm: Settings,
    /// Side of the turn.
    #[serde(default = "starboard")]
    pub to: Board,
    /// How long the approach is held first \[s\].
    #[serde(default)]
    pub hold_s: f64,
    /// How long the helm is held \[s\].
    pub turn_s: f64,
}

/// Dieudonné's direct spiral: the helm in steps from one side to the other and back.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpiralTest {
    /// Speed of the approach \[m/s\].
    pub speed_m_s: f64,
    /// Greatest helm to starboard: changes of inputs from those of the approach.
    pub helm: Settings,
    /// Side of the first helm.
    #[serde(default = "starboard")]
    pub to: Board,
    /// Steps from amidships to the greatest helm.
    #[serde(default = "four")]
    pub steps: u32,
    /// Time on a step \[s\].
    pub dwell_s: f64,
}

/// A reverse spiral: yaw rates in steps from one side to the other, each held by the helm.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReverseSpiral {
    /// Speed of the approach \[m/s\].
    pub speed_m_s: f64,
    /// Greatest helm to starboard: changes of inputs from those of the approach.
    pub helm: Settings,
    /// Greatest yaw rate \[rad/s\].
    pub yaw_rate_rad_s: f64,
    /// Side of the first turn.
    #[serde(default = "starboard")]
    pub to: Board,
    /// Steps from straight ahead to the greatest yaw rate.
    #[serde(default = "four")]
    pub steps: u32,
    /// Time on a step \[s\].
    pub dwell_s: f64,
    /// The yaw rate's sensor.
    #[serde(default = "own_sensors")]
    pub sensors: Sensors,
}

fn four() -> u32 {
    4
}

/// A stop: inputs are set, until the ship has lost her way.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stop {
    /// Speed of the approach \[m/s\].
    pub speed_m_s: f64,
    /// Settings of inputs, astern for a crash stop; all others, and all of them by default (an inertial stop), are zero.
    #[serde(default)]
    pub inputs: Settings,
    /// How long the approach is held first \[s\].
    #[serde(default)]
    pub hold_s: f64,
}

/// Speed at the end of an inertial stop, which has no end otherwise, as a fraction of that of the approach.
pub(crate) const INERTIAL_END: f64 = 0.05;

impl Stop {
    /// Speed at which the ship counts as stopped \[m/s\].
    pub fn end_m_s(&self) -> f64 {
        if self.inputs.is_empty() { INERTIAL_END * self.speed_m_s } else { 0.0 }
    }
}

/// A standard maneuver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Standard<'a> {
    /// A zig-zag test.
    ZigZagTest(&'a ZigZagTest),
    /// A turning circle.
    TurningCircle(&'a TurningCircle),
    /// A pull-out.
    PullOut(&'a PullOut),
    /// A direct spiral.
    SpiralTest(&'a SpiralTest),
    /// A reverse spiral.
    ReverseSpiral(&'a ReverseSpiral),
    /// A stop.
    Stop(&'a Stop),
}

impl Standard<'_> {
    /// Its kind in `dictionary.toml`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::ZigZagTest(_) => "zig-zag-test",
            Self::TurningCircle(_) => "turning-circle",
            Self::PullOut(_) => "pull-out",
            Self::SpiralTest(_) => "spiral-test",
            Self::ReverseSpiral(_) => "reverse-spiral",
            Self::Stop(_) => "stop",
        }
    }

    /// Speed of the approach \[m/s\].
    pub fn speed_m_s(&self) -> f64 {
        match self {
            Self::ZigZagTest(test) => test.speed_m_s,
            Self::TurningCircle(turn) => turn.speed_m_s,
            Self::PullOut(turn) => turn.speed_m_s,
            Self::SpiralTest(spiral) => spiral.speed_m_s,
            Self::ReverseSpiral(spiral) => spiral.speed_m_s,
            Self::Stop(stop) => stop.speed_m_s,
        }
    }

    /// The sensor that decides when orders are given.
    pub fn sensors(&self) -> Sensors {
        match self {
            Self::ZigZagTest(test) => test.sensors,
            Self::ReverseSpiral(spiral) => spiral.sensors,
            Self::TurningCircle(_) | Self::PullOut(_) | Self::SpiralTest(_) | Self::Stop(_) => Sensors::Own,
        }
    }

    /// Its helm to starboard or, of a stop, its settings, and their key.
    pub(crate) fn settings(&self) -> (&'static str, &Settings) {
        match self {
            Self::ZigZagTest(test) => ("helm", &test.helm),
            Self::TurningCircle(turn) => ("helm", &turn.helm),
            Self::PullOut(turn) => ("helm", &turn.helm),
            Self::SpiralTest(spiral) => ("helm", &spiral.helm),
            Self::ReverseSpiral(spiral) => ("helm", &spiral.helm),
            Self::Stop(stop) => ("inputs", &stop.inputs),
        }
    }
}

/// The steps of a spiral as fractions of its greatest: from 1 to −1 and, of a direct one, back.
pub(crate) fn steps(steps: u32, and_back: bool) -> impl Iterator<Item = f64> {
    let steps = i64::from(steps);
    let down = move |k: i64| k as f64 / steps as f64;
    let back = if and_back { 1 - steps..steps + 1 } else { 0..0 };
    (-steps..=steps).rev().map(down).chain(back.map(down))
}

/// The most steps of a spiral to one side.
const MOST_STEPS: u32 = 1000;

impl Standard<'_> {
    /// Its numbers with their keys.
    pub(crate) fn numbers(&self) -> Vec<(&'static str, f64)> {
        let speed = ("speed_m_s", self.speed_m_s());
        match self {
            Self::ZigZagTest(test) => vec![speed, ("heading_rad", test.heading_rad)],
            Self::TurningCircle(turn) => vec![speed, ("turn_rad", turn.turn_rad)],
            Self::ReverseSpiral(spiral) => vec![speed, ("yaw_rate_rad_s", spiral.yaw_rate_rad_s)],
            Self::PullOut(_) | Self::SpiralTest(_) | Self::Stop(_) => vec![speed],
        }
    }

    /// Refuses what cannot be carried out by any ship; `name` is the maneuver's.
    pub(crate) fn check(&self, name: &str, duration_s: Option<f64>) -> Result<(), Invalid> {
        let refuse = |key: &str, given: String, expected: &str| {
            Err(Invalid::new(format!("maneuver `{name}`, `{key}`"), given, expected, "correct it"))
        };
        let seconds = |key: &'static str, value: f64, zero: bool| match value {
            _ if (zero && value == 0.0) || (value > 0.0 && value <= LONGEST_S) => Ok(()),
            _ => refuse(key, value.to_string(), &format!("more than 0 s, at most {LONGEST_S:e} s")),
        };
        let above = |key: &'static str, value: f64, most: f64, unit: &str| match value {
            _ if value > 0.0 && value <= most => Ok(()),
            _ => refuse(key, value.to_string(), &format!("more than 0, at most {most} {unit}")),
        };
        let (key, settings) = self.settings();
        if let Some((input, given)) = settings.iter().find(|(_, value)| !value.is_finite()) {
            return refuse(&format!("{key}.{input}"), given.to_string(), "a finite number");
        }
        if !matches!(self, Self::Stop(_)) && settings.values().all(|value| *value == 0.0) {
            return refuse(
                key,
                "none".to_owned(),
                "changes of inputs that turn the ship to starboard, such as { rudder = 0.35 }",
            );
        }
        above("speed_m_s", self.speed_m_s(), 100.0, "m/s")?;
        match self {
            Self::ZigZagTest(test) => {
                above("heading_rad", test.heading_rad, std::f64::consts::PI, "rad")?;
                seconds("hold_s", test.hold_s, true)?;
                seconds("delay_s", test.delay_s, true)?;
                test.every_s.map_or(Ok(()), |every| seconds("every_s", every, false))
            }
            Self::TurningCircle(turn) => {
                above("turn_rad", turn.turn_rad, 100.0, "rad")?;
                seconds("hold_s", turn.hold_s, true)
            }
            Self::PullOut(turn) => {
                seconds("hold_s", turn.hold_s, true)?;
                seconds("turn_s", turn.turn_s, false)?;
                enough(name, turn.hold_s + turn.turn_s, duration_s)
            }
            Self::SpiralTest(test) => {
                spiral(name, test.steps, test.dwell_s)?;
                enough(name, test.dwell_s * steps(test.steps, true).count() as f64, duration_s)
            }
            Self::ReverseSpiral(test) => {
                above("yaw_rate_rad_s", test.yaw_rate_rad_s, 10.0, "rad/s")?;
                spiral(name, test.steps, test.dwell_s)?;
                enough(name, test.dwell_s * steps(test.steps, false).count() as f64, duration_s)
            }
            Self::Stop(stop) => seconds("hold_s", stop.hold_s, true),
        }
    }

    /// Refuses names that are no inputs of `vessel`, and followers of others.
    pub(crate) fn check_inputs(&self, name: &str, vessel: &Vessel) -> Result<(), Invalid> {
        let (key, settings) = self.settings();
        check_names(name, key, settings, vessel)
    }
}

/// Refuses names in `key` of maneuver `name` that are no inputs of `vessel`, and followers of others.
pub(crate) fn check_names(
    name: &str,
    key: &str,
    settings: &Settings,
    vessel: &Vessel,
) -> Result<(), Invalid> {
    let inputs = vessel.model.input_variables();
    let free = |i: &usize| vessel.couplings[*i].is_none();
    for input in settings.keys() {
        let place = inputs.iter().position(|variable| variable.name == *input);
        if place.filter(free).is_none() {
            let known: Vec<String> =
                (0..inputs.len()).filter(free).map(|i| format!("`{}`", inputs[i].name)).collect();
            let given = if place.is_some() { "an input that follows another" } else { "no input" };
            return Err(Invalid::new(
                format!("maneuver `{name}`, `{key}.{input}`"),
                given,
                format!("one of {} of the vessel", known.join(", ")),
                "correct the name",
            ));
        }
    }
    Ok(())
}

fn spiral(name: &str, steps: u32, dwell_s: f64) -> Result<(), Invalid> {
    let refuse = |key: &str, given: String, expected: String| {
        Err(Invalid::new(format!("maneuver `{name}`, `{key}`"), given, expected, "correct it"))
    };
    if !(1..=MOST_STEPS).contains(&steps) {
        return refuse("steps", steps.to_string(), format!("1 to {MOST_STEPS}"));
    }
    if !(dwell_s > 0.0 && dwell_s <= LONGEST_S) {
        return refuse("dwell_s", dwell_s.to_string(), format!("more than 0 s, at most {LONGEST_S:e} s"));
    }
    Ok(())
}

/// Refuses a maneuver of `needed` seconds in a shorter `duration_s`.
fn enough(name: &str, needed: f64, duration_s: Option<f64>) -> Result<(), Invalid> {
    match duration_s {
        Some(seconds) if needed > seconds * (1.0 + 1e-9) => Err(Invalid::new(
            format!("maneuver `{name}`, `duration_s`"),
            format!("{seconds} s"),
            format!("at least {needed} s for all of its steps"),
            "lengthen it",
        )),
        _ => Ok(()),
    }
}
