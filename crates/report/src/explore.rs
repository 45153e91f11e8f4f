//! `explore.html`: the trials, the model over time and the plans of a study, to be zoomed, filtered and sorted.

use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::{Value, json};
use study::documents::{
    Check, MapArea, MapCells, MapClass, MapDocument, MapLine, MapPlace, MapRaster, MapRuns, MapTrack,
    MapTrackKind, PlanDocument, Traced, Voyage, VoyageLeg,
};
use study::{scores, selection};

use crate::headline::kind;
use crate::page::STYLE;
use crate::parts::{coded, missing, statements};
use crate::planned_trial::{PlannedTrial, label};
use crate::study::Study;
use crate::trajectory::words::{action, heading, knots, latitude, longitude};

/// No request leaves the page: the browser refuses all but what stands in it.
const POLICY: &str =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:";

/// The interactive page beside the report, whose file is called `report`. The same study gives the same bytes.
pub fn explore(study: &Study, report: &str) -> String {
    let mut panels = self::panels(study);
    panels.extend(panel(study));
    panels.extend(plan_panels(study));
    page(study, report, &panels).into_string()
}

fn page(study: &Study, report: &str, panels: &[Panel]) -> Markup {
    let of = |library: Library| panels.iter().any(|panel| panel.library == library).then_some(library);
    let libraries: Vec<Library> = [Library::Plots, Library::Maps].into_iter().filter_map(of).collect();
    let data: Value = panels.iter().map(|panel| json!({"id": panel.id, "data": panel.data})).collect();
    // JSON that no tag can end.
    let data = data.to_string().replace('<', "\\u003c");
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (study.name) " – explore" }
                style { (PreEscaped(STYLE)) @for library in &libraries { (PreEscaped(library.style())) } (PreEscaped(EXPLORE_STYLE)) }
            }
            body {
                main {
                    (head(study, report))
                    nav aria-label="Contents" { @for panel in panels { a href={ "#" (panel.id) } { (panel.title) } } }
                    noscript { p.missing { "This page needs JavaScript. " (link(report, "The report")) " does without." } }
                    @for panel in panels { section id=(panel.id) { h2 { (panel.title) } (panel.about) div.panel {} } }
                    @if panels.is_empty() {
                        (missing("Trials are", "scores.parquet", "validate"))
                        (missing("Measured and simulated motion is", "compare.parquet", "validate --model"))
                        (missing("A plan on its map is", "map.json", "plan"))
                    }
                }
                script #data type="application/json" { (PreEscaped(data)) }
                @for library in &libraries { script { (PreEscaped(library.script())) } }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
}

fn head(study: &Study, report: &str) -> Markup {
    html! {
        header {
            p.kicker { (kind(study)) ", to explore" }
            h1 { (study.name) }
            p.about { (link(report, "The report")) " has the results in words, and the digests of all files." }
            @if let Some(label) = &study.data {
                p.label { "Data: " b { (label) } ". No real ship was measured; the logs that everything here is made of were simulated." }
            }
            @if !study.mixed.is_empty() {
                p.label { "Mixed: files of different studies, made with more than one " (study.mixed.join(", ")) "." }
            }
        }
    }
}

/// A link to a file beside the page; `./` keeps a name with a colon from being read as another address.
fn link(file: &str, words: &str) -> Markup {
    html! { a href={ "./" (file.replace('%', "%25").replace('#', "%23").replace('?', "%3F")) } { (words) } }
}

/// Samples beyond this many are not in the page.
const MOST: usize = 12_000;

/// Measured and simulated motion of every window; `None` in a study without.
fn panel(study: &Study) -> Option<Panel> {
    let (document, rows) = study.measured.as_ref()?.compared.as_ref()?;
    let windows = rows.chunk_by(|a, b| a.source == b.source && a.window == b.window);
    let every = stride(rows.len(), MOST);
    let windows: Vec<Value> = windows.map(|rows| window(rows, every)).collect();
    let verdict = document.statements.first();
    let about = html! {
        @if let Some(verdict) = verdict { p { (coded(verdict)) } }
        p {
            "Measured in the colour of the text, simulated in blue with its 95 % band. "
            "Drag to zoom; all three plots have the same time."
        }
        @if every > 1 { p.note { "One of every " (every) " samples is in this page; the file has all." } }
    };
    (!rows.is_empty()).then(|| Panel {
        id: "time".to_owned(),
        title: "Measured and simulated".to_owned(),
        about,
        data: json!({"kind": "time", "windows": windows}),
        library: Library::Plots,
    })
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

/// The head of a column of a table; `kind` is `text`, `number` or `clock`.
fn column(name: &str, unit: &str, kind: &str) -> Value {
    json!({"name": name, "unit": unit, "kind": kind})
}

/// One of so many elements is kept that at most `most` remain.
fn stride(all: usize, most: usize) -> usize {
    all.div_ceil(most).max(1)
}

/// A section with its data, which the script draws.
struct Panel {
    id: String,
    title: String,
    about: Markup,
    data: Value,
    library: Library,
}

/// The script and the style of the page, and the libraries that it has where they are needed.
const SCRIPT: &str = include_str!("../assets/explore.js");
const EXPLORE_STYLE: &str = include_str!("../assets/explore.css");

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

/// Simulated trials by their scores, and picks of sub-experiments by their errors.
fn panels(study: &Study) -> Vec<Panel> {
    let trials = study.scores.as_deref().filter(|rows| !rows.is_empty());
    let picks = study.selection.as_ref().map(|selection| &selection.rows).filter(|rows| !rows.is_empty());
    trials.map(scored).into_iter().chain(picks.map(|rows| picked(rows))).collect()
}

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

fn scored(rows: &[scores::Row]) -> Panel {
    let columns = run_columns("run", "parameter error", ("simulation error", ""));
    let row = |row: &scores::Row| {
        let [u, v, r] = row.rmse.map(number);
        let [parameter, simulation] = [row.parameter_error, row.simulation_error].map(number);
        json!([row.design, row.run, row.status.name(), parameter, u, v, r, simulation])
    };
    runs_panel("trials", "Trials", &columns, rows, row, [3, 7])
}

fn picked(rows: &[selection::Row]) -> Panel {
    let columns = run_columns("realization", "error norm", ("error norm, left out", "1"));
    let row = |row: &selection::Row| {
        let [u, v, r] = row.rmse.map_or([const { Value::Null }; 3], |rmse| rmse.map(number));
        let [norm, left_out] = [row.error_norm, row.left_out_norm].map(number);
        json!([row.design, row.number, row.status.name(), norm, u, v, r, left_out])
    };
    runs_panel("picks", "Selected sub-experiments", &columns, rows, row, [3, 7])
}

/// Dots at the columns `axes`, in a colour per design, the first column.
fn runs_panel<R>(
    id: &str,
    title: &str,
    columns: &[Value],
    rows: &[R],
    row: impl Fn(&R) -> Value,
    axes: [usize; 2],
) -> Panel {
    let every = stride(rows.len(), MOST_RUNS);
    let shown: Vec<Value> = rows.iter().step_by(every).map(row).collect();
    Panel {
        id: id.to_owned(),
        title: title.to_owned(),
        about: about(rows.len(), every),
        data: json!({"kind": "dots", "columns": columns, "rows": shown, "axes": axes, "group": 0}),
        library: Library::Plots,
    }
}

fn about(all: usize, every: usize) -> Markup {
    html! {
        p {
            "Each dot is one of " (all) " trials. Drag over dots to keep them in the table, or type limits. "
            "Click a row to find its dot."
        }
        @if every > 1 { p.note { "One of every " (every) " trials is in this page; the file has all." } }
    }
}

/// A section for each plan with a map: the study's own, its variants, that of the next trial.
fn plan_panels(study: &Study) -> Vec<Panel> {
    let plans = study.trajectory.iter().flat_map(|plans| plans.main.iter().chain(&plans.variants));
    let next = study.measured.iter().filter_map(|measured| measured.next.as_ref()?.planned.as_ref());
    let all = plans.chain(next).enumerate();
    all.filter_map(|(index, trial)| plan_panel(study, trial, index)).collect()
}

fn plan_panel(study: &Study, trial: &PlannedTrial, index: usize) -> Option<Panel> {
    let map = trial.document.as_ref()?;
    let voyage = trial.plan.voyage.as_ref();
    let sheet = voyage.map(|voyage| sheet(study, &trial.plan, voyage));
    let linked = voyage.and_then(|voyage| steps_of(&map.tracks, &voyage.legs));
    let title = if trial.name.is_empty() { "Plan".to_owned() } else { format!("Plan {}", trial.name) };
    Some(Panel {
        id: format!("plan-{}", index + 1),
        title,
        about: about_plan(trial, map, voyage, linked.is_some()),
        data: json!({"kind": "map", "map": drawn(map, linked.as_deref()), "sheet": sheet}),
        library: Library::Maps,
    })
}

fn about_plan(trial: &PlannedTrial, map: &MapDocument, voyage: Option<&Voyage>, linked: bool) -> Markup {
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
