//! Clearance of the hull from charted obstacles, in continuous space.

use chart::{Bounds, Distances, Polygon, Raster};
use refusal::Invalid;
use ship::engine::Pose;

use super::error::VoyageError;
use super::prepared::Prepared;
use super::task::{Goal, Place, Task};
use crate::lattice;

/// How far beyond the lattice a hull's clearance is measured \[m\]. The chart is read farther than that.
const BEYOND_M: f64 = 500.0;
/// Most raster cells that distances are measured on, unless the lattice's own raster has more.
const MOST_CELLS: f64 = 4e6;
/// Most cells of that raster per cell of the lattice's raster.
const FINEST: u32 = 8;

/// Distance of the hull from obstacles.
pub struct Clearance {
    /// Outline about the reference point, x forward, y to starboard \[m\], including the midpoints of its sides.
    pub outline: Vec<[f64; 2]>,
    /// Greatest distance of the outline from the reference point \[m\].
    pub radius_m: f64,
    /// Obstacles in transit.
    pub transit: Distances,
    /// Obstacles in informative maneuvers, if they differ.
    pub trial: Option<Distances>,
    /// The lattice's area.
    pub area: Bounds,
    /// The allowed part of it, if that is not all.
    pub polygon: Option<Polygon>,
    /// Greatest measured distance \[m\].
    pub sight_m: f64,
}

/// The clearance along a track so far.
#[derive(Clone, Copy, Debug)]
pub struct Cleared {
    /// Least distance from obstacles; 0 where the chart was not read \[m\].
    pub clearance_m: f64,
    /// The same, interpolated between cells; only where runs are compared \[m\].
    pub between_cells_m: Option<f64>,
    /// Whether the hull left the lattice's area.
    pub left_area: bool,
    /// Distance that the vessel can advance before its clearance can decrease \[m\].
    unseen_m: f64,
    /// The last position, east and north \[m\], and whether it was in an informative maneuver.
    last: ([f64; 2], bool),
}

impl Cleared {
    /// The combination of both.
    pub(super) fn and(self, other: &Self) -> Self {
        Self {
            clearance_m: self.clearance_m.min(other.clearance_m),
            left_area: self.left_area || other.left_area,
            unseen_m: 0.0,
            ..self
        }
    }
}

impl Clearance {
    /// Rasters of the chart around the lattice, finer than those of the search.
    pub(super) fn new(plan: &Prepared, keep_going: &(dyn Fn() -> bool + Sync)) -> Result<Self, VoyageError> {
        let task = &plan.brief.task;
        let (area, sight_m) = (task.raster(&plan.grid).bounds(), sight_m(task));
        let raster = plan.clearance_raster()?;
        let hull = task.hull.outline();
        let between = |(a, b): (&[f64; 2], &[f64; 2])| [*a, [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0]];
        let outline: Vec<[f64; 2]> = hull.iter().zip(hull.iter().cycle().skip(1)).flat_map(between).collect();
        let radius_m = outline.iter().map(|[x, y]| libm::hypot(*x, *y)).fold(0.0, f64::max);
        let (chart, safety) = (&plan.chart, &task.safety);
        let (transit, trial) = rayon::join(
            || Distances::in_transit(chart, raster, [safety.transit_depth_m, sight_m], keep_going),
            || {
                let trial = || Distances::new(chart, raster, [safety.trial_depth_m, sight_m], keep_going);
                plan.has_waters_of_trials().then(trial).transpose()
            },
        );
        let late = VoyageError::OutOfTime("the layout of the chart");
        let polygon = task.area.polygon(chart.plane());
        let (Some(transit), trial) = (transit?, trial?) else { return Err(late) };
        let trial = trial.map(|trial| trial.ok_or(late)).transpose()?;
        Ok(Self { outline, radius_m, transit, trial, area, polygon, sight_m })
    }

    /// A passage without samples.
    pub fn open(&self) -> Cleared {
        Cleared {
            clearance_m: self.sight_m,
            between_cells_m: None,
            left_area: false,
            unseen_m: 0.0,
            last: ([0.0; 2], false),
        }
    }

    /// The same of a run that is compared with others.
    pub fn open_to_compare(&self) -> Cleared {
        Cleared { between_cells_m: Some(self.sight_m), ..self.open() }
    }

    /// Distance of a place from where the hull can reach out of the area, or out of `seen` once it has left
    /// the area; below 0 beyond it \[m\].
    fn inside_m(&self, place: [f64; 2], seen: Option<Bounds>) -> f64 {
        let Bounds { min, max } = seen.unwrap_or(self.area);
        let ends = [0, 1].map(|k| (place[k] - min[k]).min(max[k] - place[k]));
        let polygon_m = if seen.is_some() { f64::INFINITY } else { self.inside_polygon_m(place) };
        ends[0].min(ends[1]).min(polygon_m) - self.radius_m
    }

    fn inside_polygon_m(&self, place: [f64; 2]) -> f64 {
        self.polygon.as_ref().map_or(f64::INFINITY, |polygon| polygon.inside_m(place))
    }

    /// Adds the clearance of the hull at a sample to `passage`.
    pub fn add(&self, passage: &mut Cleared, pose: Pose, informative: bool) {
        let place = [pose.y, pose.x];
        let (before, was_informative) = std::mem::replace(&mut passage.last, (place, informative));
        let [east, north] = [0, 1].map(|k| place[k] - before[k]);
        passage.unseen_m -= (east * east + north * north).sqrt();
        if passage.unseen_m > 0.0 && was_informative == informative {
            return;
        }
        passage.unseen_m = 0.0;
        let obstacles = self.trial.as_ref().filter(|_| informative).unwrap_or(&self.transit);
        // If the reference point is farther away than the hull reaches, no corner matters.
        let cell_m = obstacles.raster().cell_m;
        let far = obstacles.distance_m(pose.y, pose.x) - self.radius_m - 2.0 * cell_m;
        // Interpolated distances may be a cell less.
        let least_m = passage.clearance_m;
        let nearest = passage.between_cells_m.map_or(least_m, |between| between.max(least_m) + cell_m);
        let inside_m = self.inside_m(place, passage.left_area.then(|| obstacles.raster().bounds()));
        if far > nearest && inside_m >= 0.0 {
            passage.unseen_m = (far - nearest).min(inside_m);
            return;
        }
        let (sin, cos) = libm::sincos(pose.psi);
        for [x, y] in &self.outline {
            let place = [pose.y + x * sin + y * cos, pose.x + x * cos - y * sin];
            let distance_m = obstacles.distance_m(place[0], place[1]);
            passage.clearance_m = passage.clearance_m.min(distance_m);
            // Interpolated, it is at most a cell's diagonal less.
            let between = passage.between_cells_m.as_mut();
            if let Some(least) = between.filter(|least| distance_m < **least + 1.5 * cell_m) {
                *least = least.min(obstacles.between_cells_m(place[0], place[1]));
            }
            let is_outside = || inside_m < 0.0 && self.inside_polygon_m(place) < 0.0;
            passage.left_area |= !self.area.contains(place) || is_outside();
        }
    }
}

impl Prepared {
    /// The raster that clearances are measured on.
    fn clearance_raster(&self) -> Result<Raster, Invalid> {
        let raster = self.brief.task.raster(&self.grid);
        fine(&raster.bounds().grown(BEYOND_M), raster.cell_m, sight_m(&self.brief.task))
    }

    /// Its cells, including those around it, of all rasters that are built at once.
    pub(super) fn clearance_cells(&self) -> Result<u128, Invalid> {
        let layers = if self.has_waters_of_trials() { 2 } else { 1 };
        Ok(layers * cells_around(&self.clearance_raster()?, sight_m(&self.brief.task)))
    }

    /// Whether informative maneuvers keep clear of other obstacles than legs in transit.
    fn has_waters_of_trials(&self) -> bool {
        let safety = &self.brief.task.safety;
        self.chart.has_transit_only() || safety.trial_depth_m != safety.transit_depth_m
    }
}

fn sight_m(task: &Task) -> f64 {
    BEYOND_M + task.safety.margin_m
}

/// The finest raster over `bounds`, with cells that divide `cell_m`, of a reasonable size including `around_m`.
fn fine(bounds: &Bounds, cell_m: f64, around_m: f64) -> Result<Raster, Invalid> {
    let wide = bounds.grown(around_m);
    let cells =
        |parts: u32| (0..2).map(|k| (wide.max[k] - wide.min[k]) / cell_m * f64::from(parts)).product::<f64>();
    let parts = (2..=FINEST).rev().find(|parts| cells(*parts) <= MOST_CELLS).unwrap_or(1);
    Raster::covering(bounds, cell_m / f64::from(parts))
}

/// Cells of a raster, including those around it for a margin.
pub(super) fn cells_around(raster: &Raster, margin_m: f64) -> u128 {
    let around = 2 * ((margin_m / raster.cell_m).ceil() as u128 + 1);
    (raster.nx as u128 + around) * (raster.ny as u128 + around)
}

impl Prepared {
    /// The node and heading level nearest to a place, in its speed mode (by default the slowest).
    pub(super) fn pose(&self, key: &str, place: &Place) -> Result<lattice::Pose, Invalid> {
        let [east, north] = self.chart.plane().to_plane(place.longitude_deg, place.latitude_deg);
        let node = |at: f64, origin: f64| ((at - origin) / self.grid.cell_m).round();
        let (i, j) = (node(east, self.grid.origin_m[0]), node(north, self.grid.origin_m[1]));
        let inside = |n: f64, count: usize| n >= 0.0 && n < count as f64;
        if !inside(i, self.grid.nx) || !inside(j, self.grid.ny) || !place.heading_deg.is_finite() {
            let Place { longitude_deg, latitude_deg, heading_deg, .. } = place;
            let value = format!("longitude {longitude_deg}, latitude {latitude_deg}, heading {heading_deg}");
            let expected = "a place inside `area` and a compass heading";
            return Err(refuse(key, &value, expected, "move it, or widen `area`"));
        }
        let grid_rad = place.heading_deg.to_radians() + self.chart.plane().north_rad([east, north]);
        let level = self.grid.nearest_level(grid_rad);
        let layer = self.grid.layer(level, self.mode(key, place)?);
        Ok(lattice::Pose { i: i as usize, j: j as usize, layer })
    }

    fn mode(&self, key: &str, place: &Place) -> Result<usize, Invalid> {
        let Some(name) = &place.mode else { return Ok(0) };
        let names = || self.grid.modes.iter().map(|m| m.name.as_str()).collect::<Vec<_>>().join(", ");
        self.grid.modes.iter().position(|m| m.name == *name).ok_or_else(|| {
            refuse(&format!("{key}.mode"), &format!("`{name}`"), &names(), "name one of these")
        })
    }

    /// Where the trial may end.
    pub(super) fn goal(&self, goal: &Goal, start: lattice::Pose) -> Result<lattice::Goal, Invalid> {
        match goal {
            Goal::Any {} => Ok(lattice::Goal::Any),
            Goal::Home {} => Ok(lattice::Goal::Poses(vec![start])),
            Goal::Places { places } if places.is_empty() => {
                Err(refuse("goal.places", "none", "at least one place", "add one, or take kind = \"any\""))
            }
            Goal::Places { places } => {
                let poses = places.iter().map(|place| self.pose("goal.places", place));
                Ok(lattice::Goal::Poses(poses.collect::<Result<_, _>>()?))
            }
        }
    }

    /// The true heading of a pose on the plane, from 0 to 360 \[deg\].
    pub fn true_deg(&self, pose: Pose) -> f64 {
        compass_deg(pose.psi - self.chart.plane().north_rad([pose.y, pose.x]))
    }

    /// A pose in words: its position in degrees, and its true heading.
    pub(super) fn words(&self, pose: lattice::Pose) -> String {
        let (level, _) = self.grid.level_and_mode(pose.layer);
        let at = self.grid.pose(pose.i, pose.j, level);
        let (longitude, latitude) = self.chart.plane().to_geographic([at.y, at.x]);
        let part = |degrees: f64, side: char| format!("{:.4} {side}", degrees.abs());
        let north = part(latitude, if latitude < 0.0 { 'S' } else { 'N' });
        let east = part(longitude, if longitude < 0.0 { 'W' } else { 'E' });
        format!("{north} {east} heading {:.0}°", self.true_deg(at).round() % 360.0)
    }
}

fn refuse(key: &str, value: &str, expected: &str, remedy: &str) -> Invalid {
    Invalid::new(format!("`{key}`"), value, expected, remedy)
}

/// A heading in degrees from 0 to 360.
pub fn compass_deg(heading_rad: f64) -> f64 {
    heading_rad.to_degrees().rem_euclid(360.0)
}
