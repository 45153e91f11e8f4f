use std::fs;

use tempfile::TempDir;

use crate::support::*;
use crate::{INGEST, LOGS, small};

fn log(folder: &TempDir, name: &str) -> Vec<u8> {
    bytes(folder, &format!("logs/{name}.csv"))
}

#[test]
fn a_log_per_repeat_is_sealed_and_labelled_as_simulated() {
    let folder = small();
    let ran = run(&folder, LOGS).succeeds();
    assert!(ran.stdout.contains("22 simulated logs of 11 maneuvers, 75 samples each"), "{ran}");
    let document = json(&folder, "logs/simulated.json");
    assert_eq!(document["settings"]["data"], "simulated logs");
    assert_eq!(document["data"]["label"], "simulated logs");
    let recordings = document["data"]["recordings"].as_array().unwrap();
    assert_eq!(recordings.len(), 22);
    for recording in recordings {
        let text = bytes(&folder, &format!("logs/{}", recording["file"].as_str().unwrap()));
        assert_eq!(recording["digest"], files::Digest::of_bytes(&text).to_string());
        let text = String::from_utf8(text).unwrap();
        assert!(text.starts_with("simulated t [s],"), "{text}");
        assert_eq!(text.lines().count(), 1 + 75 + 2);
    }
}

#[test]
fn law_neither_threads_nor_other_maneuvers_nor_more_repeats_change_a_log() {
    let folder = small();
    run(&folder, &format!("{LOGS} --threads 1")).succeeds();
    let first = listing_of_logs(&folder);
    run(&folder, &format!("{LOGS} --threads 3")).succeeds();
    assert!(first == listing_of_logs(&folder));
    let more = small();
    edit(&more, "logs.toml", "repeats = 2", "repeats = 3");
    edit(&more, "logs.toml", "\"decelerate\", ", "");
    run(&more, LOGS).succeeds();
    for name in ["accelerate_01", "spiral-fast_02"] {
        assert!(log(&folder, name) == log(&more, name), "{name}");
    }
    assert!(!more.path().join("logs/decelerate_01.csv").exists());
    assert!(log(&folder, "spiral-fast_01") != log(&folder, "spiral-fast_02"));
    let other = small();
    run(&other, &format!("{LOGS} --seed 2")).succeeds();
    assert!(log(&folder, "spiral-fast_01") != log(&other, "spiral-fast_01"));
}

fn listing_of_logs(folder: &TempDir) -> Vec<(std::path::PathBuf, Vec<u8>)> {
    let entries = fs::read_dir(folder.path().join("logs")).unwrap().map(|entry| entry.unwrap().path());
    let mut all: Vec<_> = entries.map(|path| (path.clone(), fs::read(path).unwrap())).collect();
    all.sort();
    all
}

#[test]
fn law_without_noise_ingest_gives_the_forces_and_the_motion_back() {
    let folder = small();
    let quiet = [
        ("white_std_m = 0.003", "white_std_m = 0.0"),
        ("wander_std_m = 0.010", "wander_std_m = 0.0"),
        ("resolution_m = 0.001", "resolution_m = 0.0"),
        ("white_std_rad = 0.001", "white_std_rad = 0.0"),
        ("wander_std_rad = 0.017", "wander_std_rad = 0.0"),
        ("resolution_rad = 0.0002", "resolution_rad = 0.0"),
        ("scatter_std = 0.05", "scatter_std = 0.0"),
    ];
    quiet.iter().for_each(|(from, to)| edit(&folder, "logs.toml", from, to));
    let thrusters = ["speed_std_rps = 0.2", "angle_std_rad = 0.01", "speed_resolution_rps = 0.0166667"];
    let thrusters = thrusters.iter().chain(["angle_resolution_rad = 0.00175"].iter());
    let still = "current = { north_m_s = 0.02, east_m_s = -0.02, std_m_s = 0.035, time_s = 0.5 }";
    edit(&folder, "logs.toml", still, "");
    for key in thrusters {
        let name = key.split(' ').next().unwrap();
        (0..2).for_each(|_| edit(&folder, "logs.toml", key, &format!("{name}= 0.0")));
    }
    run(&folder, LOGS).succeeds();
    run(&folder, INGEST).succeeds();
    run(&folder, DICTIONARY).succeeds();
    let (truth, logged) = (rows(&folder, "dictionary.parquet"), rows(&folder, "trajectories.parquet"));
    let dt = 1.0 / 8.0;
    // The dictionary is in its own order, the logs in that of their names.
    let run_of = |name: &str| truth.iter().find(|run| run.segments[0].maneuver == name).unwrap();
    assert_eq!((truth.len(), logged.len()), (11, 22));
    for found in &logged {
        let name = found.segments[0].maneuver.as_str();
        let expected = run_of(name);
        assert_eq!(found.samples(), 75);
        // Spirals are swept over the whole log, which is two rows longer than the dictionary's 75 samples.
        if name.starts_with("spiral") {
            continue;
        }
        for k in 0..74 {
            for d in 0..3 {
                let (force, wanted) = (found.exogenous[3 * k + d], expected.exogenous[3 * k + d]);
                assert!((force - wanted).abs() < 0.05, "{name}, force {d} at {k}: {force} {wanted}");
                let (now, next) = (expected.measured[3 * k + d], expected.measured[3 * (k + 1) + d]);
                let rates = expected.measured[3 * k + 2].abs() + expected.measured[3 * k + 5].abs();
                let turned = if d < 2 { 1.3 * rates * dt } else { 0.0 };
                let bound = (next - now).abs() + turned + 1e-4;
                let error = (found.measured[3 * k + d] - now).abs();
                assert!(error < bound, "{name}, state {d} at {k}: {error} above {bound}");
            }
        }
    }
}

fn rows(folder: &TempDir, name: &str) -> Vec<ship::engine::Run> {
    use study::trajectories::{Layout, TrajectoryReader};
    let path = folder.path().join("vessel.toml");
    let vessel = study::files::read_vessel(&path, &mut files::Provenance::default()).unwrap();
    let reader = TrajectoryReader::open(&folder.path().join(name), &Layout::new(&vessel.model), 8.0).unwrap();
    (0..reader.blocks()).flat_map(|block| reader.runs(block).unwrap()).collect()
}

#[test]
fn thrusters_that_cannot_follow_are_told() {
    let folder = small();
    edit(&folder, "logs.toml", "speed_limit_rps = 75.0", "speed_limit_rps = 40.0");
    let ran = run(&folder, LOGS).succeeds();
    assert!(ran.stdout.contains("thruster 1 was held at its highest speed at "), "{ran}");
    let document = json(&folder, "logs/simulated.json");
    let limited = |i: usize| {
        let all = document["data"]["recordings"].as_array().unwrap();
        all.iter().map(|r| r["limited"][i].as_f64().unwrap()).fold(0.0, f64::max)
    };
    assert!(limited(0) > 0.1 && limited(1) == 0.0, "{} {}", limited(0), limited(1));
}

#[test]
fn a_slow_receiver_leaves_rows_without_a_fix() {
    let folder = small();
    edit(&folder, "logs.toml", "rate_hz = 8.0\nwhite", "rate_hz = 4.0\nwhite");
    run(&folder, LOGS).succeeds();
    let text = String::from_utf8(log(&folder, "accelerate_01")).unwrap();
    let places: Vec<bool> = text.lines().skip(1).map(|line| !line.contains(",,")).collect();
    assert!(places.iter().enumerate().all(|(k, fix)| *fix == (k % 2 == 0)), "{text}");
    run(&folder, INGEST).succeeds();
}
