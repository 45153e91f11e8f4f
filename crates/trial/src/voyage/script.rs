//! A plan as a script for any vessel, in any current.

use engine::{Pose, Ship, Streams};
use refusal::Invalid;

use super::prepared::Prepared;
use crate::{Autopilot, End, Leg, Passing, Sailed, simulate_legs};

/// Legs from their nodes (north, east), in order.
pub(super) struct Script<'a> {
    pub prepared: &'a Prepared,
    pub legs: Vec<([f64; 2], &'a Leg)>,
    pub start: Pose,
    pub speed_m_s: f64,
}

impl Script<'_> {
    /// Simulates a vessel with `parameters` in the known current and `unknown` (north, east); calls `record`
    /// with every sample. `noise` of its sensors: the purpose of the streams and the run; without it they are exact.
    pub(super) fn simulate(
        &self,
        parameters: &[f64],
        unknown: [f64; 2],
        noise: Option<(&str, u32)>,
        record: impl FnMut(Passing),
    ) -> Result<Vec<End>, Invalid> {
        let Prepared { brief, pieces, mirror, .. } = self.prepared;
        let mut ship = self.ship(parameters, unknown);
        let mut autopilot = Autopilot::new(&brief.vessel, &brief.vessel.nominal, brief.task.handling);
        if let Some((purpose, run)) = noise {
            autopilot = autopilot.with_sensors(brief.task.sensors, Streams::new(brief.seed, purpose), run);
        }
        autopilot.known_current_m_s = brief.task.known_current_m_s;
        let mirror = mirror.as_deref().unwrap_or_default();
        Ok(simulate_legs(self.legs.iter().copied(), pieces, mirror, &mut ship, &mut autopilot, record)?)
    }

    /// The trajectory of a vessel with `parameters`.
    pub(super) fn simulated(&self, parameters: &[f64], unknown: [f64; 2]) -> Result<Sailed, Invalid> {
        let mut samples = Vec::new();
        let ends = self.simulate(parameters, unknown, None, |passing| samples.push(passing.into()))?;
        Ok(Sailed { samples, ends })
    }

    /// Repeats the inputs of a track, sample by sample, without corrections: calls `record` with every sample
    /// until it returns false.
    pub(super) fn repeat(
        &self,
        nominal: &Sailed,
        parameters: &[f64],
        unknown: [f64; 2],
        mut record: impl FnMut(Passing) -> bool,
    ) {
        let mut ship = self.ship(parameters, unknown);
        for sample in &nominal.samples {
            let (pose, state, inputs) = (ship.pose, ship.state, &sample.inputs[..]);
            if !record(Passing { leg: sample.leg, informative: sample.informative, pose, state, inputs }) {
                return;
            }
            ship.step(inputs);
        }
    }

    fn ship<'s>(&'s self, parameters: &[f64], unknown: [f64; 2]) -> Ship<'s> {
        let brief = &self.prepared.brief;
        let mut ship = Ship::new(&brief.vessel, parameters, self.start, self.speed_m_s);
        ship.current_m_s = [0, 1].map(|d| brief.task.known_current_m_s[d] + unknown[d]);
        ship
    }
}
