//! The simulated legs of a plan, and the moves of its maneuvers.

use std::collections::{BTreeMap, BTreeSet};

use chart::{Bounds, Causes, Class, GridCell, Obstacles, Polygon, Raster};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::Pose;

use super::aborts::{AbortTrack, LegDrift};
use super::clearance::compass_deg;
use super::orders::{WheelOver, place};
use super::prepared::Prepared;
use super::sailing::SailedPlan;
use super::settled_legs::SettledLeg;
use crate::lattice::Step;
use crate::{Fix, Sample, Side};

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
    /// What the bridge is told of a maneuver; absent of a move.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order: Option<String>,
    /// Where the nominal vessel's inputs change in a maneuver; none where they change all the time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub wheel_over: Vec<WheelOver>,
    /// If it fails: her way to the nearest place where she may wait, from the end of this leg; absent where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub abort: Option<AbortTrack>,
    /// Why there is none; absent where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub no_abort: Option<String>,
    /// How she drifts with her engine stopped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift: Option<LegDrift>,
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
            let of_leg;
            (of_leg, rest) = rest.split_at(rest.iter().take_while(|s| s.leg == index).count());
            start += of_leg.len();
            self.leg(index, step, start - of_leg.len(), of_leg)
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
        let off = |pose: Pose| libm::hypot(pose.x - to[0], pose.y - to[1]);
        let open = samples.iter().position(|s| s.informative);
        let largest = |i: usize| samples.iter().map(|s| s.inputs[i].abs()).fold(0.0, f64::max);
        let model = &brief.vessel.model;
        let inputs = model.variables[3..3 + model.inputs].iter().enumerate();
        let failure = self.sailing.failures.get(index);
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
            order: self.order(leg, samples),
            wheel_over: self.wheel_over(leg, start, samples),
            abort: failure.and_then(|failure| Some(failure.abort.as_ref().ok()?.0.clone())),
            no_abort: failure.and_then(|failure| failure.abort.as_ref().err().cloned()),
            drift: failure.map(|failure| failure.drift.clone()),
        }
    }

    /// One per informative leg.
    pub fn primitives(&self) -> Vec<Primitive> {
        let legs = self.prepared.legs.iter().enumerate();
        legs.filter_map(|(index, leg)| self.primitive(index, leg)).collect()
    }

    fn primitive(&self, index: usize, settled: &SettledLeg) -> Option<Primitive> {
        let (grid, leg) = (&self.prepared.grid, &settled.leg);
        let rate_hz = self.prepared.brief.vessel.sample_rate_hz;
        let [north, east] = grid.displacement(leg.di, leg.dj);
        let [(from, _), (to, _)] = [leg.from, leg.to].map(|layer| grid.level_and_mode(layer));
        let turned = compass_deg(settled.end.psi - grid.heading_rad(to));
        Some(Primitive {
            maneuver: settled.name.clone(),
            side: leg.purpose.side()?,
            h: from as u64,
            di: i64::from(leg.di),
            dj: i64::from(leg.dj),
            to_h: to as u64,
            maneuver_s: settled.maneuver() as f64 / rate_hz,
            leg_s: settled.seconds(rate_hz),
            residual_m: libm::hypot(settled.end.x - north, settled.end.y - east),
            residual_deg: if turned > 180.0 { turned - 360.0 } else { turned },
            spread_m: settled.spread_m(),
            fits: self.solved.waters.fits_at(index) as u64,
        })
    }
}

/// Limits between the shades of depth \[m\].
const SHADES_M: [f64; 6] = [0.0, 2.0, 5.0, 10.0, 20.0, 50.0];

/// Cells of a tube's raster along the longer side of the map.
const TUBE_CELLS: f64 = 560.0;

/// A section of the nominal track with one purpose.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackPart {
    /// Step of the plan.
    pub step: usize,
    /// Whether an informative maneuver is run.
    pub informative: bool,
    /// Its points, including the first one of the next part.
    pub points: Vec<[f64; 2]>,
}

impl SailedPlan<'_> {
    /// The lattice's area.
    pub fn frame(&self) -> Bounds {
        let grid = &self.prepared.grid;
        let point = |i: f64, j: f64| [grid.origin_m[0] + grid.cell_m * i, grid.origin_m[1] + grid.cell_m * j];
        Bounds { min: point(-0.5, -0.5), max: point(grid.nx as f64 - 0.5, grid.ny as f64 - 0.5) }
    }

    /// Limits between the shades of depth \[m\]; none where no depth is charted.
    pub fn shades_m(&self) -> &'static [f64] {
        if self.prepared.chart.has_depth() { &SHADES_M } else { &[] }
    }

    /// The raster of the obstacles.
    pub fn raster(&self) -> Raster {
        self.solved.waters.transit().raster()
    }

    /// Cells of gridded charts on that raster, by class: land, then water of each shade with the least depth of its cells.
    pub fn cells(&self) -> Vec<(Class, Vec<bool>)> {
        let (chart, raster) = (&self.prepared.chart, self.raster());
        let cell = |k: usize| {
            let at = raster.node(k % raster.nx, k / raster.nx).map(|o| o + raster.cell_m / 2.0);
            chart.grids().iter().filter_map(|grid| grid.at(at)).find(|cell| *cell != GridCell::Missing)
        };
        let count = if chart.grids().is_empty() { 0 } else { raster.nx * raster.ny };
        let cells: Vec<Option<GridCell>> = (0..count).map(cell).collect();
        let limits_m = self.shades_m();
        let depth_m = |cell: &Option<GridCell>, shade: usize| {
            let depth_m = match cell {
                Some(GridCell::Water) => 0.0,
                Some(GridCell::Depth(depth_m)) => *depth_m,
                _ => return None,
            };
            (limits_m.iter().filter(|limit_m| depth_m >= **limit_m).count() == shade).then_some(depth_m)
        };
        let land = cells.iter().map(|cell| *cell == Some(GridCell::Land)).collect();
        let water = (0..=limits_m.len()).map(|shade| {
            let least_m = cells.iter().filter_map(|cell| depth_m(cell, shade)).reduce(f64::min);
            let set = cells.iter().map(|cell| depth_m(cell, shade).is_some()).collect();
            (Class::Depth { least_m }, set)
        });
        let all = std::iter::once((Class::Land, land)).chain(water);
        all.filter(|(_, set): &(_, Vec<bool>)| set.contains(&true)).collect()
    }

    /// Polygons of the chart that are drawn in the frame, without dangers that are deep enough for maneuvers,
    /// and without those around a point.
    pub fn areas(&self) -> Vec<Polygon> {
        let deep_m = self.prepared.brief.task.safety.trial_depth_m;
        let mut areas = self.prepared.chart.drawn(&self.frame());
        areas.retain(|polygon| match polygon.class {
            Class::Danger { least_m } => {
                !(polygon.is_of_point || least_m.is_some_and(|least| least >= deep_m))
            }
            _ => true,
        });
        areas
    }

    /// Names of areas, the largest first, each where its area is widest halfway up.
    pub fn names(&self) -> Vec<([f64; 2], String)> {
        let named = |polygon: Polygon| {
            let Bounds { min, max } = polygon.bounds;
            let halfway = (min[1] + max[1]) / 2.0;
            let [west, east] = widest(&polygon.rings, halfway)?;
            let name = polygon.called.name.filter(|_| !polygon.is_of_point)?;
            let size = (max[0] - min[0]) * (max[1] - min[1]);
            Some((size, [(west + east) / 2.0, halfway], name.to_string()))
        };
        let drawn = self.prepared.chart.drawn(&self.frame());
        let mut all: Vec<_> = drawn.into_iter().filter_map(named).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut seen = BTreeSet::new();
        all.retain(|(_, _, name)| seen.insert(name.clone()));
        all.into_iter().map(|(_, at, name)| (at, name)).collect()
    }

    /// Cells of the raster that are blocked only by depth (of charted water) or margin: for informative
    /// maneuvers, and in transit.
    pub fn margins(&self) -> [Vec<bool>; 2] {
        let waters = &self.solved.waters;
        [waters.deepest(&self.prepared.legs), waters.transit()].map(|obstacles: &Obstacles| {
            let raster = obstacles.raster();
            let is_margin = |k: usize| {
                let (col, row) = (k % raster.nx, k / raster.nx);
                let causes = obstacles.causes(col, row);
                let solid = [Causes::LAND, Causes::NO_GO, Causes::UNCHARTED].iter().any(|c| causes.has(*c));
                obstacles.is_blocked(col, row) && !solid
            };
            (0..raster.nx * raster.ny).map(is_margin).collect()
        })
    }

    /// Cells that the hulls of the nominal track and of the check's runs swept; `None` without such runs.
    pub fn swept(&self) -> Option<(Raster, Vec<bool>)> {
        let bounds = self.frame();
        let side = (0..2).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f64::max);
        let grid = Raster::covering(&bounds, side / TUBE_CELLS).ok()?;
        let body = self.prepared.brief.task.hull.body(grid.cell_m);
        let mut swept = vec![false; grid.nx * grid.ny];
        let sailed: Vec<Fix> = self.sailing.sailed.fixes().collect();
        for track in std::iter::once(&sailed).chain(&self.sailing.runs) {
            let mut last = [f64::INFINITY; 2];
            for Fix { pose, .. } in track {
                let place = [pose.y, pose.x];
                if libm::hypot(place[0] - last[0], place[1] - last[1]) < grid.cell_m / 2.0 {
                    continue;
                }
                last = place;
                let cells = placed(*pose, &body).filter_map(|point| grid.cell_at(point));
                cells.for_each(|(column, row)| swept[row * grid.nx + column] = true);
            }
        }
        (!self.sailing.runs.is_empty()).then_some((grid, swept))
    }

    /// The nominal track in parts.
    pub fn track(&self) -> Vec<TrackPart> {
        let samples = &self.sailing.sailed.samples;
        let mut end = 0;
        let part = |leg: &[Sample]| {
            end += leg.len();
            let next = samples.get(end).map(place).or_else(|| self.end());
            let points = leg.iter().map(place).chain(next).collect();
            TrackPart { step: leg[0].leg, informative: leg[0].informative, points }
        };
        samples.chunk_by(|a, b| a.leg == b.leg && a.informative == b.informative).map(part).collect()
    }

    /// The start of the nominal track.
    pub fn start(&self) -> Option<[f64; 2]> {
        self.sailing.sailed.samples.first().map(place)
    }

    /// Its end.
    pub fn end(&self) -> Option<[f64; 2]> {
        self.sailing.sailed.ends.last().map(|(pose, _)| [pose.y, pose.x])
    }

    /// The hulls at the beginnings of maneuvers.
    pub fn hulls(&self) -> Vec<Vec<[f64; 2]>> {
        let pairs = self.sailing.sailed.samples.windows(2);
        let begins = pairs.filter(|pair| !pair[0].informative && pair[1].informative);
        let outline = self.prepared.brief.task.hull.outline();
        begins.map(|pair| placed(pair[1].pose, &outline).collect()).collect()
    }

    /// Longitudes at round minutes with their east coordinates, and latitudes with their north coordinates,
    /// through the centre of the frame.
    pub fn graticule(&self) -> [Vec<(f64, f64)>; 2] {
        let (plane, bounds) = (self.prepared.chart.plane(), self.frame());
        let (west, south) = plane.to_geographic(bounds.min);
        let (east, north) = plane.to_geographic(bounds.max);
        let centre = [(west + east) / 2.0, (south + north) / 2.0];
        [
            round_minutes(west, east).map(|lon| (lon, plane.to_plane(lon, centre[1])[0])).collect(),
            round_minutes(south, north).map(|lat| (lat, plane.to_plane(centre[0], lat)[1])).collect(),
        ]
    }
}

/// Degrees between two, at round minutes.
pub fn round_minutes(from: f64, to: f64) -> impl Iterator<Item = f64> {
    let steps = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0].map(|minutes| minutes / 60.0);
    let step = steps.into_iter().find(|step| (to - from) / step <= 6.0).unwrap_or(1.0);
    (0..).map(move |k| (from / step).ceil() * step + f64::from(k) * step).take_while(move |at| *at <= to)
}

/// East and north \[m\] of `points` of a ship at `pose`, x forward and y to starboard of its reference point \[m\].
pub fn placed(pose: Pose, points: &[[f64; 2]]) -> impl Iterator<Item = [f64; 2]> {
    let (sin, cos) = libm::sincos(pose.psi);
    points.iter().map(move |[x, y]| [pose.y + x * sin + y * cos, pose.x + x * cos - y * sin])
}

/// The longest interval of `rings`, filled by the even-odd rule, along the parallel at `y`.
pub fn widest(rings: &[Vec<[f64; 2]>], y: f64) -> Option<[f64; 2]> {
    let mut crossings: Vec<f64> = Vec::new();
    for ring in rings {
        let edges = ring.iter().zip(ring.iter().cycle().skip(1));
        let crossing = edges.filter(|(p, q)| (p[1] > y) != (q[1] > y));
        crossings.extend(crossing.map(|(p, q)| p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0])));
    }
    crossings.sort_by(f64::total_cmp);
    let intervals = crossings.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
    intervals.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))
}
