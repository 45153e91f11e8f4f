//! Thrusters whose force is a table.

use crate::runner::*;

const CONFIG: [&str; 2] = ["--config", "ingest.toml"];

/// A configuration with an azimuth thruster that pushes ahead.
fn config_of(table: &str) -> String {
    let pitch = "[[file.channel]]\ncolumn = \"v\"\nchannel = \"pitch\"\nunit = \"1\"\noptional = true\n";
    let ahead = "[[derived]]\nchannel = \"a\"\nformula = \"0 n\"\nunit = \"rad\"\n";
    let thruster =
        "[[thruster]]\nkind = \"azimuth\"\nspeed = \"n\"\nangle = \"a\"\nposition_m = [-2.0, 0.5]\n";
    config("") + pitch + ahead + thruster + table
}

#[test]
fn forces_are_interpolated_in_a_table_over_the_speed() {
    let text = config_of("table = { speed = [0.0, 1.0, 2.0], force = [0.0, 10.0, 40.0] }\n");
    let made = ingest(folder(&[("ingest.toml", &text), ("a.csv", &log(31))]).path(), &CONFIG);
    for k in 0..30 {
        let n = (60.0 + k as f64) / 60.0;
        let force = 10.0 + 30.0 * (n - 1.0);
        assert!((made.f64("tau1")[k] - force).abs() < 1e-12);
        assert!((made.f64("tau3")[k] + 0.5 * force).abs() < 1e-12, "a thruster to starboard turns to port");
    }
}

#[test]
fn a_table_over_speed_and_pitch_needs_the_pitch() {
    let table = "pitch = \"pitch\"\ntable = { speed = [0.0, 2.0], pitch = [0.0, 1.0], forces = [[0.0, 0.0], [0.0, 80.0]] }\n";
    let made = ingest(folder(&[("ingest.toml", &config_of(table)), ("a.csv", &log(11))]).path(), &CONFIG);
    // A pitch of 0.02 throughout.
    assert!((made.f64("tau1")[6] - 0.02 * 40.0 * 1.1).abs() < 1e-12);
    let without = table.replace("pitch = \"pitch\"\n", "");
    refused(&config_of(&without), &log(11), &["ingest.toml: [[thruster]]", "`pitch`"]);
    let short = table.replace("[0.0, 80.0]", "[80.0]");
    refused(&config_of(&short), &log(11), &["ingest.toml: forces of a table", "2 rows of 2 numbers"]);
}

#[test]
fn what_lies_outside_of_a_table_is_refused() {
    let table = "table = { speed = [0.0, 1.1], force = [0.0, 10.0] }\n";
    let pieces = ["a.csv: run `a`", "in channel `n`", "from 0 to 1.1", "extend the table"];
    refused(&config_of(table), &log(31), &pieces);
    let falling = table.replace("[0.0, 1.1]", "[1.1, 0.0]");
    refused(&config_of(&falling), &log(31), &["ingest.toml: `speed` of a table", "increase"]);
    let both = format!("coefficient = 1.0\n{table}");
    refused(&config_of(&both), &log(31), &["ingest.toml: [[thruster]]", "`coefficient` and `table`"]);
}
