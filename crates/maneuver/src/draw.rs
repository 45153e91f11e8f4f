//! The random numbers of one candidate, turned into a maneuver.

use rand::Rng;
use refusal::Invalid;
use ship::engine::Streams;

use super::generate_spec::{CandidateKind, GenerateSpec};
use super::signal::{Shape, Signal, SignalShape};
use super::spec::Kind;
use crate::feedback::Kept;
use crate::spec::ManeuverSpec;

/// The random numbers of one candidate.
struct Draw<'a, R> {
    pub(super) rng: R,
    pub(super) spec: &'a GenerateSpec,
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

    pub(super) fn kind(&mut self, kind: CandidateKind, index: u32) -> Kind {
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
                let [low, high] = self.spec.speeds();
                let speed = self.start(low, high);
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
        Kind::Combined { exact: false, start_m_s, speed_m_s, yaw_rate_rad_s, sway_m_s }
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
    fn change(&mut self, kind: CandidateKind) -> Kind {
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
            CandidateKind::Accelerate => Kind::Accelerate { from_m_s: slow, to_m_s: fast, hold_s: 0.0 },
            _ => Kind::Decelerate { from_m_s: fast, to_m_s: slow, hold_s: 0.0 },
        }
    }
}

// Candidates by generation: a table `[generate]` in `dictionary.toml` instead of maneuvers written by hand.

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
