use std::collections::BTreeSet;
use std::str::FromStr;

use rand::Rng;
use refusal::{Invalid, check_bounds, check_name, strictly};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::Streams;
use ship::model::Source;

use super::spec::ManeuverSpec;
use crate::feedback::Executed;
use crate::kind::ManeuverKind;
use crate::limits::{Kept, Limits, StatedLimits, Tolerance};
use crate::signal::{MULTISINE_SAMPLES, SWING_SAMPLES, Shape, Signal, SignalShape, check_period};

/// `dictionary.toml` as written.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DictionaryFile {
    /// Duration of every maneuver that states none \[s\].
    pub duration_s: Option<f64>,
    /// The parameters that turn maneuvers into inputs.
    #[serde(default)]
    pub inputs_from: Source,
    /// By how much written motions may differ from what they are called.
    #[serde(default)]
    pub tolerance: Tolerance,
    /// The maneuvers, in order.
    #[serde(default, rename = "maneuver")]
    pub maneuvers: Vec<ManeuverSpec>,
    /// More maneuvers, by generation.
    pub generate: Option<GenerateSpec>,
    /// What `design --refine` keeps.
    #[serde(default)]
    pub limits: StatedLimits,
}

/// From the text of `dictionary.toml`, compiled here alone: others would have code of their own for every type in it.
impl FromStr for DictionaryFile {
    type Err = toml::de::Error;

    fn from_str(text: &str) -> Result<Self, toml::de::Error> {
        strictly(toml::Deserializer::parse(text)?)
    }
}

impl DictionaryFile {
    /// The written maneuvers, then the generated ones, with unique names.
    ///
    /// # Errors
    /// An empty dictionary, a duplicate name and meaningless numbers: names the maneuver and the key.
    pub fn expanded(&self) -> Result<Vec<ManeuverSpec>, Invalid> {
        let generated = self.generate.as_ref().map(GenerateSpec::candidates).transpose()?;
        let all: Vec<ManeuverSpec> =
            self.maneuvers.iter().cloned().chain(generated.into_iter().flatten()).collect();
        check_all(&all, self.duration_s)?;
        check_bounds(&self.tolerance)?;
        Ok(all)
    }

    /// Refuses swings that are too fast for `rate_hz`.
    pub(super) fn check_sampling(&self, rate_hz: f64) -> Result<(), Invalid> {
        self.maneuvers.iter().try_for_each(|maneuver| maneuver.check_sampling(rate_hz))?;
        self.generate.as_ref().map_or(Ok(()), |generate| generate.check_sampling(rate_hz))
    }
}

fn check_all(maneuvers: &[ManeuverSpec], default_s: Option<f64>) -> Result<(), Invalid> {
    if maneuvers.is_empty() {
        return Err(Invalid::new("[[maneuver]]", "none", "at least one maneuver", "add one, or [generate]"));
    }
    let mut names = BTreeSet::new();
    for maneuver in maneuvers {
        check_name("`name` of a [[maneuver]]", &maneuver.name)?;
        if !names.insert(maneuver.name.as_str()) {
            return Err(Invalid::new(
                format!("maneuver `{}`", maneuver.name),
                "a name that is used twice",
                "a name of its own for every maneuver",
                "rename one of them",
            ));
        }
        maneuver.check(default_s)?;
    }
    Ok(())
}

/// `[generate]` as written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GenerateSpec {
    /// Number of draws. Those beyond the limits are left out.
    #[schemars(range(min = 1, max = 1000000))]
    pub candidates: u32,
    /// Seed: candidate i of a seed does not depend on their number or the limits.
    #[serde(default = "one")]
    pub seed: u64,
    /// Duration of every candidate \[s\]; without it the dictionary's.
    #[schemars(range(max = 1e9), extend("exclusiveMinimum" = 0.0))]
    pub duration_s: Option<f64>,
    /// Kinds, in turn; all by default.
    #[serde(default)]
    pub kinds: Vec<CandidateKind>,
    /// Range of speeds to draw from \[m/s\]; by default from standstill to the limit.
    #[schemars(inner(range(min = -100.0, max = 100.0)))]
    pub speed_m_s: Option<[f64; 2]>,
    /// Initial speeds of candidates \[m/s\], as the modes of a plan; by default each has its own.
    #[serde(default)]
    pub start_m_s: Vec<f64>,
    /// Periods to draw from \[s\]: shortest and longest.
    #[serde(default = "periods")]
    #[schemars(extend("items" = {"type": "number", "exclusiveMinimum": 0, "maximum": 1e9}))]
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

impl GenerateSpec {
    pub(super) fn check(&self) -> Result<(), Invalid> {
        let refuse = |key: &str, given: f64, expected: &str| {
            Err(Invalid::new(format!("`generate.{key}`"), given.to_string(), expected, "correct it"))
        };
        check_bounds(self)?;
        let mut inputs = self.limits.inputs.iter();
        inputs.try_for_each(|(name, limit)| limit.check(format!("`generate.limits.inputs.{name}`")))?;
        let [shortest, longest] = self.period_s;
        if shortest > longest {
            return refuse("period_s", shortest, "a shortest period and a longest one not below it");
        }
        match self.speed_m_s {
            Some([low, high]) if low > high => {
                refuse("speed_m_s", low, "a lowest speed and a highest one not below it")
            }
            _ => self.check_starts(),
        }
    }

    /// Refuses initial speeds outside the range of speeds, and kinds that none of them allows.
    fn check_starts(&self) -> Result<(), Invalid> {
        let [low, high] = self.speeds();
        let refuse = |given: String, expected: String| {
            let remedy = "correct it, or widen `generate.speed_m_s`";
            Err(Invalid::new("`generate.start_m_s`", given, expected, remedy))
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
    fn kinds(&self) -> &[CandidateKind] {
        if self.kinds.is_empty() { &CandidateKind::ALL } else { &self.kinds }
    }

    /// Lowest and highest speed to draw \[m/s\].
    fn speeds(&self) -> [f64; 2] {
        let limit = self.limits.u_m_s;
        let [low, high] = self.speed_m_s.unwrap_or([0.0, limit]);
        [low.max(-limit), high.min(limit)]
    }

    /// Lowest and highest speed that a change of speed may start at \[m/s\], a quarter of the range from its
    /// end; `None` for kinds that start at any speed.
    fn starts_of(&self, kind: CandidateKind) -> Option<[f64; 2]> {
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

/// The random numbers of one candidate.
struct Draw<'a, R> {
    rng: R,
    spec: &'a GenerateSpec,
}

impl<R: Rng> Draw<'_, R> {
    /// Uniform from 0 to 1.
    fn share(&mut self) -> f64 {
        (self.rng.next_u64() >> 11) as f64 * 2.0_f64.powi(-53)
    }

    /// Uniform within a range, to three decimals.
    fn within(&mut self, low: f64, high: f64) -> f64 {
        let value = low + (high - low) * self.share();
        // Rounded towards zero, so that no limit is exceeded.
        (value * 1000.0).trunc() / 1000.0
    }

    /// Of modulus `most` or less, at least a quarter of it.
    fn amplitude(&mut self, most: f64) -> f64 {
        self.within(0.25 * most, most)
    }

    fn either(&mut self, most: f64) -> f64 {
        let amplitude = self.amplitude(most);
        if self.share() < 0.5 { -amplitude } else { amplitude }
    }

    /// Uniform in the logarithm: short periods are as likely as long ones.
    fn period(&mut self) -> f64 {
        let [shortest, longest] = self.spec.period_s;
        let period = shortest * libm::pow(longest / shortest, self.share());
        ((period * 10.0).round() / 10.0).clamp(shortest, longest)
    }

    fn speed(&mut self) -> f64 {
        let [low, high] = self.spec.speeds();
        self.start(low, high)
    }

    /// One of the stated initial speeds that lie within a range, or any speed in it if none are stated.
    fn start(&mut self, low: f64, high: f64) -> f64 {
        let starts: Vec<f64> =
            self.spec.start_m_s.iter().copied().filter(|start| (low..=high).contains(start)).collect();
        match starts.len() {
            0 => self.within(low, high),
            n => starts[(n as f64 * self.share()) as usize],
        }
    }

    fn shape(&mut self) -> Shape {
        [Shape::Square, Shape::Sine, Shape::Triangle][(3.0 * self.share()) as usize]
    }

    fn kind(&mut self, kind: CandidateKind, index: u32) -> ManeuverKind {
        let (sway, rate) = (self.spec.limits.v_m_s, self.spec.limits.r_rad_s);
        let seed = u64::from(index);
        match kind {
            CandidateKind::Accelerate | CandidateKind::Decelerate => self.change(kind),
            CandidateKind::ZigZag => ManeuverKind::ZigZag {
                shape: self.shape(),
                speed_m_s: self.speed(),
                yaw_rate_amplitude_rad_s: Some(self.amplitude(rate)),
                heading_amplitude_rad: None,
                sway_amplitude_m_s: if self.share() < 0.5 { Some(self.either(sway)) } else { None },
                period_s: self.period(),
            },
            CandidateKind::SwayZigZag => ManeuverKind::SwayZigZag {
                shape: self.shape(),
                speed_m_s: self.speed(),
                sway_amplitude_m_s: self.amplitude(sway),
                period_s: self.period(),
            },
            CandidateKind::Spiral => ManeuverKind::Spiral {
                speed_m_s: self.speed(),
                yaw_rate_from_rad_s: self.within(-0.5 * rate, 0.5 * rate),
                yaw_rate_to_rad_s: self.either(rate),
                sway_speed_m_s: Some(self.within(-sway, sway)),
            },
            CandidateKind::SteadyTurn => ManeuverKind::SteadyTurn {
                speed_m_s: self.speed(),
                yaw_rate_rad_s: self.either(rate),
                sway_speed_m_s: Some(self.within(-sway, sway)),
            },
            CandidateKind::PseudoRandomBinary => {
                let [low, high] = self.spec.speeds();
                let speed = self.start(low, high);
                ManeuverKind::PseudoRandomBinary {
                    speed_m_s: speed,
                    speed_amplitude_m_s: self.within(0.0, (high - speed).min(speed - low)),
                    yaw_rate_amplitude_rad_s: self.amplitude(rate),
                    sway_amplitude_m_s: Some(self.amplitude(sway)),
                    dwell_s: (0.5 * self.period()).max(0.1),
                    seed,
                }
            }
            CandidateKind::Multisine => {
                let shape = |_: &mut Self| SignalShape::Multisine;
                self.combined(seed, shape)
            }
            CandidateKind::Combined => self.combined(seed, Self::signal_shape),
        }
    }

    fn signal_shape(&mut self) -> SignalShape {
        use SignalShape::{Constant, PseudoRandom, Ramp, Sine, Square, Triangle};
        [Constant, Square, Sine, Triangle, Ramp, PseudoRandom, Square][(7.0 * self.share()) as usize]
    }

    fn combined(&mut self, seed: u64, shape: impl Fn(&mut Self) -> SignalShape) -> ManeuverKind {
        let [low, high] = self.spec.speeds();
        let (sway, rate) = (self.spec.limits.v_m_s, self.spec.limits.r_rad_s);
        let mut drawn = |low: f64, high: f64| {
            let shape = shape(self);
            self.signal(shape, seed, low, high)
        };
        let speed_m_s = drawn(low, high);
        let yaw_rate_rad_s = Some(drawn(-rate, rate));
        let sway_m_s = drawn(-sway, sway);
        let sway_m_s = (self.share() < 0.8).then_some(sway_m_s);
        let start_m_s = if self.spec.start_m_s.is_empty() { None } else { Some(self.start(low, high)) };
        ManeuverKind::Combined { exact: false, start_m_s, speed_m_s, yaw_rate_rad_s, sway_m_s }
    }

    /// A signal within a range.
    fn signal(&mut self, shape: SignalShape, seed: u64, low: f64, high: f64) -> Signal {
        let half = 0.5 * (high - low);
        let amplitude = self.either(half);
        let spread = half - amplitude.abs();
        let centre = 0.5 * (low + high);
        let mean = match shape {
            SignalShape::Constant => self.within(low, high),
            _ => self.within(centre - spread, centre + spread),
        };
        let amplitude = if shape == SignalShape::Constant { 0.0 } else { amplitude };
        let (period_s, phase) = (self.period(), self.within(0.0, 1.0));
        Signal {
            shape,
            mean,
            amplitude,
            period_s,
            phase,
            seed,
            steepness: None,
            exponent: None,
            over_s: None,
        }
    }

    /// From one speed to another that differs by at least a quarter of the range.
    fn change(&mut self, kind: CandidateKind) -> ManeuverKind {
        let [low, high] = self.spec.speeds();
        let far = 0.25 * (high - low);
        let starts = self.spec.starts_of(kind).filter(|_| !self.spec.start_m_s.is_empty());
        let (slow, fast) = match (kind, starts) {
            (CandidateKind::Decelerate, Some([least, most])) => {
                let fast = self.start(least, most);
                (self.within(low, fast - far), fast)
            }
            _ => {
                let slow = self.start(low, high - far);
                (slow, self.within(slow + far, high))
            }
        };
        match kind {
            CandidateKind::Accelerate => {
                ManeuverKind::Accelerate { from_m_s: slow, to_m_s: fast, hold_s: 0.0 }
            }
            _ => ManeuverKind::Decelerate { from_m_s: fast, to_m_s: slow, hold_s: 0.0 },
        }
    }
}

impl GenerateSpec {
    /// All candidates, whether or not they keep the limits.
    ///
    /// # Errors
    /// A meaningless number.
    pub fn candidates(&self) -> Result<Vec<ManeuverSpec>, Invalid> {
        self.check()?;
        let kinds = self.kinds();
        let streams = Streams::new(self.seed, "candidates");
        let one = |index: u32| {
            let kind = kinds[index as usize % kinds.len()];
            let mut draw = Draw { rng: streams.channel(index, 0), spec: self };
            ManeuverSpec {
                name: format!("{kind}-{index:05}"),
                description: "generated".into(),
                duration_s: self.duration_s,
                keeps: Kept::default(),
                executed: self.executed,
                feedback: None,
                approach: None,
                kind: draw.kind(kind, index),
            }
        };
        Ok((0..self.candidates).map(one).collect())
    }
}
