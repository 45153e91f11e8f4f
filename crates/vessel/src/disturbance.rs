use serde::Deserialize;

use crate::normals::Normals;
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
                add_noise(streams, runs, CURRENT_CHANNEL, [std_m_s; 2], &mut out);
                out
            }
        }
    }

    /// Adds measurement noise to the states of [`LANES`] runs, rows × 3.
    pub fn measure(&self, streams: &Streams, runs: [u32; LANES], states: &mut [Lane]) {
        let m = self.measurement;
        add_noise(streams, runs, 0, [m.std_u_m_s, m.std_v_m_s, m.std_r_rad_s], states);
    }
}

/// Adds white noise of standard deviation `std[i]` to column i of row-major `out`; column i draws from channel
/// `first + i` of each lane's run.
fn add_noise<const WIDTH: usize>(
    streams: &Streams,
    runs: [u32; LANES],
    first: u32,
    std: [f64; WIDTH],
    out: &mut [Lane],
) {
    let normals = streams.lanes(runs, first);
    pulp::Arch::new().dispatch(AddNoise { normals, std: std.map(Lane::splat), out });
}

/// [`add_noise`] compiled for every instruction set that pulp picks from.
struct AddNoise<'a, const WIDTH: usize> {
    normals: [Normals; WIDTH],
    std: [Lane; WIDTH],
    out: &'a mut [Lane],
}

impl<const WIDTH: usize> pulp::WithSimd for AddNoise<'_, WIDTH> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) {
        let mut pairs = self.out.chunks_exact_mut(2 * WIDTH);
        for rows in &mut pairs {
            for (column, normals) in self.normals.iter_mut().enumerate() {
                let [one, two] = normals.pair();
                rows[column] += self.std[column] * one;
                rows[WIDTH + column] += self.std[column] * two;
            }
        }
        let last = pairs.into_remainder().iter_mut();
        for ((entry, normals), std) in last.zip(&mut self.normals).zip(self.std) {
            *entry += std * normals.pair()[0];
        }
    }
}
