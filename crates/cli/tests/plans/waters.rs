//! Real charts: Tacoma with depths, as polygons and as a grid, and the archipelago of Turku.

use std::path::{Path, PathBuf};
use std::time::Instant;

use tempfile::TempDir;

use crate::geometry::{Polygon, local_m, moved, polygons, utm_m};
use crate::planned::*;
use crate::support::*;

/// A shared chart, or a note that it is missing.
fn chart(name: &str) -> Option<PathBuf> {
    let path = repository().join("../shared/data/charts").join(name);
    if !path.is_file() {
        println!("skipped: {} is not here", path.display());
        return None;
    }
    Some(path.canonicalize().unwrap())
}

const OWN_CHART: &str = "[[chart]]\nfile = \"land.geojson\"\nkind = \"land\"";
const OWN_AREA: &str = "west_deg = 24.98\nsouth_deg = 59.99\neast_deg = 25.02\nnorth_deg = 60.01";
const OWN_START: &str = "longitude_deg = 24.985\nlatitude_deg = 60.0";

/// Where the trial is: Commencement Bay off Tacoma.
const TACOMA_AREA: &str = "west_deg = -122.49\nsouth_deg = 47.265\neast_deg = -122.42\nnorth_deg = 47.305";
const TACOMA_START: &str = "longitude_deg = -122.455\nlatitude_deg = 47.285";

fn tacoma(charts: &str) -> Planned {
    let depths = "margin_m = 20.0\ntransit_depth_m = 4.0\ntrial_depth_m = 9.0";
    let folder = small_with(&[
        ("uncharted = \"water\"\n", ""),
        (OWN_CHART, charts),
        (OWN_AREA, TACOMA_AREA),
        (OWN_START, TACOMA_START),
        ("margin_m = 20.0", depths),
    ]);
    run(&folder, PLAN).succeeds();
    Planned::of(&folder)
}

/// Depth areas and the areas used as land.
fn tacoma_polygons(path: &Path) -> Planned {
    let file = path.display();
    tacoma(&format!(
        "[[chart]]\nfile = \"{file}\"\nkind = \"depth\"\nonly = {{ property = \"objl\", values = [\"DEPARE\", \"DRGARE\"] }}\n\
         [[chart]]\nfile = \"{file}\"\nkind = \"land\"\nonly = {{ property = \"objl\", values = [\"LNDARE\", \"PONTON\", \"HULKES\"] }}"
    ))
}

/// An ESRI ASCII grid, read anew.
struct Depths {
    corner: [f64; 2],
    cell: f64,
    rows: Vec<Vec<f64>>,
}

impl Depths {
    fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap();
        let mut lines = text.lines();
        let header: Vec<f64> =
            lines.by_ref().take(6).map(|l| l.split_whitespace().nth(1).unwrap().parse().unwrap()).collect();
        let row = |l: &str| l.split_whitespace().map(|n| n.parse().unwrap()).collect();
        let mut rows: Vec<Vec<f64>> = lines.map(row).collect();
        rows.reverse();
        assert_eq!((rows[0].len() as f64, rows.len() as f64), (header[0], header[1]));
        Self { corner: [header[2], header[3]], cell: header[4], rows }
    }

    /// Least charted depth at a place; −9999 where there is none.
    fn at(&self, place: [f64; 2]) -> f64 {
        let [x, y] = utm_m(10, place);
        let at = |p: f64, corner: f64| ((p - corner) / self.cell).floor();
        let (column, row) = (at(x, self.corner[0]), at(y, self.corner[1]));
        let row = self.rows.get(row as usize).filter(|_| row >= 0.0);
        row.and_then(|row| row.get(column as usize)).filter(|_| column >= 0.0).copied().unwrap_or(-9999.0)
    }
}

/// The hull's corners at every second, and whether a maneuver is under way.
pub fn hull(planned: &Planned) -> impl Iterator<Item = ([f64; 2], bool)> {
    let corners = [[0.0, 0.0], [15.0, 0.0], [9.0, 4.0], [-15.0, 4.0], [-15.0, -4.0], [9.0, -4.0]];
    let track = &planned.track;
    (0..track.place.len()).flat_map(move |row| {
        corners.map(|corner| (moved(track.place[row], track.pose[row][2], corner), track.informative[row]))
    })
}

fn assert_deep(planned: &Planned, depth: impl Fn([f64; 2]) -> f64) {
    let mut least = [f64::INFINITY; 2];
    for (place, informative) in hull(planned) {
        let own = &mut least[usize::from(informative)];
        *own = own.min(depth(place));
    }
    assert!(least[0] >= 4.0 && least[1] >= 9.0, "transit over {} m, maneuvers over {} m", least[0], least[1]);
    assert!(planned.number("/voyage/check/clearance_m") > 0.0);
    assert_eq!(planned.plan["status"], "optimal");
}

/// Least depth of all areas over a place; nothing charted, or land, is −9999.
fn charted(chart: &[Polygon], place: [f64; 2]) -> f64 {
    let mut depths = chart.iter().filter(|p| p.holds(place)).map(|p| {
        let depth = p.properties["DRVAL1"].as_str().map(|text| text.parse::<f64>().unwrap());
        depth.unwrap_or(-9999.0)
    });
    let first = depths.next().unwrap_or(-9999.0);
    depths.fold(first, f64::min)
}

#[test]
fn oracle_in_tacoma_the_hull_is_never_over_depth_areas_shoaler_than_its_layer() {
    let Some(path) = chart("US5WA22M_areas.geojson") else { return };
    let (planned, chart) = (tacoma_polygons(&path), polygons(&path));
    assert_deep(&planned, |place| charted(&chart, place));
}

#[test]
fn oracle_in_tacoma_the_hull_is_never_over_cells_shoaler_than_its_layer() {
    let Some(path) = chart("US5WA22M_depth_25m_utm10n.asc") else { return };
    let file = path.display();
    let planned = tacoma(&format!("[[chart]]\nfile = \"{file}\"\nkind = \"depth\"\ncrs = \"EPSG:32610\""));
    let depths = Depths::read(&path);
    assert_deep(&planned, |place| depths.at(place));
}

#[test]
fn the_shoal_part_of_the_bay_is_closed_to_maneuvers() {
    let Some(path) = chart("US5WA22M_areas.geojson") else { return };
    let planned = tacoma_polygons(&path);
    let fits: Vec<u64> = planned.voyage()["primitives"]
        .as_array()
        .unwrap()
        .iter()
        .map(|p| p["fits"].as_u64().unwrap())
        .collect();
    let nodes = planned.number("/voyage/lattice/nx") * planned.number("/voyage/lattice/ny");
    assert!(fits.iter().all(|n| *n > 0 && (*n as f64) < 0.9 * nodes), "{fits:?} of {nodes}");
}

#[test]
fn elevations_of_the_same_grid_are_the_same_waters() {
    let Some(path) = chart("US5WA22M_depth_25m_utm10n.asc") else { return };
    let text = std::fs::read_to_string(&path).unwrap();
    let (header, cells) = text.match_indices('\n').nth(5).map(|(at, _)| text.split_at(at)).unwrap();
    let turned = |token: &str| match token {
        "-9999" => token.to_owned(),
        _ => (-token.parse::<f64>().unwrap()).to_string(),
    };
    let line = |l: &str| l.split_whitespace().map(turned).collect::<Vec<_>>().join(" ");
    let up = cells.lines().map(line).collect::<Vec<_>>().join("\n");
    let plan = |kind: &str, text: &str| {
        let folder: TempDir = small_with(&[
            ("uncharted = \"water\"\n", ""),
            (OWN_CHART, &format!("[[chart]]\nfile = \"own.asc\"\nkind = \"{kind}\"\ncrs = \"EPSG:32610\"")),
            (OWN_AREA, TACOMA_AREA),
            (OWN_START, TACOMA_START),
            ("margin_m = 20.0", "margin_m = 20.0\ntransit_depth_m = 4.0\ntrial_depth_m = 9.0"),
        ]);
        put(&folder, "own.asc", text);
        run(&folder, PLAN).succeeds();
        bytes(&folder, "track.geojson")
    };
    assert!(plan("depth", &text) == plan("elevation", &format!("{header}{up}")));
}

#[test]
fn turkus_two_thousand_islands_load_and_are_planned_among() {
    let Some(path) = chart("turku_archipelago_land_gshhg_f.geojson") else { return };
    let folder = small_with(&[
        ("file = \"land.geojson\"", &format!("file = \"{}\"", path.display())),
        (OWN_AREA, "west_deg = 21.98\nsouth_deg = 60.09\neast_deg = 22.10\nnorth_deg = 60.15"),
        (OWN_START, "longitude_deg = 22.04\nlatitude_deg = 60.12"),
    ]);
    // The first clear place, from where the message says it is.
    let started = Instant::now();
    let mut ran = run(&folder, PLAN);
    if ran.code == Some(4) {
        let (lat, lon) = clear_node(&ran.stderr);
        edit(&folder, "plan.toml", OWN_START, &format!("longitude_deg = {lon}\nlatitude_deg = {lat}"));
        ran = run(&folder, PLAN);
    }
    println!("Turku: {:.1} s", started.elapsed().as_secs_f64());
    ran.succeeds();
    let (planned, land) = (Planned::of(&folder), polygons(&path));
    assert!(land.len() == 2148 && planned.plan["status"] == "optimal");
    let near: Vec<&Polygon> = land.iter().filter(|p| touches(p, &planned)).collect();
    for (place, _) in hull(&planned) {
        assert!(!near.iter().any(|polygon| polygon.holds(place)), "{place:?} is on land");
    }
}

/// Whether a polygon may contain a position of the track: one of every half minute is within 3 km of it or inside.
fn touches(polygon: &Polygon, planned: &Planned) -> bool {
    planned.track.place.iter().step_by(30).any(|place| polygon.is_within(*place, 3000.0))
}

/// Latitude and longitude of the node that a refusal names as clear.
fn clear_node(message: &str) -> (f64, f64) {
    let (_, after) = message.split_once(" away, ").unwrap_or_else(|| panic!("{message}"));
    let words: Vec<&str> = after.split_whitespace().collect();
    assert_eq!((words[1], words[3]), ("N", "E"), "{message}");
    (words[0].parse().unwrap(), words[2].parse().unwrap())
}

#[test]
fn the_node_that_a_refusal_names_as_clear_is_one_to_start_from() {
    let land = small_with(&[(OWN_START, "longitude_deg = 25.0\nlatitude_deg = 60.0")]);
    let ran = run(&land, PLAN).refuses(4, &["`start`", "m away"]);
    let (lat, lon) = clear_node(&ran.stderr);
    let [x, y] = local_m([25.0, 60.0], [lon, lat]);
    let told: f64 = ran.stderr.split(" m away").next().unwrap().rsplit(' ').next().unwrap().parse().unwrap();
    assert!((x.hypot(y) - told).abs() < 100.0, "{told} {x} {y}{ran}");
    edit(
        &land,
        "plan.toml",
        "longitude_deg = 25.0\nlatitude_deg = 60.0",
        &format!("longitude_deg = {lon}\nlatitude_deg = {lat}"),
    );
    run(&land, PLAN).succeeds();
}

#[test]
fn grids_as_agencies_publish_them_are_planned_on_and_damaged_ones_refused() {
    let name = "elevation_point.tif";
    let folder = small_with(&[
        ("uncharted = \"water\"\n", ""),
        (OWN_CHART, &format!("[[chart]]\nfile = \"{name}\"\nkind = \"elevation\"")),
        (OWN_AREA, "west_deg = 25.005\nsouth_deg = 60.003\neast_deg = 25.095\nnorth_deg = 60.072"),
        (OWN_START, "longitude_deg = 25.03\nlatitude_deg = 60.055"),
        ("margin_m = 20.0", "margin_m = 20.0\ntransit_depth_m = 5.0\ntrial_depth_m = 8.0"),
    ]);
    let bytes = std::fs::read(repository().join("fixtures/charts/grids").join(name)).unwrap();
    std::fs::write(folder.path().join(name), &bytes).unwrap();
    run(&folder, PLAN).succeeds();
    let planned = Planned::of(&folder);
    let island = [25.0 + 20.5 / 240.0, 60.0 + 14.5 / 240.0];
    let nearest = planned.track.place.iter().map(|place| {
        let [x, y] = local_m(island, *place);
        x.hypot(y)
    });
    assert!(nearest.fold(f64::INFINITY, f64::min) > 200.0, "{name}");
    std::fs::write(folder.path().join(name), &bytes[..bytes.len() / 2]).unwrap();
    refused(&folder, 3, PLAN, &[name, "export it again"]);
}
