//! Kinds of maneuvers, and the motion that each is.

use refusal::strictly;
use schemars::JsonSchema;
use serde::Deserialize;
use ship::engine::Streams;

use crate::signal::{Shape, Signal, Wave};
use crate::standard::{PullOut, ReverseSpiral, SpiralTest, Standard, Stop, TurningCircle, ZigZagTest};
use crate::steady::Motion;

/// A kind of maneuver with its parameters. Speeds are surge speeds unless stated otherwise.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(clippy::large_enum_variant)] // A dictionary has only dozens of these.
pub enum ManeuverKind {
    /// The thrust for `to_m_s`, set at the speed `from_m_s`.
    Accelerate {
        /// Speed at the start \[m/s\].
        from_m_s: f64,
        /// Steady speed of the thrust that is set \[m/s\].
        to_m_s: f64,
        /// How long the speed at the start is held first \[s\].
        #[serde(default)]
        hold_s: f64,
    },
    /// The same towards a lower speed.
    Decelerate {
        /// Speed at the start \[m/s\].
        from_m_s: f64,
        /// Steady speed of the thrust that is set \[m/s\].
        to_m_s: f64,
        /// How long the speed at the start is held first \[s\].
        #[serde(default)]
        hold_s: f64,
    },
    /// The yaw rate swings about zero.
    ZigZag {
        /// How it swings.
        #[serde(default)]
        shape: Shape,
        /// Speed \[m/s\].
        speed_m_s: f64,
        /// Amplitude of the yaw rate \[rad/s\]; this or `heading_amplitude_rad`.
        yaw_rate_amplitude_rad_s: Option<f64>,
        /// Amplitude of the heading \[rad\].
        heading_amplitude_rad: Option<f64>,
        /// Amplitude of the sway speed, outwards of the turn \[m/s\]; by default the drift of the turn.
        sway_amplitude_m_s: Option<f64>,
        /// Period \[s\].
        period_s: f64,
    },
    /// The sway speed swings about zero, heading kept.
    SwayZigZag {
        /// How it swings.
        #[serde(default)]
        shape: Shape,
        /// Surge speed \[m/s\].
        #[serde(default)]
        speed_m_s: f64,
        /// Amplitude of the sway speed \[m/s\].
        sway_amplitude_m_s: f64,
        /// Period \[s\].
        period_s: f64,
    },
    /// The yaw rate is swept evenly over the maneuver.
    Spiral {
        /// Speed \[m/s\].
        speed_m_s: f64,
        /// Yaw rate at the start \[rad/s\].
        #[serde(default)]
        yaw_rate_from_rad_s: f64,
        /// Yaw rate at the end \[rad/s\].
        yaw_rate_to_rad_s: f64,
        /// Sway speed \[m/s\]; by default the drift of the turn.
        sway_speed_m_s: Option<f64>,
    },
    /// A turning circle, approached straight ahead.
    SteadyTurn {
        /// Speed \[m/s\].
        speed_m_s: f64,
        /// Yaw rate \[rad/s\].
        yaw_rate_rad_s: f64,
        /// Sway speed \[m/s\]; by default the drift of the turn.
        sway_speed_m_s: Option<f64>,
    },
    /// Speed, yaw rate and sway speed each switch at random between two levels.
    PseudoRandomBinary {
        /// Mean speed \[m/s\].
        speed_m_s: f64,
        /// The speed is above or below its mean by this much \[m/s\].
        #[serde(default)]
        speed_amplitude_m_s: f64,
        /// The yaw rate is plus or minus this \[rad/s\].
        #[serde(default)]
        yaw_rate_amplitude_rad_s: f64,
        /// The sway speed is plus or minus this \[m/s\]; by default the drift of the turn.
        sway_amplitude_m_s: Option<f64>,
        /// Shortest time at a level \[s\].
        dwell_s: f64,
        /// Seed of the sequence.
        #[serde(default)]
        seed: u64,
    },
    /// Speed, yaw rate and sway speed each follow a signal of their own.
    Combined {
        /// Whether the inputs make the model follow the signals from sample to sample, from the start on.
        /// Otherwise inputs hold the motion of each sample steady, and the ship lags behind.
        #[serde(default)]
        exact: bool,
        /// Surge speed at the start \[m/s\]; by default that of the signal.
        start_m_s: Option<f64>,
        /// Surge speed \[m/s\].
        #[serde(deserialize_with = "strictly")]
        speed_m_s: Signal,
        /// Yaw rate \[rad/s\]; zero by default.
        #[serde(default, deserialize_with = "strictly")]
        yaw_rate_rad_s: Option<Signal>,
        /// Sway speed \[m/s\]; by default the drift of the turn.
        #[serde(default, deserialize_with = "strictly")]
        sway_m_s: Option<Signal>,
    },
    /// Inputs from a file.
    Inputs {
        /// Name of the table with a column per input, and a row per sample or with its time in a column `t` \[s\].
        file: String,
        /// Whether the table's rows are at other times than the samples, so that inputs are interpolated
        /// linearly.
        #[serde(default)]
        resample: bool,
        /// Speed at the start \[m/s\].
        #[serde(default)]
        speed_m_s: f64,
    },
    /// A zig-zag test δ/ψ.
    ZigZagTest(ZigZagTest),
    /// A turning circle.
    TurningCircle(TurningCircle),
    /// A pull-out.
    PullOut(PullOut),
    /// Dieudonné's direct spiral.
    SpiralTest(SpiralTest),
    /// A reverse spiral.
    ReverseSpiral(ReverseSpiral),
    /// A crash stop or an inertial stop.
    Stop(Stop),
}

impl ManeuverKind {
    /// The standard maneuver that it is, if it is one.
    pub fn standard(&self) -> Option<Standard<'_>> {
        match self {
            Self::ZigZagTest(test) => Some(Standard::ZigZagTest(test)),
            Self::TurningCircle(turn) => Some(Standard::TurningCircle(turn)),
            Self::PullOut(turn) => Some(Standard::PullOut(turn)),
            Self::SpiralTest(spiral) => Some(Standard::SpiralTest(spiral)),
            Self::ReverseSpiral(spiral) => Some(Standard::ReverseSpiral(spiral)),
            Self::Stop(stop) => Some(Standard::Stop(stop)),
            _ => None,
        }
    }

    /// Whether its beginning does not depend on its length.
    pub(super) fn is_unstretched(&self) -> bool {
        match *self {
            Self::Spiral { .. } => false,
            Self::Combined { speed_m_s, yaw_rate_rad_s, sway_m_s, .. } => {
                let signals = [Some(speed_m_s), yaw_rate_rad_s, sway_m_s];
                !signals.iter().flatten().any(Signal::is_stretched)
            }
            _ => true,
        }
    }

    /// Its numbers with their keys, where given.
    pub(super) fn numbers(&self) -> Vec<(&'static str, f64)> {
        // An absent optional number counts as 0.
        macro_rules! keyed {
            ($($key:ident),+) => { vec![$((stringify!($key), Option::from($key).unwrap_or(0.0))),+] };
        }
        match *self {
            Self::Accelerate { from_m_s, to_m_s, .. } | Self::Decelerate { from_m_s, to_m_s, .. } => {
                keyed![from_m_s, to_m_s]
            }
            Self::ZigZag {
                speed_m_s,
                yaw_rate_amplitude_rad_s,
                heading_amplitude_rad,
                sway_amplitude_m_s,
                ..
            } => keyed![speed_m_s, yaw_rate_amplitude_rad_s, heading_amplitude_rad, sway_amplitude_m_s],
            Self::SwayZigZag { speed_m_s, sway_amplitude_m_s, .. } => keyed![speed_m_s, sway_amplitude_m_s],
            Self::Spiral { speed_m_s, yaw_rate_from_rad_s, yaw_rate_to_rad_s, sway_speed_m_s } => {
                keyed![speed_m_s, yaw_rate_from_rad_s, yaw_rate_to_rad_s, sway_speed_m_s]
            }
            Self::SteadyTurn { speed_m_s, yaw_rate_rad_s, sway_speed_m_s } => {
                keyed![speed_m_s, yaw_rate_rad_s, sway_speed_m_s]
            }
            Self::PseudoRandomBinary {
                speed_m_s,
                speed_amplitude_m_s,
                yaw_rate_amplitude_rad_s,
                sway_amplitude_m_s,
                ..
            } => keyed![speed_m_s, speed_amplitude_m_s, yaw_rate_amplitude_rad_s, sway_amplitude_m_s],
            Self::Combined { start_m_s, .. } => {
                let numbers =
                    |(key, s): (&'static str, Signal)| [s.mean, s.amplitude, s.phase].map(|x| (key, x));
                let signals = self.signals().into_iter().flat_map(numbers);
                signals.chain(start_m_s.map(|start| ("start_m_s", start))).collect()
            }
            Self::Inputs { speed_m_s, .. } => keyed![speed_m_s],
            _ => self.standard().map_or(Vec::new(), |standard| standard.numbers()),
        }
    }

    /// The signals of a combined maneuver with their keys.
    pub(crate) fn signals(&self) -> Vec<(&'static str, Signal)> {
        let Self::Combined { speed_m_s, yaw_rate_rad_s, sway_m_s, .. } = *self else { return Vec::new() };
        let others = [("yaw_rate_rad_s", yaw_rate_rad_s), ("sway_m_s", sway_m_s)];
        let others = others.into_iter().filter_map(|(key, signal)| signal.map(|signal| (key, signal)));
        [("speed_m_s", speed_m_s)].into_iter().chain(others).collect()
    }

    /// Whether the sway speed is left to the drift of the turn.
    pub(super) fn sway_is_free(&self) -> bool {
        match self {
            Self::ZigZag { sway_amplitude_m_s: sway, .. }
            | Self::Spiral { sway_speed_m_s: sway, .. }
            | Self::SteadyTurn { sway_speed_m_s: sway, .. }
            | Self::PseudoRandomBinary { sway_amplitude_m_s: sway, .. } => sway.is_none(),
            Self::Combined { sway_m_s, .. } => sway_m_s.is_none(),
            Self::SwayZigZag { .. } => false,
            _ => true,
        }
    }

    /// Removes commanded sway, so that only the drift of the turn remains. A swing of the sway speed alone is kept.
    pub(super) fn release_sway(&mut self) {
        match self {
            Self::ZigZag { sway_amplitude_m_s: sway, .. }
            | Self::Spiral { sway_speed_m_s: sway, .. }
            | Self::SteadyTurn { sway_speed_m_s: sway, .. }
            | Self::PseudoRandomBinary { sway_amplitude_m_s: sway, .. } => *sway = None,
            Self::Combined { sway_m_s, .. } => *sway_m_s = None,
            _ => {}
        }
    }

    /// Amplitude of the yaw rate of a zig-zag \[rad/s\].
    fn yaw_rate_amplitude(shape: Shape, rate: Option<f64>, heading: Option<f64>, period_s: f64) -> f64 {
        rate.or(heading.map(|h| h / (shape.integral() * period_s))).unwrap_or(0.0)
    }
}

/// The wanted motion, sample by sample.
pub(crate) struct Plan<'a> {
    kind: &'a ManeuverKind,
    rate_hz: f64,
    samples: usize,
    signs: [Vec<f64>; 3],
    /// Speed, yaw rate and sway speed of a combined maneuver.
    waves: [Option<Wave>; 3],
}

impl<'a> Plan<'a> {
    pub(crate) fn new(kind: &'a ManeuverKind, rate_hz: f64, samples: usize) -> Self {
        let signs = match kind {
            ManeuverKind::PseudoRandomBinary { dwell_s, seed, .. } => {
                let dwells = ((samples as f64 / (dwell_s * rate_hz)).floor() as usize).min(samples) + 1;
                let streams = Streams::new(*seed, "pseudo-random-binary");
                [0, 1, 2].map(|c| {
                    streams.choices(0, c, 2, dwells).iter().map(|b| 2.0 * f64::from(*b) - 1.0).collect()
                })
            }
            _ => [const { Vec::new() }; 3],
        };
        let duration_s = samples as f64 / rate_hz;
        let waves = match *kind {
            ManeuverKind::Combined { speed_m_s, yaw_rate_rad_s, sway_m_s, .. } => {
                let mut channel = 0;
                [Some(speed_m_s), yaw_rate_rad_s, sway_m_s].map(|signal| {
                    channel += 1;
                    signal.map(|signal| Wave::new(signal, channel, duration_s))
                })
            }
            _ => [const { None }; 3],
        };
        Self { kind, rate_hz, samples, signs, waves }
    }

    fn start_speed(&self) -> f64 {
        match *self.kind {
            ManeuverKind::Accelerate { from_m_s, .. } | ManeuverKind::Decelerate { from_m_s, .. } => from_m_s,
            ManeuverKind::ZigZag { speed_m_s, .. }
            | ManeuverKind::SwayZigZag { speed_m_s, .. }
            | ManeuverKind::Spiral { speed_m_s, .. }
            | ManeuverKind::SteadyTurn { speed_m_s, .. }
            | ManeuverKind::PseudoRandomBinary { speed_m_s, .. }
            | ManeuverKind::Inputs { speed_m_s, .. } => speed_m_s,
            ManeuverKind::Combined { start_m_s, .. } => start_m_s.unwrap_or_else(|| self.motion(0).u),
            _ => self.kind.standard().map_or(0.0, |standard| standard.speed_m_s()),
        }
    }

    /// State at the start: u, v \[m/s\], r \[rad/s\].
    pub(crate) fn start(&self) -> [f64; 3] {
        if !self.exact() {
            return [self.start_speed(), 0.0, 0.0];
        }
        let Motion { u, v, r } = self.motion(0);
        [u, v.unwrap_or(0.0), r]
    }

    /// Whether each motion leads to the next.
    fn exact(&self) -> bool {
        matches!(self.kind, ManeuverKind::Combined { exact: true, .. })
    }

    /// The state's increment until the next sample: zero where a steady motion is held.
    pub(crate) fn gain(&self, k: usize) -> [f64; 3] {
        if !self.exact() {
            return [0.0; 3];
        }
        let (now, next) = (self.motion(k), self.motion(k + 1));
        [next.u - now.u, next.v.unwrap_or(0.0) - now.v.unwrap_or(0.0), next.r - now.r]
    }

    pub(crate) fn motion(&self, k: usize) -> Motion {
        let t = k as f64 / self.rate_hz;
        match *self.kind {
            ManeuverKind::Accelerate { from_m_s: from, to_m_s: to, hold_s }
            | ManeuverKind::Decelerate { from_m_s: from, to_m_s: to, hold_s } => {
                Motion { u: if t < hold_s { from } else { to }, v: None, r: 0.0 }
            }
            ManeuverKind::ZigZag {
                shape,
                speed_m_s: u,
                yaw_rate_amplitude_rad_s: rate,
                heading_amplitude_rad: heading,
                sway_amplitude_m_s: sway,
                period_s,
            } => {
                let swing = shape.at(t / period_s);
                let amplitude = ManeuverKind::yaw_rate_amplitude(shape, rate, heading, period_s);
                Motion { u, v: sway.map(|v| -v * swing), r: amplitude * swing }
            }
            ManeuverKind::SwayZigZag { shape, speed_m_s: u, sway_amplitude_m_s, period_s } => {
                Motion { u, v: Some(sway_amplitude_m_s * shape.at(t / period_s)), r: 0.0 }
            }
            ManeuverKind::Spiral {
                speed_m_s: u,
                yaw_rate_from_rad_s: from,
                yaw_rate_to_rad_s: to,
                sway_speed_m_s: v,
            } => Motion { u, v, r: from + (to - from) * (k as f64 + 0.5) / self.samples as f64 },
            ManeuverKind::SteadyTurn { speed_m_s: u, yaw_rate_rad_s: r, sway_speed_m_s: v } => {
                Motion { u, v, r }
            }
            ManeuverKind::PseudoRandomBinary {
                speed_m_s,
                speed_amplitude_m_s,
                yaw_rate_amplitude_rad_s,
                sway_amplitude_m_s,
                dwell_s,
                ..
            } => {
                let dwell = (t / dwell_s).floor() as usize;
                let sign = |c: usize| self.signs[c][dwell.min(self.signs[c].len() - 1)];
                Motion {
                    u: speed_m_s + speed_amplitude_m_s * sign(0),
                    v: sway_amplitude_m_s.map(|v| v * sign(1)),
                    r: yaw_rate_amplitude_rad_s * sign(2),
                }
            }
            ManeuverKind::Combined { exact, .. } => {
                // Inputs hold the motion halfway between two samples; an exact motion is that at the sample.
                let done = (k as f64 + if exact { 0.0 } else { 0.5 }) / self.samples as f64;
                let [u, r, v] = self.waves.each_ref().map(|wave| wave.as_ref().map(|wave| wave.at(t, done)));
                Motion { u: u.unwrap_or(0.0), v, r: r.unwrap_or(0.0) }
            }
            ManeuverKind::Inputs { speed_m_s: u, .. } => Motion { u, v: None, r: 0.0 },
            _ => Motion { u: self.start_speed(), v: None, r: 0.0 },
        }
    }
}
