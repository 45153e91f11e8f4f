//! The parts of `plan.json` that tell legs and moves.

use lattice::Solution;
use trial::{Leg, Purpose, Sailed};

use super::moves::Rehearsed;
use super::places::compass_deg;
use super::trial::Trial;
use super::waters::Waters;
use study::documents::{PlanLattice, Primitive, VoyageLeg};

impl Trial {
    /// The lattice.
    pub(super) fn lattice_document(&self) -> PlanLattice {
        let (longitude_deg, latitude_deg) = self.chart.plane().to_geographic(self.grid.origin_m);
        PlanLattice {
            nx: self.grid.nx as u64,
            ny: self.grid.ny as u64,
            headings: self.grid.headings as u64,
            cell_m: self.grid.cell_m,
            longitude_deg,
            latitude_deg,
            modes: self.grid.modes.iter().map(|m| (m.name.clone(), m.speed_m_s)).collect(),
        }
    }

    /// One per step, as sailed.
    pub(super) fn leg_documents(
        &self,
        solution: &Solution,
        legs: &[usize],
        sailed: &Sailed,
    ) -> Vec<VoyageLeg> {
        let rate = self.vessel.sample_rate_hz;
        let mut start = 0;
        let mut documents = Vec::with_capacity(legs.len());
        for (index, (step, leg)) in solution.steps.iter().zip(legs).enumerate() {
            let own = &self.rehearsed[*leg];
            let samples: Vec<&trial::Sample> =
                sailed.samples[start..].iter().take_while(|s| s.leg == index).collect();
            let (level, mode) = self.grid.level_and_mode(step.from.layer);
            let at = self.grid.pose(step.from.i, step.from.j, level);
            let (longitude_deg, latitude_deg) = self.chart.plane().to_geographic([at.y, at.x]);
            let to = self.node(step.to);
            let open = samples.iter().position(|s| s.informative);
            let largest = |i: usize| samples.iter().map(|s| s.inputs[i].abs()).fold(0.0, f64::max);
            let inputs = self.vessel.model.variables[3..3 + self.vessel.model.inputs].iter().enumerate();
            documents.push(VoyageLeg {
                name: own.name.clone(),
                informative: own.is_informative(),
                side: side(&own.leg),
                start_s: start as f64 / rate,
                duration_s: samples.len() as f64 / rate,
                maneuver_start_s: open.map(|k| (start + k) as f64 / rate),
                maneuver_s: open.map(|_| samples.iter().filter(|s| s.informative).count() as f64 / rate),
                longitude_deg,
                latitude_deg,
                heading_deg: compass_deg(at.psi),
                speed_m_s: self.grid.modes[mode].speed_m_s,
                end_error_m: sailed
                    .ends
                    .get(index)
                    .map_or(0.0, |(end, _)| (end.x - to[0]).hypot(end.y - to[1])),
                largest_inputs: inputs.map(|(i, v)| (v.name.clone(), largest(i))).collect(),
            });
            start += samples.len();
        }
        documents
    }

    /// One per informative leg.
    pub(super) fn primitives(&self, waters: &Waters) -> Vec<Primitive> {
        let rate = self.vessel.sample_rate_hz;
        let informative = self.rehearsed.iter().enumerate().filter(|(_, own)| own.is_informative());
        let document = |(index, own): (usize, &Rehearsed)| {
            let [north, east] = self.grid.displacement(own.leg.di, own.leg.dj);
            let (from, _) = self.grid.level_and_mode(own.leg.from);
            let (to, _) = self.grid.level_and_mode(own.leg.to);
            let turned = compass_deg(own.end.psi - self.grid.heading_rad(to));
            let nodes = (0..self.grid.nx).flat_map(|i| (0..self.grid.ny).map(move |j| (i, j)));
            Primitive {
                maneuver: own.name.clone(),
                side: side(&own.leg).unwrap_or_default(),
                h: from as u64,
                di: i64::from(own.leg.di),
                dj: i64::from(own.leg.dj),
                to_h: to as u64,
                maneuver_s: own.sailed.samples.iter().filter(|s| s.informative).count() as f64 / rate,
                leg_s: own.seconds(rate),
                residual_m: (own.end.x - north).hypot(own.end.y - east),
                residual_deg: if turned > 180.0 { turned - 360.0 } else { turned },
                drift_margin_m: self.drift_margin_m(own),
                fits: nodes.filter(|(i, j)| waters.fits(index, *i, *j)).count() as u64,
            }
        };
        informative.map(document).collect()
    }
}

fn side(leg: &Leg) -> Option<String> {
    match leg.purpose {
        Purpose::Informative { mirrored: true, .. } => Some("mirrored".into()),
        Purpose::Informative { mirrored: false, .. } => Some("as designed".into()),
        Purpose::Basic(_) => None,
    }
}
