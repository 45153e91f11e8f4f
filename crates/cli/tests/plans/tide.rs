//! Trials in a tide: depths, currents and the slot from a table.

use std::fs;

use tempfile::TempDir;

use crate::planned::*;
use crate::support::*;

/// Five metres of water everywhere, the island in the centre.
const DEPTH: &str = r#"{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"DRVAL1": 5.0}, "geometry":
    {"type": "Polygon", "coordinates": [[[24.9, 59.9], [25.1, 59.9], [25.1, 60.1], [24.9, 60.1], [24.9, 59.9]]]}}]}"#;

const TABLE: &str = "time,level_m,stream_m_s,towards_deg
2026-06-01T07:00:00Z,-1.0,0.0,0
2026-06-01T08:00:00Z,0.5,0.02,90
2026-06-01T12:00:00Z,0.9,0.04,90
2026-06-01T16:00:00Z,-2.0,0.5,270
";

/// The small study in five metres of water, of which the ship needs `depth_m`, with `table` of the tide.
fn study(depth_m: f64, table: &str, departure: &str, until: &str) -> TempDir {
    let safety = format!("[safety]\ntransit_depth_m = {depth_m}\ntrial_depth_m = {depth_m}");
    let chart = "[[chart]]\nfile = \"depth.geojson\"\nkind = \"depth\"\n\n[hull]";
    let tide = format!(
        "departure = \"{departure}\"\ntide = {{ file = \"tide.csv\", until = \"{until}\" }}\nheadings = 4"
    );
    let folder = small_with(&[
        ("[safety]", safety.as_str()),
        ("[hull]", chart),
        ("headings = 4", tide.as_str()),
        ("uncharted = \"water\"\n", ""),
    ]);
    put(&folder, "depth.geojson", DEPTH);
    put(&folder, "tide.csv", table);
    folder
}

const DEPARTURE: &str = "2026-06-01T08:00:00Z";
const UNTIL: &str = "2026-06-01T15:00:00+03:00";

#[test]
fn law_charted_depths_count_with_the_least_level_of_the_slot() {
    // 5 m on the chart and 0.5 m of tide at least: enough for 5.4 m, not for 5.6 m.
    let folder = study(5.4, TABLE, DEPARTURE, UNTIL);
    run(&folder, PLAN).succeeds();
    let plan = json(&folder, "plan.json");
    let tide = &plan["data"]["voyage"]["passage"]["tide"];
    assert_eq!((&tide["level_m"], &tide["slot_s"]), (&0.5.into(), &14400.0.into()));
    let stream: Vec<f64> =
        tide["stream_m_s"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    assert!(stream[0].abs() < 1e-12 && (stream[1] - 0.03).abs() < 1e-12, "{stream:?}");
    assert!((tide["spread_m_s"].as_f64().unwrap() - 0.01).abs() < 1e-12);
    let check = &plan["data"]["voyage"]["check"];
    assert!(
        (check["unknown_current_m_s"].as_f64().unwrap() - 0.06).abs() < 1e-12,
        "0.05 and the stream's spread"
    );
    let folder = study(5.6, TABLE, DEPARTURE, UNTIL);
    run(&folder, PLAN).refuses(4, &["plan.toml", "start"]);
    assert!(!folder.path().join("plan.json").exists());
}

#[test]
fn tables_and_slots_that_make_no_sense_are_refused() {
    let cases: [(&str, &str, &str, i32, &[&str]); 9] = [
        (
            TABLE,
            DEPARTURE,
            "2026-06-02T08:00:00Z",
            3,
            &["tide.csv", "2026-06-01T07:00:00Z to 2026-06-01T16:00:00Z"],
        ),
        (TABLE, "2026-06-01T06:00:00Z", UNTIL, 3, &["tide.csv", "covers 2026-06-01T06:00:00Z"]),
        (TABLE, DEPARTURE, "2026-06-01T07:30:00Z", 3, &["plan.toml", "tide.until", "after the departure"]),
        (TABLE, DEPARTURE, "noon", 3, &["plan.toml", "tide.until", "noon"]),
        (TABLE, DEPARTURE, "2026-06-01T08:01:00Z", 4, &["plan.toml", "tide.until", "a slot of 60 s"]),
        ("time,height\n", DEPARTURE, UNTIL, 3, &["tide.csv", "level_m", "time, height"]),
        (
            "time,level_m\n2026-06-01T08:00:00Z,nan\n",
            DEPARTURE,
            UNTIL,
            3,
            &["tide.csv", "line 2", "level_m", "nan"],
        ),
        (
            "time,level_m\n2026-06-01T09:00:00Z,1\n2026-06-01T08:00:00Z,1\n",
            DEPARTURE,
            UNTIL,
            3,
            &["tide.csv", "line 3", "sort"],
        ),
        (
            "time,level_m,stream_m_s\n2026-06-01T08:00:00Z,1,1\n",
            DEPARTURE,
            UNTIL,
            3,
            &["tide.csv", "towards_deg"],
        ),
    ];
    for (table, departure, until, code, pieces) in cases {
        let folder = study(5.4, table, departure, until);
        run(&folder, PLAN).refuses(code, pieces);
        assert!(!folder.path().join("plan.json").exists());
    }
    let folder = study(5.4, TABLE, DEPARTURE, UNTIL);
    edit(&folder, "plan.toml", &format!("departure = \"{DEPARTURE}\"\n"), "");
    run(&folder, PLAN).refuses(3, &["plan.toml", "departure", "[tide]"]);
    let folder = study(5.4, TABLE, DEPARTURE, UNTIL);
    fs::remove_file(folder.path().join("tide.csv")).unwrap();
    run(&folder, PLAN).refuses(1, &["tide.csv"]);
}
