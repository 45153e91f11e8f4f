//! Depths are read in the unit, scale and direction that a chart states, in any format.

use tempfile::TempDir;

use crate::grid_files::*;
use crate::planned::*;
use crate::support::*;

const AREA: (&str, &str) = (
    "west_deg = 24.98\nsouth_deg = 59.99\neast_deg = 25.02\nnorth_deg = 60.01",
    "west_deg = 24.89\nsouth_deg = 60.09\neast_deg = 24.93\nnorth_deg = 60.13",
);
const START: (&str, &str) =
    ("longitude_deg = 24.985\nlatitude_deg = 60.0", "longitude_deg = 24.91\nlatitude_deg = 60.11");
const DEPTHS: (&str, &str) =
    ("margin_m = 20.0", "margin_m = 20.0\ntransit_depth_m = 5.0\ntrial_depth_m = 8.0");
const MANEUVERS: (&str, &str) = (", { name = \"sway-zig-zag\", count = 1 }", "");
const OWN_CHART: &str = "[[chart]]\nfile = \"land.geojson\"\nkind = \"land\"";
/// The refusal of a start over the shoal: 3 m is too little, and the water around it deep enough.
pub const SHOAL: [&str; 3] = ["`start`", "m from an obstacle", "the nearest clear node is"];

/// A study whose start lies over a shoal of 3 m in the middle of a basin of 20 m, on the chart `name`, declared by
/// `keys`.
pub fn over_a_shoal(name: &str, keys: &str, chart: &[u8]) -> TempDir {
    let own = format!("[[chart]]\nfile = \"{name}\"\n{keys}");
    let folder =
        small_with(&[("uncharted = \"water\"\n", ""), (OWN_CHART, &own), AREA, START, DEPTHS, MANEUVERS]);
    std::fs::write(folder.path().join(name), chart).unwrap();
    folder
}

/// Refuses a start over the shoal as such.
#[track_caller]
fn shoal(name: &str, keys: &str, chart: &[u8]) {
    refused(&over_a_shoal(name, keys, chart), 4, PLAN, &SHOAL);
}

/// Refuses a chart.
#[track_caller]
fn unread(name: &str, keys: &str, chart: &[u8], pieces: &[&str]) {
    refused(&over_a_shoal(name, keys, chart), 3, PLAN, &[&[name], pieces].concat());
}

pub const METRES: Packed =
    Packed { numbers: Numbers::F32, metres: 1.0, up: false, scale: 1.0, offset: 0.0, missing: -9999.0 };

pub fn scaled(scale: f64, offset: f64, unit: &str) -> String {
    let unit = match unit {
        "" => String::new(),
        unit => format!("  <Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">{unit}</Item>\n"),
    };
    format!(
        "<GDALMetadata>\n  <Item name=\"OFFSET\" sample=\"0\" role=\"offset\">{offset}</Item>\n  \
         <Item name=\"SCALE\" sample=\"0\" role=\"scale\">{scale}</Item>\n{unit}</GDALMetadata>\n"
    )
}

/// Units by their metres, their name in plan.toml, their code of the EPSG's table, and how files write them.
const UNITS: [(f64, &str, u16, &[&str]); 6] = [
    (1.0, "m", 9001, &["m", "metre", "Meters"]),
    (0.1, "dm", 0, &["dm", "decimeters"]),
    (0.01, "cm", 1033, &["cm", "Centimetres"]),
    (0.3048, "ft", 9002, &["ft", "feet", "FOOT"]),
    (1200.0 / 3937.0, "us-ft", 9003, &["US survey foot", "us_survey_feet"]),
    (1.8288, "fathom", 9014, &["fathom", "Fathoms"]),
];

/// Pseudo-random numbers from 0 up to `most`.
struct Drawn(u64);

impl Drawn {
    fn below(&mut self, most: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % most
    }

    fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }
}

/// A chart of the shoal: its name, its keys in plan.toml, and its bytes.
fn drawn(format: usize, drawn: &mut Drawn) -> (&'static str, String, Vec<u8>) {
    let basin = Basin::with_a_shoal();
    let (metres, name, code, words) = drawn.of(&UNITS);
    let word = drawn.of(words);
    let mut up = drawn.below(2) == 1;
    let numbers = drawn.of(&[Numbers::F32, Numbers::I16, Numbers::I32, Numbers::U16]);
    let (mut scale, mut offset): (f64, f64) =
        (drawn.of(&[1.0, 0.1, 0.5, 0.25, -0.1]), drawn.of(&[0.0, 0.0, 2.0, -10.0]));
    // Whole numbers stand for centimetres or so, and have to fit.
    if numbers != Numbers::F32 {
        scale = scale.signum() * if metres < 0.05 { 0.1 } else { 0.01 };
    }
    if numbers == Numbers::U16 {
        (up, scale, offset) = (false, scale.abs(), 0.0);
    }
    let missing = if numbers == Numbers::U16 { 65535.0 } else { drawn.of(&[-9999.0, -32768.0, -32767.0]) };
    let kind = if up { "elevation" } else { "depth" };
    let mut packed = Packed { numbers, metres, up, scale, offset, missing };
    let mut keys = format!("kind = \"{kind}\"\n");
    let by_plan = format!("depth_unit = \"{name}\"\n");
    let chart = match format {
        0 => {
            packed = Packed { numbers: Numbers::F32, scale: 1.0, offset: 0.0, ..packed };
            keys += &format!("crs = \"WGS84\"\n{by_plan}");
            let no_data = drawn.of(&["-9999", "nan", "NaN", "null", "-9999.0", "NULL", "-nan"]);
            ("own.asc", ascii(&basin, &packed, no_data))
        }
        1 => {
            let by_key = drawn.below(2) == 1 && code > 0;
            let silent = drawn.below(3) == 0;
            let unit = if by_key || silent { "" } else { word };
            let metadata = scaled(scale, offset, unit);
            let keys_of_file: &[[u16; 4]] = if by_key && !silent { &[[4099, 0, 1, code]] } else { &[] };
            if silent {
                keys += &by_plan;
            }
            if numbers == Numbers::F32 && drawn.below(2) == 1 {
                packed.missing = f64::NAN;
            }
            let no_data = if packed.missing.is_nan() { "nan".to_owned() } else { packed.missing.to_string() };
            ("own.tif", tiff(&basin, &packed, Some(&no_data), Some(&metadata), keys_of_file))
        }
        _ => {
            packed = Packed { numbers: Numbers::F32, up: false, scale: 1.0, offset: 0.0, ..packed };
            let least = drawn.of(&["DRVAL1", "depth_min"]);
            keys = format!("kind = \"depth\"\nleast = \"{least}\"\n{by_plan}");
            let text = geojson(&basin, &packed, least);
            ("own.geojson", [drawn.of(&[&b""[..], b"\xef\xbb\xbf"]), &text].concat())
        }
    };
    (chart.0, keys, chart.1)
}

/// Draws plans whose start is over a shoal.
fn over_shoals(cases: usize, seed: u64) {
    let mut draws = Drawn(seed);
    for case in 0..cases {
        let (name, keys, chart) = drawn(case % 3, &mut draws);
        let folder = over_a_shoal(name, &keys, &chart);
        let ran = run(&folder, PLAN);
        assert_eq!(ran.code, Some(4), "case {case}, {keys}: {ran}");
        ran.refuses(4, &SHOAL);
    }
}

#[test]
fn law_a_start_over_a_shoal_is_refused_in_any_unit_scale_and_format() {
    over_shoals(24, 40);
}

#[test]
#[ignore = "long: `make nightly` runs it"]
fn law_a_start_over_a_shoal_is_refused_however_many_are_drawn() {
    over_shoals(200, 41);
}

#[test]
fn depths_of_a_geotiff_with_a_scale_are_what_it_says() {
    let packed = Packed { numbers: Numbers::I16, scale: 0.1, missing: -32768.0, ..METRES };
    let basin = Basin::with_a_shoal();
    let chart = tiff(&basin, &packed, Some("-32768"), Some(&scaled(0.1, 0.0, "")), &[]);
    shoal("own.tif", "kind = \"depth\"", &chart);
    let broken = scaled(0.1, 0.0, "").replace("</Item>", "");
    let chart = tiff(&basin, &packed, None, Some(&broken), &[]);
    unread("own.tif", "kind = \"depth\"", &chart, &["GDAL_METADATA"]);
    let chart = tiff(&basin, &packed, None, Some(&scaled(0.1, 0.0, "yd")), &[]);
    unread("own.tif", "kind = \"depth\"", &chart, &["UNITTYPE", "`yd`"]);
    let chart = tiff(&basin, &packed, Some("none"), None, &[]);
    unread("own.tif", "kind = \"depth\"", &chart, &["GDAL_NODATA", "`none`"]);
    let chart = tiff(&basin, &packed, None, None, &[[4099, 0, 1, 9084]]);
    unread("own.tif", "kind = \"depth\"", &chart, &["VerticalUnitsGeoKey", "`9084`"]);
    let chart = tiff(&basin, &packed, None, Some(&scaled(0.1, 0.0, "m")), &[[4099, 0, 1, 9002]]);
    unread("own.tif", "kind = \"depth\"", &chart, &["UNITTYPE", "`ft`"]);
}

/// GDAL writes metadata that does not fit an ASCII grid into a file next to it.
#[test]
fn what_stands_beside_a_grid_is_not_passed_over() {
    let basin = Basin::with_a_shoal();
    let decimetres = ascii(&basin, &Packed { scale: 0.1, ..METRES }, "-9999");
    let keys = "kind = \"depth\"\ncrs = \"WGS84\"";
    let beside = |chart: &[u8], keys: &str, said: &str| {
        let folder = over_a_shoal("own.asc", keys, chart);
        let text = format!("<PAMDataset><PAMRasterBand band=\"1\">{said}</PAMRasterBand></PAMDataset>");
        put(&folder, "own.asc.aux.xml", &text);
        folder
    };
    let scale = "<Offset>0</Offset>\n<Scale>0.1</Scale>";
    refused(
        &beside(&decimetres, keys, scale),
        3,
        PLAN,
        &["own.asc.aux.xml", "Scale: found 0.1", "gdal_translate"],
    );
    let feet = ascii(&basin, &Packed { metres: 0.3048, ..METRES }, "-9999");
    let unit = "<UnitType>ft</UnitType><Scale>1</Scale>";
    refused(&beside(&feet, keys, unit), 3, PLAN, &["own.asc.aux.xml", "`ft`", "`depth_unit`"]);
    refused(&beside(&feet, &format!("{keys}\ndepth_unit = \"ft\""), unit), 4, PLAN, &SHOAL);
}

#[test]
fn depths_in_the_feet_of_a_vertical_system_are_feet() {
    let packed = Packed { metres: 1200.0 / 3937.0, up: true, ..METRES };
    let chart = tiff(&Basin::with_a_shoal(), &packed, Some("-9999"), None, &[[4096, 0, 1, 6360]]);
    shoal("own.tif", "kind = \"elevation\"", &chart);
}

/// Whatever the file is called, and before its units.
#[test]
fn grids_of_netcdf_are_refused_with_the_command_that_converts_them() {
    for (name, first, tiff) in [
        ("own.nc", b"CDF\x01\0\0\0\0", "own.tif"),
        ("own.grd", b"CDF\x02\0\0\0\0", "own.tif"),
        ("own.tif", b"CDF\x05\0\0\0\0", "own.geo.tif"),
        ("own.asc", b"\x89HDF\r\n\x1A\n", "own.tif"),
    ] {
        let folder = over_a_shoal(name, "kind = \"depth\"", first);
        let ran = run(&folder, PLAN);
        ran.refuses(
            3,
            &[name, "chart: found NetCDF, expected GeoTIFF", &format!("`gdal_translate {name} {tiff}`")],
        );
    }
}

#[test]
fn units_of_what_has_none_are_refused() {
    let basin = Basin::with_a_shoal();
    let mask =
        Basin { depths_m: basin.depths_m.iter().map(|d| d.map(|d| f64::from(d < 5.0))).collect(), ..basin };
    let packed = Packed { numbers: Numbers::I16, ..METRES };
    let chart = tiff(&mask, &packed, Some("-9999"), Some(&scaled(0.1, 0.0, "m")), &[]);
    unread("own.tif", "kind = \"land\"", &chart, &["0 and 1 only in a land mask"]);
    let chart = tiff(&mask, &packed, Some("-9999"), Some(&scaled(1.0, 0.0, "none")), &[]);
    shoal("own.tif", "kind = \"land\"", &chart);
    unread("own.tif", "kind = \"land\"\ndepth_unit = \"m\"", &chart, &["`depth_unit`"]);
    unread("own.geojson", "kind = \"objects\"\ndepth_unit = \"m\"", b"{}", &["`depth_unit`"]);
}

/// The unit and datum are in plan.json, in the summary and on the page.
#[test]
fn unit_and_datum_are_told_wherever_the_plan_is() {
    let basin = Basin::with_a_shoal();
    let packed = Packed { metres: 0.3048, scale: 0.5, ..METRES };
    let chart = tiff(&basin, &packed, Some("-9999"), Some(&scaled(0.5, 0.0, "ft")), &[[4096, 0, 1, 5866]]);
    let folder = over_a_shoal("own.tif", "kind = \"depth\"", &chart);
    edit(&folder, "plan.toml", "longitude_deg = 24.91\n", "longitude_deg = 24.895\n");
    let ran = run(&folder, PLAN).succeeds();
    let words = "own.tif: depths in ft (as the file says) after scale 0.5 and offset 0, datum EPSG:5866";
    assert!(ran.stdout.contains(words) && ran.stderr.contains(words), "{ran}");
    let depths = json(&folder, "plan.json")["data"]["charts"][0]["depths"].take();
    let said = |key: &str| depths[key].as_str().unwrap().to_owned();
    assert_eq!([said("unit"), said("unit_from"), said("datum")], ["ft", "file", "EPSG:5866"]);
    let number = |key: &str| depths[key].as_f64().unwrap();
    assert_eq!([number("scale"), number("offset"), number("invalid")], [0.5, 0.0, 0.0]);
    let least = json(&folder, "plan.json")["data"]["voyage"]["passage"]["legs"][0]["least_depth_m"].as_f64();
    assert!((least.unwrap() - 20.0).abs() < 1e-5, "{least:?}");
    run(&folder, REPORT).succeeds();
    assert!(std::fs::read_to_string(folder.path().join("report.html")).unwrap().contains(words));
    let silent = ascii(&basin, &METRES, "nan");
    edit(&folder, "plan.toml", "own.tif\"\nkind = \"depth\"", "own.asc\"\nkind = \"depth\"\ncrs = \"WGS84\"");
    std::fs::write(folder.path().join("own.asc"), silent).unwrap();
    let ran = run(&folder, PLAN).succeeds();
    assert!(ran.stdout.contains("own.asc: depths in m (assumed"), "{ran}");
}
