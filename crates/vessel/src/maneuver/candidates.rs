//! Candidates by generation: a table `[generate]` in `dictionary.toml` instead of maneuvers written by hand.

use std::collections::BTreeMap;

use rand::Rng;
use serde::Deserialize;

use super::signal::{Signal, SignalShape};
use super::spec::{Kind, ManeuverSpec, Shape};
use crate::{Invalid, Model, Streams, nearest};

/// `[generate]` as written.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GenerateSpec {
    /// How many are drawn. Fewer are left within the limits.
    pub candidates: u32,
    /// Seed: candidate i of a seed is the same whatever their number and the limits.
    #[serde(default = "one")]
    pub seed: u64,
    /// Duration of every candidate \[s\]; without it the dictionary's.
    pub duration_s: Option<f64>,
    /// Kinds, in turn; all where there are none.
    #[serde(default)]
    pub kinds: Vec<CandidateKind>,
    /// Speeds to draw from \[m/s\]: lowest and highest; without it from standstill to the limit.
    pub speed_m_s: Option<[f64; 2]>,
    /// Periods to draw from \[s\]: shortest and longest.
    #[serde(default = "periods")]
    pub period_s: [f64; 2],
    /// What no candidate may exceed.
    pub limits: Limits,
}

fn one() -> u64 {
    1
}

fn periods() -> [f64; 2] {
    [4.0, 40.0]
}

/// Largest moduli that a candidate may reach.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Of the surge speed \[m/s\].
    pub u_m_s: f64,
    /// Of the sway speed \[m/s\].
    pub v_m_s: f64,
    /// Of the yaw rate \[rad/s\].
    pub r_rad_s: f64,
    /// Of inputs by name, in their units; an input that is not named has no limit.
    #[serde(default)]
    pub inputs: BTreeMap<String, f64>,
}

/// The kinds that candidates are drawn of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CandidateKind {
    /// From rest or slow to faster.
    Accelerate,
    /// To a lower speed.
    Decelerate,
    /// The yaw rate swings.
    ZigZag,
    /// The sway speed swings.
    SwayZigZag,
    /// The yaw rate is swept.
    Spiral,
    /// A turning circle.
    SteadyTurn,
    /// All speeds switch at random.
    PseudoRandomBinary,
    /// All speeds are sums of sines.
    Multisine,
    /// Speed, sway and yaw rate each in a shape of its own.
    Combined,
}

const ALL: [CandidateKind; 9] = [
    CandidateKind::Combined,
    CandidateKind::ZigZag,
    CandidateKind::PseudoRandomBinary,
    CandidateKind::Multisine,
    CandidateKind::Spiral,
    CandidateKind::Accelerate,
    CandidateKind::SwayZigZag,
    CandidateKind::Decelerate,
    CandidateKind::SteadyTurn,
];

/// Which limit a motion exceeds most.
#[derive(Clone, Debug, PartialEq)]
pub struct Exceeded {
    /// Key of the limit.
    pub limit: String,
    /// Its value.
    pub allowed: f64,
    /// What the motion reaches.
    pub found: f64,
}

impl GenerateSpec {
    /// All candidates, within the limits or not.
    ///
    /// # Errors
    /// A number without meaning.
    pub fn candidates(&self) -> Result<Vec<ManeuverSpec>, Invalid> {
        self.check()?;
        let kinds: &[CandidateKind] = if self.kinds.is_empty() { &ALL } else { &self.kinds };
        let streams = Streams::new(self.seed, "candidates");
        let one = |index: u32| {
            let kind = kinds[index as usize % kinds.len()];
            let mut draw = Draw { rng: streams.channel(index, 0), spec: self };
            ManeuverSpec {
                name: format!("{}-{index:05}", kind.name()),
                description: "generated".into(),
                duration_s: self.duration_s,
                kind: draw.kind(kind, index),
            }
        };
        Ok((0..self.candidates).map(one).collect())
    }

    fn check(&self) -> Result<(), Invalid> {
        let refuse = |key: &str, found: f64, expected: &str| {
            Err(Invalid::new(format!("`generate.{key}`"), found.to_string(), expected, "correct it"))
        };
        if self.candidates == 0 || self.candidates > MOST {
            return refuse("candidates", f64::from(self.candidates), &format!("1 to {MOST}"));
        }
        let limits = &self.limits;
        let named = [("u_m_s", limits.u_m_s), ("v_m_s", limits.v_m_s), ("r_rad_s", limits.r_rad_s)];
        let inputs = limits.inputs.iter().map(|(name, limit)| (name.as_str(), *limit));
        for (key, value) in named.into_iter().chain(inputs) {
            if !(value.is_finite() && value > 0.0) {
                return refuse(&format!("limits.{key}"), value, "more than zero");
            }
        }
        if let Some(duration) = self.duration_s.filter(|d| !(d.is_finite() && *d > 0.0)) {
            return refuse("duration_s", duration, "more than 0 s");
        }
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
            _ => Ok(()),
        }
    }
}

/// Most candidates of a dictionary.
const MOST: u32 = 1_000_000;

impl Limits {
    /// Refuses limits of inputs that `model` does not have.
    pub(crate) fn check(&self, model: &Model) -> Result<(), Invalid> {
        let names = || model.variables[3..3 + model.inputs].iter().map(|v| v.name.as_str());
        match self.inputs.keys().find(|key| names().all(|name| name != key.as_str())) {
            None => Ok(()),
            Some(unknown) => Err(Invalid::new(
                "`generate.limits.inputs`",
                format!("`{unknown}`"),
                names().collect::<Vec<_>>().join(", "),
                format!("did you mean `{}`?", nearest(unknown, names()).unwrap_or_default()),
            )),
        }
    }

    /// The limit that `states` (rows × 3) or `inputs` (rows × inputs) exceed most, if any. A state that is no number
    /// exceeds every limit.
    pub fn exceeded(&self, model: &Model, states: &[f64], inputs: &[f64]) -> Option<Exceeded> {
        let largest = |values: &[f64], column: usize, width: usize| {
            let moduli = values.iter().skip(column).step_by(width.max(1)).map(|x| x.abs());
            moduli.fold(0.0, |most: f64, x| if x.is_nan() { f64::INFINITY } else { most.max(x) })
        };
        let states = [("u_m_s", self.u_m_s), ("v_m_s", self.v_m_s), ("r_rad_s", self.r_rad_s)]
            .into_iter()
            .enumerate()
            .map(|(d, (key, allowed))| (key.to_owned(), allowed, largest(states, d, 3)));
        let inputs = model.variables[3..3 + model.inputs].iter().enumerate().filter_map(|(i, v)| {
            let allowed = *self.inputs.get(&v.name)?;
            Some((format!("inputs.{}", v.name), allowed, largest(inputs, i, model.inputs)))
        });
        let most = states.chain(inputs).max_by(|a, b| (a.2 / a.1).total_cmp(&(b.2 / b.1)))?;
        let (limit, allowed, found) = most;
        // What is asked to reach a limit may pass it by rounding.
        (found > allowed * (1.0 + 1e-9)).then_some(Exceeded { limit, allowed, found })
    }
}

impl CandidateKind {
    fn name(self) -> &'static str {
        match self {
            Self::Accelerate => "accelerate",
            Self::Decelerate => "decelerate",
            Self::ZigZag => "zig-zag",
            Self::SwayZigZag => "sway-zig-zag",
            Self::Spiral => "spiral",
            Self::SteadyTurn => "steady-turn",
            Self::PseudoRandomBinary => "pseudo-random-binary",
            Self::Multisine => "multisine",
            Self::Combined => "combined",
        }
    }
}

/// The random numbers of one candidate.
struct Draw<'a, R> {
    rng: R,
    spec: &'a GenerateSpec,
}

impl<R: Rng> Draw<'_, R> {
    /// Evenly from 0 to 1.
    fn share(&mut self) -> f64 {
        (self.rng.next_u64() >> 11) as f64 * 2.0_f64.powi(-53)
    }

    /// Evenly within a range, to three decimals.
    fn within(&mut self, low: f64, high: f64) -> f64 {
        let value = low + (high - low) * self.share();
        // Rounded towards zero: never beyond a limit.
        (value * 1000.0).trunc() / 1000.0
    }

    /// Of a modulus up to `most`, at least a quarter of it.
    fn amplitude(&mut self, most: f64) -> f64 {
        self.within(0.25 * most, most)
    }

    fn either(&mut self, most: f64) -> f64 {
        let amplitude = self.amplitude(most);
        if self.share() < 0.5 { -amplitude } else { amplitude }
    }

    /// Short ones as likely as long ones: evenly in the logarithm.
    fn period(&mut self) -> f64 {
        let [shortest, longest] = self.spec.period_s;
        let period = shortest * (longest / shortest).powf(self.share());
        ((period * 10.0).round() / 10.0).clamp(shortest, longest)
    }

    fn speeds(&self) -> [f64; 2] {
        let limit = self.spec.limits.u_m_s;
        let [low, high] = self.spec.speed_m_s.unwrap_or([0.0, limit]);
        [low.max(-limit), high.min(limit)]
    }

    fn speed(&mut self) -> f64 {
        let [low, high] = self.speeds();
        self.within(low, high)
    }

    fn shape(&mut self) -> Shape {
        [Shape::Square, Shape::Sine, Shape::Triangle][(3.0 * self.share()) as usize]
    }

    fn kind(&mut self, kind: CandidateKind, index: u32) -> Kind {
        let (sway, rate) = (self.spec.limits.v_m_s, self.spec.limits.r_rad_s);
        let seed = u64::from(index);
        match kind {
            CandidateKind::Accelerate | CandidateKind::Decelerate => self.change(kind),
            CandidateKind::ZigZag => Kind::ZigZag {
                shape: self.shape(),
                speed_m_s: self.speed(),
                yaw_rate_amplitude_rad_s: Some(self.amplitude(rate)),
                heading_amplitude_rad: None,
                sway_amplitude_m_s: if self.share() < 0.5 { Some(self.either(sway)) } else { None },
                period_s: self.period(),
            },
            CandidateKind::SwayZigZag => Kind::SwayZigZag {
                shape: self.shape(),
                speed_m_s: self.speed(),
                sway_amplitude_m_s: self.amplitude(sway),
                period_s: self.period(),
            },
            CandidateKind::Spiral => Kind::Spiral {
                speed_m_s: self.speed(),
                yaw_rate_from_rad_s: self.within(-0.5 * rate, 0.5 * rate),
                yaw_rate_to_rad_s: self.either(rate),
                sway_speed_m_s: Some(self.within(-sway, sway)),
            },
            CandidateKind::SteadyTurn => Kind::SteadyTurn {
                speed_m_s: self.speed(),
                yaw_rate_rad_s: self.either(rate),
                sway_speed_m_s: Some(self.within(-sway, sway)),
            },
            CandidateKind::PseudoRandomBinary => {
                let [low, high] = self.speeds();
                let speed = self.within(low, high);
                Kind::PseudoRandomBinary {
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

    fn combined(&mut self, seed: u64, shape: impl Fn(&mut Self) -> SignalShape) -> Kind {
        let [low, high] = self.speeds();
        let (sway, rate) = (self.spec.limits.v_m_s, self.spec.limits.r_rad_s);
        let mut drawn = |low: f64, high: f64| {
            let shape = shape(self);
            self.signal(shape, seed, low, high)
        };
        let speed_m_s = drawn(low, high);
        let yaw_rate_rad_s = Some(drawn(-rate, rate));
        let sway_m_s = drawn(-sway, sway);
        let sway_m_s = (self.share() < 0.8).then_some(sway_m_s);
        Kind::Combined { speed_m_s, yaw_rate_rad_s, sway_m_s }
    }

    /// A signal within a range.
    fn signal(&mut self, shape: SignalShape, seed: u64, low: f64, high: f64) -> Signal {
        let half = 0.5 * (high - low);
        let amplitude = self.either(half);
        let room = half - amplitude.abs();
        let middle = 0.5 * (low + high);
        let mean = match shape {
            SignalShape::Constant => self.within(low, high),
            _ => self.within(middle - room, middle + room),
        };
        let amplitude = if shape == SignalShape::Constant { 0.0 } else { amplitude };
        Signal { shape, mean, amplitude, period_s: self.period(), phase: self.within(0.0, 1.0), seed }
    }

    /// From one speed to another at least a quarter of the range away.
    fn change(&mut self, kind: CandidateKind) -> Kind {
        let [low, high] = self.speeds();
        let far = 0.25 * (high - low);
        let slow = self.within(low, high - far);
        let fast = self.within(slow + far, high);
        match kind {
            CandidateKind::Accelerate => Kind::Accelerate { from_m_s: slow, to_m_s: fast },
            _ => Kind::Decelerate { from_m_s: fast, to_m_s: slow },
        }
    }
}
