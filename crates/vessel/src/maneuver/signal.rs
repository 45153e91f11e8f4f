//! Signals that a combined maneuver asks of speed, sway speed and yaw rate.

use rand::Rng;
use serde::Deserialize;

use super::shape::Shape;
use crate::{Invalid, Streams};

/// What one speed does over a combined maneuver, in the unit of the key that it stands under.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Signal {
    /// How it moves.
    #[serde(default)]
    pub shape: SignalShape,
    /// Middle of its range.
    #[serde(default)]
    pub mean: f64,
    /// Half of its range; a negative one starts downwards.
    #[serde(default)]
    pub amplitude: f64,
    /// Period; of a pseudo-random signal the shortest time at a level, of a multisine the longest period \[s\].
    #[serde(default)]
    pub period_s: f64,
    /// Where a square, sine or triangle starts, in periods.
    #[serde(default)]
    pub phase: f64,
    /// Seed of a pseudo-random signal's levels and of a multisine's phases.
    #[serde(default)]
    pub seed: u64,
}

/// How a signal moves within its range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SignalShape {
    /// It stays at the mean.
    #[default]
    Constant,
    /// Between two levels.
    Square,
    /// As a sine.
    Sine,
    /// In straight ramps up and down.
    Triangle,
    /// Once through the range, evenly over the maneuver.
    Ramp,
    /// Between two levels at random.
    PseudoRandom,
    /// A sum of [`LINES`] harmonics with random phases.
    Multisine,
}

/// Harmonics of a multisine.
pub const LINES: usize = 5;

impl Signal {
    /// Whether `period_s` counts.
    pub(crate) fn has_period(&self) -> bool {
        self.least_samples().is_some()
    }

    /// Samples that `period_s` has to last at least, where it counts.
    pub(super) fn least_samples(&self) -> Option<usize> {
        match self.shape {
            SignalShape::Constant | SignalShape::Ramp => None,
            SignalShape::Square | SignalShape::Sine | SignalShape::Triangle => Some(SWING_SAMPLES),
            SignalShape::PseudoRandom => Some(1),
            SignalShape::Multisine => Some(MULTISINE_SAMPLES),
        }
    }
}

/// Fewest samples of a period: two to either side. With the two of Nyquist's bound a square may be sampled where it jumps and a
/// sine at its zeros, and nothing is left of them.
pub(super) const SWING_SAMPLES: usize = 4;

/// Fewest samples of a multisine's longest period: its fastest harmonic then stays below Nyquist's bound.
pub(super) const MULTISINE_SAMPLES: usize = 2 * LINES + 1;

/// Refuses a period of fewer samples than `least`.
pub(super) fn check_period(thing: String, period_s: f64, least: usize, rate_hz: f64) -> Result<(), Invalid> {
    // Whole samples are often not quite so many in binary fractions.
    if period_s * rate_hz >= least as f64 * (1.0 - 1e-9) {
        return Ok(());
    }
    let samples = if least == 1 { "sample" } else { "samples" };
    let expected = format!("at least {} s: {least} {samples} at {rate_hz} Hz", least as f64 / rate_hz);
    Err(Invalid::new(thing, format!("{period_s} s"), expected, "lengthen it"))
}

/// A signal ready to be read sample by sample.
#[derive(Clone, Debug)]
pub(crate) struct Wave {
    signal: Signal,
    /// Levels (±1) of a pseudo-random signal, phases (in periods) of a multisine.
    draws: Vec<f64>,
    /// Largest modulus of the sum of a multisine's harmonics.
    peak: f64,
}

impl Wave {
    /// `channel` keeps the random numbers of a maneuver's signals apart.
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

    /// At `t` seconds, of a maneuver of which `done` (0 to 1) is over.
    pub(crate) fn at(&self, t: f64, done: f64) -> f64 {
        let Signal { mean, amplitude, period_s, phase, .. } = self.signal;
        let swing = match self.signal.shape {
            SignalShape::Constant => 0.0,
            SignalShape::Square => Shape::Square.at(t / period_s + phase),
            SignalShape::Sine => Shape::Sine.at(t / period_s + phase),
            SignalShape::Triangle => Shape::Triangle.at(t / period_s + phase),
            SignalShape::Ramp => 2.0 * done - 1.0,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_every_signal_stays_in_its_range_and_all_but_a_constant_use_it() {
        use SignalShape::*;
        for shape in [Constant, Square, Sine, Triangle, Ramp, PseudoRandom, Multisine] {
            let signal = Signal { shape, mean: 0.3, amplitude: 0.2, period_s: 4.0, phase: 0.1, seed: 3 };
            let wave = Wave::new(signal, 1, 40.0);
            let values: Vec<f64> =
                (0..400).map(|k| wave.at(f64::from(k) / 10.0, f64::from(k) / 400.0)).collect();
            let low = values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            assert!(low >= 0.1 - 1e-3 && high <= 0.5 + 1e-3, "{shape:?}: {low} {high}");
            let used = if shape == Constant { 0.0 } else { 0.26 };
            assert!(high - low >= used, "{shape:?}: {low} {high}");
        }
    }

    #[test]
    fn signals_of_one_seed_move_apart_in_different_channels() {
        let signal = Signal {
            shape: SignalShape::PseudoRandom,
            mean: 0.0,
            amplitude: 1.0,
            period_s: 1.0,
            phase: 0.0,
            seed: 3,
        };
        let levels = |channel: u32| -> Vec<f64> {
            let wave = Wave::new(signal, channel, 30.0);
            (0..30).map(|k| wave.at(f64::from(k), 0.0)).collect()
        };
        assert_eq!(levels(0), levels(0));
        assert_ne!(levels(0), levels(1));
    }
}
