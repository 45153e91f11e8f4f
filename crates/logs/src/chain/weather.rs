use refusal::Invalid;
use schemars::JsonSchema;
use serde::Deserialize;
use ship::engine::{Streams, check_currents};

use super::{Wind, above_zero, from_zero};

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
    pub north_m_s: f64,
    /// Towards east \[m/s\].
    #[serde(default)]
    pub east_m_s: f64,
    /// Standard deviation of the varying part \[m/s\].
    #[serde(default)]
    pub std_m_s: f64,
    /// Its correlation time \[s\].
    pub time_s: Option<f64>,
}

impl Weather {
    /// Refuses numbers without meaning.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self) -> Result<(), Invalid> {
        let drift = &self.current;
        check_currents([
            ("current.north_m_s", drift.north_m_s),
            ("current.east_m_s", drift.east_m_s),
            ("current.std_m_s", drift.std_m_s),
        ])?;
        from_zero([("current.std_m_s", drift.std_m_s)])?;
        above_zero([("current.time_s", drift.time_s.unwrap_or(1.0))])?;
        self.wind.map_or(Ok(()), |wind| wind.check())
    }
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
