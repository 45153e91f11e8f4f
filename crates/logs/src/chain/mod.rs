//! Simulates the logs of a ship's instruments: from forces to thruster commands, thrusters with limits, a
//! ship in current and wind, sensors with noise and resolution.
//!
//! A [`Chain`] is the ship with its thrusters and sensors; [`Chain::record`] simulates one sub-experiment, a
//! [`Logbook`] all those of a [`Schedule`]. Every random number is keyed by (seed, maneuver, repeat,
//! channel), so that recordings do not depend on each other.

mod logbook;
mod recording;

pub use logbook::{Day, Entry, Fault, Logbook, NoLogs, Schedule, force_factors};
pub use recording::{Chain, Commanded, Failed, Key, Pace, Recording, Truth, advance};

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::Deserialize;
use ship::engine::{MOST_CURRENT_M_S, Streams};

use crate::{Law, Setting, Thruster};

/// A satellite receiver at the reference point.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gnss {
    /// Fixes per second; the samples per second are a multiple.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub rate_hz: f64,
    /// White noise of north and east \[m\].
    #[schemars(range(min = 0.0))]
    pub white_std_m: f64,
    /// Slow error of north and east \[m\].
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub wander_std_m: f64,
    /// Its correlation time \[s\].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub wander_time_s: Option<f64>,
    /// Step of the logged coordinates \[m\]; 0: none.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub resolution_m: f64,
}

/// A heading sensor.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Compass {
    /// White noise \[rad\].
    #[schemars(range(min = 0.0))]
    pub white_std_rad: f64,
    /// Slow error \[rad\].
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub wander_std_rad: f64,
    /// Its correlation time \[s\].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub wander_time_s: Option<f64>,
    /// Step of the logged heading \[rad\]; 0: none.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub resolution_rad: f64,
}

impl Gnss {
    /// Samples between fixes; `None` if that is not a whole number.
    pub fn every(&self, sample_rate_hz: f64) -> Option<usize> {
        let every = (sample_rate_hz / self.rate_hz).round();
        (every >= 1.0 && (every * self.rate_hz / sample_rate_hz - 1.0).abs() < 1e-9).then_some(every as usize)
    }
}

/// `value` rounded to a multiple of `resolution`; unchanged without one.
pub fn quantised(value: f64, resolution: f64) -> f64 {
    if resolution > 0.0 { (value / resolution).round() * resolution } else { value }
}

/// Density of air at 15 °C \[kg/m³\].
const AIR: f64 = 1.225;

/// The aerodynamic areas and coefficients of a ship that is symmetric fore and aft. Coefficients as in Fossen
/// (Handbook of Marine Craft Hydrodynamics and Motion Control, 8.1.3): c_x 0.5 to 0.9, c_y 0.7 to 0.95, c_n
/// 0.05 to 0.2.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hull {
    /// Frontal projected area \[m²\].
    #[schemars(range(min = 0.0), extend("x-unit" = "m²"))]
    pub frontal_area_m2: f64,
    /// Lateral projected area \[m²\].
    #[schemars(range(min = 0.0), extend("x-unit" = "m²"))]
    pub lateral_area_m2: f64,
    /// Length over all \[m\].
    #[schemars(range(min = 0.0))]
    pub length_m: f64,
    /// Coefficient of the longitudinal force \[1\].
    #[schemars(range(min = 0.0))]
    pub c_x: f64,
    /// Coefficient of the lateral force \[1\].
    #[schemars(range(min = 0.0))]
    pub c_y: f64,
    /// Coefficient of the moment \[1\].
    #[schemars(range(min = 0.0))]
    pub c_n: f64,
}

/// Wind: a mean with gusts along it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wind {
    /// Mean speed \[m/s\].
    #[schemars(range(min = 0.0, max = 100.0))]
    pub speed_m_s: f64,
    /// Direction it comes from, clockwise from north \[rad\].
    pub from_rad: f64,
    /// Standard deviation of the gusts \[m/s\].
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub gust_std_m_s: f64,
    /// Their correlation time \[s\].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub gust_time_s: Option<f64>,
}

impl Wind {
    /// Velocity of the air, north and east \[m/s\], at speed `speed_m_s`.
    pub fn velocity(&self, speed_m_s: f64) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.from_rad + PI);
        [speed_m_s * cos, speed_m_s * sin]
    }
}

impl Hull {
    /// Forward and starboard force \[N\] and moment \[N m\] when the ship moves through the air with `u`, `v`
    /// \[m/s\] (body axes).
    ///
    /// With V² = u² + v² and γ = −atan2(v, u): X = −½ρV² c_x cos γ A_F, Y = ½ρV² c_y sin γ A_L, N = ½ρV² c_n sin 2γ A_L L.
    pub fn forces(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        let pressure = 0.5 * AIR * (u * u + v * v);
        let gamma = -libm::atan2(v, u);
        [
            -pressure * self.c_x * libm::cos(gamma) * self.frontal_area_m2,
            pressure * self.c_y * libm::sin(gamma) * self.lateral_area_m2,
            pressure * self.c_n * libm::sin(2.0 * gamma) * self.lateral_area_m2 * self.length_m,
        ]
    }
}

/// Current and wind while recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Weather {
    /// The current.
    #[serde(default)]
    pub current: Drift,
    /// The wind, if it acts on the ship.
    pub wind: Option<Wind>,
}

/// A current in earth axes: a constant and a time-varying part, independent north and east.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Drift {
    /// Towards north \[m/s\].
    #[serde(default)]
    #[schemars(range(min = -MOST_CURRENT_M_S, max = MOST_CURRENT_M_S))]
    pub north_m_s: f64,
    /// Towards east \[m/s\].
    #[serde(default)]
    #[schemars(range(min = -MOST_CURRENT_M_S, max = MOST_CURRENT_M_S))]
    pub east_m_s: f64,
    /// Standard deviation of the varying part \[m/s\].
    #[serde(default)]
    #[schemars(range(min = 0.0, max = MOST_CURRENT_M_S))]
    pub std_m_s: f64,
    /// Its correlation time \[s\].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub time_s: Option<f64>,
}

/// A first-order Gauss-Markov process, x(k+1) = a x(k) + std √(1 − a²) w(k) with a = exp(−dt/time), stationary from its
/// first sample on; white where `time_s` is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussMarkov {
    /// Standard deviation.
    pub std: f64,
    /// Correlation time \[s\].
    pub time_s: f64,
}

impl GaussMarkov {
    /// `samples` samples, `dt` seconds apart, from one channel of one run.
    pub fn samples(&self, streams: &Streams, run: u32, channel: u32, samples: usize, dt: f64) -> Vec<f64> {
        let mut out = vec![0.0; samples];
        if self.std == 0.0 {
            return out;
        }
        streams.normals(run, channel, &mut out);
        let kept = if self.time_s > 0.0 { libm::exp(-dt / self.time_s) } else { 0.0 };
        let new = (1.0 - kept * kept).sqrt();
        let mut last = None;
        for value in &mut out {
            let next = last.map_or(*value, |last| kept * last + new * *value);
            last = Some(next);
            *value = self.std * next;
        }
        out
    }
}

/// An azimuth thruster with its limits and its sensors. Axes: x forward, y starboard, z down.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Actuator {
    /// Forward and to starboard of the reference point \[m\].
    pub position_m: [f64; 2],
    /// Force per speed squared \[N s²\], or per speed \[N s\].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub coefficient: f64,
    /// Force from speed.
    #[serde(default)]
    pub law: Law,
    /// Highest speed, ahead or reversed \[1/s\].
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "1/s"))]
    pub speed_limit_rps: Option<f64>,
    /// Fastest change of speed \[1/s²\].
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "1/s²"))]
    pub speed_rate_limit_rps_s: Option<f64>,
    /// Fastest turn \[rad/s\].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub angle_rate_limit_rad_s: Option<f64>,
    /// White noise of the logged speed \[1/s\].
    #[serde(default)]
    #[schemars(range(min = 0.0), extend("x-unit" = "1/s"))]
    pub speed_std_rps: f64,
    /// Step of the logged speed \[1/s\]; 0: none.
    #[serde(default)]
    #[schemars(range(min = 0.0), extend("x-unit" = "1/s"))]
    pub speed_resolution_rps: f64,
    /// White noise of the logged angle \[rad\].
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub angle_std_rad: f64,
    /// Step of the logged angle \[rad\]; 0: none.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub angle_resolution_rad: f64,
    /// Which of speed and angle are logged.
    #[serde(default)]
    pub logged: Logged,
}

/// What the log of a thruster holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Logged {
    /// What it reached, by its sensors.
    #[default]
    Setting,
    /// What it was commanded, whether or not it could follow.
    Command,
}

/// Number of samples at which a thruster could not follow its command.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hits {
    /// The speed is beyond its limit.
    pub speed: usize,
    /// The speed changes too fast.
    pub speed_rate: usize,
    /// The angle changes too fast.
    pub angle_rate: usize,
}

impl Actuator {
    /// The thruster without limits.
    pub fn thruster(&self) -> Thruster {
        Thruster { law: self.law, coefficient: self.coefficient, position_m: self.position_m }
    }

    /// The setting that it reaches `dt` seconds after `from` (`None` at the start, where it has had time)
    /// when `wanted` is commanded.
    pub fn follow(&self, from: Option<Setting>, wanted: Setting, dt: f64, hits: &mut Hits) -> Setting {
        let n = within(0.0, wanted.n, self.speed_limit_rps, &mut hits.speed);
        let Some(from) = from else { return Setting { n, ..wanted } };
        let step = |rate: Option<f64>| rate.map(|rate| rate * dt);
        Setting {
            n: within(from.n, n, step(self.speed_rate_limit_rps_s), &mut hits.speed_rate),
            alpha: within(from.alpha, wanted.alpha, step(self.angle_rate_limit_rad_s), &mut hits.angle_rate),
        }
    }
}

/// `wanted`, or the nearest setting that `most` from `centre` allows: then a hit is counted.
fn within(centre: f64, wanted: f64, most: Option<f64>, hits: &mut usize) -> f64 {
    match most.filter(|most| (wanted - centre).abs() > most * (1.0 + 1e-12)) {
        Some(most) => {
            *hits += 1;
            centre + most.copysign(wanted - centre)
        }
        None => wanted,
    }
}
