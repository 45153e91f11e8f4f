//! The memory of a plan is reported before the work, and every phase of it ends in time.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::lattice_problems::SOLVE;
use crate::planned::*;
use crate::support::*;

/// An empty map of 3000 × 3000 × 4 poses.
fn vast() -> TempDir {
    const SIDE: u64 = 3000;
    let ways = [(1, 0), (0, 1), (-1, 0), (0, -1)];
    let moves = |ahead: i64, turn: i64| -> Value {
        let one = |(h, (x, y)): (usize, &(i64, i64))| {
            let to_h = (h as i64 + turn).rem_euclid(4);
            json!({"h": h, "di": ahead * x, "dj": ahead * y, "to_h": to_h, "swept": [[-9.0, -9.0, 9.0, 9.0]]})
        };
        ways.iter().enumerate().map(one).collect()
    };
    let problem = json!({
        "schema": "experiment-lattice-planning/1", "name": "vast",
        "lattice": {"nx": SIDE, "ny": SIDE, "headings": 4, "cell": 100.0, "origin": [50.0, 50.0]},
        "bounds": [0.0, 0.0, 100 * SIDE, 100 * SIDE], "obstacles": [],
        "informative": [{"name": "q", "count": 3, "cost": 0, "moves": moves(3, 0)}],
        "basic": [
            {"name": "ahead", "cost": 66.7, "moves": moves(1, 0)},
            {"name": "port", "cost": 31.3, "moves": moves(0, 1)},
        ],
        "start": [2, 2, 0], "goal": [SIDE - 5, SIDE - 4, 1],
    });
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "problem.json", &problem.to_string());
    folder
}

#[test]
fn a_lattice_that_does_not_fit_is_refused_before_it_is_laid_out() {
    let pieces = ["problem.json", "36000000 poses", "MiB", "--memory-mib"];
    refused(&vast(), 4, &format!("{SOLVE} --memory-mib 512"), &pieces);
    let fine = small_with(&[
        ("cell_m = 120.0", "cell_m = 2.0"),
        ("[start]", "[approach]\ntolerance_cells = 6.0\n[start]"),
    ]);
    let pieces = ["plan.toml", "poses", "raster cells", "MiB", "--memory-mib"];
    refused(&fine, 4, &format!("{PLAN} --memory-mib 512"), &pieces);
}

#[test]
fn law_a_plan_goes_through_with_the_memory_that_its_refusal_tells() {
    let folder = small();
    let tried = |mib: u64| run(&folder, &format!("{PLAN} --memory-mib {mib}"));
    let told = |ran: Ran| -> u64 {
        let ran = ran.refuses(4, &["plan.toml", "raster cells", "expected at most --memory-mib"]);
        let number = ran.stderr.split("which take ").nth(1).and_then(|after| after.split(' ').next());
        number.and_then(|text| text.parse().ok()).unwrap_or_else(|| panic!("{ran}"))
    };
    // The size of rasters is known before the simulation of legs, that of legs after it, that of the check when there
    // is a plan.
    let mut needed = 25;
    for _ in 0..4 {
        let ran = tried(needed);
        if ran.code == Some(0) {
            assert!(needed > 40 && told(tried(needed - 1)) >= needed, "{ran}");
            return;
        }
        let more = told(ran);
        assert!(more > needed, "{needed} {more}");
        needed = more;
    }
    panic!("refused with {needed} MiB, which it says to take");
}

/// Exit code and peak memory of the program in a folder \[MiB\].
#[cfg(target_os = "linux")]
pub fn peak_mib(folder: &TempDir, line: &str) -> (Option<i32>, f64) {
    let mut command = std::process::Command::new(SEATRIAL);
    command.args(line.split_whitespace()).arg("--quiet").current_dir(folder.path());
    let (out, err) = (std::process::Stdio::null(), std::process::Stdio::null());
    let mut child = command.stdout(out).stderr(err).spawn().unwrap();
    let mut peak_kib = 0.0_f64;
    loop {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let told = status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.split_whitespace().next());
        peak_kib = peak_kib.max(told.and_then(|text| text.parse().ok()).unwrap_or(0.0));
        if let Some(ended) = child.try_wait().unwrap() {
            return (ended.code(), peak_kib / 1024.0);
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
}

/// A vessel with very uncertain parameters: after the first round there is no plan, so the first one is used.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "long: `make nightly` runs it"]
fn law_a_plan_that_is_kept_although_unsafe_keeps_to_the_memory() {
    let folder = small_with(&[
        ("runs = 4", "runs = 64\nparameter_error = 0.7"),
        ("margin_m = 20.0", "margin_m = 60.0"),
        ("headings = 4", "headings = 4\nraster_per_cell = 64"),
    ]);
    let line = format!("{PLAN} --allow=unsafe");
    let (mut planned, mut refused) = (0, 0);
    for mib in [100, 160, 200] {
        let (code, peak) = peak_mib(&folder, &format!("{line} --memory-mib {mib}"));
        assert!(peak > 1.0 && peak <= 1.1 * f64::from(mib), "{peak} of {mib} MiB");
        match code {
            Some(0) => planned += 1,
            code => refused += i32::from(code == Some(4)),
        }
    }
    assert!(planned > 0 && refused > 0 && planned + refused == 3, "{planned} {refused}");
    assert_eq!(json(&folder, "plan.json")["data"]["voyage"]["check"]["safe"], false);
}

#[test]
fn the_time_limit_counts_layout_and_check() {
    let line = format!("{SOLVE} --memory-mib 8192 --time-limit-s 0.05");
    refused(&vast(), 4, &line, &["problem.json", "none in time", "--time-limit-s"]);
    let many = small_with(&[("runs = 4", "runs = 1000000")]);
    let pieces = ["plan.toml", "none in time", "the check of the plan", "`safety.runs`"];
    run(&many, &format!("{PLAN} --time-limit-s 4")).refuses(4, &pieces);
}

#[test]
fn areas_that_no_plane_holds_are_refused() {
    for (from, to) in [("south_deg = 59.99", "south_deg = -1"), ("west_deg = 24.98", "west_deg = -170.0")] {
        refused(&small_with(&[(from, to)]), 3, PLAN, &["plan.toml", "`area`", "at most 200 km on a side"]);
    }
    let narrow =
        small_with(&[("north_deg = 60.01", "north_deg = 59.9905"), ("cell_m = 120.0", "cell_m = 20.0")]);
    refused(&narrow, 3, PLAN, &["`area`", "within 20 to 1"]);
}

#[test]
fn handling_that_makes_legs_endless_is_refused() {
    for (key, from, to, bounds) in [
        ("response_s", "30.0", "1e9", "0.001 to 3600 s"),
        ("turn_rate_rad_s", "0.05", "1e-9", "1e-4 to 10 rad/s"),
        ("acceleration_m_s2", "0.05", "1e-12", "1e-5 to 100 m/s²"),
        ("lookahead_m", "60.0", "1e12", "0.001 to 100000 m"),
    ] {
        let folder = small_with(&[(&format!("{key} = {from}"), &format!("{key} = {to}"))]);
        refused(&folder, 3, PLAN, &["plan.toml", &format!("`handling.{key}`"), bounds]);
    }
}

#[test]
fn shares_that_are_no_shares_are_refused_by_the_designs_name() {
    let folder = small_with(&[(
        "maneuver = [{ name = \"zig-zag-steep\", count = 1 }, { name = \"sway-zig-zag\", count = 1 }]",
        "informative_s = 700.0\nmaneuver = [{ name = \"zig-zag-steep\" }, { name = \"sway-zig-zag\" }]",
    )]);
    run(&folder, MOMENTS).succeeds();
    run(&folder, DESIGN).succeeds();
    let line = format!("{PLAN} --design design.json");
    let whole = document::<study::documents::DesignDocument>(&folder, "design.json");
    let first = whole.data.order[0].clone();
    let changed = |change: &dyn Fn(&mut BTreeMap<String, f64>)| {
        let mut body = whole.data.clone();
        change(&mut body.shares);
        let path = folder.path().join("design.json");
        files::commit(vec![files::stage_document(path, &whole.provenance, &body).unwrap()]).unwrap();
    };
    changed(&|shares| *shares.get_mut(&first).unwrap() = -5.0);
    refused(&folder, 3, &line, &["design.json", &format!("`{first}`"), "-5", "from 0 to 1"]);
    changed(&|shares| shares.values_mut().for_each(|share| *share *= 7.0));
    refused(&folder, 3, &line, &["design.json", "share"]);
    changed(&|shares| shares.values_mut().for_each(|share| *share = 0.9));
    refused(&folder, 3, &line, &["design.json", "shares", "found 2.7", "expected 1;"]);
}
