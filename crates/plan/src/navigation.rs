use ship::engine::{NormalRows, Pose, Ship, Streams};

use crate::grid::wrap;

/// Standard deviations of a ship's measurements, independent from sample to sample; 0 if exact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensors {
    /// Position, north and east each \[m\].
    pub position_m: f64,
    /// Heading \[rad\].
    pub heading_rad: f64,
    /// u and v \[m/s\].
    pub speed_m_s: f64,
    /// r \[rad/s\].
    pub yaw_rate_rad_s: f64,
}

/// A ship's position and motion: true, measured or estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fixed {
    /// Position and heading.
    pub pose: Pose,
    /// u, v \[m/s\], r \[rad/s\].
    pub state: [f64; 3],
}

/// Quantities that are measured: position, heading, u, v, r.
const MEASURED: usize = 6;

/// Measures a ship, and estimates where it is from noisy measurements and what its model predicts: an observer with
/// constant gains. Exact quantities are taken as measured.
#[derive(Clone, Debug)]
pub struct Navigation {
    sensors: Sensors,
    /// The fraction of a difference from the prediction that is believed, where a quantity is noisy.
    gain: f64,
    noise: NormalRows<MEASURED>,
    /// The prediction for the next sample.
    predicted: Option<Fixed>,
}

impl From<&Ship<'_>> for Fixed {
    fn from(ship: &Ship) -> Self {
        Self { pose: ship.pose, state: ship.state }
    }
}

impl Sensors {
    /// Whether everything is measured exactly.
    pub fn are_exact(&self) -> bool {
        *self == Self::default()
    }

    fn deviations(&self) -> [f64; MEASURED] {
        let Self { position_m, heading_rad, speed_m_s, yaw_rate_rad_s } = *self;
        [position_m, position_m, heading_rad, speed_m_s, speed_m_s, yaw_rate_rad_s]
    }
}

impl Navigation {
    /// Of run `run` of `streams`, smoothing over `memory` samples; `None` for exact sensors.
    pub fn new(sensors: Sensors, memory: f64, streams: Streams, run: u32) -> Option<Self> {
        let gain = 1.0 / memory.max(1.0);
        let noise = NormalRows::new(streams, run);
        (!sensors.are_exact()).then_some(Self { sensors, gain, noise, predicted: None })
    }

    /// The standard deviations that remain after smoothing: σ √(K / (2 − K)) for a gain of K.
    pub fn smoothed(&self) -> Sensors {
        let part = (self.gain / (2.0 - self.gain)).sqrt();
        let Sensors { position_m, heading_rad, speed_m_s, yaw_rate_rad_s } = self.sensors;
        Sensors {
            position_m: part * position_m,
            heading_rad: part * heading_rad,
            speed_m_s: part * speed_m_s,
            yaw_rate_rad_s: part * yaw_rate_rad_s,
        }
    }

    /// The fraction of what an estimate of u, v, r gains on its prediction that may count as a lasting error of the model:
    /// with as much as the gain K both estimates are still damped, by K / 2 at the frequency K.
    pub fn most_believed(&self) -> [f64; 3] {
        let Sensors { speed_m_s, yaw_rate_rad_s, .. } = self.sensors;
        [speed_m_s, speed_m_s, yaw_rate_rad_s].map(|noise| if noise > 0.0 { self.gain } else { 1.0 })
    }

    /// The estimate of a ship that is `truly` there, from its next measurement.
    pub fn estimate(&mut self, truly: Fixed) -> Fixed {
        let deviations = self.sensors.deviations();
        let noise = self.noise.next().unwrap_or_default();
        let measured: [f64; MEASURED] = std::array::from_fn(|i| deviations[i] * noise[i]);
        let numbers = |of: &Fixed| {
            let [u, v, r] = of.state;
            [of.pose.x, of.pose.y, of.pose.psi, u, v, r]
        };
        let (truth, predicted) = (numbers(&truly), numbers(&self.predicted.unwrap_or(truly)));
        let own = |i: usize| {
            let off = truth[i] + measured[i] - predicted[i];
            let off = if i == 2 { wrap(off) } else { off };
            predicted[i] + if deviations[i] > 0.0 { self.gain * off } else { off }
        };
        let [x, y, psi, u, v, r] = std::array::from_fn(own);
        Fixed { pose: Pose { x, y, psi }, state: [u, v, r] }
    }

    /// Predicts the next sample from an estimate of this one, and the motion that a model predicts.
    pub fn predict(&mut self, from: Fixed, state: [f64; 3], sample_s: f64) {
        let (Pose { x, y, psi }, [u, v, r]) = (from.pose, from.state);
        let (sin, cos) = libm::sincos(psi);
        let [north, east] = [u * cos - v * sin, u * sin + v * cos].map(|speed| speed * sample_s);
        let pose = Pose { x: x + north, y: y + east, psi: psi + r * sample_s };
        self.predicted = Some(Fixed { pose, state });
    }

    /// Forgets the prediction: the ship is put elsewhere.
    pub fn restart(&mut self) {
        self.predicted = None;
    }
}
