use crate::support::*;
use crate::{INGEST, LOGS, small};

#[track_caller]
fn refused_after(file: &str, from: &str, to: &str, code: i32, pieces: &[&str]) {
    let folder = small();
    edit(&folder, file, from, to);
    refused(&folder, code, LOGS, pieces);
}

#[test]
fn an_unknown_key_is_refused_with_the_nearest() {
    refused_after("logs.toml", "repeats = 2", "repeat = 2", 3, &["logs.toml", "`repeat`", "`repeats`"]);
    let (from, to) = ("angle_std_rad = 0.01", "angle_std_deg = 0.6");
    refused_after("logs.toml", from, to, 3, &["`angle_std_deg`", "`angle_std_rad`"]);
}

#[test]
fn an_unknown_maneuver_on_a_day_is_refused_with_the_nearest() {
    let pieces = ["logs.toml", "day `pond`", "`acelerate`", "did you mean `accelerate`?"];
    refused_after("logs.toml", "\"accelerate\"", "\"acelerate\"", 3, &pieces);
    let top = "repeats = 2\nsettle_s = { spiral = 1.0 }";
    refused_after("logs.toml", "repeats = 2", top, 3, &["[settle_s]", "`spiral`"]);
}

#[test]
fn thrusters_that_cannot_make_the_forces_are_refused() {
    // Both at one position: a sway force causes a moment that spirals must not have.
    let folder = small();
    edit(&folder, "logs.toml", "position_m = [-0.4, -0.1]", "position_m = [-0.4, 0.1]");
    refused(&folder, 3, LOGS, &["logs.toml", "[[thruster]]", "tau3", "maneuver `"]);
}

#[test]
fn a_simulation_that_diverges_is_refused() {
    let folder = small();
    put(&folder, "vessel.toml", "preset = \"ljungberg-model-ship\"\n[value]\nN_r = -2.9\n");
    refused(&folder, 3, LOGS, &["vessel.toml", "maneuver `", "diverges"]);
}

#[test]
fn numbers_without_meaning_are_refused() {
    for (from, to, piece) in [
        ("sample_rate_hz = 8.0", "sample_rate_hz = 4.0", "8 Hz"),
        ("rate_hz = 8.0\nwhite", "rate_hz = 3.0\nwhite", "gnss.rate_hz"),
        ("white_std_m = 0.003", "white_std_m = -0.003", "`gnss.white_std_m`"),
        ("coefficient = 1.44", "coefficient = 0.0", "`coefficient` of thruster 1"),
        ("samples = 75", "samples = 0", "`samples`"),
        ("std_m_s = 0.035", "std_m_s = nan", "`current.std_m_s` of day `pond`"),
        ("current = {", "wind = { speed_m_s = 3.0, from_rad = 0.0 }\ncurrent = {", "[hull]"),
    ] {
        refused_after("logs.toml", from, to, 3, &["logs.toml", piece]);
    }
}

#[test]
fn logs_that_do_not_fit_into_memory_are_refused() {
    let folder = small();
    edit(&folder, "logs.toml", "repeats = 2", "repeats = 100000");
    let pieces = ["logs.toml", "`repeats`", "GiB of memory", "256 MiB of --memory-mib"];
    refused(&folder, 3, &format!("{LOGS} --memory-mib 256"), &pieces);
}

#[test]
fn a_vessel_without_the_forces_of_azimuth_thrusters_is_refused() {
    let folder = small();
    let vessel = std::fs::read_to_string(repository().join("pipelines/paper/vessel.toml")).unwrap();
    put(&folder, "vessel.toml", &vessel.replace("tau1", "thrust"));
    refused(&folder, 3, LOGS, &["vessel.toml", "thrust [N]", "tau1 [N]"]);
}

#[test]
fn a_failed_output_leaves_nothing_behind() {
    let folder = small();
    edit(&folder, "logs.toml", "samples = 75", "samples = 2000");
    let before = listing(folder.path());
    run_on_full_disk(&folder, LOGS).refuses(1, &["logs"]);
    assert_eq!(listing(folder.path()), before);
    refused(&folder, 2, &LOGS.replace("logs/", "logs.toml"), &["--out", "logs.toml"]);
}

#[test]
fn logs_that_were_changed_are_refused_by_ingest() {
    let folder = small();
    run(&folder, LOGS).succeeds();
    edit(&folder, "logs/spiral-fast_02.csv", "0.125000,", "0.125001,");
    refused(
        &folder,
        3,
        INGEST,
        &["spiral-fast_02.csv", "another file than the one written", "simulated.json"],
    );
    run(&folder, LOGS).succeeds();
    put(
        &folder,
        "logs/spiral-fast_03.csv",
        &String::from_utf8(bytes(&folder, "logs/spiral-fast_02.csv")).unwrap(),
    );
    refused(&folder, 3, INGEST, &["spiral-fast_03.csv", "not listed"]);
}
