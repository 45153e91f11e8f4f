//! A ship with a propeller and a rudder in its stream, by channels that are derived from both.

use tempfile::TempDir;
use vessel::simulate_one;

use crate::support::*;

const RUDDER: &str =
    "[[maneuver]]\nname = \"recorded\"\nkind = \"inputs\"\nfile = \"rudder.csv\"\nspeed_m_s = 0.3\n";

/// The made-up ship with a maneuver whose inputs stand in a table.
fn folder() -> TempDir {
    let (folder, ship) = (tempfile::tempdir().unwrap(), repository().join("fixtures/propeller/vessel.toml"));
    std::fs::copy(ship, folder.path().join("vessel.toml")).unwrap();
    put(&folder, "dictionary.toml", RUDDER);
    put(&folder, "rudder.csv", &table("", |_| String::new()));
    folder
}

/// Propeller and rudder at sample k: astern at last.
fn inputs(k: i32) -> [f64; 2] {
    [f64::from(12 - k / 5), if k % 14 < 7 { 0.3 } else { -0.2 }]
}

fn table(more: &str, cell: impl Fn(i32) -> String) -> String {
    let row = |k: i32| format!("{},{}{}\n", inputs(k)[0], inputs(k)[1], cell(k));
    format!("n,delta{more}\n") + &(0..80).map(row).collect::<String>()
}

#[test]
fn inputs_from_a_table_move_the_propellers_stream_too() {
    let folder = folder();
    run(&folder, DICTIONARY).succeeds();
    let made = craft::read(&folder.path().join("dictionary.parquet"), "trajectories");
    let column = |name: &str| {
        let place = made.schema.columns.iter().position(|c| c.name == name).unwrap();
        made.blocks[0].columns[place].as_f64().unwrap()
    };
    let row = |k: i32| {
        let [n, delta] = inputs(k);
        let ahead = n.max(0.0);
        [n, delta, 0.0, ahead * ahead * delta, ahead, n.min(0.0)]
    };
    let rows: Vec<f64> = (0..80).flat_map(row).collect();
    for (i, name) in ["n", "delta", "wind_y", "stream", "n_ahead", "n_astern"].into_iter().enumerate() {
        // The last row has no inputs.
        for k in 0..80 {
            approx::assert_relative_eq!(column(name)[k], rows[6 * k + i], max_relative = 1e-14);
        }
    }
    // The same motion as where every channel is given.
    let mut vessel = read_vessel(&folder);
    vessel.model.derived.clear();
    let states = simulate_one(&vessel.model, &vessel.nominal, [0.3, 0.0, 0.0], &rows);
    for (d, name) in ["u", "v", "r"].into_iter().enumerate() {
        for k in 0..=80 {
            let (found, expected) = (column(name)[k], states[3 * k + d]);
            approx::assert_relative_eq!(found, expected, epsilon = 1e-15, max_relative = 1e-12);
        }
    }
    assert!(column("r").iter().any(|r| r.abs() > 0.01), "the stream turns the ship");
}

fn read_vessel(folder: &TempDir) -> vessel::Vessel {
    let path = folder.path().join("vessel.toml");
    study::files::read_vessel(&path, &mut artifact::Provenance::default()).unwrap()
}

#[test]
fn a_table_may_repeat_a_derived_channel_and_not_contradict_it() {
    let folder = folder();
    put(&folder, "rudder.csv", &table(",n_ahead", |k| format!(",{}", inputs(k)[0].max(0.0))));
    run(&folder, DICTIONARY).succeeds();
    std::fs::remove_file(folder.path().join("dictionary.parquet")).unwrap();
    put(&folder, "rudder.csv", &table(",n_ahead", |k| format!(",{}", inputs(k)[0])));
    let pieces = ["rudder.csv: line 67, column `n_ahead`", "found -1", "expected 0,", "remove the column"];
    refused(&folder, 3, DICTIONARY, &pieces);
}

#[test]
fn channels_that_nothing_defines_are_not_simulated_as_zero() {
    let folder = folder();
    edit(&folder, "vessel.toml", "simulated = 0.0\n", "");
    let pieces = ["measured disturbance `wind_y`", "[[derived]]", "add `simulated = 0.0`"];
    refused(&folder, 3, DICTIONARY, &pieces);
    let derived = "[[derived]]\nname = \"n_ahead\"\nformula = \"positive(n)\"";
    edit(&folder, "vessel.toml", derived, "[[measured]]\nname = \"n_ahead\"");
    refused(&folder, 3, DICTIONARY, &["measured disturbance"]);
}

#[test]
fn derived_channels_that_depend_on_each_other_in_a_circle_are_refused_by_the_circle() {
    let folder = folder();
    edit(&folder, "vessel.toml", "\"positive(n)\"", "\"positive(stream)\"");
    let pieces = ["vessel.toml", "derived channel", "stream from n_ahead from stream", "break the circle"];
    refused(&folder, 3, DICTIONARY, &pieces);
    edit(&folder, "vessel.toml", "\"positive(stream)\"", "\"positive(u)\"");
    refused(&folder, 3, DICTIONARY, &["derived channel `n_ahead`", "`u`, a state"]);
    edit(&folder, "vessel.toml", "\"positive(u)\"", "\"positive(m)\"");
    refused(&folder, 3, DICTIONARY, &["derived channel `n_ahead`", "`m`, which is declared nowhere"]);
}

#[test]
fn trajectories_with_other_derived_channels_are_refused() {
    let folder = folder();
    run(&folder, DICTIONARY).succeeds();
    edit(&folder, "vessel.toml", "n_ahead^2 delta", "n_ahead^3 delta");
    let pieces = ["dictionary.parquet", "column `stream`, row 0", "formula `n_ahead^3 delta`"];
    refused(&folder, 3, &format!("{MOMENTS} --allow-mixed"), &pieces);
}
