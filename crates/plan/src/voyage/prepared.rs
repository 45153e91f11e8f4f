//! The start of a search: chart and lattice laid out, counts determined, every leg simulated.

use std::sync::Arc;

use chart::route::{Route, Waypoint};
use chart::{Bounds, Chart, Class, Layer, Mask, Plane, Polygon, Raster};
use maneuver::{Motion, Steady};
use refusal::Invalid;
use ship::model::Vessel;
use trial::Piece;

use super::error::{Search, VoyageError, parameters_in_words};
use super::moment_sums::MomentSums;
use super::settled_legs::{Dropped, LegGroup, LegSimulation, SettledLeg, Wanted, groups};
use super::task::{Area, Brief, Task};
use crate::{Grid, Mode, Repertoire, SampledVessel, mirror};

/// The groups of legs, the legs on which all vessels settle, and the others.
pub(super) type KnownLegs = (Vec<LegGroup>, Vec<Arc<SettledLeg>>, Vec<Dropped>);

/// A trial prepared for the search.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Its inputs.
    pub brief: Brief,
    /// The chart on its plane.
    pub chart: Chart,
    /// The lattice.
    pub grid: Grid,
    /// Pieces with their counts.
    pub wanted: Vec<Wanted>,
    /// The pieces alone.
    pub(super) pieces: Vec<Piece>,
    /// Signs of inputs for the other side, if the vessel has mirror symmetry.
    pub(super) mirror: Option<Vec<f64>>,
    groups: Vec<LegGroup>,
    /// The sampled vessels of every leg.
    pub(super) others: Vec<SampledVessel>,
    /// Every leg of the lattice.
    pub legs: Vec<Arc<SettledLeg>>,
    /// Legs on which not all vessels settle.
    pub dropped: Vec<Dropped>,
    /// The information of each piece.
    pub(super) information: Vec<MomentSums>,
}

impl Prepared {
    /// Lays out chart and lattice, determines the counts and simulates every leg.
    ///
    /// # Errors
    /// Values of the task that are invalid for this vessel, dictionary, design or chart; rasters that exceed
    /// the memory; a maneuver without a leg on which all vessels settle.
    pub fn new(mut brief: Brief, search: &Search) -> Result<Self, VoyageError> {
        let layers = std::mem::take(&mut brief.layers);
        let Brief { vessel, task, .. } = &brief;
        let wanted = brief.wanted()?;
        let pieces: Vec<Piece> = wanted.iter().map(|w| w.piece.clone()).collect();
        let (chart, grid) = task.ground(vessel, &layers, brief.drift_m(&wanted), search.keep_going)?;
        drop(layers);
        let summing = brief.summing()?;
        let information = pieces.iter().map(|piece| summing.of_piece(piece)).collect();
        let others = brief.sampled_vessels();
        let mirror =
            mirror(vessel).filter(|signs| pieces.iter().all(|piece| piece.is_mirrored_within(vessel, signs)));
        let (legs, dropped) = (Vec::new(), Vec::new());
        let mut prepared = Self {
            brief,
            chart,
            grid,
            wanted,
            pieces,
            mirror,
            groups: Vec::new(),
            others,
            legs,
            dropped,
            information,
        };
        prepared.check_modes()?;
        prepared.check_rasters(search)?;
        prepared.check_steered()?;
        prepared.groups = groups(&prepared.repertoire());
        prepared.learn(Vec::new(), search)?;
        prepared.check_offered()?;
        Ok(prepared)
    }

    /// The data that legs are made from.
    pub(super) fn repertoire(&self) -> Repertoire<'_> {
        let task = &self.brief.task;
        Repertoire {
            vessel: &self.brief.vessel,
            grid: &self.grid,
            handling: &task.handling,
            approach: &task.approach,
            pieces: &self.pieces,
            mirror: self.mirror.as_deref(),
            mean_current_m_s: task.known_current_m_s,
            deviations: &task.deviations,
            unknown_current_m_s: task.safety.unknown_current_m_s,
            sensors: task.sensors,
            changes: task.changes,
            seed: self.brief.seed,
        }
    }

    fn check_modes(&self) -> Result<(), Invalid> {
        (0..self.pieces.len()).try_for_each(|piece| self.repertoire().mode_of(piece).map(|_| ()))
    }

    /// Refuses maneuvers that have no leg from any heading: all of them at once.
    pub(super) fn check_offered(&self) -> Result<(), VoyageError> {
        let offered = |name: &&str| self.legs.iter().any(|leg| leg.name == **name);
        let mut names: Vec<&str> = self.wanted.iter().map(|wanted| wanted.piece.maneuver.as_str()).collect();
        names.retain(|name| !offered(name));
        names.dedup();
        let dropped = |name: &str| self.dropped.iter().find(|dropped| dropped.name == name);
        let Some((name, others)) = names.split_first() else { return Ok(()) };
        let why = dropped(name).map_or_else(String::new, |dropped| self.named(dropped));
        let others = others.iter().map(|name| {
            let why = dropped(name).map_or_else(String::new, |dropped| format!(" ({})", dropped.why));
            format!("; nor of `{name}`{why}")
        });
        Err(VoyageError::NoAnswer(Invalid::new(
            format!("maneuver `{name}`"),
            format!("no leg on which all sampled vessels settle{why}{}", others.collect::<String>()),
            format!("one for all within `{}`", self.brief.task.safety.key()),
            "know the parameters better, raise the tolerances of `approach`, or shorten it",
        )))
    }

    /// The vessel that does not settle on a dropped leg, and how.
    fn named(&self, Dropped { why, parameters, .. }: &Dropped) -> String {
        let who = parameters.as_ref().map(|all| parameters_in_words(&self.brief.vessel, all));
        who.map_or_else(|| format!(", {why}"), |who| format!(", such as {who}: {why}"))
    }

    /// Adds counter-examples to the sampled vessels of their legs; returns the previous state.
    pub(super) fn learn(
        &mut self,
        counter_examples: Vec<(usize, SampledVessel)>,
        search: &Search,
    ) -> Result<KnownLegs, VoyageError> {
        let mut groups = self.groups.clone();
        counter_examples.into_iter().for_each(|(leg, who)| groups[self.legs[leg].group].learn(who));
        let task = &self.brief.task;
        let simulation = LegSimulation {
            repertoire: self.repertoire(),
            wanted: &self.wanted,
            others: &self.others,
            hull: task.hull.outline(),
            cell_m: task.raster(&self.grid).cell_m,
        };
        let (legs, dropped) = simulation.run(&mut groups, search.keep_going)?;
        Ok(self.know((groups, legs, dropped)))
    }

    /// Replaces the known legs; returns the previous ones.
    pub(super) fn know(&mut self, (groups, legs, dropped): KnownLegs) -> KnownLegs {
        let groups = std::mem::replace(&mut self.groups, groups);
        let legs = std::mem::replace(&mut self.legs, legs);
        (groups, legs, std::mem::replace(&mut self.dropped, dropped))
    }

    /// The share of the area that no chart covers, from 0 to 1, counted on the lattice's raster.
    pub fn uncharted_share(&self) -> f64 {
        let raster = self.brief.task.raster(&self.grid);
        let area = self.brief.task.area.polygon(self.chart.plane());
        let beyond = area.map(|polygon| Mask::beyond(&polygon, raster));
        let is_in = |cell: usize| beyond.as_ref().is_none_or(|beyond| !beyond.closed()[cell]);
        let cells = self.chart.uncharted_cells(raster).into_iter().enumerate();
        let inside = cells.filter(|(cell, _)| is_in(*cell)).map(|(_, uncharted)| u64::from(uncharted));
        let (all, uncharted) = inside.fold((0_u64, 0), |(all, sum), cell| (all + 1, sum + cell));
        uncharted as f64 / all.max(1) as f64
    }

    /// The straight way between two places, both north and east \[m\].
    pub(super) fn route(&self, places: [[f64; 2]; 2]) -> Route {
        let waypoint = |[north, east]: [f64; 2]| {
            let (lon_deg, lat_deg) = self.chart.plane().to_geographic([east, north]);
            Waypoint { lon_deg, lat_deg, ..Waypoint::default() }
        };
        Route { waypoints: places.map(waypoint).into(), ..Route::default() }
    }

    /// North and east of a pose's node \[m\].
    pub fn node(&self, pose: crate::lattice::Pose) -> [f64; 2] {
        let at = self.grid.pose(pose.i, pose.j, 0);
        [at.x, at.y]
    }
}

/// Name of the mode of a vessel at rest.
pub const AT_REST: &str = "at rest";
/// How far beyond the lattice and the hull's margins the chart is read \[m\]: the range of the check, and
/// more than the few cells in which nearness to obstacles is classified.
const CHART_BEYOND_M: f64 = 1000.0;
const CHART_BEYOND_CELLS: f64 = 5.0;
/// Fraction of a cell by which a start may be off its node.
const ON_NODE: f64 = 1e-6;
/// Longest side of an area: beyond it lengths on a plane are off by more than a hull's length; maps of very
/// elongated areas are illegible.
const LONGEST_SIDE_M: f64 = 200e3;
const MOST_ELONGATED: f64 = 20.0;

impl Brief {
    /// The plane of the trial, and the part of it that charts must cover.
    ///
    /// # Errors
    /// As [`Prepared::new`], of counts and area.
    pub fn sight(&self) -> Result<(Plane, Bounds), VoyageError> {
        let plane = self.task.area.plane()?;
        let laid = self.task.laid(&plane)?;
        Ok((plane, self.task.sight(laid, self.drift_m(&self.wanted()?))?))
    }

    /// Drift by unknown currents, and three standard deviations of their changes, in the longest piece of a maneuver \[m\].
    pub(super) fn drift_m(&self, wanted: &[Wanted]) -> f64 {
        let longest = wanted.iter().map(|wanted| wanted.piece.samples).max().unwrap_or(0);
        let changes_m_s = self.task.changes.current.map_or(0.0, |current| 3.0 * current.std_m_s);
        let unknown_m_s = self.task.safety.unknown_current_m_s + changes_m_s;
        unknown_m_s * longest as f64 / self.vessel.sample_rate_hz
    }
}

impl Task {
    /// The part of the plane that charts must cover. Maneuvers drift by up to `drift_m`.
    fn sight(&self, (corner, [nx, ny]): ([f64; 2], [usize; 2]), drift_m: f64) -> Result<Bounds, Invalid> {
        let far = [corner[0] + nx as f64 * self.cell_m, corner[1] + ny as f64 * self.cell_m];
        let margin = self.safety.margin_m + drift_m + CHART_BEYOND_CELLS * self.cell_m + CHART_BEYOND_M;
        Ok(Bounds::new(corner, far)?.grown(margin))
    }

    /// The chart of `layers` around the area, and the lattice over it. Maneuvers drift by up to `drift_m`.
    pub(super) fn ground(
        &self,
        vessel: &Vessel,
        layers: &[Layer],
        drift_m: f64,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<(Chart, Grid), VoyageError> {
        let plane = self.area.plane()?;
        let laid = self.laid(&plane)?;
        let bounds = self.sight(laid, drift_m)?;
        let chart = Chart::new_while(plane, bounds, layers, self.uncharted, keep_going)?;
        let chart = chart.ok_or(VoyageError::OutOfTime("the layout of the chart"))?;
        self.area.check_shown(layers, &chart)?;
        let grid = self.grid(vessel, laid);
        if grid.modes.is_empty() {
            let expected = "at least one, for a vessel that cannot turn on the spot";
            return Err(Invalid::new("[[speed_mode]]", "none", expected, "add one").into());
        }
        Ok((chart, grid))
    }

    /// The lattice that is laid so.
    pub(super) fn grid(&self, vessel: &Vessel, (corner, [nx, ny]): ([f64; 2], [usize; 2])) -> Grid {
        let origin_m = corner.map(|c| c + self.cell_m / 2.0);
        let (headings, cell_m, modes) = (self.headings, self.cell_m, self.modes_of(vessel));
        Grid { nx, ny, headings, cell_m, origin_m, modes }
    }

    /// South-western corner and size of the lattice on a plane, cropped to the area.
    pub(super) fn laid(&self, plane: &Plane) -> Result<([f64; 2], [usize; 2]), Invalid> {
        Ok(self.on_start(plane, self.nodes(plane)?))
    }

    /// South-western corner of the lattice's cells (east, north) \[m\], and the number of nodes eastward and northward.
    fn nodes(&self, plane: &Plane) -> Result<([f64; 2], [usize; 2]), Invalid> {
        let corners = match self.area.polygon(plane) {
            Some(polygon) => polygon.rings.concat(),
            None => self.area.box_corners().map(|[lon, lat]| plane.to_plane(lon, lat)).into(),
        };
        let least = |k: usize| corners.iter().map(|c| c[k]).fold(f64::INFINITY, f64::min);
        let most = |k: usize| corners.iter().map(|c| c[k]).fold(f64::NEG_INFINITY, f64::max);
        let sides = [0, 1].map(|k: usize| most(k) - least(k));
        let (longer, shorter) = (sides[0].max(sides[1]), sides[0].min(sides[1]));
        if !(longer <= LONGEST_SIDE_M && longer <= MOST_ELONGATED * shorter) {
            let size = format!("{:.1} × {:.1} km", sides[0] / 1e3, sides[1] / 1e3);
            let expected = "at most 200 km on a side, within 20 to 1: one plane and one map hold no more";
            return Err(Invalid::new("`area`", size, expected, "correct its corners"));
        }
        let count = |k: usize| ((most(k) - least(k)) / self.cell_m).floor();
        let (nx, ny) = (count(0), count(1));
        if nx >= 2.0 && ny >= 2.0 && nx * ny <= 4e6 {
            return Ok(([least(0), least(1)], [nx as usize, ny as usize]));
        }
        let nodes = format!("{nx} × {ny} nodes");
        let expected = "from 2 × 2 to four million nodes";
        Err(Invalid::new("`area` and `cell_m`", nodes, expected, "correct one of them"))
    }

    /// The same lattice, moved by up to half a cell if its start has to be a node, and cropped to the area.
    fn on_start(&self, plane: &Plane, (mut min, mut size): ([f64; 2], [usize; 2])) -> ([f64; 2], [usize; 2]) {
        let start = plane.to_plane(self.start.longitude_deg, self.start.latitude_deg);
        for k in 0..2 {
            let cells = (start[k] - min[k]) / self.cell_m - 0.5;
            let off = cells - cells.round();
            if self.on_node && off.abs() > ON_NODE {
                min[k] += (if off < 0.0 { off + 1.0 } else { off }) * self.cell_m;
                size[k] -= 1;
            }
        }
        (min, size)
    }

    /// The speed modes, slowest first; at rest first of all where the vessel can turn on the spot.
    fn modes_of(&self, vessel: &Vessel) -> Vec<Mode> {
        let rest = can_hold(vessel).then(|| Mode { name: AT_REST.to_owned(), speed_m_s: 0.0 });
        let mut modes: Vec<Mode> = rest.into_iter().chain(self.modes.iter().cloned()).collect();
        modes.sort_by(|a, b| a.speed_m_s.total_cmp(&b.speed_m_s));
        modes
    }

    /// The raster on which chart and footprints are compared: a subdivision of the lattice.
    pub(super) fn raster(&self, grid: &Grid) -> Raster {
        let cell_m = self.cell_m / self.raster_per_cell as f64;
        let origin = grid.origin_m.map(|o| o - self.cell_m / 2.0);
        let count = |n: usize| n * self.raster_per_cell;
        Raster { origin, cell_m, nx: count(grid.nx), ny: count(grid.ny) }
    }
}

impl Area {
    /// A plane about its centre.
    pub(super) fn plane(&self) -> Result<Plane, Invalid> {
        let [lon, lat] = self.centre_deg();
        Plane::new(lon, lat)
    }

    /// Longitude and latitude of the box's centre.
    pub fn centre_deg(&self) -> [f64; 2] {
        let centre = (self.west_deg + self.east_beyond_deg()) / 2.0;
        let lon = if centre > 180.0 { centre - 360.0 } else { centre };
        [lon, (self.south_deg + self.north_deg) / 2.0]
    }

    /// The polygon on a plane; `None` if the area is the whole box.
    pub(super) fn polygon(&self, plane: &Plane) -> Option<Polygon> {
        Polygon::of_corners(Class::NoGo, &self.corners, plane)
    }

    /// The eastern edge, beyond 180° if the area lies across the antimeridian.
    fn east_beyond_deg(&self) -> f64 {
        if self.east_deg < self.west_deg { self.east_deg + 360.0 } else { self.east_deg }
    }

    /// Longitude and latitude of the box's corners \[deg\].
    fn box_corners(&self) -> [[f64; 2]; 4] {
        [
            [self.west_deg, self.south_deg],
            [self.east_deg, self.south_deg],
            [self.west_deg, self.north_deg],
            [self.east_deg, self.north_deg],
        ]
    }

    /// Refuses charts none of which covers any of the area: they are of another place, or in another CRS.
    fn check_shown(&self, layers: &[Layer], chart: &Chart) -> Result<(), Invalid> {
        let on_chart = !chart.polygons().is_empty() || !chart.grids().is_empty();
        if on_chart || layers.iter().any(|layer| self.is_within(layer)) {
            return Ok(());
        }
        Err(Invalid::new(
            "[[chart]]",
            "nothing within `area`",
            "charts that cover the area, or lie around it",
            "check the charts' `crs` and the corners of `area`, or set `open_sea = true` for a chart of land",
        ))
    }

    /// Whether the polygons of a layer lie around the area, or it is declared open sea: an area without any
    /// of them nearby would be all water.
    fn is_within(&self, layer: &Layer) -> bool {
        let Layer::Polygons(layer) = layer else { return false };
        if layer.open_sea {
            return true;
        }
        let marks = || layer.marks.iter().flat_map(|mark| &mark.positions);
        let all = || layer.areas.iter().flat_map(|area| area.rings.iter().flatten()).chain(marks());
        let low = |k: usize| all().map(|p| p[k]).fold(f64::INFINITY, f64::min);
        let high = |k: usize| all().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max);
        let (west, east) = (self.west_deg, self.east_beyond_deg());
        let meets = |turn: f64| low(0) + turn <= east && high(0) + turn >= west;
        (meets(0.0) || meets(360.0)) && low(1) <= self.north_deg && high(1) >= self.south_deg
    }
}

/// Whether the vessel can be held at a place while it turns.
fn can_hold(vessel: &Vessel) -> bool {
    let mut unknowns = vec![0.0; vessel.model.inputs + 1];
    let turning = Motion { u: 0.0, v: Some(0.01), r: 0.01 };
    Steady::new(vessel, &vessel.nominal).solve(turning, &mut unknowns).is_ok()
}
