//! The simulated legs of a plan, and the moves of its maneuvers.

use std::collections::BTreeMap;

use crate::lattice::Step;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::places::compass_deg;
use super::prepared::Prepared;
use super::sailed_plan::SailedPlan;
use super::settled_legs::SettledLeg;
use crate::{Sample, Side};

/// One step at sea, as simulated.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VoyageLeg {
    /// Action, and side of a maneuver.
    pub name: String,
    /// Whether it is an informative maneuver.
    pub informative: bool,
    /// Which way, for an informative maneuver.
    pub side: Option<Side>,
    /// When it begins \[s\].
    pub start_s: f64,
    /// How long it takes \[s\].
    pub duration_s: f64,
    /// When its maneuver begins \[s\]; after the steady approach.
    pub maneuver_start_s: Option<f64>,
    /// How long the maneuver takes \[s\].
    pub maneuver_s: Option<f64>,
    /// Longitude of its first node.
    pub longitude_deg: f64,
    /// Latitude of its first node.
    pub latitude_deg: f64,
    /// True heading at its first node.
    pub heading_deg: f64,
    /// Speed at its first node \[m/s\].
    pub speed_m_s: f64,
    /// Distance from the end node when it is over \[m\].
    pub end_error_m: f64,
    /// Largest modulus of every input, in its unit.
    pub largest_inputs: BTreeMap<String, f64>,
}

/// A maneuver as a move of the lattice.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Primitive {
    /// Name of the maneuver.
    pub maneuver: String,
    /// Which way.
    pub side: Side,
    /// Heading level at its start.
    pub h: u64,
    /// Displacement in nodes, east.
    pub di: i64,
    /// Displacement in nodes, north.
    pub dj: i64,
    /// Heading level at its end.
    pub to_h: u64,
    /// The maneuver \[s\].
    pub maneuver_s: f64,
    /// With approach and recovery \[s\].
    pub leg_s: f64,
    /// Distance from the node at its end, under the nominal model \[m\].
    pub residual_m: f64,
    /// Difference from the level's heading at its end \[deg\].
    pub residual_deg: f64,
    /// Largest distance from the nominal vessel of those who rehearsed it, before the recovery \[m\].
    pub spread_m: f64,
    /// Nodes of the lattice at which it fits on the chart.
    pub fits: u64,
}

impl SailedPlan<'_> {
    /// One per step.
    pub fn legs(&self) -> Vec<VoyageLeg> {
        let mut rest = &self.sailing.sailed.samples[..];
        let mut start = 0;
        let mut document = |(index, step): (usize, &Step)| {
            let own;
            (own, rest) = rest.split_at(rest.iter().take_while(|s| s.leg == index).count());
            start += own.len();
            self.leg(index, step, start - own.len(), own)
        };
        self.solved.solution.steps.iter().enumerate().map(&mut document).collect()
    }

    /// Leg `index` with its `samples`, the first of which has index `start`.
    fn leg(&self, index: usize, step: &Step, start: usize, samples: &[Sample]) -> VoyageLeg {
        let Prepared { brief, chart, grid, .. } = self.prepared;
        let rate_hz = brief.vessel.sample_rate_hz;
        let leg = &self.prepared.legs[self.sailing.legs[index]];
        let (level, mode) = grid.level_and_mode(step.from.layer);
        let at = grid.pose(step.from.i, step.from.j, level);
        let (longitude_deg, latitude_deg) = chart.plane().to_geographic([at.y, at.x]);
        let to = self.prepared.node(step.to);
        let off = |pose: ship::engine::Pose| libm::hypot(pose.x - to[0], pose.y - to[1]);
        let open = samples.iter().position(|s| s.informative);
        let largest = |i: usize| samples.iter().map(|s| s.inputs[i].abs()).fold(0.0, f64::max);
        let model = &brief.vessel.model;
        let inputs = model.variables[3..3 + model.inputs].iter().enumerate();
        VoyageLeg {
            name: leg.name.clone(),
            informative: leg.is_informative(),
            side: leg.leg.purpose.side(),
            start_s: start as f64 / rate_hz,
            duration_s: samples.len() as f64 / rate_hz,
            maneuver_start_s: open.map(|k| (start + k) as f64 / rate_hz),
            maneuver_s: open.map(|_| samples.iter().filter(|s| s.informative).count() as f64 / rate_hz),
            longitude_deg,
            latitude_deg,
            heading_deg: self.prepared.true_deg(at),
            speed_m_s: grid.modes[mode].speed_m_s,
            end_error_m: self.sailing.sailed.ends.get(index).map_or(0.0, |(end, _)| off(*end)),
            largest_inputs: inputs.map(|(i, v)| (v.name.clone(), largest(i))).collect(),
        }
    }

    /// One per informative leg.
    pub fn primitives(&self) -> Vec<Primitive> {
        let legs = self.prepared.legs.iter().enumerate();
        legs.filter_map(|(index, own)| self.primitive(index, own)).collect()
    }

    fn primitive(&self, index: usize, settled_leg: &SettledLeg) -> Option<Primitive> {
        let grid = &self.prepared.grid;
        let rate_hz = self.prepared.brief.vessel.sample_rate_hz;
        let [north, east] = grid.displacement(settled_leg.leg.di, settled_leg.leg.dj);
        let (from, _) = grid.level_and_mode(settled_leg.leg.from);
        let (to, _) = grid.level_and_mode(settled_leg.leg.to);
        let turned = compass_deg(settled_leg.end.psi - grid.heading_rad(to));
        Some(Primitive {
            maneuver: settled_leg.name.clone(),
            side: settled_leg.leg.purpose.side()?,
            h: from as u64,
            di: i64::from(settled_leg.leg.di),
            dj: i64::from(settled_leg.leg.dj),
            to_h: to as u64,
            maneuver_s: settled_leg.maneuver() as f64 / rate_hz,
            leg_s: settled_leg.seconds(rate_hz),
            residual_m: libm::hypot(settled_leg.end.x - north, settled_leg.end.y - east),
            residual_deg: if turned > 180.0 { turned - 360.0 } else { turned },
            spread_m: settled_leg.spread_m(),
            fits: self.solved.waters.fits_at(index) as u64,
        })
    }
}
