//! What a motion has to keep: limits of candidates, ranges of maneuvers, what they are to reach.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use refusal::Invalid;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize};
use ship::model::Model;

use crate::standard::{Standard, is_turned_away, steps};

/// Largest moduli of a candidate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Of the surge speed \[m/s\].
    #[schemars(range(max = 100.0), extend("exclusiveMinimum" = 0.0))]
    pub u_m_s: f64,
    /// Of the sway speed \[m/s\].
    #[schemars(range(max = 100.0), extend("exclusiveMinimum" = 0.0))]
    pub v_m_s: f64,
    /// Of the yaw rate \[rad/s\].
    #[schemars(range(max = 10.0), extend("exclusiveMinimum" = 0.0))]
    pub r_rad_s: f64,
    /// Of inputs by name, in their units: the largest modulus, or the lowest and the highest value; others have no limit.
    #[serde(default, skip_serializing)]
    pub inputs: BTreeMap<String, InputLimit>,
    /// Of the inputs' changes by name, in their units per second; others have no limit.
    #[serde(default)]
    #[schemars(extend("additionalProperties" = {"type": "number", "exclusiveMinimum": 0}))]
    pub rates: BTreeMap<String, f64>,
}

/// Limits that refined inputs keep, in place of those of candidates; without either, the extremes of the experiment they began as.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StatedLimits {
    /// Largest modulus of the surge speed \[m/s\].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub u_m_s: Option<f64>,
    /// Of the sway speed \[m/s\].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub v_m_s: Option<f64>,
    /// Of the yaw rate \[rad/s\].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub r_rad_s: Option<f64>,
    /// Of inputs by name, in their units: the largest modulus, or the lowest and the highest value.
    #[serde(default)]
    pub inputs: BTreeMap<String, InputLimit>,
    /// Of the inputs' changes by name, in their units per second.
    #[serde(default)]
    #[schemars(extend("additionalProperties" = {"type": "number", "exclusiveMinimum": 0}))]
    pub rates: BTreeMap<String, f64>,
}

impl StatedLimits {
    /// Refuses limits for inputs that `model` does not have, and ranges that are none.
    pub(crate) fn check(&self, model: &Model) -> Result<(), Invalid> {
        check_known("limits", &self.inputs, &self.rates, model)?;
        let mut ranges = self.inputs.iter();
        ranges.try_for_each(|(name, range)| range.check(format!("`limits.inputs.{name}`")))
    }
}

/// Refuses names of `inputs` and `rates` in `table` that `model` does not have as inputs.
fn check_known(
    table: &str,
    inputs: &BTreeMap<String, InputLimit>,
    rates: &BTreeMap<String, f64>,
    model: &Model,
) -> Result<(), Invalid> {
    let names = model.input_names();
    let mut keys = inputs.keys().map(|key| ("inputs", key)).chain(rates.keys().map(|key| ("rates", key)));
    match keys.find(|(_, key)| !names.contains(&key.as_str())) {
        None => Ok(()),
        Some((of, key)) => Err(Invalid::unknown(format!("`{table}.{of}`"), key, names)),
    }
}

/// The limit that a motion exceeds most.
#[derive(Clone, Debug, PartialEq)]
pub struct Exceeded {
    /// Key of the limit.
    pub limit: String,
    /// Its value; of an input with two ends, half of the width between them.
    pub allowed: f64,
    /// The motion's value; of such an input, how far it is from the middle.
    pub found: f64,
}

impl Limits {
    /// Refuses limits for inputs that `model` does not have.
    pub(crate) fn check(&self, model: &Model) -> Result<(), Invalid> {
        check_known("generate.limits", &self.inputs, &self.rates, model)
    }

    /// The limit that `states` (rows × 3) or `inputs` (rows × inputs), which change `rate_hz` times a second, exceed most, if any.
    /// NaN exceeds every limit.
    pub fn exceeded(&self, model: &Model, states: &[f64], inputs: &[f64], rate_hz: f64) -> Option<Exceeded> {
        let most = |values: &mut dyn Iterator<Item = f64>| {
            values.fold(0.0, |most: f64, x| if x.is_nan() { f64::INFINITY } else { most.max(x) })
        };
        let width = model.inputs.max(1);
        let limits = [("u_m_s", self.u_m_s), ("v_m_s", self.v_m_s), ("r_rad_s", self.r_rad_s)];
        let states = limits.into_iter().enumerate().map(|(d, (key, allowed))| {
            let most_found = most(&mut states.iter().skip(d).step_by(3).map(|x| x.abs()));
            Exceeded { limit: key.to_owned(), allowed, found: most_found }
        });
        let variables = || model.input_variables().iter().enumerate();
        let settings = variables().filter_map(|(i, input)| {
            let limit = self.inputs.get(&input.name)?;
            let away = most(&mut inputs.iter().skip(i).step_by(width).map(|x| (x - limit.middle()).abs()));
            Some(Exceeded { limit: format!("inputs.{}", input.name), allowed: limit.half(), found: away })
        });
        let changes = variables().filter_map(|(i, input)| {
            let allowed = *self.rates.get(&input.name)?;
            let places = (i..inputs.len().saturating_sub(width)).step_by(width);
            let fastest = most(&mut places.map(|e| (inputs[e + width] - inputs[e]).abs() * rate_hz));
            Some(Exceeded { limit: format!("rates.{}", input.name), allowed, found: fastest })
        });
        let share = |exceeded: &Exceeded| exceeded.found / exceeded.allowed;
        let exceeded = states.chain(settings).chain(changes).max_by(|a, b| share(a).total_cmp(&share(b)))?;
        // An amplitude at its limit may exceed it by rounding.
        (exceeded.found > exceeded.allowed * (1.0 + 1e-9)).then_some(exceeded)
    }
}

/// The lowest and the highest value of an input, written as the largest modulus or as both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputLimit {
    /// The lowest.
    pub low: f64,
    /// The highest.
    pub high: f64,
}

impl From<f64> for InputLimit {
    fn from(modulus: f64) -> Self {
        Self { low: -modulus, high: modulus }
    }
}

impl InputLimit {
    /// Half of its width.
    pub fn half(&self) -> f64 {
        0.5 * (self.high - self.low)
    }

    /// Its middle: zero where it is a modulus.
    pub fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }

    /// The largest modulus within.
    pub fn modulus(&self) -> f64 {
        self.high.max(-self.low)
    }

    /// As much of it as is within the `range` of an actuator; all of that where they have nothing in common.
    #[must_use]
    pub fn within(self, [low, high]: [f64; 2]) -> Self {
        let both = Self { low: self.low.max(low), high: self.high.min(high) };
        if both.low < both.high { both } else { Self { low, high } }
    }

    /// Refuses one without width; `thing` names it.
    ///
    /// # Errors
    /// Ends that are no numbers, or in the wrong order; a modulus that is not above 0.
    pub fn check(&self, thing: String) -> Result<(), Invalid> {
        if self.low < self.high && self.half().is_finite() {
            return Ok(());
        }
        let given = if self.low == -self.high {
            self.high.to_string()
        } else {
            format!("[{}, {}]", self.low, self.high)
        };
        let expected = "a number above 0, or the lowest and a higher, highest value";
        Err(Invalid::new(thing, given, expected, "correct it"))
    }
}

impl JsonSchema for InputLimit {
    fn schema_name() -> Cow<'static, str> {
        "InputLimit".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let (modulus, ends) = (generator.subschema_for::<f64>(), generator.subschema_for::<[f64; 2]>());
        json_schema!({
            "description": "The lowest and the highest value of an input, written as the largest modulus or as both.",
            "anyOf": [modulus, ends]
        })
    }
}

impl<'de> Deserialize<'de> for InputLimit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "a number, or two: the lowest and the highest value")]
        enum Written {
            Modulus(f64),
            Ends([f64; 2]),
        }
        Ok(match Written::deserialize(deserializer)? {
            Written::Modulus(modulus) => modulus.into(),
            Written::Ends([low, high]) => Self { low, high },
        })
    }
}

/// Ranges that the undisturbed motion of a maneuver has to keep, as \[from, to\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Kept {
    /// Of the surge speed \[m/s\].
    pub u_m_s: Option<[f64; 2]>,
    /// Of the sway speed \[m/s\].
    pub v_m_s: Option<[f64; 2]>,
    /// Of the yaw rate \[rad/s\].
    pub r_rad_s: Option<[f64; 2]>,
}

/// The fraction of a range by which rounding may exceed it.
const ROUNDING: f64 = 1e-9;

impl Kept {
    /// Refuses empty ranges; `maneuver` is the name.
    pub(super) fn check(&self, maneuver: &str) -> Result<(), Invalid> {
        let none =
            |(_, _, [low, high]): &(_, _, [f64; 2])| !(low.is_finite() && high.is_finite() && low <= high);
        match self.ranges().find(none) {
            None => Ok(()),
            Some((state, unit, [low, high])) => Err(Invalid::new(
                format!("maneuver `{maneuver}`, `keeps.{}`", key(state, unit)),
                format!("[{low}, {high}]"),
                "two finite numbers, the lower one first",
                "correct it",
            )),
        }
    }

    /// Refuses `states`, (N+1) × 3 row-major, of `maneuver` that leave a range.
    ///
    /// # Errors
    /// Names the maneuver, the sample, what was found and the range.
    pub fn check_states(&self, maneuver: &str, states: &[f64]) -> Result<(), Invalid> {
        for (state, unit, [low, high]) in self.ranges() {
            let slack = ROUNDING * low.abs().max(high.abs());
            let values = states.iter().skip(state).step_by(3);
            let beyond = |x: &f64| !(low - slack..=high + slack).contains(x);
            if let Some((sample, x)) = values.enumerate().find(|(_, x)| beyond(x)) {
                return Err(Invalid::new(
                    format!("maneuver `{maneuver}`, sample {sample}"),
                    format!("{} = {x} {unit}", NAMES[state]),
                    format!("from {low} to {high} {unit}, as its `keeps.{}` says", key(state, unit)),
                    "lower its amplitudes, or correct the range",
                ));
            }
        }
        Ok(())
    }

    /// The declared ranges, with their states and units.
    fn ranges(&self) -> impl Iterator<Item = (usize, &'static str, [f64; 2])> {
        let all = [(0, "m/s", self.u_m_s), (1, "m/s", self.v_m_s), (2, "rad/s", self.r_rad_s)];
        all.into_iter().filter_map(|(state, unit, range)| range.map(|range| (state, unit, range)))
    }
}

const NAMES: [&str; 3] = ["u", "v", "r"];

/// Such as `u_m_s`.
fn key(state: usize, unit: &str) -> String {
    format!("{}_{}", NAMES[state], unit.replace('/', "_"))
}

/// By how much a motion may differ from what it is called.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tolerance {
    /// By how much the mean speed over its second half may be beyond all wanted ones, as a fraction of the greatest.
    #[schemars(range(min = 0.0))]
    pub speed: f64,
    /// The change of heading at its end, as a fraction of all turning that is wanted, to either side.
    #[schemars(range(min = 0.0))]
    pub turn: f64,
    /// The least of these changes of heading that counts \[rad\].
    #[schemars(range(min = 0.0))]
    pub least_turn_rad: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { speed: 0.25, turn: 0.25, least_turn_rad: 0.35 }
    }
}

/// A quantity that a maneuver is to reach.
#[derive(Clone, Debug, PartialEq)]
pub struct Aim {
    /// What it is: `heading to starboard`.
    pub what: String,
    /// Its unit, in words: `°`, `m/s`.
    pub unit: &'static str,
    /// The value that is wanted.
    pub wanted: f64,
    /// The value that was reached.
    pub reached: f64,
    /// Whether it is what was wanted, within the tolerance.
    pub is_met: bool,
}

impl Aim {
    /// One that is to be reached or passed; angles in rad.
    fn passed(what: impl Into<String>, wanted: f64, reached: f64) -> Self {
        let is_met = reached >= wanted * (1.0 - 1e-9);
        let (what, unit) = (what.into(), "°");
        Self { what, unit, wanted: wanted.to_degrees(), reached: reached.to_degrees(), is_met }
    }

    /// One of a turn to the side of the greatest of `changes`; a ship that turned to the other side reached less than 0.
    fn turned(what: impl Into<String>, wanted: f64, changes: impl Iterator<Item = f64>) -> Self {
        let [ordered, other] =
            changes.fold([0.0, 0.0], |[ordered, other]: [f64; 2], psi| [ordered.max(psi), other.max(-psi)]);
        Self::passed(what, wanted, if is_turned_away(ordered, other) { -other } else { ordered })
    }

    /// Whether the ship turned to the other side.
    pub fn is_turned_away(&self) -> bool {
        self.unit == "°" && self.wanted > 0.0 && self.reached < 0.0
    }

    /// A value with its unit.
    pub fn value(&self, x: f64) -> String {
        match self.unit {
            "°" => format!("{x:.1}°"),
            unit => format!("{x:.3} {unit}"),
        }
    }
}

impl fmt::Display for Aim {
    /// `heading to starboard 20.0° (wanted 20.0°)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, wanted, reached, .. } = self;
        write!(f, "{what} {} (wanted {})", self.value(*reached), self.value(*wanted))
    }
}

/// The aims of a standard maneuver, with what `states`, (N+1) × 3, reach of them.
pub(crate) fn of_standard(standard: Standard, states: &[f64], rate_hz: f64) -> Vec<Aim> {
    let headings = headings(states, rate_hz);
    let after = |seconds: f64| ((seconds * rate_hz).round() as usize).min(headings.len() - 1);
    match standard {
        Standard::ZigZagTest(test) => {
            let from = after(test.hold_s);
            let side = test.to.sign();
            let changed = |k: usize| side * (headings[k] - headings[from]);
            let first = (from..headings.len()).find(|k| changed(*k) >= test.heading_rad * (1.0 - 1e-9));
            let [to, back] = if side > 0.0 { ["starboard", "port"] } else { ["port", "starboard"] };
            let changes = (from..headings.len()).map(changed);
            let one = Aim::turned(format!("heading to {to}"), test.heading_rad, changes);
            let from = first.unwrap_or(headings.len() - 1);
            let two = (from..headings.len()).map(|k| -changed(k)).fold(0.0, f64::max);
            vec![one, Aim::passed(format!("then to {back}"), test.heading_rad, two)]
        }
        Standard::TurningCircle(turn) => {
            let from = headings[after(turn.hold_s)];
            let changes = headings.iter().map(|psi| turn.to.sign() * (psi - from));
            vec![Aim::turned(format!("turn to {}", turn.to), turn.turn_rad, changes)]
        }
        Standard::ReverseSpiral(spiral) => {
            // The second half of each step; of all steps the one that is furthest from its yaw rate.
            let rates = steps(spiral.steps, false).enumerate().map(|(step, part)| {
                let wanted = spiral.to.sign() * part * spiral.yaw_rate_rad_s;
                let half = |halves: f64| after((step as f64 + 0.5 * halves) * spiral.dwell_s);
                let rates = &states.as_chunks::<3>().0[half(1.0)..half(2.0).max(half(1.0) + 1)];
                (wanted, rates.iter().map(|state| state[2]).sum::<f64>() / rates.len() as f64)
            });
            let off = |(wanted, reached): &(f64, f64)| (wanted - reached).abs();
            let worst = rates.max_by(|a, b| off(a).total_cmp(&off(b)));
            let aim = |(wanted, reached): (f64, f64)| Aim {
                what: "yaw rate of the worst step".to_owned(),
                unit: "°/s",
                wanted: wanted.to_degrees(),
                reached: reached.to_degrees(),
                is_met: (wanted - reached).abs() <= 0.1 * spiral.yaw_rate_rad_s,
            };
            worst.map(aim).into_iter().collect()
        }
        Standard::Stop(stop) => {
            let speeds = states.iter().step_by(3).skip(after(stop.hold_s));
            let reached = speeds.copied().fold(f64::INFINITY, f64::min);
            let (what, unit, wanted) = ("least speed".to_owned(), "m/s", stop.end_m_s());
            vec![Aim { what, unit, wanted, reached, is_met: reached <= wanted + 1e-3 * stop.speed_m_s }]
        }
        Standard::PullOut(_) | Standard::SpiralTest(_) => Vec::new(),
    }
}

/// The aims of a motion, `wanted` u and r of every sample, with what `states`, (N+1) × 3, reach of them. A ship may lag behind
/// speeds that change, so that only those beyond all that are wanted count.
pub fn of_motion(wanted: &[[f64; 2]], states: &[f64], rate_hz: f64, tolerance: &Tolerance) -> Vec<Aim> {
    let half = wanted.len() / 2;
    let count = (wanted.len() - half).max(1) as f64;
    let mean = wanted[half..].iter().map(|[u, _]| u).sum::<f64>() / count;
    let reached = states.iter().step_by(3).skip(half).take(wanted.len() - half).sum::<f64>() / count;
    let speeds = || wanted.iter().map(|[u, _]| *u).chain(states.first().copied());
    let (low, high) = (speeds().fold(f64::INFINITY, f64::min), speeds().fold(f64::NEG_INFINITY, f64::max));
    let slack = tolerance.speed * low.abs().max(high.abs());
    let turned = |of: &dyn Fn(f64) -> f64| wanted.iter().map(|[_, rate]| of(*rate)).sum::<f64>() / rate_hz;
    let (turn, all) = (turned(&|r| r), turned(&f64::abs));
    let heading = headings(states, rate_hz).last().copied().unwrap_or(0.0);
    vec![
        Aim {
            what: "mean speed of the second half".to_owned(),
            unit: "m/s",
            wanted: mean,
            reached,
            is_met: (low - slack..=high + slack).contains(&reached),
        },
        Aim {
            what: "change of heading".to_owned(),
            unit: "°",
            wanted: turn.to_degrees(),
            reached: heading.to_degrees(),
            is_met: (turn - heading).abs() <= (tolerance.turn * all).max(tolerance.least_turn_rad),
        },
    ]
}

/// Headings at the samples, from 0 \[rad\].
fn headings(states: &[f64], rate_hz: f64) -> Vec<f64> {
    let mut heading = 0.0;
    let next = |state: &[f64; 3]| {
        heading += state[2] / rate_hz;
        heading - state[2] / rate_hz
    };
    states.as_chunks::<3>().0.iter().map(next).collect()
}
