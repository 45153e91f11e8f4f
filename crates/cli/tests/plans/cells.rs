//! Plans on cells of electronic charts (S-57), and cells that are refused.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::planned::*;
use crate::support::*;

const OWN_CHART: &str = "file = \"land.geojson\"\nkind = \"land\"";
const CELL: &str = "ZZ5BAY01.000";
/// Of a ship that needs 6 m.
const DEPTHS: (&str, &str) =
    ("margin_m = 20.0", "margin_m = 20.0\ntransit_depth_m = 6.0\ntrial_depth_m = 6.0");

/// The small study on the cell of the bay with its updates; `keys` follow its name.
fn bay(keys: &str) -> TempDir {
    let folder = small_with(&[(OWN_CHART, &format!("file = \"{CELL}\"\n{keys}")), DEPTHS]);
    for suffix in ["000", "001", "002"] {
        let name = CELL.replace("000", suffix);
        fs::copy(repository().join("fixtures/charts/enc").join(&name), folder.path().join(name)).unwrap();
    }
    folder
}

/// The bay with the first place of `from` in one of its files changed into `to`.
fn damaged(name: &str, from: &[u8], to: &[u8]) -> TempDir {
    let folder = bay("");
    let path = folder.path().join(name);
    let mut bytes = fs::read(&path).unwrap();
    let at = bytes.windows(from.len()).position(|w| w == from).expect("what is to be changed");
    bytes[at..at + to.len()].copy_from_slice(to);
    fs::write(path, bytes).unwrap();
    folder
}

/// Metres between places of longitude and latitude a few kilometres apart, on a sphere.
fn apart_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    let north = (b[1] - a[1]).to_radians();
    let east = (b[0] - a[0]).to_radians() * ((a[1] + b[1]) / 2.0).to_radians().cos();
    6_371_000.0 * north.hypot(east)
}

/// Longitudes and latitudes of a track.
fn places(planned: &Planned) -> &[[f64; 2]] {
    &planned.track.place
}

#[test]
fn a_cell_is_planned_on_as_its_updates_leave_it() {
    let folder = bay("");
    let told = run(&folder, PLAN).succeeds();
    for piece in
        ["ZZ5BAY01.000 (edition 2, update 2, 1 : 20000)", "1 COALNE", "only maneuvers avoid 1 FAIRWY"]
    {
        assert!(told.stderr.contains(piece), "{told}");
    }
    let planned = Planned::of(&folder);
    let chart = &planned.plan["charts"][0];
    assert_eq!((chart["file"].as_str(), chart["update"].as_u64()), (Some(CELL), Some(2)));
    let class = |name: &str| chart["classes"][name].clone();
    let counts = |objects: u64, avoided: u64, maneuvers: u64, ignored: u64| -> Value {
        serde_json::json!({"objects": objects, "avoided": avoided, "maneuvers_avoid": maneuvers, "ignored": ignored})
    };
    let mut resare = counts(2, 1, 0, 1);
    resare["reasons"] = serde_json::json!({"restricts no passing ship": 1});
    assert_eq!(class("RESARE"), resare);
    assert_eq!(class("UWTROC"), counts(1, 1, 0, 0));
    assert_eq!(class("CBLARE"), Value::Null);
    // Wreck, rock of the second update, obstruction of unknown depth, shoal sounding: 50 m and the margin.
    for danger in [[25.01, 60.005], [24.994, 60.0055], [24.99, 59.996], [24.992, 60.004]] {
        let nearest = places(&planned).iter().map(|p| apart_m(*p, danger)).fold(f64::INFINITY, f64::min);
        assert!(nearest > 70.0, "{danger:?}: {nearest}");
    }
}

#[test]
fn the_passage_tells_the_water_under_the_keel_and_the_nearest_danger() {
    let folder = bay("");
    edit(&folder, "plan.toml", "length_m = 30.0", "length_m = 30.0\ndraught_m = 4.0");
    run(&folder, PLAN).succeeds();
    let planned = Planned::of(&folder);
    let legs = planned.plan["voyage"]["passage"]["legs"].as_array().unwrap();
    for leg in legs {
        let number = |value: &Value| value.as_f64().unwrap();
        let (depth, keel) = (number(&leg["least_depth_m"]), number(&leg["under_keel_m"]));
        assert!(depth >= 6.0 && (depth - 4.0 - keel).abs() < 1e-9, "{leg}");
        assert!(number(&leg["nearest"]["distance_m"]) >= 20.0, "{leg}");
        assert!(leg["nearest"]["what"].as_str().is_some_and(|what| !what.is_empty()), "{leg}");
    }
    // No charted danger is nearer to the track than the least distance in the passage plan, less 50 m of uncertainty.
    let least =
        legs.iter().map(|leg| leg["nearest"]["distance_m"].as_f64().unwrap()).fold(f64::INFINITY, f64::min);
    for danger in [[25.01, 60.005], [24.994, 60.0055], [24.99, 59.996], [24.992, 60.004]] {
        let nearest = places(&planned).iter().map(|p| apart_m(*p, danger)).fold(f64::INFINITY, f64::min);
        assert!(nearest > least + 40.0, "{danger:?}: {nearest}, {least}");
    }
    let draught = ("length_m = 30.0", "length_m = 30.0\ndraught_m = 0.0");
    refused(&small_with(&[draught]), 3, PLAN, &["plan.toml", "hull.draught_m"]);
}

#[test]
fn rules_radii_and_the_air_draught_are_taken_from_plan_toml() {
    let folder = bay(
        "rules = { FAIRWY = \"avoid\", RESARE = \"ignore\" }\nradius_m = 80.0\ndoubtful_radius_m = 300.0",
    );
    edit(&folder, "plan.toml", "length_m = 30.0", "length_m = 30.0\nair_draught_m = 12.0");
    run(&folder, PLAN).succeeds();
    let planned = Planned::of(&folder);
    let classes = &planned.plan["charts"][0]["classes"];
    for (class, key) in [("FAIRWY", "avoided"), ("BRIDGE", "ignored")] {
        assert_eq!(classes[class][key].as_u64(), Some(1), "{class}");
    }
    assert_eq!(classes["RESARE"]["ignored"].as_u64(), Some(2));
    let nearest = places(&planned).iter().map(|p| apart_m(*p, [25.01, 60.005])).fold(f64::INFINITY, f64::min);
    assert!(nearest > 100.0, "{nearest}");
}

#[test]
fn objects_that_gdal_wrote_go_by_the_same_rules() {
    let folder = small();
    edit(
        &folder,
        "plan.toml",
        OWN_CHART,
        &format!("{OWN_CHART}\n\n[[chart]]\nfile = \"wrecks.geojson\"\nkind = \"objects\""),
    );
    edit(&folder, "plan.toml", DEPTHS.0, DEPTHS.1);
    let wrecks = repository().join("fixtures/charts/enc/ZZ5BAY01_WRECKS.geojson");
    let text = fs::read_to_string(wrecks).unwrap();
    put(&folder, "wrecks.geojson", &text);
    run(&folder, PLAN).succeeds();
    let planned = Planned::of(&folder);
    assert_eq!(planned.plan["charts"][0]["classes"]["WRECKS"]["avoided"].as_u64(), Some(2));
    put(&folder, "wrecks.geojson", &text.replace("\"OBJL\": 159, ", ""));
    refused(&folder, 3, PLAN, &["wrecks.geojson", "OBJL", "ogr2ogr"]);
    let at = text.find("\"geometry\": {").unwrap();
    let end = at + text[at..].find('}').unwrap() + 1;
    put(&folder, "wrecks.geojson", &format!("{}\"geometry\": null{}", &text[..at], &text[end..]));
    refused(&folder, 3, PLAN, &["wrecks.geojson", "WRECKS", "no geometry"]);
}

#[test]
fn cells_that_are_encrypted_cut_off_or_of_another_product_are_refused() {
    let folder = bay("");
    let whole = fs::read(folder.path().join(CELL)).unwrap();
    let scrambled: Vec<u8> = whole.iter().enumerate().map(|(k, b)| b ^ (k * 151 % 251) as u8).collect();
    fs::write(folder.path().join(CELL), scrambled).unwrap();
    refused(&folder, 3, PLAN, &[CELL, "S-63", "decrypt"]);
    fs::write(folder.path().join(CELL), &whole[..whole.len() / 2]).unwrap();
    refused(&folder, 3, PLAN, &[CELL, "a whole record", "download"]);
    refused(&damaged(CELL, b"03.1\x01", b"03.1\x02"), 3, PLAN, &[CELL, "product 2", "S-57"]);
    refused(&damaged(CELL, b"FSPC00", b"CSID00"), 3, PLAN, &[CELL, "S-101"]);
}

#[test]
fn a_cell_that_does_not_fit_in_the_memory_is_refused_before_it_is_read() {
    let pieces = ["ZZ5BAY01.000: file", "bytes, which takes 24 MiB of memory", "24 MiB of --memory-mib"];
    refused(&damaged(CELL, b"DSID", b"none"), 3, &format!("{PLAN} --memory-mib 24"), &pieces);
}

#[test]
fn updates_of_which_one_is_missing_are_refused() {
    let folder = bay("");
    fs::remove_file(folder.path().join("ZZ5BAY01.001")).unwrap();
    refused(&folder, 3, PLAN, &["ZZ5BAY01.002", "update 2 of edition 2", "update 1 of edition 2"]);
    fs::rename(folder.path().join("ZZ5BAY01.002"), folder.path().join(CELL)).unwrap();
    refused(&folder, 3, PLAN, &[CELL, "update 2 of edition 2", "a base cell"]);
}

#[test]
fn an_object_that_matters_without_a_place_is_refused() {
    let wreck = |primitive: u8| [100, 10, 0, 0, 0, primitive, 2, 159, 0, 1, 0, 1];
    refused(&damaged(CELL, &wreck(1), &wreck(255)), 3, PLAN, &[CELL, "WRECKS 65535-1010-1", "no geometry"]);
}

#[test]
fn keys_that_say_nothing_about_a_cell_are_refused() {
    refused(&bay("kind = \"land\""), 3, PLAN, &[CELL, "`kind`", "rules"]);
    refused(&bay("least = \"DRVAL1\""), 3, PLAN, &[CELL, "least"]);
    refused(&bay("rules = { WRECK = \"avoid\" }"), 3, PLAN, &[CELL, "rules.WRECK", "WRECKS"]);
    refused(
        &bay("rules = { DEPARE = \"ignore\" }"),
        3,
        PLAN,
        &[CELL, "rules.DEPARE", "safety.transit_depth_m"],
    );
    refused(&bay("rules = { WRECKS = \"never\" }"), 3, PLAN, &["plan.toml", "never"]);
    refused(&small_with(&[("\nkind = \"land\"", "")]), 3, PLAN, &["land.geojson", "`kind`", "none"]);
    let ruled = "kind = \"land\"\nrules = { WRECKS = \"avoid\" }";
    refused(&small_with(&[("kind = \"land\"", ruled)]), 3, PLAN, &["land.geojson", "`rules`"]);
    let high = ("length_m = 30.0", "length_m = 30.0\nair_draught_m = -1.0");
    refused(&small_with(&[high]), 3, PLAN, &["plan.toml", "hull.air_draught_m"]);
}

/// The figure: a plan among the wrecks of Chesapeake Bay keeps clear of each by its rule.
#[test]
fn a_plan_on_a_whole_cell_keeps_from_every_danger_what_its_rule_says() {
    let cell = repository().join("../shared/data/charts/enc/US4MD81M.000");
    let Ok(base) = fs::read(&cell) else {
        println!("skipped: {} is not there", cell.display());
        return;
    };
    let updates = ["001", "002", "003"].map(|suffix| fs::read(cell.with_extension(suffix)).unwrap());
    let folder = small_with(&[
        (OWN_CHART, "file = \"US4MD81M.000\"\nrules = { CTNARE = \"ignore\" }"),
        ("west_deg = 24.98", "west_deg = -76.395"),
        ("east_deg = 25.02", "east_deg = -76.345"),
        ("south_deg = 59.99", "south_deg = 38.97"),
        ("north_deg = 60.01", "north_deg = 39.0"),
        ("longitude_deg = 24.985", "longitude_deg = -76.372"),
        ("latitude_deg = 60.0", "latitude_deg = 38.985"),
        ("margin_m = 20.0", "margin_m = 20.0\ntransit_depth_m = 8.0\ntrial_depth_m = 8.0"),
    ]);
    fs::write(folder.path().join("US4MD81M.000"), &base).unwrap();
    for (number, update) in (1..).zip(&updates) {
        fs::write(folder.path().join(format!("US4MD81M.00{number}")), update).unwrap();
    }
    run(&folder, PLAN).succeeds();
    let planned = Planned::of(&folder);
    let classes = &planned.plan["charts"][0]["classes"];
    assert_eq!((&classes["OBSTRN"]["avoided"], &classes["WRECKS"]["avoided"]), (&219.into(), &111.into()));
    let mut read = chart::enc::Cell::read(&base).unwrap();
    updates.iter().for_each(|update| read.update(update).unwrap());
    let mut near = 0;
    for object in read.features().unwrap() {
        let danger = ["OBSTRN", "WRECKS", "UWTROC"]
            .contains(&chart::enc::class_name(object.class).unwrap_or_default());
        let chart::enc::Geometry::Points(points) = &object.geometry else { continue };
        let over = object.number(chart::enc::VALSOU).unwrap();
        if !danger || over.is_some_and(|depth| depth >= 8.0) {
            continue;
        }
        for point in points {
            let nearest = places(&planned).iter().map(|p| apart_m(*p, *point)).fold(f64::INFINITY, f64::min);
            assert!(nearest > 70.0, "{}: {nearest} m", object.named());
            near += u32::from(nearest < 3000.0);
        }
    }
    assert!(near >= 3, "{near} dangers near the plan");
}

#[test]
fn an_area_without_room_names_what_closes_it_and_the_keys_that_open_it() {
    let folder = bay("");
    let config = fs::read_to_string(folder.path().join("plan.toml")).unwrap();
    put(&folder, "plan.toml", &config.replace("_depth_m = 6.0", "_depth_m = 60.0"));
    let told =
        run(&folder, PLAN).refuses(4, &["`start`", "no node of the lattice is clear: 100 % by DEPARE"]);
    assert!(told.stderr.contains("(`safety.transit_depth_m`)"), "{told}");
    let folder = bay("rules = { FAIRWY = \"avoid\" }");
    let config = fs::read_to_string(folder.path().join("plan.toml")).unwrap();
    put(&folder, "plan.toml", &config.replace("margin_m = 20.0", "margin_m = 3000.0"));
    let told = run(&folder, PLAN).refuses(4, &["`start`", "no node of the lattice is clear"]);
    assert!(told.stderr.contains("(`rules = { FAIRWY = \"ignore\" }`)"), "{told}");
}
