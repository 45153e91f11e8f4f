//! The files of a plan: `plan.json`, `map.json`, and its tracks and routes in other formats.

use std::collections::BTreeMap;

use chart::route::{Feature, Geometry, Route, Track, Waypoint, geojson, gpx, qgroundcontrol, rtz};
use chart::{Class, Invalid, Plane, Polygon, Raster, Spot, Uncharted};
use serde_json::json;

use crate::documents::{
    CostUnit, DroppedMove, MapArea, MapCellClass, MapCells, MapClass, MapContour, MapDocument, MapFrame,
    MapLine, MapMargin, MapMeridian, MapName, MapParallel, MapPlace, MapPurpose, MapRaster, MapRuns, MapSpot,
    MapSwept, MapSymbol, MapTrack, MapTrackKind, Passage, PlanDocument, PlanHandling, PlanLattice, PlanPose,
    PlanStatus, PlanStep, SecondaryCost, Voyage,
};
use plan::lattice::{Pose, Problem, Solution, Status, Step};
use plan::voyage::{Check, Prepared, SailedPlan, Solved, TrackPart};
use plan::{Sailed, Sample};

/// The plan of a lattice problem.
pub fn of_problem(problem: &Problem, solution: &Solution) -> PlanDocument {
    let pose = |p: Pose| PlanPose { i: p.i as u64, j: p.j as u64, h: p.layer as u64, mode: None };
    plan(problem, solution, CostUnit::Cost, pose)
}

/// The plan of a trial on a chart, as simulated.
pub fn of_voyage(voyage: &SailedPlan) -> PlanDocument {
    let SailedPlan { prepared, solved, sailing } = *voyage;
    let (grid, cost) = (&prepared.grid, prepared.brief.task.cost);
    let pose = |p: Pose| {
        let (level, mode) = grid.level_and_mode(p.layer);
        let mode = Some(grid.modes[mode].name.clone());
        PlanPose { i: p.i as u64, j: p.j as u64, h: level as u64, mode }
    };
    let Solved { problem, solution, .. } = solved;
    let planned = plan(problem, solution, cost.primary.into(), pose);
    PlanDocument {
        statement: labelled(planned.statement, &sailing.check),
        secondary: Some(SecondaryCost { name: cost.secondary, value: solution.cost.secondary }),
        voyage: Some(at_sea(voyage)),
        ..planned
    }
}

/// The statement on a plan, with the violations that its check found.
fn labelled(statement: String, check: &Check) -> String {
    match check.safe {
        true => statement,
        false => format!("{statement} Unsafe: {}.", check.faults.join(", ")),
    }
}

fn plan(
    problem: &Problem,
    solution: &Solution,
    cost_unit: CostUnit,
    pose: impl Fn(Pose) -> PlanPose,
) -> PlanDocument {
    let step = |s: &Step| PlanStep {
        action: problem.actions()[s.action].name.clone(),
        variant: s.variant as u64,
        from: pose(s.from),
        to: pose(s.to),
        cost: s.cost.primary,
    };
    let (status, statement) = status(problem, solution);
    PlanDocument {
        status,
        statement,
        cost_unit,
        cost: solution.cost.primary,
        lower_bound: solution.lower_bound.primary,
        gap: solution.gap(),
        secondary: None,
        counts: uses(problem, solution),
        steps: solution.steps.iter().map(step).collect(),
        voyage: None,
        charts: Vec::new(),
        beyond: Vec::new(),
        begun: None,
    }
}

/// The status of the plan, also in words.
fn status(problem: &Problem, solution: &Solution) -> (PlanStatus, String) {
    match solution.status {
        Status::Optimal => {
            let states = problem.states();
            let statement = format!("Proved: no plan over the {states} states of the lattice costs less.");
            (PlanStatus::Optimal, statement)
        }
        Status::Feasible { .. } => (
            PlanStatus::Feasible,
            format!(
                "Not proved optimal: no plan costs less than {}, so this one is at most {} dearer than the best.",
                solution.lower_bound.primary,
                solution.gap()
            ),
        ),
    }
}

/// Uses of every informative action.
fn uses(problem: &Problem, solution: &Solution) -> BTreeMap<String, u64> {
    let used = |index: usize| solution.steps.iter().filter(|s| s.action == index).count() as u64;
    let informative = problem.actions().iter().enumerate().filter(|(_, action)| action.required > 0);
    informative.map(|(index, action)| (action.name.clone(), used(index))).collect()
}

fn at_sea(voyage: &SailedPlan) -> Voyage {
    let SailedPlan { prepared, solved, sailing } = *voyage;
    let samples = &sailing.sailed.samples;
    let (task, rate_hz) = (&prepared.brief.task, prepared.brief.vessel.sample_rate_hz);
    Voyage {
        lattice: lattice(prepared),
        legs: voyage.legs(),
        primitives: voyage.primitives(),
        dropped: dropped(prepared),
        handling: PlanHandling { used: task.handling, derived: task.derived },
        duration_s: samples.len() as f64 / rate_hz,
        informative_s: samples.iter().filter(|s| s.informative).count() as f64 / rate_hz,
        check: sailing.check.clone(),
        uncharted_share: prepared.uncharted_share(),
        uncharted_is_water: prepared.chart.uncharted() == Uncharted::Water,
        passage: voyage.passage(),
        information: sailing.information.clone(),
        front: solved.front.clone(),
    }
}

fn lattice(prepared: &Prepared) -> PlanLattice {
    let grid = &prepared.grid;
    let (longitude_deg, latitude_deg) = prepared.chart.plane().to_geographic(grid.origin_m);
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

/// Moves that are not available to the search.
fn dropped(prepared: &Prepared) -> Vec<DroppedMove> {
    let grid = &prepared.grid;
    let dropped = prepared.dropped.iter().map(|dropped| {
        let (level, mode) = grid.level_and_mode(dropped.from);
        let (name, mode, why) = (dropped.name.clone(), grid.modes[mode].name.clone(), dropped.why.clone());
        DroppedMove { name, side: dropped.side, h: level as u64, mode, why }
    });
    dropped.collect()
}

/// The map of a trial with its `plan` and the simulated `voyage`.
pub fn map_of(planned: &SailedPlan, plan: &PlanDocument, voyage: &Voyage) -> MapDocument {
    let (task, chart) = (&planned.prepared.brief.task, &planned.prepared.chart);
    let (plane, bounds) = (chart.plane(), planned.frame());
    let ([west_m, south_m], [east_m, north_m]) = (bounds.min, bounds.max);
    let (longitude_deg, latitude_deg) = plane.to_geographic([0.0; 2]);
    let ring = |corners: &[[f64; 2]]| -> MapLine {
        corners.iter().map(|[longitude, latitude]| plane.to_plane(*longitude, *latitude)).collect()
    };
    let [meridians, parallels] = planned.graticule();
    MapDocument {
        safe: voyage.check.safe,
        statement: format!(
            "{} steps, {} {}: {}",
            plan.steps.len(),
            plan.cost,
            plan.cost_unit.name(),
            plan.statement
        ),
        counts: plan.counts.clone(),
        longitude_deg,
        latitude_deg,
        frame: MapFrame { west_m, south_m, east_m, north_m },
        uncharted_is_water: chart.uncharted() == Uncharted::Water,
        depth_limits_m: planned.shades_m().to_vec(),
        cells: cells(planned),
        areas: planned.areas().into_iter().filter_map(area).collect(),
        contours: chart
            .contours()
            .iter()
            .map(|c| MapContour { depth_m: c.depth_m, line: c.line.iter().copied().collect() })
            .collect(),
        margins: margins(planned),
        spots: chart.spots().iter().map(spot).collect(),
        names: planned.names().into_iter().map(|(at, name)| MapName { place: at.into(), name }).collect(),
        swept: planned.swept().map(|(raster, set)| MapSwept {
            vessels: planned.sailing.runs.len() as u64,
            raster: raster.into(),
            runs: set.into_iter().collect(),
        }),
        corridors: voyage.passage.corridors(plane).into_iter().flatten().map(MapLine::from_iter).collect(),
        edge: Some(ring(&task.area.corners)).filter(|edge| !edge.east_m.is_empty()),
        speed_limits: task.speed_limits.iter().map(|speed_limit| ring(&speed_limit.corners)).collect(),
        tracks: tracks(planned, plan, voyage),
        aborts: planned.aborts().map(|(_, places, _)| places.iter().copied().collect()).collect(),
        hulls: planned.hulls().into_iter().map(MapLine::from_iter).collect(),
        start: planned.start().map(Into::into),
        goal: planned.end().map(Into::into),
        meridians: meridians
            .into_iter()
            .map(|(longitude_deg, east_m)| MapMeridian { longitude_deg, east_m })
            .collect(),
        parallels: parallels
            .into_iter()
            .map(|(latitude_deg, north_m)| MapParallel { latitude_deg, north_m })
            .collect(),
    }
}

fn cells(planned: &SailedPlan) -> Option<MapCells> {
    let class = |(class, set): (Class, Vec<bool>)| {
        let (class, least_m) = called(class)?;
        Some(MapCellClass { class, least_m, runs: set.into_iter().collect() })
    };
    let classes: Vec<MapCellClass> = planned.cells().into_iter().filter_map(class).collect();
    (!planned.prepared.chart.grids().is_empty())
        .then(|| MapCells { raster: planned.raster().into(), classes })
}

fn area(polygon: Polygon) -> Option<MapArea> {
    let (class, least_m) = called(polygon.class)?;
    let rings = polygon.rings.into_iter().map(MapLine::from_iter).collect();
    Some(MapArea { class, least_m, rings })
}

/// The class in the map, and its least depth; `None` for water for transit only or of unknown depth.
fn called(class: Class) -> Option<(MapClass, Option<f64>)> {
    match class {
        Class::Land => Some((MapClass::Land, None)),
        Class::NoGo | Class::Danger { .. } => Some((MapClass::NoGo, None)),
        Class::TransitOnly => None,
        Class::Depth { least_m } => Some((MapClass::Depth, Some(least_m?))),
    }
}

fn margins(planned: &SailedPlan) -> Vec<MapMargin> {
    let purposes = [MapPurpose::Trial, MapPurpose::Transit];
    let margin = |(purpose, set): (MapPurpose, Vec<bool>)| MapMargin {
        purpose,
        raster: planned.raster().into(),
        runs: set.into_iter().collect(),
    };
    purposes.into_iter().zip(planned.margins()).map(margin).collect()
}

fn spot(spot: &Spot) -> MapSpot {
    MapSpot {
        place: spot.place.into(),
        symbol: if spot.sounding { MapSymbol::Sounding } else { MapSymbol::Danger },
        depth_m: spot.called.depth_m,
        title: spot.called.to_string(),
    }
}

fn tracks(planned: &SailedPlan, plan: &PlanDocument, voyage: &Voyage) -> Vec<MapTrack> {
    let mut number = 0;
    let track = |part: TrackPart| {
        let name = Some(voyage.legs[part.step].name.clone());
        let maneuver = name.filter(|name| plan.counts.contains_key(name));
        let kind = match (part.informative, &maneuver) {
            (true, Some(_)) => MapTrackKind::Maneuver,
            (false, Some(_)) => MapTrackKind::RunIn,
            _ => MapTrackKind::Basic,
        };
        number += u64::from(part.informative);
        let number = part.informative.then_some(number);
        MapTrack { kind, maneuver, number, line: part.points.into_iter().collect() }
    };
    planned.track().into_iter().map(track).collect()
}

impl From<[f64; 2]> for MapPlace {
    fn from([east_m, north_m]: [f64; 2]) -> Self {
        Self { east_m, north_m }
    }
}

impl FromIterator<[f64; 2]> for MapLine {
    fn from_iter<I: IntoIterator<Item = [f64; 2]>>(places: I) -> Self {
        let (east_m, north_m) = places.into_iter().map(|[east, north]| (east, north)).unzip();
        Self { east_m, north_m }
    }
}

impl From<Raster> for MapRaster {
    fn from(raster: Raster) -> Self {
        let ([west_m, south_m], cell_m) = (raster.origin, raster.cell_m);
        Self { west_m, south_m, cell_m, columns: raster.nx as u64, rows: raster.ny as u64 }
    }
}

impl FromIterator<bool> for MapRuns {
    fn from_iter<I: IntoIterator<Item = bool>>(set: I) -> Self {
        let (mut runs, mut is_in) = (vec![0], false);
        for cell in set {
            if cell != is_in {
                runs.push(0);
                is_in = cell;
            }
            if let Some(run) = runs.last_mut() {
                *run += 1;
            }
        }
        Self(runs)
    }
}

/// A file's name and content.
pub type NamedFile = (String, Vec<u8>);

/// The index of the step that an abort track leads from the end of, its places, east and north \[m\], and which of them are its
/// waypoints.
pub type Abort<'a> = (usize, &'a [[f64; 2]], Vec<usize>);

/// A plan's track on the globe.
pub struct Routes<'a> {
    /// Name of the trial.
    pub name: &'a str,
    /// The plane of its coordinates.
    pub plane: &'a Plane,
    /// The plan.
    pub document: &'a PlanDocument,
    /// Its part at sea.
    pub voyage: &'a Voyage,
    /// The simulated track.
    pub sailed: &'a Sailed,
    /// Abort tracks.
    pub aborts: Vec<Abort<'a>>,
    /// Time from sample to sample \[s\].
    pub sample_s: f64,
}

impl Routes<'_> {
    /// Names and contents of the files for bridges and maps; `rtz_name` is that of `route.rtz`, without
    /// its ending.
    ///
    /// # Errors
    /// A route that the format does not support, with the name of its file.
    pub fn files(&self, rtz_name: &str) -> Result<Vec<NamedFile>, (String, Invalid)> {
        let route = self.route();
        // ECDIS expect the route to be called as its file.
        let filed = Route { name: self.labelled(rtz_name), ..route.clone() };
        let files = [
            ("track.geojson", geojson(&self.features())),
            ("route.rtz", rtz(&filed)),
            ("route.gpx", gpx(&[&route], &[self.track()])),
            ("route.plan", qgroundcontrol(&route)),
        ];
        let files = files.map(|(name, text)| (name.to_owned(), text)).into_iter();
        let aborts: Vec<(usize, Route)> =
            self.aborts.iter().map(|one| (one.0 + 1, self.abort(one))).collect();
        let routes: Vec<&Route> = aborts.iter().map(|(_, route)| route).collect();
        let all = [
            ("aborts.gpx".to_owned(), gpx(&routes, &[])),
            ("aborts.geojson".to_owned(), geojson(&self.abort_features())),
        ];
        let (before, after) = rtz_name.rsplit_once("route").unwrap_or_default();
        let single = aborts.iter().map(|(number, route)| {
            let name = self.labelled(&format!("{before}abort-{number}{after}"));
            (format!("abort-{number}.rtz"), rtz(&Route { name, ..route.clone() }))
        });
        let named = |(name, text): (String, Result<String, Invalid>)| match text {
            Ok(text) => Ok((name, text.into_bytes())),
            Err(invalid) => Err((name, invalid)),
        };
        files.chain(all).chain(single).map(named).collect()
    }

    /// The route along an abort track.
    fn abort(&self, (step, places, corners): &Abort) -> Route {
        let waypoint = |(index, corner): (usize, &usize)| {
            let [lon_deg, lat_deg] = self.position(places[*corner]);
            let before = corners[index.saturating_sub(1)];
            let way_m = self.plane.distance_m(self.position(places[before]), [lon_deg, lat_deg]);
            let speed_m_s = way_m / ((corner - before) as f64 * self.sample_s);
            let speed_m_s = Some(speed_m_s).filter(|speed| *speed > 0.0);
            let (id, name) = (index as u32, index.to_string());
            Waypoint { id, name, lon_deg, lat_deg, speed_m_s, ..Waypoint::default() }
        };
        let waypoints = corners.iter().enumerate().map(waypoint).collect();
        Route { name: self.labelled(&format!("abort from leg {}", step + 1)), departure: None, waypoints }
    }

    /// A line per abort track, with its place.
    fn abort_features(&self) -> Vec<Feature> {
        let feature = |(step, places, _): &Abort| {
            let line = places.iter().map(|place| self.position(*place)).collect();
            let leg = &self.voyage.legs[*step];
            let properties = json!({
                "step": step + 1,
                "name": self.labelled(&format!("abort from leg {}", step + 1)),
                "from": leg.name,
                "to": leg.abort.as_ref().map(|abort| abort.kind),
                "duration_s": leg.abort.as_ref().map(|abort| abort.duration_s),
                "safe": self.voyage.check.safe,
            });
            Feature::new(Geometry::Line(line), properties)
        };
        self.aborts.iter().map(feature).collect()
    }

    /// The route along the passage.
    pub fn route(&self) -> Route {
        let departure = self.voyage.passage.departure.as_deref().and_then(|at| at.parse().ok());
        let mut route = Route { name: self.labelled(self.name), departure, waypoints: self.waypoints() };
        route.fit_radii();
        route
    }

    /// The prefix of names in an unsafe plan; empty for a safe one.
    pub fn label(&self) -> &'static str {
        if self.voyage.check.safe { "" } else { "unsafe plan: " }
    }

    /// A name, with the prefix if the plan fails its check.
    fn labelled(&self, name: &str) -> String {
        if self.voyage.check.safe { name.to_owned() } else { format!("{name} (unsafe)") }
    }

    fn place(&self, sample: &Sample) -> [f64; 2] {
        self.position([sample.pose.y, sample.pose.x])
    }

    fn position(&self, place: [f64; 2]) -> [f64; 2] {
        let (longitude, latitude) = self.plane.to_geographic(place);
        [longitude, latitude]
    }

    /// The end of the track.
    fn end(&self) -> [f64; 2] {
        self.sailed.ends.last().map_or([0.0; 2], |(pose, _)| self.position([pose.y, pose.x]))
    }

    /// The waypoints of the passage.
    fn waypoints(&self) -> Vec<Waypoint> {
        let Passage { longitude_deg, latitude_deg, before, leave_s, legs, .. } = &self.voyage.passage;
        let label = self.label();
        let first = Waypoint {
            name: "start".to_owned(),
            lon_deg: *longitude_deg,
            lat_deg: *latitude_deg,
            time_s: Some(0.0),
            leave_s: Some(*leave_s).filter(|leave| *leave > 0.0),
            note: noted(label, before),
            ..Waypoint::default()
        };
        let later = legs.iter().enumerate().map(|(index, leg)| Waypoint {
            id: index as u32 + 1,
            name: (index + 1).to_string(),
            lon_deg: leg.longitude_deg,
            lat_deg: leg.latitude_deg,
            turn_radius_m: leg.turn_radius_m,
            // A leg without duration has no speed.
            speed_m_s: Some(leg.speed_m_s).filter(|speed| *speed > 0.0),
            xtd_m: Some([leg.xtd_port_m, leg.xtd_starboard_m]),
            time_s: Some(leg.end_s),
            leave_s: Some(leg.leave_s).filter(|leave| *leave > leg.end_s),
            note: noted(label, std::iter::once(&leg.what).chain(&leg.then)),
        });
        let mut waypoints: Vec<Waypoint> = std::iter::once(first).chain(later).collect();
        if waypoints.len() == 1 {
            // A trial that stays at its node still needs a leg: to its farthest position.
            let from = [waypoints[0].lon_deg, waypoints[0].lat_deg];
            let away = |place: &[f64; 2]| self.plane.distance_m(from, *place);
            let places = self.sailed.samples.iter().map(|s| self.place(s));
            let farthest = places.max_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(from);
            let [lon_deg, lat_deg] = farthest;
            waypoints.push(Waypoint { id: 1, name: "1".to_owned(), lon_deg, lat_deg, ..Waypoint::default() });
        }
        waypoints
    }

    fn track(&self) -> Track {
        let points = self.sailed.samples.iter().map(|s| self.place(s)).chain([self.end()]);
        let clock_s = [0.0, self.sample_s];
        Track { name: self.labelled("planned track"), points: points.collect(), clock_s }
    }

    /// The track of step `k`, up to the start of the next one.
    fn line(&self, k: usize) -> Vec<[f64; 2]> {
        let samples = &self.sailed.samples;
        let leg = samples.iter().skip_while(|s| s.leg != k).take_while(|s| s.leg == k);
        let mut line: Vec<[f64; 2]> = leg.map(|s| self.place(s)).collect();
        line.push(samples.iter().find(|s| s.leg == k + 1).map_or(self.end(), |s| self.place(s)));
        line
    }

    /// A line per step that moves the ship, then start and goal.
    pub fn features(&self) -> Vec<Feature> {
        let mut features = Vec::new();
        let samples = &self.sailed.samples;
        for (k, (step, leg)) in self.document.steps.iter().zip(&self.voyage.legs).enumerate() {
            let line = self.line(k);
            if line.len() < 2 {
                continue;
            }
            let properties = json!({
                "step": k + 1,
                "name": format!("{}{}", self.label(), leg.name),
                "order": leg.order,
                "action": step.action,
                "variant": step.variant,
                "informative": leg.informative,
                "side": leg.side,
                "start_s": leg.start_s,
                "duration_s": leg.duration_s,
                "heading_deg": leg.heading_deg,
                "speed_m_s": leg.speed_m_s,
                "safe": self.voyage.check.safe,
            });
            features.push(Feature::new(Geometry::Line(line), properties));
        }
        let check = &self.voyage.check;
        let point = |name: &str, place: [f64; 2]| {
            let properties = json!({ "name": name, "safe": check.safe, "faults": check.faults });
            Feature::new(Geometry::Point(place), properties)
        };
        if let Some(first) = samples.first() {
            features.push(point("start", self.place(first)));
            features.push(point("goal", self.end()));
        }
        features
    }
}

/// The actions, in words, with the prefix in an unsafe plan.
fn noted<'a>(label: &str, what: impl IntoIterator<Item = &'a String>) -> String {
    let what: Vec<String> = what.into_iter().map(|what| format!("{label}{what}")).collect();
    what.join(", ")
}
