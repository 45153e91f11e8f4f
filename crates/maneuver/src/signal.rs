//! Signals for speed, sway speed and yaw rate in a combined maneuver.

use rand::Rng;
use refusal::Invalid;
use schemars::JsonSchema;
use serde::Deserialize;
use ship::engine::Streams;

/// The course of one speed over a combined maneuver, in the unit of its key.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Signal {
    /// Its shape.
    #[serde(default)]
    pub shape: SignalShape,
    /// Centre of its range.
    #[serde(default)]
    pub mean: f64,
    /// Half of its range; a negative one starts downwards.
    #[serde(default)]
    pub amplitude: f64,
    /// Period; for a pseudo-random signal the shortest time at a level, for a multisine the longest period
    /// \[s\].
    #[serde(default)]
    pub period_s: f64,
    /// Where a square, sine, flat sine or triangle starts, in periods.
    #[serde(default)]
    pub phase: f64,
    /// Seed of a pseudo-random signal's levels and of a multisine's phases.
    #[serde(default)]
    pub seed: u64,
    /// How many times as steep as the sine a flat sine crosses its centre.
    pub steepness: Option<f64>,
    /// Power of the time that a ramp follows; without it 1, a straight line.
    pub exponent: Option<f64>,
    /// Duration of a ramp, which then holds its end value; by default that of the maneuver \[s\].
    pub over_s: Option<f64>,
}

/// The shape of a signal within its range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SignalShape {
    /// Constant at the mean.
    #[default]
    Constant,
    /// Between two levels.
    Square,
    /// As a sine.
    Sine,
    /// As a sine of `steepness` times the amplitude, cut off where it leaves the range.
    FlatSine,
    /// In straight ramps up and down.
    Triangle,
    /// Once through the range: evenly, or by a power of the time.
    Ramp,
    /// Between two levels at random.
    PseudoRandom,
    /// A sum of [`LINES`] harmonics with random phases.
    Multisine,
}

/// Harmonics of a multisine.
pub const LINES: usize = 5;

impl Signal {
    /// Whether `period_s` has an effect.
    pub(crate) fn has_period(&self) -> bool {
        self.least_samples().is_some()
    }

    /// Fewest samples in `period_s`, if that has an effect.
    pub(super) fn least_samples(&self) -> Option<usize> {
        match self.shape {
            SignalShape::Constant | SignalShape::Ramp => None,
            SignalShape::Square | SignalShape::Sine | SignalShape::FlatSine | SignalShape::Triangle => {
                Some(SWING_SAMPLES)
            }
            SignalShape::PseudoRandom => Some(1),
            SignalShape::Multisine => Some(MULTISINE_SAMPLES),
        }
    }

    /// Whether it is stretched to the length of its maneuver.
    pub(super) fn is_stretched(&self) -> bool {
        self.shape == SignalShape::Ramp && self.over_s.is_none()
    }

    /// Refuses a key that is out of range, missing, or belongs to another shape: key, found, expected.
    pub(super) fn check_shape(&self) -> Result<(), (&'static str, Option<f64>, &'static str)> {
        self.check_ramp()?;
        let flat = self.shape == SignalShape::FlatSine;
        match self.steepness {
            None if flat => Err(("steepness", None, "how many times as steep as a sine it is, 1 or more")),
            Some(s) if !flat => Err(("steepness", Some(s), "none, but with shape = \"flat-sine\"")),
            Some(s) if !(1.0..=STEEPEST).contains(&s) => {
                Err(("steepness", Some(s), "a number from 1, the sine itself, to 1e6"))
            }
            _ => Ok(()),
        }
    }

    fn check_ramp(&self) -> Result<(), (&'static str, Option<f64>, &'static str)> {
        let keys = [
            ("exponent", self.exponent, LARGEST_EXPONENT, "a number above 0, and 100 at most"),
            ("over_s", self.over_s, LONGEST_S, "more than 0 s, and 1e9 s at most"),
        ];
        for (key, given, most, expected) in keys {
            let Some(x) = given else { continue };
            if self.shape != SignalShape::Ramp {
                return Err((key, given, "none, but with shape = \"ramp\""));
            }
            if !(x > 0.0 && x <= most) {
                return Err((key, given, expected));
            }
        }
        Ok(())
    }
}

/// The longest duration and period of a maneuver \[s\].
pub(super) const LONGEST_S: f64 = 1e9;

/// A flat sine this steep is a square wave at any sampling rate.
const STEEPEST: f64 = 1e6;

/// A ramp of this power stays at its beginning until the maneuver is over.
const LARGEST_EXPONENT: f64 = 100.0;

/// Fewest samples of a period: two to either side. With the two of Nyquist's bound a square may be sampled
/// where it jumps and a sine at its zeros, and vanish.
pub(super) const SWING_SAMPLES: usize = 4;

/// Fewest samples of a multisine's longest period: its fastest harmonic then stays below Nyquist's bound.
pub(super) const MULTISINE_SAMPLES: usize = 2 * LINES + 1;

/// Refuses a period of fewer samples than `least`.
pub(super) fn check_period(thing: String, period_s: f64, least: usize, rate_hz: f64) -> Result<(), Invalid> {
    // The number of samples may be slightly below an integer in binary fractions.
    if period_s * rate_hz >= least as f64 * (1.0 - 1e-9) {
        return Ok(());
    }
    let samples = if least == 1 { "sample" } else { "samples" };
    let expected = format!("at least {} s: {least} {samples} at {rate_hz} Hz", least as f64 / rate_hz);
    Err(Invalid::new(thing, format!("{period_s} s"), expected, "lengthen it"))
}

/// A signal that can be evaluated.
#[derive(Clone, Debug)]
pub(crate) struct Wave {
    signal: Signal,
    /// Levels (±1) of a pseudo-random signal, phases (in periods) of a multisine.
    draws: Vec<f64>,
    /// Largest modulus of the sum of a multisine's harmonics.
    peak: f64,
}

impl Wave {
    /// `channel` separates the random numbers of a maneuver's signals.
    pub(crate) fn new(signal: Signal, channel: u32, duration_s: f64) -> Self {
        let streams = Streams::new(signal.seed, "combined");
        let draws = match signal.shape {
            SignalShape::PseudoRandom => {
                let dwells = (duration_s / signal.period_s).floor() as usize + 1;
                streams.choices(0, channel, 2, dwells).iter().map(|b| 2.0 * f64::from(*b) - 1.0).collect()
            }
            SignalShape::Multisine => {
                let mut rng = streams.channel(0, channel);
                (0..LINES).map(|_| (rng.next_u64() >> 11) as f64 * 2.0_f64.powi(-53)).collect()
            }
            _ => Vec::new(),
        };
        let mut wave = Self { signal, draws, peak: 1.0 };
        if signal.shape == SignalShape::Multisine {
            wave.peak = (0..512).map(|i| wave.harmonics(f64::from(i) / 512.0).abs()).fold(0.0, f64::max);
        }
        wave
    }

    /// Its value at `t` seconds, in a maneuver of which the fraction `done` (0 to 1) is over.
    pub(crate) fn at(&self, t: f64, done: f64) -> f64 {
        let Signal { mean, amplitude, period_s, phase, .. } = self.signal;
        let swing = match self.signal.shape {
            SignalShape::Constant => 0.0,
            SignalShape::Square => Shape::Square.at(t / period_s + phase),
            SignalShape::Sine => Shape::Sine.at(t / period_s + phase),
            SignalShape::Triangle => Shape::Triangle.at(t / period_s + phase),
            SignalShape::FlatSine => {
                let steep = self.signal.steepness.unwrap_or(1.0) * Shape::Sine.at(t / period_s + phase);
                steep.clamp(-1.0, 1.0)
            }
            SignalShape::Ramp => {
                let done = self.signal.over_s.map_or(done, |over_s| (t / over_s).min(1.0));
                let passed = self.signal.exponent.map_or(done, |exponent| libm::pow(done, exponent));
                2.0 * passed - 1.0
            }
            SignalShape::PseudoRandom => {
                self.draws[((t / period_s).floor() as usize).min(self.draws.len() - 1)]
            }
            SignalShape::Multisine => self.harmonics(t / period_s) / self.peak,
        };
        mean + amplitude * swing
    }

    fn harmonics(&self, periods: f64) -> f64 {
        let line = |(h, phase): (usize, &f64)| Shape::Sine.at((h + 1) as f64 * periods + phase);
        self.draws.iter().enumerate().map(line).sum()
    }
}

/// How a zig-zag swings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// Between two levels.
    Square,
    /// As a sine.
    #[default]
    Sine,
    /// In straight ramps.
    Triangle,
}

impl Shape {
    /// Value at `phase` (in periods), within −1 and 1, starting upwards.
    pub fn at(self, phase: f64) -> f64 {
        let phase = phase - phase.floor();
        match self {
            Self::Square => {
                if phase < 0.5 {
                    1.0
                } else {
                    -1.0
                }
            }
            Self::Sine => libm::sin(std::f64::consts::TAU * phase),
            Self::Triangle => 1.0 - 4.0 * ((phase + 0.75) % 1.0 - 0.5).abs(),
        }
    }

    /// Amplitude of a signal whose derivative swings like this with amplitude 1 and period 1 s.
    pub(super) fn integral(self) -> f64 {
        match self {
            Self::Square => 0.25,
            Self::Sine => 1.0 / std::f64::consts::TAU,
            Self::Triangle => 0.125,
        }
    }
}
