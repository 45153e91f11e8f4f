//! Sampled vessels, currents and offsets: for the simulation of legs, and for the check of a plan.

use std::f64::consts::TAU;

use ship::engine::Streams;

use super::task::Brief;
use crate::SampledVessel;
use crate::deviations::Doubt;

/// Number of sampled vessels on every leg, besides the nominal vessel on its node.
const SAMPLED: u32 = 32;
/// Resolution of the draws.
const STEPS: u32 = 1 << 20;

impl Brief {
    /// The vessels and currents that legs and plans have to hold for.
    pub(crate) fn doubt(&self) -> Doubt<'_> {
        Doubt {
            nominal: &self.vessel.nominal,
            deviations: &self.task.deviations,
            current_m_s: self.task.safety.unknown_current_m_s,
        }
    }

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

    /// Parameters of run `run`: uniform within the stated errors of the nominal ones.
    pub(super) fn drawn(&self, purpose: &str, run: u32) -> Vec<f64> {
        let (streams, count) = (Streams::new(self.seed, purpose), self.vessel.nominal.len());
        let drawn = streams.choices(run, 0, STEPS, count);
        let uniform: Vec<f64> =
            drawn.iter().map(|draw| 2.0 * (f64::from(*draw) + 0.5) / f64::from(STEPS) - 1.0).collect();
        let mut normal = vec![0.0; count];
        streams.normals(run, 1, &mut normal);
        let deviations = &self.task.deviations;
        deviations.parameters(&self.vessel.nominal, &deviations.drawn(&uniform, &normal))
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
