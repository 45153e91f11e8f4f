//! Ships of any size on charts.

use serde_json::Value;

use crate::support::*;

/// A sea of open water, with an islet at each of its corners.
fn sea(folder: &tempfile::TempDir) {
    let islet = |x: f64, y: f64| {
        let ring = [[x, y], [x + 0.02, y], [x + 0.02, y + 0.01], [x, y + 0.01], [x, y]];
        serde_json::json!({"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}})
    };
    let islets = [[3.5, 54.3], [5.6, 54.3], [3.5, 56.1], [5.6, 56.1]].map(|[x, y]| islet(x, y));
    let all: Value = serde_json::json!({"type": "FeatureCollection", "features": islets});
    put(folder, "sea.geojson", &all.to_string());
}

#[test]
fn ships_of_any_size_get_a_plan_whose_lengths_and_speeds_are_hers() {
    let folder = tempfile::tempdir().unwrap();
    sea(&folder);
    let chart = "--chart sea.geojson --place 4.6,55.2";
    run(&folder, &format!("new mine --vessel kvlcc2-l7 --scale length_m=320,density_kg_m3=1025 {chart}"))
        .succeeds();
    let text = |name: &str| String::from_utf8(bytes(&folder, name)).unwrap();
    let plan = text("mine/plan.toml");
    for line in ["length_m = 320\n", "position_m = 3\n", "tolerance_m_s = 0.3 ", "parameter_error = 0.03 "] {
        assert!(plan.contains(line), "{line}: {plan}");
    }
    // Maneuvers begin at the speeds of the plan.
    let dictionary = text("mine/dictionary.toml");
    let modes: Vec<&str> = plan.lines().filter(|line| line.starts_with("speed_m_s = ")).collect();
    let full = modes.last().unwrap().strip_prefix("speed_m_s = ").unwrap();
    for line in
        [format!("to_m_s = {full}\n"), format!("from_m_s = {full}\n"), format!("speed_m_s = {full}\n")]
    {
        assert!(dictionary.contains(&line), "{line}: {dictionary}");
    }
    assert!(!dictionary.contains("0.9"), "{dictionary}");
    // A guess is planned for vessels within her priors.
    run(
        &folder,
        &format!("new guess --guess length_m=100,beam_m=16,draught_m=6,block=0.7,speed_m_s=7 {chart}"),
    )
    .succeeds();
    assert!(text("guess/plan.toml").contains("\nstandard_errors = 0.5 "), "{}", text("guess/plan.toml"));
}

#[test]
#[ignore = "long: `make nightly` runs it"]
fn a_ship_of_320_m_is_planned_in_open_water() {
    let folder = tempfile::tempdir().unwrap();
    sea(&folder);
    let line = "new mine --vessel kvlcc2-l7 --scale length_m=320,density_kg_m3=1025 --chart sea.geojson --place 4.6,55.2";
    run(&folder, line).succeeds();
    for stage in [
        "simulate dictionary --vessel mine/vessel.toml --dictionary mine/dictionary.toml --out dictionary.parquet",
        "plan --vessel mine/vessel.toml --trajectories dictionary.parquet --dictionary mine/dictionary.toml \
         --config mine/plan.toml --set plan.safety.runs=16 --out plan.json",
    ] {
        run(&folder, stage).succeeds();
    }
    let planned = &json(&folder, "plan.json")["data"];
    assert_eq!(planned["status"], "optimal");
}
