//! `plan.json` of a plan.

use std::collections::BTreeMap;

use chart::{Class, Polygon, Raster, Spot, Uncharted};

use crate::documents::{
    CostUnit, DroppedMove, MapArea, MapCellClass, MapCells, MapClass, MapContour, MapDocument, MapFrame,
    MapLine, MapMargin, MapMeridian, MapName, MapParallel, MapPlace, MapPurpose, MapRaster, MapRuns, MapSpot,
    MapSwept, MapSymbol, MapTrack, MapTrackKind, PlanDocument, PlanHandling, PlanLattice, PlanPose,
    PlanStatus, PlanStep, SecondaryCost, Voyage,
};
use plan::lattice::{Pose, Problem, Solution, Status, Step};
use plan::voyage::{Check, Prepared, SailedPlan, Solved, TrackPart};

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
    let dropped = prepared.dropped.iter().map(|own| {
        let (level, mode) = grid.level_and_mode(own.from);
        let (name, mode, why) = (own.name.clone(), grid.modes[mode].name.clone(), own.why.clone());
        DroppedMove { name, side: own.side, h: level as u64, mode, why }
    });
    dropped.collect()
}

// `map.json` of a plan.

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
            .map(|contour| MapContour {
                depth_m: contour.depth_m,
                line: contour.line.iter().copied().collect(),
            })
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
