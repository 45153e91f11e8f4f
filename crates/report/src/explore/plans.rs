//! Plans on their maps, with their sheets.

use maud::{Markup, html};
use serde_json::{Value, json};
use study::documents::{
    Check, MapArea, MapCells, MapClass, MapDocument, MapLine, MapPlace, MapRaster, MapRuns, MapTrack,
    MapTrackKind, PlanDocument, Voyage, VoyageLeg,
};

use super::{Library, Panel, column, line, number};
use crate::parts::statements;
use crate::planned_trial::{PlannedTrial, label};
use crate::study::Study;
use crate::trajectory::words::{action, heading, knots, latitude, longitude};

/// A section for each plan with a map: the study's own, its variants, that of the next trial.
pub(super) fn panels(study: &Study) -> Vec<Panel> {
    let own = study.trajectory.iter().flat_map(|own| own.main.iter().chain(&own.variants));
    let next = study.measured.iter().filter_map(|own| own.next.as_ref()?.planned.as_ref());
    let all = own.chain(next).enumerate();
    all.filter_map(|(index, trial)| panel(study, trial, index)).collect()
}

fn panel(study: &Study, trial: &PlannedTrial, index: usize) -> Option<Panel> {
    let map = trial.document.as_ref()?;
    let voyage = trial.plan.voyage.as_ref();
    let sheet = voyage.map(|voyage| sheet(study, &trial.plan, voyage));
    let linked = voyage.and_then(|voyage| steps_of(&map.tracks, &voyage.legs));
    let title = if trial.name.is_empty() { "Plan".to_owned() } else { format!("Plan {}", trial.name) };
    Some(Panel {
        id: format!("plan-{}", index + 1),
        title,
        about: about(trial, map, voyage, linked.is_some()),
        data: json!({"kind": "map", "map": drawn(map, linked.as_deref()), "sheet": sheet}),
        library: Library::Maps,
    })
}

fn about(trial: &PlannedTrial, map: &MapDocument, voyage: Option<&Voyage>, linked: bool) -> Markup {
    let faults = voyage.map(|Voyage { check: Check { faults, .. }, .. }| faults.join(", "));
    html! {
        p.missing {
            b { "Not for navigation." } " The plan was checked in simulation against its charts and nothing else. The master decides."
        }
        @if !map.safe {
            p.missing { b { "Unsafe." } " The plan fails its own check: " (faults.unwrap_or_default()) "." }
        }
        @if !trial.stale.is_empty() {
            p.missing { b { "Outdated." } " These files differ from those that the plan was made from: " (trial.stale.join(", ")) "." }
        }
        (statements(std::slice::from_ref(&map.statement)))
        p {
            "Drag to pan. After a click into the map, the wheel zooms; two fingers, + and − always do. "
            @if linked { "A row of the sheet shows its step on the map, and a click on the track finds its row." }
        }
    }
}

/// What the script draws, in the order of the map's document.
fn drawn(map: &MapDocument, steps: Option<&[usize]>) -> Value {
    let frame = map.frame;
    json!({
        "frame": [frame.west_m, frame.south_m, frame.east_m, frame.north_m],
        "uncharted": !map.uncharted_is_water,
        "bands": map.depth_limits_m.len() + 1,
        "cells": map.cells.as_ref().map(|own| cells(own, map)),
        "areas": map.areas.iter().map(|own| area(own, map)).collect::<Value>(),
        "contours": map.contours.iter().map(|contour| json!([contour.depth_m, line(&contour.line)])).collect::<Value>(),
        "margins": map.margins.iter().map(|margin| json!([margin.purpose.name(), raster(&margin.raster), margin.runs])).collect::<Value>(),
        "spots": map.spots.iter().map(|spot| json!([place(spot.place), spot.symbol.name(), spot.depth_m, spot.title])).collect::<Value>(),
        "names": map.names.iter().map(|name| json!([place(name.place), name.name])).collect::<Value>(),
        "swept": map.swept.as_ref().map(|swept| json!([swept.vessels, raster(&swept.raster), swept.runs])),
        "corridors": lines(&map.corridors),
        "edge": map.edge.as_ref().map(line),
        "limits": lines(&map.speed_limits),
        "tracks": tracks(map, steps),
        "maneuvers": map.counts.keys().collect::<Vec<_>>(),
        "hulls": lines(&map.hulls),
        "start": map.start.map(place),
        "goal": map.goal.map(place),
        "meridians": map.meridians.iter().map(|meridian| json!([number(meridian.east_m), label(meridian.longitude_deg, ["E", "W"])])).collect::<Value>(),
        "parallels": map.parallels.iter().map(|parallel| json!([number(parallel.north_m), label(parallel.latitude_deg, ["N", "S"])])).collect::<Value>(),
    })
}

fn lines(all: &[MapLine]) -> Value {
    all.iter().map(line).collect()
}

fn place(map_place: MapPlace) -> Value {
    json!([map_place.east_m, map_place.north_m])
}

fn raster(map_raster: &MapRaster) -> Value {
    json!([map_raster.west_m, map_raster.south_m, map_raster.cell_m, map_raster.columns, map_raster.rows])
}

/// `land`, `no-go`, or the number of the band of depth, from the shoalest.
fn class(class: MapClass, least_m: Option<f64>, map: &MapDocument) -> Value {
    let band = |depth_m: f64| map.depth_limits_m.iter().filter(|limit| depth_m >= **limit).count();
    match (class, least_m) {
        (MapClass::Depth, Some(depth_m)) => band(depth_m).into(),
        (MapClass::Depth, None) => Value::Null,
        _ => class.name().into(),
    }
}

fn area(map_area: &MapArea, map: &MapDocument) -> Value {
    json!([class(map_area.class, map_area.least_m, map), lines(&map_area.rings)])
}

fn cells(map_cells: &MapCells, map: &MapDocument) -> Value {
    let classes: Vec<(Value, &MapRuns)> =
        map_cells.classes.iter().map(|cell| (class(cell.class, cell.least_m, map), &cell.runs)).collect();
    json!([raster(&map_cells.raster), classes])
}

/// Kind, place of the maneuver among all, its number, the line, and the step of the plan.
fn tracks(map: &MapDocument, steps: Option<&[usize]>) -> Value {
    let track = |(index, own): (usize, &study::documents::MapTrack)| {
        let maneuver = map.counts.keys().position(|name| own.maneuver.as_ref() == Some(name));
        json!([own.kind.name(), maneuver, own.number, line(&own.line), steps.map(|steps| steps[index])])
    };
    map.tracks.iter().enumerate().map(track).collect()
}

// The sheet of a plan as a table, and which part of the track belongs to which of its steps.

/// A row per step of the plan.
fn sheet(study: &Study, plan: &PlanDocument, voyage: &Voyage) -> Value {
    let inputs = study.inputs();
    let mut columns = vec![
        column("step", "", "number"),
        column("maneuver no.", "", "number"),
        column("time", "h:min:s", "clock"),
        column("what", "", "text"),
        column("heading", "", "text"),
        column("speed", "m/s", "number"),
        column("speed", "kn", "number"),
        column("duration", "s", "number"),
        column("latitude", "", "text"),
        column("longitude", "", "text"),
    ];
    columns
        .extend(inputs.iter().map(|input| column(&format!("largest {}", input.name), &input.unit, "number")));
    let mut maneuvers = 0;
    let rows = plan.steps.iter().zip(&voyage.legs).enumerate();
    let rows = rows.map(|(index, (step, leg))| {
        maneuvers += usize::from(leg.informative);
        let mut row = vec![
            json!(index + 1),
            json!(leg.informative.then_some(maneuvers)),
            number(leg.start_s),
            json!(action(step, leg, &voyage.lattice)),
            json!(heading(leg.heading_deg)),
            number(leg.speed_m_s),
            number(knots(leg.speed_m_s).parse().ok()),
            number(leg.duration_s),
            json!(latitude(leg.latitude_deg)),
            json!(longitude(leg.longitude_deg)),
        ];
        row.extend(inputs.iter().map(|input| number(leg.largest_inputs.get(&input.name).copied())));
        Value::Array(row)
    });
    json!({"rows": rows.collect::<Value>(), "columns": columns})
}

/// The step of the plan that each part of the track belongs to; `None` if they are not of the same plan.
///
/// A basic step has one part. An informative one has its approach, the maneuver and, unless it ends with it, its recovery.
fn steps_of(tracks: &[MapTrack], legs: &[VoyageLeg]) -> Option<Vec<usize>> {
    let mut next = 0;
    let mut steps = Vec::with_capacity(tracks.len());
    for (index, track) in tracks.iter().enumerate() {
        let begins = match track.kind {
            MapTrackKind::Basic => true,
            MapTrackKind::Maneuver => !approached(tracks, index),
            MapTrackKind::RunIn => leads(tracks, index),
        };
        next += usize::from(begins);
        let leg = legs.get(next.checked_sub(1)?)?;
        if leg.informative == (track.kind == MapTrackKind::Basic) {
            return None;
        }
        steps.push(next - 1);
    }
    (next == legs.len()).then_some(steps)
}

/// Whether an approach leads to the maneuver at `index`.
fn approached(tracks: &[MapTrack], index: usize) -> bool {
    index.checked_sub(1).is_some_and(|before| tracks[before].kind == MapTrackKind::RunIn)
}

/// Whether the part at `index` is an approach: a maneuver follows.
fn leads(tracks: &[MapTrack], index: usize) -> bool {
    tracks.get(index + 1).is_some_and(|after| after.kind == MapTrackKind::Maneuver)
}
