//! Where legs fit on the chart.

use chart::{Footprint, Obstacles, Raster};
use rayon::prelude::*;

use super::chart_layers::invalid;
use super::moves::{Rehearsed, footprint};
use super::trial::{Trial, VoyageFiles};
use crate::failure::Failure;

/// How near a node is to obstacles, in classes that cost 0, 1, 2, 3.
pub(super) const CLEARANCE_CLASSES: usize = 4;

/// The chart as legs see it.
pub(super) struct Waters {
    /// Raster cells per lattice cell.
    pub per_cell: usize,
    /// Where each leg's footprint may be: index into `obstacles`.
    pub layer_of_leg: Vec<usize>,
    pub obstacles: Vec<Obstacles>,
    pub footprints: Vec<Footprint>,
    pub cell_m: f64,
    /// Distance of the node (i, j) to the nearest obstacle \[m\].
    pub node_distance_m: Vec<f64>,
    pub nx: usize,
}

impl Waters {
    /// Whether leg `index` may start at node (i, j).
    pub(super) fn fits(&self, index: usize, i: usize, j: usize) -> bool {
        let at = |n: usize| n * self.per_cell + self.per_cell / 2;
        self.obstacles[self.layer_of_leg[index]].is_free(&self.footprints[index], at(i), at(j))
    }

    /// Obstacles of informative maneuvers, with the widest margin.
    pub(super) fn deepest(&self, rehearsed: &[Rehearsed]) -> &Obstacles {
        let blocked = |index: &usize| {
            self.obstacles[self.layer_of_leg[*index]].blocked().iter().filter(|b| **b).count()
        };
        let informative = (0..rehearsed.len()).filter(|index| rehearsed[*index].is_informative());
        let widest = informative.max_by_key(blocked).unwrap_or(0);
        &self.obstacles[self.layer_of_leg[widest]]
    }

    /// The clearance class of a node: 0 far from obstacles, 3 near.
    pub(super) fn class(&self, i: usize, j: usize) -> usize {
        let cells = self.node_distance_m[j * self.nx + i] / self.cell_m;
        (CLEARANCE_CLASSES - 1).saturating_sub(cells.max(0.0) as usize)
    }
}

impl Trial {
    /// The raster that chart and footprints are compared on: whole cells of the lattice.
    pub(super) fn raster(&self) -> Raster {
        let cell_m = self.config.cell_m / self.config.raster_per_cell as f64;
        let corner = self.grid.origin_m.map(|o| o - self.config.cell_m / 2.0);
        let count = |n: usize| n * self.config.raster_per_cell;
        Raster { origin: corner, cell_m, nx: count(self.grid.nx), ny: count(self.grid.ny) }
    }

    /// Clearance to keep for the drift of an unknown current while a leg's maneuver is run open loop.
    pub(super) fn drift_margin_m(&self, own: &Rehearsed) -> f64 {
        let open = own.sailed.samples.iter().filter(|s| s.informative).count() as f64;
        self.config.safety.unknown_current_m_s * open / self.vessel.sample_rate_hz
    }

    /// Footprints of all legs, and the obstacles that each of them has to keep clear of.
    pub(super) fn waters(&self, files: &VoyageFiles) -> Result<Waters, Failure> {
        let raster = self.raster();
        let hull = self.config.hull.outline();
        let refuse = |e: chart::Invalid| invalid(files.config, &e);
        let footprints: Vec<Footprint> = self
            .rehearsed
            .par_iter()
            .map(|own| footprint(&hull, own, raster.cell_m))
            .collect::<Result<_, _>>()
            .map_err(refuse)?;
        let safety = &self.config.safety;
        // One set of obstacles per depth and margin, margins in whole raster cells.
        let mut kinds: Vec<(f64, f64)> = Vec::new();
        let mut layer_of_leg = Vec::new();
        for own in &self.rehearsed {
            let margin =
                ((safety.margin_m + self.drift_margin_m(own)) / raster.cell_m).ceil() * raster.cell_m;
            let kind = match own.is_informative() {
                true => (safety.trial_depth_m, margin),
                false => (safety.transit_depth_m, safety.margin_m),
            };
            let known = kinds.iter().position(|k| *k == kind);
            layer_of_leg.push(known.unwrap_or_else(|| {
                kinds.push(kind);
                kinds.len() - 1
            }));
        }
        let obstacles: Vec<Obstacles> = kinds
            .par_iter()
            .map(|(depth, margin)| Obstacles::new(&self.chart, raster, *depth, *margin))
            .collect::<Result<_, _>>()
            .map_err(refuse)?;
        let node = |k: usize| {
            let at = self.grid.pose(k % self.grid.nx, k / self.grid.nx, 0);
            obstacles[0].distance_m(at.y, at.x)
        };
        Ok(Waters {
            per_cell: self.config.raster_per_cell,
            layer_of_leg,
            node_distance_m: (0..self.grid.nx * self.grid.ny).map(node).collect(),
            obstacles,
            footprints,
            cell_m: self.config.cell_m,
            nx: self.grid.nx,
        })
    }

    /// Refuses a pose whose hull is not clear, and says where the nearest clear node is.
    pub(super) fn check_water(
        &self,
        files: &VoyageFiles,
        waters: &Waters,
        what: &str,
        pose: lattice::Pose,
    ) -> Result<(), Failure> {
        let (level, _) = self.grid.level_and_mode(pose.layer);
        let still = (0.0, 0.0, self.grid.heading_rad(level));
        let raster = self.raster();
        let hull = Footprint::swept(&self.config.hull.outline(), &[still], raster.cell_m)
            .map_err(|e| invalid(files.config, &e))?;
        let transit = self.rehearsed.iter().position(|own| !own.is_informative()).unwrap_or(0);
        let obstacles = &waters.obstacles[waters.layer_of_leg[transit]];
        let at = |n: usize| n * waters.per_cell + waters.per_cell / 2;
        if obstacles.is_free(&hull, at(pose.i), at(pose.j)) {
            return Ok(());
        }
        let nodes = (0..self.grid.nx).flat_map(|i| (0..self.grid.ny).map(move |j| (i, j)));
        let away = |(i, j): (usize, usize)| {
            let (di, dj) = (i.abs_diff(pose.i) as f64, j.abs_diff(pose.j) as f64);
            di.hypot(dj) * self.grid.cell_m
        };
        let free = nodes.filter(|(i, j)| obstacles.is_free(&hull, at(*i), at(*j)));
        let nearest = free.min_by(|a, b| away(*a).total_cmp(&away(*b)));
        let places = self.places(files);
        let remedy = match nearest {
            Some((i, j)) => {
                let near = places.words(lattice::Pose { i, j, ..pose });
                format!("the nearest clear node is {:.0} m away, {near}", away((i, j)))
            }
            None => "no node of the lattice is clear: check depths, margin and the chart's kind".to_owned(),
        };
        let own = self.grid.pose(pose.i, pose.j, level);
        let gap = obstacles.distance_m(own.y, own.x);
        let found = format!("{}, {gap:.0} m from an obstacle", places.words(pose));
        let expected = format!("the hull at least {} m clear of obstacles", self.config.safety.margin_m);
        Err(Failure::NoAnswer(format!(
            "{}: `{what}`: found {found}, expected {expected}; {remedy}",
            files.config.display()
        )))
    }
}
