//! `[generate]` in `dictionary.toml`: how candidates are drawn, and their limits.

use std::borrow::Cow;
use std::collections::BTreeMap;

use refusal::{Invalid, check_numbers, check_ranges};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer};
use ship::model::Model;

use super::signal::{MULTISINE_SAMPLES, SWING_SAMPLES, check_period};
use crate::feedback::Executed;

/// `[generate]` as written.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GenerateSpec {
    /// Number of draws. Those beyond the limits are left out.
    pub candidates: u32,
    /// Seed: candidate i of a seed does not depend on their number or the limits.
    #[serde(default = "one")]
    pub seed: u64,
    /// Duration of every candidate \[s\]; without it the dictionary's.
    pub duration_s: Option<f64>,
    /// Kinds, in turn; all by default.
    #[serde(default)]
    pub kinds: Vec<CandidateKind>,
    /// Range of speeds to draw from \[m/s\]; by default from standstill to the limit.
    pub speed_m_s: Option<[f64; 2]>,
    /// Initial speeds of candidates \[m/s\], as the modes of a plan; by default each has its own.
    #[serde(default)]
    pub start_m_s: Vec<f64>,
    /// Periods to draw from \[s\]: shortest and longest.
    #[serde(default = "periods")]
    pub period_s: [f64; 2],
    /// How they are carried out. By feedback, limits of inputs leave none out: what the nominal ship would need for a motion says
    /// little of what another one needs, and actuators stay within their ranges.
    #[serde(default = "inputs")]
    pub executed: Executed,
    /// Limits of all candidates.
    pub limits: Limits,
}

fn inputs() -> Executed {
    Executed::Inputs
}

fn one() -> u64 {
    1
}

fn periods() -> [f64; 2] {
    [4.0, 40.0]
}

/// Largest moduli of a candidate.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Of the surge speed \[m/s\].
    pub u_m_s: f64,
    /// Of the sway speed \[m/s\].
    pub v_m_s: f64,
    /// Of the yaw rate \[rad/s\].
    pub r_rad_s: f64,
    /// Of inputs by name, in their units: the largest modulus, or the lowest and the highest value; others have no limit.
    #[serde(default)]
    pub inputs: BTreeMap<String, InputLimit>,
    /// Of the inputs' changes by name, in their units per second; others have no limit.
    #[serde(default)]
    pub rates: BTreeMap<String, f64>,
}

refusal::choices! {
    /// The kinds that candidates are drawn of, in turn.
    pub enum CandidateKind {
        /// Speed, sway and yaw rate each in a shape of its own.
        Combined = "combined",
        /// The yaw rate swings.
        ZigZag = "zig-zag",
        /// All speeds switch at random.
        PseudoRandomBinary = "pseudo-random-binary",
        /// All speeds are sums of sines.
        Multisine = "multisine",
        /// The yaw rate is swept.
        Spiral = "spiral",
        /// From rest or slow to faster.
        Accelerate = "accelerate",
        /// The sway speed swings.
        SwayZigZag = "sway-zig-zag",
        /// To a lower speed.
        Decelerate = "decelerate",
        /// A turning circle.
        SteadyTurn = "steady-turn",
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

impl GenerateSpec {
    pub(super) fn check(&self) -> Result<(), Invalid> {
        let refuse = |key: &str, found: f64, expected: &str| {
            Err(Invalid::new(format!("`generate.{key}`"), found.to_string(), expected, "correct it"))
        };
        if self.candidates == 0 || self.candidates > MOST {
            return refuse("candidates", f64::from(self.candidates), &format!("1 to {MOST}"));
        }
        let limits = &self.limits;
        let named = [("u_m_s", limits.u_m_s), ("v_m_s", limits.v_m_s), ("r_rad_s", limits.r_rad_s)];
        let named = named.map(|(key, value)| (format!("generate.limits.{key}"), value));
        let rates = limits.rates.iter();
        let rates = rates.map(|(name, rate)| (format!("generate.limits.rates.{name}"), *rate));
        let all = named.into_iter().chain(rates);
        check_numbers(all, "more than zero", |value| value > 0.0)?;
        let mut inputs = limits.inputs.iter();
        inputs.try_for_each(|(name, limit)| limit.check(format!("`generate.limits.inputs.{name}`")))?;
        let duration = self.duration_s.map(|duration| ("generate.duration_s", duration));
        check_numbers(duration, "more than 0 s", |value| value > 0.0)?;
        check_ranges(duration.map(|(key, duration)| (key, duration, 0.0..=1e9, "s")))?;
        check_ranges(self.period_s.map(|period| ("generate.period_s", period, 0.0..=1e9, "s")))?;
        let speeds = self.speed_m_s.into_iter().flatten();
        check_ranges(speeds.map(|speed| ("generate.speed_m_s", speed, -100.0..=100.0, "m/s")))?;
        let moduli = [
            ("u_m_s", limits.u_m_s, 100.0),
            ("v_m_s", limits.v_m_s, 100.0),
            ("r_rad_s", limits.r_rad_s, 10.0),
        ];
        check_ranges(
            moduli.map(|(key, limit, most)| (format!("generate.limits.{key}"), limit, 0.0..=most, "")),
        )?;
        let [shortest, longest] = self.period_s;
        if !(shortest > 0.0 && longest >= shortest && longest.is_finite()) {
            return refuse(
                "period_s",
                shortest,
                "a shortest period above 0 s and a longest one not below it",
            );
        }
        match self.speed_m_s {
            Some([low, high]) if !(low.is_finite() && high.is_finite() && low <= high) => {
                refuse("speed_m_s", low, "a lowest speed and a highest one not below it")
            }
            _ => self.check_starts(),
        }
    }

    /// Refuses initial speeds outside the range of speeds, and kinds that none of them allows.
    fn check_starts(&self) -> Result<(), Invalid> {
        let [low, high] = self.speeds();
        let refuse = |found: String, expected: String| {
            let remedy = "correct it, or widen `generate.speed_m_s`";
            Err(Invalid::new("`generate.start_m_s`", found, expected, remedy))
        };
        if let Some(outside) = self.start_m_s.iter().find(|start| !(low..=high).contains(*start)) {
            return refuse(format!("{outside} m/s"), format!("speeds from {low} to {high} m/s"));
        }
        for kind in self.kinds().iter().filter(|_| !self.start_m_s.is_empty()) {
            let Some([least, most]) = self.starts_of(*kind) else { continue };
            if !self.start_m_s.iter().any(|start| (least..=most).contains(start)) {
                let expected = format!("one from {least:.3} to {most:.3} m/s for `{kind}`");
                return refuse(format!("{:?} m/s", self.start_m_s), expected);
            }
        }
        Ok(())
    }

    /// The kinds to draw, in turn.
    pub(super) fn kinds(&self) -> &[CandidateKind] {
        if self.kinds.is_empty() { &CandidateKind::ALL } else { &self.kinds }
    }

    /// Lowest and highest speed to draw \[m/s\].
    pub(super) fn speeds(&self) -> [f64; 2] {
        let limit = self.limits.u_m_s;
        let [low, high] = self.speed_m_s.unwrap_or([0.0, limit]);
        [low.max(-limit), high.min(limit)]
    }

    /// Lowest and highest speed that a change of speed may start at \[m/s\], a quarter of the range from its
    /// end; `None` for kinds that start at any speed.
    pub(super) fn starts_of(&self, kind: CandidateKind) -> Option<[f64; 2]> {
        let [low, high] = self.speeds();
        let far = 0.25 * (high - low);
        match kind {
            CandidateKind::Accelerate => Some([low, high - far]),
            CandidateKind::Decelerate => Some([low + far, high]),
            _ => None,
        }
    }

    /// Refuses periods that are too short for `rate_hz`.
    pub(super) fn check_sampling(&self, rate_hz: f64) -> Result<(), Invalid> {
        let multisine = self.kinds.is_empty() || self.kinds.contains(&CandidateKind::Multisine);
        let least = if multisine { MULTISINE_SAMPLES } else { SWING_SAMPLES };
        check_period("`generate.period_s`".to_owned(), self.period_s[0], least, rate_hz)
    }
}

/// Most candidates of a dictionary.
const MOST: u32 = 1_000_000;

impl Limits {
    /// Refuses limits for inputs that `model` does not have.
    pub(crate) fn check(&self, model: &Model) -> Result<(), Invalid> {
        let names = model.input_names();
        let unknown = |key: &&String| !names.contains(&key.as_str());
        if let Some(key) = self.inputs.keys().find(unknown) {
            return Err(Invalid::unknown("`generate.limits.inputs`", key, names));
        }
        match self.rates.keys().find(unknown) {
            None => Ok(()),
            Some(key) => Err(Invalid::unknown("`generate.limits.rates`", key, names)),
        }
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
            let found = most(&mut states.iter().skip(d).step_by(3).map(|x| x.abs()));
            Exceeded { limit: key.to_owned(), allowed, found }
        });
        let variables = || model.input_variables().iter().enumerate();
        let settings = variables().filter_map(|(i, own)| {
            let limit = self.inputs.get(&own.name)?;
            let away = most(&mut inputs.iter().skip(i).step_by(width).map(|x| (x - limit.middle()).abs()));
            Some(Exceeded { limit: format!("inputs.{}", own.name), allowed: limit.half(), found: away })
        });
        let changes = variables().filter_map(|(i, own)| {
            let allowed = *self.rates.get(&own.name)?;
            let places = (i..inputs.len().saturating_sub(width)).step_by(width);
            let found = most(&mut places.map(|e| (inputs[e + width] - inputs[e]).abs() * rate_hz));
            Some(Exceeded { limit: format!("rates.{}", own.name), allowed, found })
        });
        let share = |own: &Exceeded| own.found / own.allowed;
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
        let found = if self.low == -self.high {
            self.high.to_string()
        } else {
            format!("[{}, {}]", self.low, self.high)
        };
        let expected = "a number above 0, or the lowest and a higher, highest value";
        Err(Invalid::new(thing, found, expected, "correct it"))
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
