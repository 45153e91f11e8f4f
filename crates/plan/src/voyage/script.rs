//! A plan as a script for any vessel, in any current.

use refusal::Invalid;
use ship::engine::{Pose, Ship, Streams};

use super::prepared::Prepared;
use crate::{Autopilot, End, Leg, Passing, Sailed, simulate_legs};

/// Legs from their nodes (north, east), in order.
pub(super) struct Script<'a> {
    pub prepared: &'a Prepared,
    pub legs: Vec<([f64; 2], &'a Leg)>,
    pub start: Pose,
    pub speed_m_s: f64,
}

/// The noise of a vessel's sensors, and of the changes of current and wind.
#[derive(Clone, Copy)]
pub(super) struct Noise {
    /// What it is simulated for.
    pub kind: &'static str,
    /// In which round.
    pub round: u32,
    /// Its number.
    pub run: u32,
}

impl Noise {
    fn streams(&self, seed: u64, of: &str) -> Streams {
        Streams::new(seed, &format!("{}-{of}-{}", self.kind, self.round))
    }
}

impl Script<'_> {
    /// Simulates a vessel with `parameters` in the known current and `unknown` (north, east); calls `record`
    /// with every sample. Without `noise` sensors are exact, and current and wind do not change.
    pub(super) fn simulate(
        &self,
        parameters: &[f64],
        unknown: [f64; 2],
        noise: Option<Noise>,
        record: impl FnMut(Passing),
    ) -> Result<Vec<End>, Invalid> {
        let Prepared { brief, pieces, mirror, .. } = self.prepared;
        let mut ship = self.ship(parameters, unknown, noise);
        let mut autopilot = Autopilot::new(&brief.vessel, &brief.vessel.nominal, brief.task.handling);
        if let Some(noise) = noise {
            let streams = noise.streams(brief.seed, "sensors");
            autopilot = autopilot.with_sensors(brief.task.sensors, streams, noise.run);
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
    /// until it returns false. `noise` as in [`Self::simulate`].
    pub(super) fn repeat(
        &self,
        nominal: &Sailed,
        parameters: &[f64],
        unknown: [f64; 2],
        noise: Option<Noise>,
        mut record: impl FnMut(Passing) -> bool,
    ) {
        let mut ship = self.ship(parameters, unknown, noise);
        for sample in &nominal.samples {
            let (pose, state, inputs) = (ship.pose, ship.state, &sample.inputs[..]);
            if !record(Passing { leg: sample.leg, informative: sample.informative, pose, state, inputs }) {
                return;
            }
            ship.step(inputs);
        }
    }

    fn ship<'s>(&'s self, parameters: &[f64], unknown: [f64; 2], noise: Option<Noise>) -> Ship<'s> {
        let brief = &self.prepared.brief;
        let mut ship = Ship::new(&brief.vessel, parameters, self.start, self.speed_m_s);
        ship.current_m_s = [0, 1].map(|d| brief.task.known_current_m_s[d] + unknown[d]);
        ship.changing = noise.and_then(|noise| {
            let streams = noise.streams(brief.seed, "changes");
            brief.task.changes.of_run(streams, noise.run, brief.vessel.sample_rate_hz)
        });
        ship
    }
}
