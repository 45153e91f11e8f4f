//! A ship with a propeller and a rudder in its slipstream, by channels that are derived from both.

use ship::engine::simulate_one;
use tempfile::TempDir;

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

fn read_vessel(folder: &TempDir) -> ship::model::Vessel {
    let path = folder.path().join("vessel.toml");
    study::files::read_vessel(&path, &mut files::Provenance::default()).unwrap()
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
    refused(&folder, 3, &format!("{MOMENTS} --allow=mixed"), &pieces);
}

/// The made-up ship without the terms that its maneuvers do not excite, and its maneuvers.
fn logged() -> TempDir {
    let (folder, fixtures) = (tempfile::tempdir().unwrap(), repository().join("fixtures/propeller"));
    std::fs::copy(fixtures.join("dictionary.toml"), folder.path().join("dictionary.toml")).unwrap();
    let text = std::fs::read_to_string(fixtures.join("vessel.toml")).unwrap();
    let blocks = text.split("\n\n").filter(|block| !block.contains("wind_y") && !block.contains("astern"));
    put(&folder, "vessel.toml", &blocks.collect::<Vec<_>>().join("\n\n"));
    put(&folder, "campaign.toml", CAMPAIGN);
    folder
}

const CAMPAIGN: &str = r#"
seed = 1
realizations = 8
duration_s = 600.0
current = { kind = "none" }
measurement = { std_u_m_s = 0.0005, std_v_m_s = 0.0005, std_r_rad_s = 0.0001 }
random = { segments = 5 }
validation = { parameter_error_bound = 1.0, simulation_error_bound = 0.2, maneuver = [
    { name = "circle", kind = "steady-turn", duration_s = 100.0, speed_m_s = 0.35, yaw_rate_rad_s = -0.02 },
] }
"#;

#[test]
fn the_next_trial_is_designed_from_the_model_that_logs_give() {
    let folder = logged();
    run(&folder, DICTIONARY).succeeds();
    let pool =
        "estimate --structure own --vessel vessel.toml --trajectories dictionary.parquet --estimator ls";
    run(&folder, &format!("{pool} --out estimates.parquet")).succeeds();
    let model = json(&folder, "model.json")["data"].clone();
    assert_eq!(model["derived"][0]["formula"], "n_ahead^2 delta");
    assert_eq!(model["inputs"][0]["range"], serde_json::json!([-10.0, 15.0]));
    // Logs without noise give the ship itself: the next maneuvers are the same.
    let of_model =
        DICTIONARY.replace("vessel.toml", "model.json").replace("dictionary.parquet", "next.parquet");
    run(&folder, &of_model).succeeds();
    let table = |name: &str| craft::read(&folder.path().join(name), "trajectories");
    let (ship, found) = (table("dictionary.parquet"), table("next.parquet"));
    for name in ["n", "delta", "u", "r"] {
        let place = ship.schema.columns.iter().position(|c| c.name == name).unwrap();
        let values = |of: &craft::Whole| of.blocks[0].columns[place].as_f64().unwrap().to_vec();
        for (ship, found) in values(&ship).into_iter().zip(values(&found)) {
            assert!((ship - found).abs() <= 1e-6 || ship.is_nan(), "{name}: {found}, not {ship}");
        }
    }
    // In a separate folder, as the page expects.
    std::fs::create_dir(folder.path().join("next")).unwrap();
    std::fs::copy(folder.path().join("model.json"), folder.path().join("next/model.json")).unwrap();
    let moments = "moments --vessel model.json --trajectories next.parquet --campaign campaign.toml";
    run(&folder, &format!("{moments} --estimator output-error --out next/moments.json")).succeeds();
    let design = "design --moments next/moments.json --for output-error --criterion v --duration-s 600";
    run(&folder, &format!("{design} --out next/design.json")).succeeds();
    let errors = json(&folder, "next/design.json")["data"]["covariance"]["standard_errors"].clone();
    let errors = errors.as_object().unwrap();
    assert!(errors.len() == 13 && errors.values().all(|error| error.as_f64().unwrap() > 0.0), "{errors:?}");
    let trial =
        "--vessel model.json --dictionary dictionary.toml --campaign campaign.toml --design next/design.json";
    run(&folder, &format!("monte-carlo {trial} --estimator output-error --out next/validation.json"))
        .succeeds();
    // Models from so long a trial follow the ship to a small part of its speed.
    let scores = json(&folder, "next/validation.json")["data"]["counted"]["scores"][0]["designs"][0].clone();
    assert!(scores["rmse_u"]["median"].as_f64().unwrap() < 0.01, "{scores}");
    run(&folder, REPORT).succeeds();
    let page = String::from_utf8(bytes(&folder, "report.html")).unwrap();
    for piece in [
        "<section id=\"next\">",
        "What that means for the fit",
        "estimated anew from this trial",
        "<code>N_stream</code>",
    ] {
        assert!(page.contains(piece), "{piece}");
    }
}

#[test]
fn maneuvers_beyond_what_the_actuators_can_be_set_to_are_refused() {
    let folder = logged();
    edit(&folder, "dictionary.toml", "to_m_s = 0.5", "to_m_s = 0.9");
    let pieces = ["maneuver `accelerate`, wanted motion: u = 0.9 m/s", "found n = ", "from -10 to 15"];
    refused(&folder, 3, DICTIONARY, &pieces);
    edit(&folder, "vessel.toml", "range = [-10.0, 15.0]", "range = [15.0, -10.0]");
    refused(&folder, 3, DICTIONARY, &["input `n`", "`range` [15, -10]", "swap or correct them"]);
}

#[test]
fn law_derived_channels_without_a_column_are_computed() {
    let folder = folder();
    run(&folder, DICTIONARY).succeeds();
    run(&folder, &format!("{MOMENTS} --allow=mixed")).succeeds();
    let with_columns = json(&folder, "moments.json")["data"]["maneuvers"].clone();
    // Under other names the file has columns of neither.
    let vessel = std::fs::read_to_string(folder.path().join("vessel.toml")).unwrap();
    put(&folder, "vessel.toml", &vessel.replace("stream", "race").replace("n_ahead", "forward"));
    run(&folder, &format!("{MOMENTS} --allow=mixed")).succeeds();
    let computed = json(&folder, "moments.json")["data"]["maneuvers"].clone();
    assert_eq!(with_columns, computed);
}

/// Trials are simulated in still air, which has no information about wind: its parameter is fixed, and the others are
/// estimated.
#[test]
fn what_simulated_trials_hold_constant_is_not_estimated_from_them() {
    let folder = logged();
    let text = std::fs::read_to_string(repository().join("fixtures/propeller/vessel.toml")).unwrap();
    let blocks: Vec<&str> = text.split("\n\n").filter(|block| !block.contains("astern")).collect();
    assert!(blocks.iter().any(|block| block.contains("term = \"wind_y\"")));
    // Simulated trials follow true values.
    put(&folder, "vessel.toml", &blocks.join("\n\n").replace("\nnominal = ", "\nvalue = "));
    let nominal = std::fs::read_to_string(folder.path().join("vessel.toml")).unwrap();
    let twice = |line: &str| match line.strip_prefix("value = ") {
        Some(value) => format!("{line}\nnominal = {value}\n"),
        None => format!("{line}\n"),
    };
    put(&folder, "vessel.toml", &nominal.lines().map(twice).collect::<String>());
    run(&folder, DICTIONARY).succeeds();
    let moments = "moments --vessel vessel.toml --trajectories dictionary.parquet --campaign campaign.toml";
    run(&folder, &format!("{moments} --estimator output-error --out moments.json")).succeeds();
    let design = "design --moments moments.json --for output-error --duration-s 600";
    run(&folder, &format!("{design} --out design.json")).succeeds();
    let trial =
        "--vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --design design.json";
    run(&folder, &format!("simulate campaign {trial} --out campaign.parquet")).succeeds();
    let line = "estimate --vessel vessel.toml --trajectories campaign.parquet --estimator output-error";
    run(&folder, &format!("{line} --out estimates.parquet")).succeeds();
    let document = json(&folder, "estimate.json")["data"].clone();
    let of_wind = |name: &serde_json::Value| name.as_str().unwrap().contains("wind");
    let parameters = document["designs"][0]["parameters"].as_array().unwrap();
    assert!(parameters.iter().all(|own| !of_wind(&own["name"])) && document["designs"][0]["identified"] == 8);
    assert!(
        document["constrained"].as_array().unwrap().iter().any(|own| of_wind(&own["name"])),
        "{document}"
    );
    // Shards of it are put together alike.
    for part in [1, 2] {
        run(&folder, &format!("{line} --shard {part}/2 --out part-{part}.parquet")).succeeds();
    }
    let gather = "estimate --vessel vessel.toml --gather part-1.parquet part-2.parquet --out whole.parquet";
    run(&folder, gather).succeeds();
    assert_eq!(json(&folder, "estimate.json")["data"], document);
}
