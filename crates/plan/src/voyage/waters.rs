//! Where legs fit on the chart.

use std::sync::Arc;

use chart::{Class, Distances, Footprint, Mask, Obstacles, Polygon, Traffic};
use rayon::prelude::*;
use refusal::Invalid;

use super::error::VoyageError;
use super::prepared::Prepared;
use super::settled_legs::SettledLeg;
use super::task::Secondary;
use crate::lattice::Pose;

/// Number of classes of nearness to obstacles, which cost 0, 1, 2, 3.
pub(super) const CLEARANCE_CLASSES: usize = 4;

/// The obstacles for legs.
#[derive(Clone, Debug)]
pub struct Waters {
    /// Raster cells per lattice cell.
    per_cell: usize,
    /// The obstacles of each leg: index into `obstacles`.
    layer_of_leg: Vec<usize>,
    /// One per depth and margin.
    obstacles: Vec<Obstacles>,
    /// The area, if that is not the whole raster.
    area: Option<Mask>,
    /// The area of each speed limit.
    limits: Vec<Mask>,
    /// Speed limits that each leg exceeds: indices into `limits`.
    exceeded: Vec<Vec<usize>>,
    /// Where the traffic has each direction.
    traffic: Vec<Mask>,
    /// Of each leg what the nominal hull sweeps on courses that a direction does not admit: indices into `traffic`.
    against: Vec<Vec<(usize, Footprint)>>,
    /// Every leg, with its footprint.
    legs: Vec<Arc<SettledLeg>>,
    /// Pitch of the lattice \[m\].
    cell_m: f64,
    /// Distance of the node (i, j) to the nearest obstacle \[m\], at j · nx + i; empty if no cost needs it.
    node_distance_m: Vec<f64>,
    nx: usize,
    ny: usize,
}

impl Waters {
    /// Whether leg `index` may start at node (i, j).
    pub fn fits(&self, index: usize, i: usize, j: usize) -> bool {
        self.fits_among(index, &self.obstacles[self.layer_of_leg[index]], [i, j])
            && self.is_with_traffic(index, i, j)
    }

    /// Whether leg `index` from node (i, j) exceeds no speed limit.
    fn is_slow(&self, index: usize, i: usize, j: usize) -> bool {
        let footprint = &self.legs[index].footprint;
        let is_slow = |limit: &usize| self.limits[*limit].is_free(footprint, self.cell(i), self.cell(j));
        self.exceeded[index].iter().all(is_slow)
    }

    /// Whether the traffic's directions admit leg `index` from node (i, j).
    fn is_with_traffic(&self, index: usize, i: usize, j: usize) -> bool {
        let is_with = |(traffic, swept): &(usize, Footprint)| {
            self.traffic[*traffic].is_free(swept, self.cell(i), self.cell(j))
        };
        self.against[index].iter().all(is_with)
    }

    /// Whether leg `index` may start at a node among some obstacles, regardless of the traffic.
    fn fits_among(&self, index: usize, obstacles: &Obstacles, [i, j]: [usize; 2]) -> bool {
        self.is_free_among(obstacles, &self.legs[index].footprint, i, j) && self.is_slow(index, i, j)
    }

    /// The number of nodes at which leg `index` may start among other obstacles, with or without regard to the traffic.
    pub(super) fn count_among(&self, index: usize, obstacles: &Obstacles, with_traffic: bool) -> usize {
        let fits = |(i, j): &(usize, usize)| {
            self.fits_among(index, obstacles, [*i, *j])
                && (!with_traffic || self.is_with_traffic(index, *i, *j))
        };
        nodes(self.nx, self.ny).filter(fits).count()
    }

    /// Column or row of the raster's cell north-east of the node in column or row `n`.
    fn cell(&self, n: usize) -> usize {
        n * self.per_cell + self.per_cell / 2
    }

    /// The number of nodes at which leg `index` may start.
    pub fn fits_at(&self, index: usize) -> usize {
        nodes(self.nx, self.ny).filter(|(i, j)| self.fits(index, *i, *j)).count()
    }

    fn is_free(&self, layer: usize, footprint: &Footprint, i: usize, j: usize) -> bool {
        self.is_free_among(&self.obstacles[layer], footprint, i, j)
    }

    fn is_free_among(&self, obstacles: &Obstacles, footprint: &Footprint, i: usize, j: usize) -> bool {
        let at = [self.cell(i), self.cell(j)];
        let in_area = self.area.as_ref().is_none_or(|area| area.is_free(footprint, at[0], at[1]));
        in_area && obstacles.is_free(footprint, at[0], at[1])
    }

    /// Whether a place, east and north \[m\], is in the area.
    pub(super) fn holds(&self, place: [f64; 2]) -> bool {
        let is_open = |area: &Mask| {
            let raster = self.obstacles[0].raster();
            raster.cell_at(place).is_some_and(|(col, row)| !area.closed()[row * raster.nx + col])
        };
        self.area.as_ref().is_none_or(is_open)
    }

    /// Whether a footprint at node (i, j) stays in the area.
    fn is_in_area(&self, footprint: &Footprint, i: usize, j: usize) -> bool {
        let raster = self.obstacles[0].raster();
        if let Some(area) = &self.area {
            return area.is_free(footprint, self.cell(i), self.cell(j));
        }
        let at = |n: usize| self.cell(n) as i64;
        let within = |from: i64, to: i64, count: usize| from >= 0 && to < count as i64;
        footprint.runs().iter().all(|run| {
            let row = at(j) + i64::from(run.row);
            let [first, last] = [run.first, run.last].map(|column| at(i) + i64::from(column));
            within(first, last, raster.nx) && within(row, row, raster.ny)
        })
    }

    /// Obstacles in transit.
    pub fn transit(&self) -> &Obstacles {
        &self.obstacles[self.layer_of_leg[0]]
    }

    /// Obstacles of informative maneuvers, with the widest margin.
    pub fn deepest(&self, legs: &[Arc<SettledLeg>]) -> &Obstacles {
        let of = |index: usize| &self.obstacles[self.layer_of_leg[index]];
        let blocked = |index: &usize| of(*index).blocked().iter().filter(|blocked| **blocked).count();
        let informative = (0..legs.len()).filter(|index| legs[*index].is_informative());
        of(informative.max_by_key(blocked).unwrap_or(0))
    }

    /// The clearance class of a node: 0 far from obstacles, 3 near.
    pub(super) fn class(&self, i: usize, j: usize) -> usize {
        let cells = self.node_distance_m[j * self.nx + i] / self.cell_m;
        (CLEARANCE_CLASSES - 1).saturating_sub(cells.max(0.0) as usize)
    }
}

fn nodes(nx: usize, ny: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..nx).flat_map(move |i| (0..ny).map(move |j| (i, j)))
}

impl Prepared {
    /// The obstacles of every leg.
    pub(super) fn waters(&self, keep_going: &(dyn Fn() -> bool + Sync)) -> Result<Waters, VoyageError> {
        let in_time = || keep_going().then_some(()).ok_or(VoyageError::OutOfTime("the layout of the chart"));
        let (task, grid) = (&self.brief.task, &self.grid);
        let raster = task.raster(grid);
        let (kinds, layer_of_leg) = self.obstacle_kinds();
        let of_kind = |(depth, margin, maneuvers): &(f64, f64, bool)| {
            let new = if *maneuvers { Obstacles::new } else { Obstacles::in_transit };
            in_time().and_then(|()| Ok(new(&self.chart, raster, *depth, *margin)?))
        };
        let obstacles: Vec<_> = kinds.par_iter().map(of_kind).collect();
        let obstacles: Vec<Obstacles> = obstacles.into_iter().collect::<Result<_, VoyageError>>()?;
        let node_distance_m = match task.cost.secondary {
            Secondary::Clearance => {
                self.node_distances_m(CLEARANCE_CLASSES as f64 * grid.cell_m, keep_going)?
            }
            _ => Vec::new(),
        };
        let area = task.area.polygon(self.chart.plane()).map(|polygon| Mask::beyond(&polygon, raster));
        let limits = task.speed_limits.iter().filter_map(|limit| {
            let polygon = Polygon::of_corners(Class::NoGo, &limit.corners, self.chart.plane())?;
            Some(Mask::within([&polygon], raster))
        });
        let directions = self.directions();
        let within = |traffic: &Traffic| {
            let parts = self.chart.traffic().filter(|(of, _)| of == traffic);
            Mask::within(parts.map(|(_, polygon)| polygon), raster)
        };
        let against = |leg: &Arc<SettledLeg>| self.against(leg, &directions, raster.cell_m);
        Ok(Waters {
            area,
            limits: limits.collect(),
            exceeded: self.legs.iter().map(|leg| self.exceeded(leg)).collect(),
            traffic: directions.iter().map(within).collect(),
            against: self.legs.iter().map(against).collect::<Result<_, Invalid>>()?,
            per_cell: task.raster_per_cell,
            layer_of_leg,
            node_distance_m,
            obstacles,
            legs: self.legs.clone(),
            cell_m: task.cell_m,
            nx: grid.nx,
            ny: grid.ny,
        })
    }

    /// The speed limits that the nominal vessel exceeds on a leg: at either end, or by more than the tolerance on the way.
    fn exceeded(&self, settled: &SettledLeg) -> Vec<usize> {
        let task = &self.brief.task;
        let mode_m_s = |layer: usize| self.grid.modes[self.grid.level_and_mode(layer).1].speed_m_s;
        let speeds_m_s = settled.sailed.samples.iter().map(|s| libm::hypot(s.state[0], s.state[1]));
        let way_m_s = speeds_m_s.fold(0.0, f64::max) - task.approach.tolerance.surge_m_s;
        let fastest_m_s = mode_m_s(settled.leg.from).max(mode_m_s(settled.leg.to)).max(way_m_s);
        let limits = task.speed_limits.iter().enumerate();
        limits.filter(|(_, limit)| fastest_m_s > limit.max_speed_m_s).map(|(index, _)| index).collect()
    }

    /// Distance of every node to the nearest obstacle, up to `farthest_m` \[m\].
    fn node_distances_m(
        &self,
        farthest_m: f64,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Vec<f64>, VoyageError> {
        let (grid, safety) = (&self.grid, &self.brief.task.safety);
        let limits = [safety.transit_depth_m, farthest_m];
        let obstacles = Distances::in_transit(&self.chart, self.brief.task.raster(grid), limits, keep_going)?
            .ok_or(VoyageError::OutOfTime("the layout of the chart"))?;
        let node = |k: usize| {
            let at = grid.pose(k % grid.nx, k / grid.nx, 0);
            obstacles.distance_m(at.y, at.x)
        };
        Ok((0..grid.nx * grid.ny).map(node).collect())
    }

    /// The distinct depths and margins of legs, and whether transit-only areas count; and the one that each leg uses.
    pub(super) fn obstacle_kinds(&self) -> (Vec<(f64, f64, bool)>, Vec<usize>) {
        let safety = &self.brief.task.safety;
        let mut kinds: Vec<(f64, f64, bool)> = Vec::new();
        let kind_of = |leg: &SettledLeg| match leg.is_informative() {
            true => (safety.trial_depth_m, safety.margin_m, self.chart.has_transit_only()),
            false => (safety.transit_depth_m, safety.margin_m, false),
        };
        let of_leg = |leg: &Arc<SettledLeg>| {
            let kind = kind_of(leg);
            kinds.iter().position(|k| *k == kind).unwrap_or_else(|| {
                kinds.push(kind);
                kinds.len() - 1
            })
        };
        let layer_of_leg = self.legs.iter().map(of_leg).collect();
        (kinds, layer_of_leg)
    }

    /// Refuses a pose whose hull is not clear, and names the nearest clear node.
    pub(super) fn check_water(&self, waters: &Waters, what: &str, pose: Pose) -> Result<(), VoyageError> {
        let (grid, task) = (&self.grid, &self.brief.task);
        let (level, _) = grid.level_and_mode(pose.layer);
        let still = (0.0, 0.0, grid.heading_rad(level));
        let hull = Footprint::swept(&task.hull.outline(), &[still], task.raster(grid).cell_m)?;
        let transit = self.legs.iter().position(|leg| !leg.is_informative()).unwrap_or(0);
        let layer = waters.layer_of_leg[transit];
        let is_free = |(i, j): (usize, usize)| waters.is_free(layer, &hull, i, j);
        if is_free((pose.i, pose.j)) {
            return Ok(());
        }
        let away = |(i, j): (usize, usize)| {
            let (di, dj) = (i.abs_diff(pose.i) as f64, j.abs_diff(pose.j) as f64);
            libm::hypot(di, dj) * grid.cell_m
        };
        let free = nodes(grid.nx, grid.ny).filter(|node| is_free(*node));
        let remedy = match free.min_by(|a, b| away(*a).total_cmp(&away(*b))) {
            Some((i, j)) => {
                let near = self.words(Pose { i, j, ..pose });
                format!("the nearest clear node is {:.0} m away, {near}", away((i, j)))
            }
            None => {
                let room_m = |[x, y]: [f64; 2]| waters.obstacles[layer].distance_m(x, y);
                let by = self.closed_by(waters, room_m);
                format!("no node of the lattice is clear: {by}")
            }
        };
        let at = grid.pose(pose.i, pose.j, level);
        let gap = waters.obstacles[layer].distance_m(at.y, at.x);
        let dangers = self.chart.dangers(task.safety.transit_depth_m);
        let nearest = dangers.nearest(&[[at.y, at.x]]);
        let named = nearest.map_or_else(String::new, |nearest| format!(" ({})", nearest.called));
        let near = match waters.is_in_area(&hull, pose.i, pose.j) {
            true => format!("{gap:.0} m from an obstacle{named}"),
            false => "where the hull reaches out of `area`".to_owned(),
        };
        let place = format!("{}, {near}", self.words(pose));
        let expected = format!("the hull in `area`, at least {} m clear of obstacles", task.safety.margin_m);
        Err(VoyageError::NoAnswer(Invalid::new(format!("`{what}`"), place, expected, remedy)))
    }
}

refusal::choices! {
    /// Where a ship waits.
    pub enum WaitingPlace {
        /// A charted anchorage (`ACHARE`, `ACHBRT`).
        Anchorage = "anchorage",
        /// Other water with depth and room.
        OpenWater = "open-water",
    }
}

/// By how much longer a ship makes for a charted anchorage \[s\].
const LONGER_S: f64 = 600.0;

/// Where a ship may wait.
pub(super) struct Waiting {
    /// By node, at j · nx + i.
    places: Vec<Option<WaitingPlace>>,
    nx: usize,
    headings: usize,
    /// What any other place costs more than an anchorage.
    longer: u64,
    /// The room that she has \[m\].
    pub room_m: f64,
}

impl Waiting {
    /// What kind of place a pose is; `None` where she may not wait, or is not in her slowest mode.
    pub fn place(&self, pose: Pose) -> Option<WaitingPlace> {
        self.places[pose.j * self.nx + pose.i].filter(|_| pose.layer < self.headings)
    }

    /// What the end of a way out costs there \[samples\].
    pub fn key(&self, pose: Pose) -> Option<u64> {
        self.place(pose).map(|place| if place == WaitingPlace::Anchorage { 0 } else { self.longer })
    }
}

impl Prepared {
    /// The nodes where she may wait, at rest or in her slowest circle to either side: as far from anything that she keeps clear of
    /// in transit as this takes, and her hull and its margin, and not where the traffic has a direction.
    pub(super) fn waiting(&self, keep_going: &dyn Fn() -> bool) -> Result<Waiting, VoyageError> {
        let (grid, task) = (&self.grid, &self.brief.task);
        let circle_m = 2.0 * grid.modes[0].speed_m_s / task.handling.turn_rate_rad_s;
        let room_m = task.failing.room_m.unwrap_or(circle_m.max(task.hull.length_m));
        let reach_m = task.hull.outline().iter().map(|[x, y]| libm::hypot(*x, *y)).fold(0.0, f64::max);
        let needed_m = room_m + reach_m + task.safety.margin_m;
        let distances_m = self.node_distances_m(needed_m, keep_going)?;
        let anchorages: Vec<&Polygon> = self.chart.anchorages().collect();
        let place = |(node, distance_m): (usize, &f64)| {
            let at = grid.pose(node % grid.nx, node / grid.nx, 0);
            let is_in = |polygon: &&Polygon| polygon.inside_m([at.y, at.x]) >= 0.0;
            let kind = || match anchorages.iter().any(is_in) {
                true => WaitingPlace::Anchorage,
                false => WaitingPlace::OpenWater,
            };
            let is_routed = || self.chart.traffic().any(|(_, polygon)| is_in(&polygon));
            // Distances are rounded down.
            (*distance_m >= needed_m * (1.0 - 1e-6) && !is_routed()).then(kind)
        };
        let places = distances_m.iter().enumerate().map(place).collect();
        let longer = (LONGER_S * self.brief.vessel.sample_rate_hz) as u64;
        Ok(Waiting { places, nx: grid.nx, headings: grid.headings, longer, room_m })
    }
}
