//! Stopped searches make no wrong claims.

use std::sync::LazyLock;

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::lattice_problems::{SOLVE, replay};
use crate::support::*;

/// Four shapes of three uses each among walls of many gaps, with costs in odd seconds: some millions of states.
fn maze() -> Value {
    const SIDE: i64 = 48;
    let ways = [(1, 0), (0, 1), (-1, 0), (0, -1)];
    let swept = |di: f64, dj: f64| {
        json!([[
            f64::min(0.0, di) * 100.0 - 9.05,
            f64::min(0.0, dj) * 100.0 - 9.05,
            f64::max(0.0, di) * 100.0 + 9.05,
            f64::max(0.0, dj) * 100.0 + 9.05
        ]])
    };
    let along = |ahead: i64, aside: i64, turn: i64| -> Value {
        let one = |h: i64| {
            let (x, y) = ways[h as usize];
            let (di, dj) = (ahead * x - aside * y, ahead * y + aside * x);
            json!({"h": h, "di": di, "dj": dj, "to_h": (h + turn).rem_euclid(4), "swept": swept(di as f64, dj as f64)})
        };
        (0..4).map(one).collect()
    };
    let informative: Vec<Value> = [(3, 1), (4, -1), (2, 2), (5, 0)]
        .iter()
        .enumerate()
        .map(|(q, (a, b))| json!({"name": format!("q{q}"), "count": 3, "cost": 0, "moves": along(*a, *b, 0)}))
        .collect();
    let wall = |k: i64| {
        let (x, gap) = (800 * k + 370, (k * 1700) % 4000);
        [json!([x, 0, x + 20, gap]), json!([x, gap + 500, x + 20, 100 * SIDE])]
    };
    json!({
        "schema": "experiment-lattice-planning/1", "name": "maze",
        "lattice": {"nx": SIDE, "ny": SIDE, "headings": 4, "cell": 100.0, "origin": [50.0, 50.0]},
        "bounds": [0.0, 0.0, 100 * SIDE, 100 * SIDE],
        "obstacles": (0..5).flat_map(wall).collect::<Value>(),
        "informative": informative,
        "basic": [
            {"name": "ahead", "cost": 66.7, "moves": along(1, 0, 0)},
            {"name": "port", "cost": 31.3, "moves": along(0, 0, 1)},
            {"name": "starboard", "cost": 29.9, "moves": along(0, 0, -1)},
        ],
        "start": [2, 2, 0], "goal": [45, 44, 1],
    })
}

static MAZE: LazyLock<Value> = LazyLock::new(maze);

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "problem.json", &MAZE.to_string());
    folder
}

#[test]
fn law_a_stopped_search_brackets_the_optimum() {
    let folder = folder();
    run(&folder, SOLVE).succeeds();
    let whole = json(&folder, "plan.json")["data"].take();
    assert_eq!(whole["status"], "optimal");
    let optimum = replay(&MAZE, &whole);
    assert!((whole["cost"].as_f64().unwrap() - optimum).abs() < 1e-6);
    let mut stopped = 0;
    for limit in ["0.000001", "0.02", "0.05", "0.2"] {
        std::fs::remove_file(folder.path().join("plan.json")).unwrap_or_default();
        let ran = run(&folder, &format!("{SOLVE} --time-limit-s {limit}"));
        if ran.code == Some(4) {
            let ran = ran.refuses(4, &["none in time", "--time-limit-s"]);
            assert!(!folder.path().join("plan.json").exists(), "{ran}");
            stopped += 1;
            continue;
        }
        let ran = ran.succeeds();
        let plan = json(&folder, "plan.json")["data"].take();
        let number = |key: &str| plan[key].as_f64().unwrap();
        assert!((replay(&MAZE, &plan) - number("cost")).abs() < 1e-6, "{ran}");
        assert!(number("lower_bound") <= optimum + 1e-6 && optimum <= number("cost") + 1e-6, "{ran}");
        match plan["status"].as_str() {
            Some("optimal") => assert!((number("cost") - optimum).abs() < 1e-6, "{ran}"),
            Some("feasible") => {
                assert!(plan["statement"].as_str().unwrap().starts_with("Not proved"), "{ran}");
                assert!(ran.stdout.contains("feasible (at most "), "no gap: {ran}");
                stopped += 1;
            }
            other => panic!("{other:?}{ran}"),
        }
    }
    assert!(stopped >= 2, "the limits never bite");
}

#[test]
fn more_states_than_memory_allows_are_told_with_what_to_reduce() {
    let pieces = ["problem.json", "states", "MiB", "--memory-mib", "reduce counts"];
    refused(&folder(), 4, &format!("{SOLVE} --memory-mib 25"), &pieces);
}

#[test]
fn little_memory_is_no_reason_for_a_wrong_claim() {
    let folder = folder();
    let ran = run(&folder, &format!("{SOLVE} --memory-mib 27 --time-limit-s 2"));
    if ran.code == Some(4) {
        ran.refuses(4, &["--memory-mib"]);
        return;
    }
    let ran = ran.succeeds();
    let plan = json(&folder, "plan.json")["data"].take();
    let cost = replay(&MAZE, &plan);
    assert!(plan["lower_bound"].as_f64().unwrap() <= cost + 1e-6, "{ran}");
}
