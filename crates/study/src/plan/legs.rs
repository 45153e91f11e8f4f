//! The parts of `plan.json` that tell lattice, legs and moves.

use lattice::Step;
use trial::Sample;
use trial::voyage::{Prepared, Rehearsed, Sailing, Solved, compass_deg};

use crate::documents::{DroppedMove, PlanLattice, Primitive, VoyageLeg};

/// Whose legs they are.
pub(super) struct Legs<'a> {
    pub prepared: &'a Prepared,
    pub solved: &'a Solved,
    pub sailing: &'a Sailing,
}

impl Legs<'_> {
    /// The lattice.
    pub(super) fn lattice(&self) -> PlanLattice {
        let grid = &self.prepared.grid;
        let (longitude_deg, latitude_deg) = self.prepared.chart.plane().to_geographic(grid.origin_m);
        PlanLattice {
            nx: grid.nx as u64,
            ny: grid.ny as u64,
            headings: grid.headings as u64,
            cell_m: grid.cell_m,
            longitude_deg,
            latitude_deg,
            modes: grid.modes.iter().map(|m| (m.name.clone(), m.speed_m_s)).collect(),
        }
    }

    /// One per step, as sailed.
    pub(super) fn as_sailed(&self) -> Vec<VoyageLeg> {
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

    /// Leg `index` with its `samples`, the first of which is sample `start` of all.
    fn leg(&self, index: usize, step: &Step, start: usize, samples: &[Sample]) -> VoyageLeg {
        let Prepared { brief, chart, grid, .. } = self.prepared;
        let rate_hz = brief.vessel.sample_rate_hz;
        let own = &self.prepared.rehearsed[self.sailing.legs[index]];
        let (level, mode) = grid.level_and_mode(step.from.layer);
        let at = grid.pose(step.from.i, step.from.j, level);
        let (longitude_deg, latitude_deg) = chart.plane().to_geographic([at.y, at.x]);
        let to = self.prepared.node(step.to);
        let off = |pose: engine::Pose| libm::hypot(pose.x - to[0], pose.y - to[1]);
        let open = samples.iter().position(|s| s.informative);
        let largest = |i: usize| samples.iter().map(|s| s.inputs[i].abs()).fold(0.0, f64::max);
        let model = &brief.vessel.model;
        let inputs = model.variables[3..3 + model.inputs].iter().enumerate();
        VoyageLeg {
            name: own.name.clone(),
            informative: own.is_informative(),
            side: own.leg.purpose.side(),
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
    pub(super) fn primitives(&self) -> Vec<Primitive> {
        let legs = self.prepared.rehearsed.iter().enumerate();
        legs.filter_map(|(index, own)| self.primitive(index, own)).collect()
    }

    /// What is not offered to the search.
    pub(super) fn dropped(&self) -> Vec<DroppedMove> {
        let grid = &self.prepared.grid;
        let dropped = self.prepared.dropped.iter().map(|own| {
            let (level, mode) = grid.level_and_mode(own.from);
            let (name, mode, why) = (own.name.clone(), grid.modes[mode].name.clone(), own.why.clone());
            DroppedMove { name, side: own.side, h: level as u64, mode, why }
        });
        dropped.collect()
    }

    fn primitive(&self, index: usize, own: &Rehearsed) -> Option<Primitive> {
        let grid = &self.prepared.grid;
        let rate_hz = self.prepared.brief.vessel.sample_rate_hz;
        let [north, east] = grid.displacement(own.leg.di, own.leg.dj);
        let (from, _) = grid.level_and_mode(own.leg.from);
        let (to, _) = grid.level_and_mode(own.leg.to);
        let turned = compass_deg(own.end.psi - grid.heading_rad(to));
        Some(Primitive {
            maneuver: own.name.clone(),
            side: own.leg.purpose.side()?,
            h: from as u64,
            di: i64::from(own.leg.di),
            dj: i64::from(own.leg.dj),
            to_h: to as u64,
            maneuver_s: own.open_loop() as f64 / rate_hz,
            leg_s: own.seconds(rate_hz),
            residual_m: libm::hypot(own.end.x - north, own.end.y - east),
            residual_deg: if turned > 180.0 { turned - 360.0 } else { turned },
            spread_m: own.spread_m,
            fits: self.solved.waters.fits_at(index) as u64,
        })
    }
}
