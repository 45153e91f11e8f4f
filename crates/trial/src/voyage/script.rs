//! A plan as a script that any vessel can carry out, in any current.

use vessel::{Invalid, Pose};

use super::prepared::Prepared;
use crate::{Autopilot, Leg, Sailed, Sample, Ship, sail};

/// What is sailed: legs from their nodes (north, east), in order.
pub(super) struct Script<'a> {
    pub prepared: &'a Prepared,
    pub legs: Vec<([f64; 2], &'a Leg)>,
    pub start: Pose,
    pub speed_m_s: f64,
}

impl Script<'_> {
    /// Carried out by a vessel with `parameters` in the known current and `unknown` (north, east).
    pub(super) fn sail(&self, parameters: &[f64], unknown: [f64; 2]) -> Result<Sailed, Invalid> {
        let Prepared { brief, pieces, mirror, .. } = self.prepared;
        let mut ship = self.ship(parameters, unknown);
        let mut autopilot = Autopilot::new(&brief.vessel, &brief.vessel.nominal, brief.task.handling);
        autopilot.known_current_m_s = brief.task.known_current_m_s;
        sail(self.legs.iter().copied(), pieces, mirror, &mut ship, &mut autopilot)
    }

    /// The inputs of a track, sample by sample, without corrections.
    pub(super) fn repeat(&self, nominal: &Sailed, parameters: &[f64], unknown: [f64; 2]) -> Sailed {
        let mut ship = self.ship(parameters, unknown);
        let mut sailed = Sailed { samples: Vec::with_capacity(nominal.samples.len()), ends: Vec::new() };
        for sample in &nominal.samples {
            sailed.samples.push(Sample { pose: ship.pose, state: ship.state, ..sample.clone() });
            ship.step(&sample.inputs);
        }
        sailed
    }

    fn ship<'s>(&'s self, parameters: &[f64], unknown: [f64; 2]) -> Ship<'s> {
        let brief = &self.prepared.brief;
        let mut ship = Ship::new(&brief.vessel, parameters, self.start, self.speed_m_s);
        ship.current_m_s = [0, 1].map(|d| brief.task.known_current_m_s[d] + unknown[d]);
        ship
    }
}
