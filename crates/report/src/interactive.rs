//! What a reader zooms, filters and sorts: trials, the model over time and plans, in the places of their figures.

use maud::{Markup, PreEscaped, html};
use serde_json::{Value, json};
use study::documents::{
    MapArea, MapCells, MapClass, MapDocument, MapLine, MapPlace, MapRaster, MapRuns, MapTrack, MapTrackKind,
    Traced, VoyageLeg,
};
use study::{scores, selection};

use crate::planned_trial::label;

/// What a script draws in the place of a figure.
pub(super) struct Panel {
    pub(super) id: String,
    pub(super) about: Markup,
    data: Value,
    library: Library,
}

/// The style that `panels` need.
pub(super) fn styles(panels: &[Panel]) -> Markup {
    html! { @if !panels.is_empty() { style { @for library in libraries(panels) { (PreEscaped(library.style())) } (PreEscaped(STYLE)) } } }
}

/// The data of `panels` and the scripts that draw them.
pub(super) fn scripts(panels: &[Panel]) -> Markup {
    let data: Value = panels.iter().map(|panel| json!({"id": panel.id, "data": panel.data})).collect();
    // JSON that no tag can end.
    let data = data.to_string().replace('<', "\\u003c");
    html! {
        @if !panels.is_empty() {
            script #data type="application/json" { (PreEscaped(data)) }
            @for library in libraries(panels) { script { (PreEscaped(library.script())) } }
            script { (PreEscaped(SCRIPT)) }
        }
    }
}

fn libraries(panels: &[Panel]) -> Vec<Library> {
    let of = |library: &Library| panels.iter().any(|panel| panel.library == *library);
    [Library::Plots, Library::Maps].into_iter().filter(of).collect()
}

/// Samples beyond this many are not in the page.
const MOST: usize = 12_000;

/// Measured and simulated motion of every window.
pub(super) fn over_time(windows: &[&[Traced]]) -> Panel {
    let every = stride(windows.iter().map(|rows| rows.len()).sum(), MOST);
    let about = html! {
        p.note {
            "Measured in the colour of the text, simulated in blue with its 95 % band. "
            "Drag to zoom; all three plots have the same time."
        }
        @if every > 1 { p.note { "One of every " (every) " samples is in this page; the file has all." } }
    };
    let windows: Vec<Value> = windows.iter().map(|rows| window(rows, every)).collect();
    let data = json!({"kind": "time", "windows": windows});
    Panel { id: "time".to_owned(), about, data, library: Library::Plots }
}

fn window(rows: &[Traced], every: usize) -> Value {
    let rows = || rows.iter().step_by(every);
    let all = |of: &dyn Fn(&Traced, usize) -> Option<f64>| -> Value {
        (0..3).map(|d| rows().map(|row| number(of(row, d))).collect::<Value>()).collect()
    };
    let first = rows().next();
    json!({
        "source": first.map(|row| row.source.as_str()),
        "window": first.map(|row| row.window + 1),
        "t": rows().map(|row| number(row.t)).collect::<Value>(),
        "measured": all(&|row, d| Some(row.measured[d])),
        "simulated": all(&|row, d| Some(row.simulated[d])),
        "half": all(&|row, d| row.half[d]),
    })
}

/// `value` with five significant digits; null if it is missing or not finite.
fn number(value: impl Into<Option<f64>>) -> Value {
    let short = |value: f64| format!("{value:.4e}").parse::<f64>().ok();
    value.into().filter(|value| value.is_finite()).and_then(short).map_or(Value::Null, Value::from)
}

/// The places of a line in tenths of a metre: the first east and north, then differences to the place before.
fn line(line: &MapLine) -> Value {
    #[expect(clippy::cast_possible_truncation, reason = "a map is smaller than the Earth")]
    let tenths = |metres: f64| (10.0 * metres).round() as i64;
    let mut last = [0; 2];
    let places = line.east_m.iter().zip(&line.north_m);
    let steps = places.flat_map(|(east, north)| {
        let place = [tenths(*east), tenths(*north)];
        let step = [place[0] - last[0], place[1] - last[1]];
        last = place;
        step
    });
    steps.collect::<Vec<i64>>().into()
}

/// The head of a column of a table; `kind` is `text` or `number`.
fn column(name: &str, unit: &str, kind: &str) -> Value {
    json!({"name": name, "unit": unit, "kind": kind})
}

/// One of so many elements is kept that at most `most` remain.
fn stride(all: usize, most: usize) -> usize {
    all.div_ceil(most).max(1)
}

const SCRIPT: &str = include_str!("../assets/interactive.js");
const STYLE: &str = include_str!("../assets/interactive.css");

/// What draws a panel.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Library {
    /// uPlot 1.6.32.
    Plots,
    /// Leaflet 1.9.4.
    Maps,
}

impl Library {
    /// The library with its license.
    fn script(self) -> String {
        let [license, code] = match self {
            Self::Plots => [
                include_str!("../assets/vendor/uplot/LICENSE"),
                include_str!("../assets/vendor/uplot/uPlot.iife.min.js"),
            ],
            Self::Maps => [
                include_str!("../assets/vendor/leaflet/LICENSE"),
                include_str!("../assets/vendor/leaflet/leaflet.js"),
            ],
        };
        format!("/*\n{license}\n*/\n{}", without(code, "sourceMappingURL"))
    }

    /// Its style, without the pictures of controls that the page does not have.
    fn style(self) -> String {
        let text = match self {
            Self::Plots => include_str!("../assets/vendor/uplot/uPlot.min.css"),
            Self::Maps => include_str!("../assets/vendor/leaflet/leaflet.css"),
        };
        without(text, "url(")
    }
}

/// `text` without the lines that have `word`.
fn without(text: &str, word: &str) -> String {
    text.lines().filter(|line| !line.contains(word)).flat_map(|line| [line, "\n"]).collect()
}

/// Trials beyond this many are not in the page.
const MOST_RUNS: usize = 10_000;

/// Columns of runs: their number, an error, the states' errors, and another error with its unit.
fn run_columns(number: &str, error: &str, (other, unit): (&str, &str)) -> [Value; 8] {
    [
        column("design", "", "text"),
        column(number, "", "number"),
        column("status", "", "text"),
        column(error, "1", "number"),
        column("RMSE u", "m/s", "number"),
        column("RMSE v", "m/s", "number"),
        column("RMSE r", "rad/s", "number"),
        column(other, unit, "number"),
    ]
}

/// Simulated trials by their scores.
pub(super) fn scored(rows: &[scores::Row]) -> Panel {
    let columns = run_columns("run", "parameter error", ("simulation error", ""));
    let row = |row: &scores::Row| {
        let [u, v, r] = row.rmse.map(number);
        let [parameter, simulation] = [row.parameter_error, row.simulation_error].map(number);
        json!([row.design, row.run, row.status.name(), parameter, u, v, r, simulation])
    };
    runs_panel("trials", &columns, rows, row)
}

/// Picks of sub-experiments by their errors.
pub(super) fn picked(rows: &[selection::Row]) -> Panel {
    let columns = run_columns("realization", "error norm", ("error norm, left out", "1"));
    let row = |row: &selection::Row| {
        let [u, v, r] = row.rmse.map_or([const { Value::Null }; 3], |rmse| rmse.map(number));
        let [norm, left_out] = [row.error_norm, row.left_out_norm].map(number);
        json!([row.design, row.number, row.status.name(), norm, u, v, r, left_out])
    };
    runs_panel("picks", &columns, rows, row)
}

/// Dots of two errors, in a colour per design, the first column.
fn runs_panel<R>(id: &str, columns: &[Value], rows: &[R], row: impl Fn(&R) -> Value) -> Panel {
    let every = stride(rows.len(), MOST_RUNS);
    let shown: Vec<Value> = rows.iter().step_by(every).map(row).collect();
    let about = html! {
        p.note {
            "Each dot is one of " (rows.len()) " trials. Drag over dots to keep them in the table, or type limits. "
            "Click a row to find its dot."
        }
        @if every > 1 { p.note { "One of every " (every) " trials is in this page; the file has all." } }
    };
    let data = json!({"kind": "dots", "columns": columns, "rows": shown, "axes": [3, 7], "group": 0});
    Panel { id: id.to_owned(), about, data, library: Library::Plots }
}

/// A plan on its map. The track is linked to the steps of the maneuver sheet that `legs` belong to.
pub(super) fn chart(id: &str, map: &MapDocument, legs: &[VoyageLeg]) -> Panel {
    let steps = steps_of(&map.tracks, legs);
    let about = html! {
        p.note {
            "Drag to pan. After a click into the map, the wheel zooms; two fingers, + and − always do. "
            @if steps.is_some() { "A row of the maneuver sheet shows its step here, and a click on the track finds its row." }
        }
    };
    Panel { id: id.to_owned(), about, data: drawn(map, steps.as_deref()), library: Library::Maps }
}

/// What the script draws, in the order of the map's document.
fn drawn(map: &MapDocument, steps: Option<&[usize]>) -> Value {
    let frame = map.frame;
    json!({
        "kind": "map",
        "frame": [frame.west_m, frame.south_m, frame.east_m, frame.north_m],
        "uncharted": !map.uncharted_is_water,
        "bands": map.depth_limits_m.len() + 1,
        "cells": map.cells.as_ref().map(|raster| cells(raster, map)),
        "areas": map.areas.iter().map(|rings| area(rings, map)).collect::<Value>(),
        "contours": map.contours.iter().map(|contour| json!([contour.depth_m, line(&contour.line)])).collect::<Value>(),
        "margins": map.margins.iter().map(|margin| json!([margin.purpose.name(), raster(&margin.raster), margin.runs])).collect::<Value>(),
        "spots": map.spots.iter().map(|spot| json!([place(spot.place), spot.symbol.name(), spot.depth_m, spot.title])).collect::<Value>(),
        "names": map.names.iter().map(|name| json!([place(name.place), name.name])).collect::<Value>(),
        "swept": map.swept.as_ref().map(|swept| json!([swept.vessels, raster(&swept.raster), swept.runs])),
        "corridors": lines(&map.corridors),
        "edge": map.edge.as_ref().map(line),
        "limits": lines(&map.speed_limits),
        "tracks": tracks(map, steps),
        "aborts": lines(&map.aborts),
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

fn place(place: MapPlace) -> Value {
    json!([place.east_m, place.north_m])
}

fn raster(raster: &MapRaster) -> Value {
    json!([raster.west_m, raster.south_m, raster.cell_m, raster.columns, raster.rows])
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

fn area(area: &MapArea, map: &MapDocument) -> Value {
    json!([class(area.class, area.least_m, map), lines(&area.rings)])
}

fn cells(cells: &MapCells, map: &MapDocument) -> Value {
    let classes: Vec<(Value, &MapRuns)> =
        cells.classes.iter().map(|cell| (class(cell.class, cell.least_m, map), &cell.runs)).collect();
    json!([raster(&cells.raster), classes])
}

/// Kind, place of the maneuver among all, its number, the line, and the step of the plan.
fn tracks(map: &MapDocument, steps: Option<&[usize]>) -> Value {
    let track = |(index, track): (usize, &MapTrack)| {
        let maneuver = map.counts.keys().position(|name| track.maneuver.as_ref() == Some(name));
        json!([track.kind.name(), maneuver, track.number, line(&track.line), steps.map(|steps| steps[index])])
    };
    map.tracks.iter().enumerate().map(track).collect()
}

/// The step that each part of the track belongs to; `None` without legs, or if they are not of the same plan.
///
/// A basic step has one part. An informative one has its approach, the maneuver and, unless it ends with it, its recovery.
fn steps_of(tracks: &[MapTrack], legs: &[VoyageLeg]) -> Option<Vec<usize>> {
    // Whether an approach leads to a maneuver, and whether a part is an approach: a maneuver follows.
    let is =
        |index: Option<usize>, kind| index.and_then(|i| tracks.get(i)).is_some_and(|part| part.kind == kind);
    let mut next = 0;
    let mut steps = Vec::with_capacity(tracks.len());
    for (index, track) in tracks.iter().enumerate() {
        let begins = match track.kind {
            MapTrackKind::Basic => true,
            MapTrackKind::Maneuver => !is(index.checked_sub(1), MapTrackKind::RunIn),
            MapTrackKind::RunIn => is(Some(index + 1), MapTrackKind::Maneuver),
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
