use refusal::Invalid;
use schemars::JsonSchema;
use serde::Deserialize;

use super::{above_zero, from_zero};

/// A satellite receiver at the reference point.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gnss {
    /// Fixes per second; the samples per second are a multiple.
    pub rate_hz: f64,
    /// White noise of north and east \[m\].
    pub white_std_m: f64,
    /// Slow error of north and east \[m\].
    #[serde(default)]
    pub wander_std_m: f64,
    /// Its correlation time \[s\].
    pub wander_time_s: Option<f64>,
    /// Step of the logged coordinates \[m\]; 0: none.
    #[serde(default)]
    pub resolution_m: f64,
}

/// A heading sensor.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Compass {
    /// White noise \[rad\].
    pub white_std_rad: f64,
    /// Slow error \[rad\].
    #[serde(default)]
    pub wander_std_rad: f64,
    /// Its correlation time \[s\].
    pub wander_time_s: Option<f64>,
    /// Step of the logged heading \[rad\]; 0: none.
    #[serde(default)]
    pub resolution_rad: f64,
}

impl Gnss {
    /// Refuses numbers without meaning.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self) -> Result<(), Invalid> {
        above_zero([
            ("gnss.rate_hz", self.rate_hz),
            ("gnss.wander_time_s", self.wander_time_s.unwrap_or(1.0)),
        ])?;
        let numbers = [
            ("gnss.white_std_m", self.white_std_m),
            ("gnss.wander_std_m", self.wander_std_m),
            ("gnss.resolution_m", self.resolution_m),
        ];
        from_zero(numbers)
    }

    /// Samples between fixes; `None` if that is not a whole number.
    pub fn every(&self, sample_rate_hz: f64) -> Option<usize> {
        let every = (sample_rate_hz / self.rate_hz).round();
        (every >= 1.0 && (every * self.rate_hz / sample_rate_hz - 1.0).abs() < 1e-9).then_some(every as usize)
    }
}

impl Compass {
    /// Refuses numbers without meaning.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self) -> Result<(), Invalid> {
        above_zero([("heading.wander_time_s", self.wander_time_s.unwrap_or(1.0))])?;
        let numbers = [
            ("heading.white_std_rad", self.white_std_rad),
            ("heading.wander_std_rad", self.wander_std_rad),
            ("heading.resolution_rad", self.resolution_rad),
        ];
        from_zero(numbers)
    }
}

/// `value` rounded to a multiple of `resolution`; unchanged without one.
pub fn quantised(value: f64, resolution: f64) -> f64 {
    if resolution > 0.0 { (value / resolution).round() * resolution } else { value }
}
