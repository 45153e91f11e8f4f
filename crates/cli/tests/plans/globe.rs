//! Plans anywhere on the globe: across the antimeridian, far north, on the open sea.

use crate::planned::*;
use crate::support::*;

/// The small study moved to the antimeridian.
#[test]
fn an_area_across_the_antimeridian_is_planned_as_any_other() {
    let folder = small_with(&[
        ("west_deg = 24.98", "west_deg = 179.98"),
        ("east_deg = 25.02", "east_deg = -179.98"),
        ("longitude_deg = 24.985", "longitude_deg = 179.985"),
    ]);
    let land = ISLAND.replace("24.998", "179.998").replace("25.002", "-179.998");
    put(&folder, "land.geojson", &land);
    run(&folder, PLAN).succeeds();
    let (own, usual) = (Planned::of(&folder), small_planned());
    assert_eq!(own.plan["cost"], usual.plan["cost"]);
    let lattice = |plan: &serde_json::Value| plan["voyage"]["lattice"]["longitude_deg"].as_f64().unwrap();
    assert!((lattice(&own.plan) - lattice(&usual.plan) - 155.0).abs() < 1e-6);
}

/// The same, heading across it.
#[test]
fn law_a_track_across_the_antimeridian_is_cut_there() {
    let folder = small_with(&[
        ("west_deg = 24.98", "west_deg = 179.98"),
        ("east_deg = 25.02", "east_deg = -179.98"),
        ("longitude_deg = 24.985", "longitude_deg = 179.997"),
        ("heading_deg = 0.0", "heading_deg = 90.0"),
    ]);
    let land = ISLAND.replace("24.998", "-179.990").replace("25.002", "-179.988");
    put(&folder, "land.geojson", &land.replace("59.999", "60.008").replace("60.001", "60.009"));
    run(&folder, PLAN).succeeds();
    let track = json(&folder, "track.geojson");
    let lines = track["features"].as_array().unwrap().iter().map(|feature| &feature["geometry"]);
    let cut = lines.filter(|geometry| geometry["type"] == "MultiLineString");
    let parts: Vec<Vec<[f64; 2]>> =
        cut.flat_map(|own| serde_json::from_value::<Vec<_>>(own["coordinates"].clone()).unwrap()).collect();
    assert!(!parts.is_empty());
    assert!(parts.iter().flat_map(|part| part.windows(2)).all(|w| (w[0][0] - w[1][0]).abs() < 1.0));
}

/// At 80 degrees north, 1 km east of the area's centre, true north is 0.3 degrees off the grid's.
#[test]
fn headings_are_true_and_not_the_grids() {
    let land = ISLAND.replace("24.998", "24.994").replace("25.002", "25.006");
    let land = land.replace("59.999", "79.999").replace("60.001", "80.001");
    let folder = small_with(&[
        ("west_deg = 24.98", "west_deg = 24.94"),
        ("east_deg = 25.02", "east_deg = 25.06"),
        ("south_deg = 59.99", "south_deg = 79.99"),
        ("north_deg = 60.01", "north_deg = 80.01"),
        ("longitude_deg = 24.985", "longitude_deg = 24.955"),
        ("latitude_deg = 60.0", "latitude_deg = 80.0"),
    ]);
    put(&folder, "land.geojson", &land);
    run(&folder, PLAN).succeeds();
    let mut most: f64 = 0.0;
    for leg in Planned::of(&folder).legs() {
        let of = |key: &str| leg[key].as_f64().unwrap();
        let off = (of("heading_deg") + 45.0).rem_euclid(90.0) - 45.0;
        let convergence = (of("longitude_deg") - 25.0) * of("latitude_deg").to_radians().sin();
        assert!((off - convergence).abs() < 1e-3, "{leg}: {off} {convergence}");
        most = most.max(off.abs());
    }
    assert!(most > 0.03, "{most}");
}

/// A chart of land far from the area.
#[test]
fn open_sea_is_planned_on_where_it_is_said_to_be() {
    let land = ISLAND.replace("59.999", "61.999").replace("60.001", "62.001");
    let folder = small();
    put(&folder, "land.geojson", &land);
    refused(&folder, 3, PLAN, &["[[chart]]", "nothing within `area`", "open_sea = true"]);
    edit(&folder, "plan.toml", "kind = \"land\"", "kind = \"land\"\nopen_sea = true");
    run(&folder, PLAN).succeeds();
}
