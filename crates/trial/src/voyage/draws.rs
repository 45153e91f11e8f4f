//! Sampled vessels, currents and offsets: for the simulation of legs, and for the check of a plan.

use std::f64::consts::TAU;

use engine::Streams;

use super::task::Brief;
use crate::SampledVessel;

/// Number of sampled vessels on every leg, besides the nominal vessel on its node.
const SAMPLED: u32 = 32;
/// Resolution of the draws.
const STEPS: u32 = 1 << 20;

impl Brief {
    /// The sampled vessels of every leg: parameters uniform within the stated error, currents of any
    /// direction, offsets from anywhere that legs may end. Half of them begin at the edge of the tolerance,
    /// in the strongest current.
    pub(super) fn sampled_vessels(&self) -> Vec<SampledVessel> {
        (0..SAMPLED).map(|run| self.sampled_vessel(run)).collect()
    }

    fn sampled_vessel(&self, run: u32) -> SampledVessel {
        let drawn = Streams::new(self.seed, "rehearsal").choices(run, 0, STEPS, 9);
        let part = |i: usize| (f64::from(drawn[i]) + 0.5) / f64::from(STEPS);
        let extreme = run.is_multiple_of(2);
        let size = |i: usize| if extreme { 1.0 } else { part(i) };
        // From -1 to 1.
        let offset = |i: usize| match extreme {
            true => (2.0 * part(i) - 1.0).signum(),
            false => 2.0 * part(i) - 1.0,
        };
        let (towards, away) = (libm::sincos(TAU * part(0)), libm::sincos(TAU * part(1)));
        let tolerance = self.task.approach.tolerance.begun();
        let current = self.task.safety.unknown_current_m_s * size(2);
        let distance = tolerance.distance_m * size(3).sqrt();
        SampledVessel {
            parameters: self.drawn("parameter-error", run),
            current_m_s: [current * towards.1, current * towards.0],
            off: [distance * away.1, distance * away.0, tolerance.heading_rad * offset(4)],
            motion: [
                tolerance.surge_m_s * offset(5),
                tolerance.sway_m_s * offset(6),
                tolerance.yaw_rate_rad_s * offset(7),
            ],
        }
    }

    /// Parameters of run `run`, each uniform within the stated error of its nominal value.
    pub(super) fn drawn(&self, purpose: &str, run: u32) -> Vec<f64> {
        let error = self.task.safety.parameter_error;
        let off = |draw: u32| 1.0 + error * (2.0 * (f64::from(draw) + 0.5) / f64::from(STEPS) - 1.0);
        let drawn = Streams::new(self.seed, purpose).choices(run, 0, STEPS, self.vessel.nominal.len());
        self.vessel.nominal.iter().zip(drawn).map(|(p, draw)| p * off(draw)).collect()
    }

    /// A constant current of run `run`, north and east: any direction, any strength up to the bound.
    pub(super) fn current(&self, purpose: &str, run: u32) -> [f64; 2] {
        let drawn = Streams::new(self.seed, purpose).choices(run, 0, STEPS, 2);
        let part = |i: usize| (f64::from(drawn[i]) + 0.5) / f64::from(STEPS);
        let (sin, cos) = libm::sincos(TAU * part(0));
        let speed = self.task.safety.unknown_current_m_s * part(1);
        [speed * cos, speed * sin]
    }
}
