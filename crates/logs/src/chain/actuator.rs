use refusal::Invalid;
use schemars::JsonSchema;
use serde::Deserialize;

use super::{above_zero, finite, from_zero};
use crate::{Law, Setting, Thruster};

/// An azimuth thruster with its limits and its sensors. Axes: x forward, y starboard, z down.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Actuator {
    /// Forward and to starboard of the reference point \[m\].
    pub position_m: [f64; 2],
    /// Force per speed squared \[N s²\], or per speed \[N s\].
    pub coefficient: f64,
    /// Force from speed.
    #[serde(default)]
    pub law: Law,
    /// Highest speed, ahead or reversed \[1/s\].
    pub speed_limit_rps: Option<f64>,
    /// Fastest change of speed \[1/s²\].
    pub speed_rate_limit_rps_s: Option<f64>,
    /// Fastest turn \[rad/s\].
    pub angle_rate_limit_rad_s: Option<f64>,
    /// White noise of the logged speed \[1/s\].
    #[serde(default)]
    pub speed_std_rps: f64,
    /// Step of the logged speed \[1/s\]; 0: none.
    #[serde(default)]
    pub speed_resolution_rps: f64,
    /// White noise of the logged angle \[rad\].
    #[serde(default)]
    pub angle_std_rad: f64,
    /// Step of the logged angle \[rad\]; 0: none.
    #[serde(default)]
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

    /// Refuses numbers without meaning.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self) -> Result<(), Invalid> {
        let given = |limit: Option<f64>| limit.unwrap_or(1.0);
        above_zero([
            ("thruster.coefficient", self.coefficient),
            ("thruster.speed_limit_rps", given(self.speed_limit_rps)),
            ("thruster.speed_rate_limit_rps_s", given(self.speed_rate_limit_rps_s)),
            ("thruster.angle_rate_limit_rad_s", given(self.angle_rate_limit_rad_s)),
        ])?;
        let numbers = [
            ("thruster.speed_std_rps", self.speed_std_rps),
            ("thruster.speed_resolution_rps", self.speed_resolution_rps),
            ("thruster.angle_std_rad", self.angle_std_rad),
            ("thruster.angle_resolution_rad", self.angle_resolution_rad),
        ];
        from_zero(numbers)?;
        finite(self.position_m.map(|metres| ("thruster.position_m", metres)))
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
