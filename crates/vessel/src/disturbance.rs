use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;

use crate::{Invalid, LANES, Lane, Streams};

/// A current in body axes.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Current {
    /// Still water.
    None,
    /// New independent surge and sway components at every sample.
    White {
        /// Standard deviation of each component \[m/s\].
        std_m_s: f64,
    },
}

/// White measurement noise.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measurement {
    /// Standard deviation of the measured surge speed \[m/s\].
    pub std_u_m_s: f64,
    /// Standard deviation of the measured sway speed \[m/s\].
    pub std_v_m_s: f64,
    /// Standard deviation of the measured yaw rate \[rad/s\].
    pub std_r_rad_s: f64,
}

/// What disturbs a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbances {
    /// Acts on the vessel through the relative velocity.
    pub current: Current,
    /// Is added to the measured states.
    pub measurement: Measurement,
}

/// Channels of the random streams: measurement noise of u, v, r, then the current's components.
const CURRENT_CHANNEL: u32 = 3;

impl Disturbances {
    /// Refuses standard deviations that are negative or not finite.
    ///
    /// # Errors
    /// Names the key and its value.
    pub fn check(&self) -> Result<(), Invalid> {
        let m = self.measurement;
        let current = match self.current {
            Current::None => 0.0,
            Current::White { std_m_s } => std_m_s,
        };
        let all = [
            ("current.std_m_s", current),
            ("measurement.std_u_m_s", m.std_u_m_s),
            ("measurement.std_v_m_s", m.std_v_m_s),
            ("measurement.std_r_rad_s", m.std_r_rad_s),
        ];
        match all.into_iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
            None => Ok(()),
            Some((key, value)) => Err(Invalid::new(
                format!("`{key}`"),
                value.to_string(),
                "a standard deviation, zero or more",
                "correct it",
            )),
        }
    }

    /// The current of [`LANES`] runs over `samples` samples, samples × 2; empty in still water.
    pub fn current(&self, streams: &Streams, runs: [u32; LANES], samples: usize) -> Vec<Lane> {
        match self.current {
            Current::None => Vec::new(),
            Current::White { std_m_s } => {
                let mut out = vec![Lane::ZERO; 2 * samples];
                add_noise(streams, runs, CURRENT_CHANNEL, &[std_m_s; 2], &mut out);
                out
            }
        }
    }

    /// Adds measurement noise to the states of [`LANES`] runs, rows × 3.
    pub fn measure(&self, streams: &Streams, runs: [u32; LANES], states: &mut [Lane]) {
        let m = self.measurement;
        add_noise(streams, runs, 0, &[m.std_u_m_s, m.std_v_m_s, m.std_r_rad_s], states);
    }
}

/// Rows that stay in the processor's nearest cache while all lanes write to them.
const ROWS: usize = 64;

/// Adds white noise of standard deviation `std[i]` to column i of row-major `out`; column i draws from channel
/// `first + i` of each lane's run.
fn add_noise(streams: &Streams, runs: [u32; LANES], first: u32, std: &[f64], out: &mut [Lane]) {
    let width = std.len();
    for (column, std) in std.iter().enumerate().filter(|(_, std)| **std > 0.0) {
        let mut sources = runs.map(|run| streams.channel(run, first + column as u32));
        for rows in out.chunks_mut(ROWS * width) {
            for (lane, source) in sources.iter_mut().enumerate() {
                for row in rows.chunks_exact_mut(width) {
                    let draw: f64 = StandardNormal.sample(source);
                    row[column][lane] += std * draw;
                }
            }
        }
    }
}
