//! Charts that are refused, in one line, with nothing written.

use crate::planned::*;
use crate::support::*;

const OWN_CHART: &str = "[[chart]]\nfile = \"land.geojson\"\nkind = \"land\"";

/// Refuses the small study with another chart.
#[track_caller]
fn charted(land: &str, pieces: &[&str]) {
    let folder = small();
    put(&folder, "land.geojson", land);
    refused(&folder, 3, PLAN, &[&["land.geojson"], pieces].concat());
}

fn polygon(rings: &str) -> String {
    ISLAND.split_once("\"coordinates\": ").unwrap().0.to_owned() + "\"coordinates\": " + rings + "}}]}"
}

#[test]
fn polygons_that_are_open_crossed_or_empty_are_refused_by_feature() {
    charted(
        &polygon("[[[24.99, 60.0], [25.0, 60.0], [25.0, 60.001], [24.99, 60.001]]]"),
        &["feature 0", "open ring"],
    );
    let bow = "[[[24.99, 60.0], [25.0, 60.001], [25.0, 60.0], [24.99, 60.001], [24.99, 60.0]]]";
    charted(&polygon(bow), &["feature 0", "cross"]);
    charted(&polygon("[]"), &["feature 0", "empty"]);
    charted(&polygon("[[]]"), &["feature 0", "empty"]);
    charted(&polygon("[[[25.0, 60.0], [25.0, 60.0], [25.0, 60.0], [25.0, 60.0]]]"), &["feature 0", "empty"]);
    charted(r#"{"type": "FeatureCollection", "features": []}"#, &["at least one polygon"]);
}

#[test]
fn charts_that_are_cut_off_or_no_geojson_are_refused() {
    for part in [0, 1, ISLAND.len() / 2, ISLAND.len() - 3] {
        charted(&ISLAND[..part], &["GeoJSON"]);
    }
    charted("[1, 2]", &["GeoJSON"]);
    let folder = small();
    std::fs::write(folder.path().join("land.geojson"), [0xff, 0x00]).unwrap();
    refused(&folder, 3, PLAN, &["land.geojson", "UTF-8"]);
    std::fs::remove_file(folder.path().join("land.geojson")).unwrap();
    refused(&folder, 1, PLAN, &["land.geojson"]);
}

#[test]
fn projected_coordinates_in_geojson_are_refused_as_mixed() {
    let projected = polygon(
        "[[[385000.0, 6671000.0], [386000.0, 6671000.0], [386000.0, 6672000.0], [385000.0, 6671000.0]]]",
    );
    charted(&projected, &["projected coordinates", "ogr2ogr"]);
    let member = ISLAND.replacen(
        '{',
        r#"{"crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::3067"}}, "#,
        1,
    );
    charted(&member, &["3067", "WGS84"]);
    let folder = small_with(&[("kind = \"land\"", "kind = \"land\"\ncrs = \"EPSG:3067\"")]);
    refused(&folder, 3, PLAN, &["land.geojson", "`crs`", "EPSG:3067", "ogr2ogr"]);
}

/// A start on the island is refused for any encoding of its chart, and any degrees that it names.
#[test]
fn islands_are_read_in_any_encoding_and_any_degrees_near_those_of_wgs84() {
    let ashore = ("longitude_deg = 24.985", "longitude_deg = 25.0");
    let is_read = |chart: &[u8], changes: &[(&str, &str)]| {
        let folder = small_with(&[&[ashore], changes].concat());
        std::fs::write(folder.path().join("land.geojson"), chart).unwrap();
        run(&folder, PLAN).refuses(4, &["`start`", "0 m from an obstacle"]);
    };
    let wide = |unit: fn(u16) -> [u8; 2]| {
        format!("\u{feff}{ISLAND}").encode_utf16().flat_map(unit).collect::<Vec<u8>>()
    };
    for chart in [format!("\u{feff}{ISLAND}").into_bytes(), wide(u16::to_le_bytes), wide(u16::to_be_bytes)] {
        is_read(&chart, &[]);
    }
    let named = |name: &str| {
        ISLAND.replacen(
            '{',
            &format!("{{\"crs\": {{\"type\": \"name\", \"properties\": {{\"name\": \"{name}\"}}}}, "),
            1,
        )
    };
    for name in [
        "urn:ogc:def:crs:OGC:1.3:CRS84",
        "EPSG:4258",
        "urn:ogc:def:crs:EPSG::4269",
        "http://www.opengis.net/def/crs/EPSG/0/4326",
    ] {
        is_read(named(name).as_bytes(), &[]);
        let crs = format!("kind = \"land\"\ncrs = \"{name}\"");
        is_read(ISLAND.as_bytes(), &[("kind = \"land\"", &crs)]);
    }
    for name in ["EPSG:4230", "EPSG:4275", "EPSG:32635", "none"] {
        charted(&named(name), &["`crs` member", name, "ogr2ogr"]);
    }
    charted(
        &"x".repeat(40)
            .encode_utf16()
            .map(|unit| char::from(unit as u8).to_string() + "\0")
            .collect::<String>(),
        &["UTF-16 without"],
    );
}

/// A grid in UTM zone 35 over the small study's area, `cell` deciding what stands in a cell.
fn grid(header: &str, cell: impl Fn(usize, usize) -> String) -> String {
    let row = |r: usize| (0..16).map(|c| cell(r, c)).collect::<Vec<_>>().join(" ");
    let rows: Vec<String> = (0..16).map(row).collect();
    format!("{header}\n{}\n", rows.join("\n"))
}

// Longitude 25, latitude 60 is at easting 388 500, northing 6 653 000 or so.
const HEADER: &str =
    "ncols 16\nnrows 16\nxllcorner 386100\nyllcorner 6650600\ncellsize 300\nNODATA_value -9999";

fn bay(r: usize, c: usize) -> String {
    if (r, c) == (8, 8) { "-2".into() } else { "20".into() }
}

/// Refuses the small study with a grid.
#[track_caller]
fn gridded(text: &str, keys: &str, pieces: &[&str]) {
    let chart = format!("[[chart]]\nfile = \"own.asc\"\n{keys}");
    let folder = small_with(&[(OWN_CHART, &chart)]);
    put(&folder, "own.asc", text);
    refused(&folder, 3, PLAN, &[&["own.asc"], pieces].concat());
}

const DEPTH: &str = "kind = \"depth\"\ncrs = \"EPSG:32635\"";

#[test]
fn a_grid_of_depths_is_planned_on() {
    let folder = small_with(&[(OWN_CHART, &format!("[[chart]]\nfile = \"own.asc\"\n{DEPTH}"))]);
    put(&folder, "own.asc", &grid(HEADER, bay));
    run(&folder, PLAN).succeeds();
}

#[test]
fn grids_without_or_with_an_unknown_crs_are_refused() {
    gridded(&grid(HEADER, bay), "kind = \"depth\"", &["`crs`", "EPSG"]);
    gridded(&grid(HEADER, bay), "kind = \"depth\"\ncrs = \"EPSG:99999\"", &["EPSG:99999", "EPSG:3067"]);
    gridded(&grid(HEADER, bay), "kind = \"depth\"\ncrs = \"Mercator\"", &["Mercator"]);
    gridded(&grid(HEADER, bay), "kind = \"depth\"\ncrs = \"WGS84\"", &["386100"]);
    gridded(&grid(HEADER, bay), "kind = \"no-go\"\ncrs = \"EPSG:32635\"", &["no-go", "polygon"]);
}

#[test]
fn grids_far_from_the_area_are_told() {
    let text = grid(&HEADER.replace("386100", "486100"), bay);
    let folder = small_with(&[
        (OWN_CHART, &format!("[[chart]]\nfile = \"own.asc\"\n{DEPTH}")),
        ("uncharted = \"water\"\n", ""),
    ]);
    put(&folder, "own.asc", &text);
    refused(&folder, 3, PLAN, &["[[chart]]", "nothing within `area`", "`crs`"]);
}

#[test]
fn depths_whose_sign_looks_wrong_are_refused() {
    let of = |value: &'static str| move |_: usize, _: usize| value.to_owned();
    gridded(&grid(HEADER, of("-20")), DEPTH, &["-20", "`elevation`"]);
    gridded(&grid(HEADER, of("20")), DEPTH, &["20", "all deep", "`elevation`"]);
    gridded(&grid(HEADER, of("20")), &DEPTH.replace("depth", "elevation"), &["20", "`depth`"]);
    gridded(&grid(HEADER, of("-20")), &DEPTH.replace("depth", "elevation"), &["-20", "all deep", "`depth`"]);
    gridded(&grid(HEADER, of("-9999")), DEPTH, &["no cell with data"]);
    gridded(&grid(HEADER, bay), &DEPTH.replace("depth", "land"), &["0 and 1"]);
}

#[test]
fn headers_of_grids_that_make_no_sense_are_refused() {
    for size in ["0", "-300", "nan", "inf", "x"] {
        gridded(
            &grid(&HEADER.replace("cellsize 300", &format!("cellsize {size}")), bay),
            DEPTH,
            &["cellsize", size],
        );
    }
    gridded(&grid(&HEADER.replace("ncols 16", "ncols 17"), bay), DEPTH, &["17"]);
    gridded(&grid(&HEADER.replace("nrows 16", "nrows 15"), bay), DEPTH, &["15"]);
    gridded(&grid(&HEADER.replace("ncols 16\n", ""), bay), DEPTH, &["ncols"]);
    gridded(
        &grid(HEADER, |r, c| if (r, c) == (3, 3) { "nan".into() } else { bay(r, c) }),
        DEPTH,
        &["line 10", "nan"],
    );
}

#[test]
fn grids_that_are_cut_off_are_refused() {
    let whole = grid(HEADER, bay);
    for part in [0, 20, HEADER.len(), whole.len() / 2, whole.len() - 30] {
        gridded(&whole[..part], DEPTH, &[]);
    }
}

#[test]
fn charts_that_do_not_fit_their_kind_are_refused() {
    let folder = small_with(&[("kind = \"land\"", "kind = \"depth\"")]);
    refused(&folder, 3, PLAN, &["land.geojson", "`DRVAL1`"]);
    let folder = small_with(&[("kind = \"land\"", "kind = \"elevation\"")]);
    refused(&folder, 3, PLAN, &["land.geojson", "elevation"]);
    let folder = small_with(&[("kind = \"land\"", "kind = \"lnad\"")]);
    refused(&folder, 3, PLAN, &["plan.toml", "`lnad`", "`land`?"]);
    let folder = small_with(&[(
        "kind = \"land\"",
        "kind = \"land\"\nonly = { property = \"objl\", values = [\"LNDARE\"] }",
    )]);
    refused(&folder, 3, PLAN, &["land.geojson", "at least one polygon", "filter"]);
    let folder =
        small_with(&[(OWN_CHART, ""), ("uncharted = \"water\"", "uncharted = \"water\"\nchart = []")]);
    refused(&folder, 3, PLAN, &["plan.toml", "[[chart]]", "at least one chart"]);
    let folder = small_with(&[("uncharted = \"water\"", "uncharted = \"obstacle\"")]);
    refused(&folder, 3, PLAN, &["plan.toml", "`uncharted`", "depths"]);
}
