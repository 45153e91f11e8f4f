//! Plans of ships with forces.

use std::sync::OnceLock;

use approx::assert_relative_eq;
use files::TableReader;
use serde_json::Value;
use tempfile::TempDir;

use crate::planned::small;
use crate::support::*;

const PLAN: &str = "plan --vessel mine/vessel.toml --trajectories dictionary.parquet --dictionary mine/dictionary.toml --config \
                    mine/plan.toml --out plan.json";
const MOMENTS: &str = "moments --vessel mine/vessel.toml --trajectories dictionary.parquet --campaign mine/campaign.toml --estimator \
                       output-error --out moments.json";
const DICTIONARY: &str = "simulate dictionary --vessel mine/vessel.toml --dictionary mine/dictionary.toml --out dictionary.parquet";

/// The study of the Otter off Helsinki as `new` writes it, with few headings and few runs of the check; nominal numbers are her only
/// ones.
fn otter() -> TempDir {
    static FILES: OnceLock<Vec<(String, Vec<u8>)>> = OnceLock::new();
    let folder = tempfile::tempdir().unwrap();
    let names = ["vessel.toml", "dictionary.toml", "campaign.toml", "plan.toml"];
    let files = FILES.get_or_init(|| {
        let made = tempfile::tempdir().unwrap();
        let chart = repository().join("fixtures/charts/helsinki_land_gshhg.geojson");
        let chart = chart.display();
        run(&made, &format!("new mine --vessel otter --place 24.95,60.15 --chart {chart}")).succeeds();
        edit(&made, "mine/plan.toml", "runs = 256", "runs = 16");
        edit(&made, "mine/plan.toml", "headings = 8", "headings = 4");
        let vessel = String::from_utf8(bytes(&made, "mine/vessel.toml")).unwrap();
        let untrue = vessel.lines().map(|line| match line.split_once(", value = ") {
            Some((before, after)) => format!("{before}{}\n", &after[after.find(" }").unwrap()..]),
            None => format!("{line}\n"),
        });
        put(&made, "mine/vessel.toml", &untrue.collect::<String>());
        run(&made, DICTIONARY).succeeds();
        let all =
            names.map(|name| format!("mine/{name}")).into_iter().chain(["dictionary.parquet".to_owned()]);
        all.map(|name| (name.clone(), bytes(&made, &name))).collect()
    });
    std::fs::create_dir(folder.path().join("mine")).unwrap();
    files.iter().for_each(|(name, bytes)| std::fs::write(folder.path().join(name), bytes).unwrap());
    folder
}

/// A plan of the Otter.
fn planned() -> &'static (TempDir, Value) {
    static MADE: OnceLock<(TempDir, Value)> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = otter();
        run(&folder, PLAN).succeeds();
        let plan = json(&folder, "plan.json")["data"].clone();
        (folder, plan)
    })
}

/// log|det| of a symmetric matrix that is positive definite, by Cholesky's method.
fn log_det(mut matrix: Vec<f64>, n: usize) -> f64 {
    let mut sum = 0.0;
    for k in 0..n {
        let pivot = matrix[k * n + k];
        sum += pivot.ln();
        for i in k + 1..n {
            let factor = matrix[i * n + k] / pivot;
            (k..n).for_each(|j| matrix[i * n + j] -= factor * matrix[k * n + j]);
        }
    }
    sum
}

/// log|det| of the information of `counts` of maneuvers, by `moments`, with what the priors know.
fn by_moments(moments: &Value, counts: &Value) -> f64 {
    let names: Vec<&str> = moments["degrees"][0]["parameters"]
        .as_array()
        .unwrap()
        .iter()
        .map(|own| own.as_str().unwrap())
        .collect();
    let (n, prior) = (names.len(), &moments["prior"]);
    assert_eq!(prior["parameters"], serde_json::json!(names));
    let known = prior["information"].as_array().unwrap();
    let mut sum: Vec<f64> = known.iter().map(|own| own.as_f64().unwrap()).collect();
    for own in moments["maneuvers"].as_array().unwrap() {
        let count = counts[own["name"].as_str().unwrap()].as_f64().unwrap_or(0.0);
        let samples = own["samples"].as_f64().unwrap();
        let f = own["output_error"]["F"].as_array().unwrap();
        sum.iter_mut().zip(f).for_each(|(sum, f)| *sum += count * samples * f.as_f64().unwrap());
    }
    log_det(sum, n)
}

#[test]
fn a_plan_of_the_otter_keeps_its_margin_and_says_what_its_errors_are() {
    let (_, plan) = planned();
    let (voyage, check) = (&plan["voyage"], &plan["voyage"]["check"]);
    assert_eq!((&plan["status"], &check["safe"]), (&"optimal".into(), &true.into()), "{check}");
    assert_eq!((&check["errors_from"], &check["standard_errors"]), (&"priors".into(), &1.2.into()));
    assert!(
        check["clearance_m"].as_f64().unwrap() > 10.0 && check["worst"]["searched"].as_u64().unwrap() > 40
    );
    let information = &voyage["information"];
    assert_eq!(information["whole_log_det"], Value::Null);
    // Orders react to her, so each maneuver is sailed nearly as promised.
    assert!((information["efficiency"].as_f64().unwrap() - 1.0).abs() < 0.02, "{information}");
    // Jointly: the squares of all deviations in standard deviations of the priors add up to those of the whole at most.
    let known = [("X_u", -77.6, 23.3), ("Y_v", -162.0, 48.8), ("N_r", -40.0, 12.0), ("N_rr", -400.0, 120.0)];
    let known = known.into_iter().chain([("strips.drag", 1.0, 0.3)]);
    for who in ["nearest", "farthest"] {
        let numbers = &check["worst"][who]["numbers"];
        let off = known
            .clone()
            .map(|(name, nominal, prior)| ((numbers[name].as_f64().unwrap() - nominal) / prior).powi(2));
        let off = off.sum::<f64>().sqrt();
        assert!(off <= 1.2 + 1e-9, "{who}: {off}");
    }
}

#[test]
#[ignore = "long: `make nightly` runs it"]
fn law_the_promised_information_is_that_of_moments() {
    let folder = otter();
    // As tables, all maneuvers have the inputs of the dictionary; by 4 headings legs would end too far off.
    edit(&folder, "mine/plan.toml", "headings = 4", "headings = 8");
    edit(&folder, "mine/plan.toml", "circle-port", "accelerate");
    edit(&folder, "mine/plan.toml", "standard_errors = 1.2 ", "standard_errors = 0.5 ");
    run(&folder, &PLAN.replace("--dictionary mine/dictionary.toml ", "")).succeeds();
    run(&folder, MOMENTS).succeeds();
    let (plan, moments) = (&json(&folder, "plan.json")["data"], &json(&folder, "moments.json")["data"]);
    let information = &plan["voyage"]["information"];
    let promised = information["predicted_log_det"].as_f64().unwrap();
    assert_relative_eq!(promised, by_moments(moments, &plan["counts"]), max_relative = 1e-9);
    assert_eq!(information["dimension"], 5);
}

#[test]
fn law_one_arranged_maneuver_is_worth_what_its_moments_say() {
    let folder = otter();
    let text = String::from_utf8(bytes(&folder, "mine/dictionary.toml")).unwrap();
    let first = text.match_indices("[[maneuver]]").nth(1).unwrap().0;
    put(&folder, "mine/dictionary.toml", &text[..first]);
    run(&folder, DICTIONARY).succeeds();
    run(&folder, MOMENTS).succeeds();
    let line = "design --moments moments.json --for output-error --criterion d --duration-s 40 --arrange --vessel mine/vessel.toml \
                --dictionary mine/dictionary.toml --out design.json";
    run(&folder, line).succeeds();
    let design = &json(&folder, "design.json")["data"];
    let (covariance, found) = (design["covariance"]["value"].as_f64().unwrap(), &design["sequence"]["value"]);
    // The one is of the whole trial of 400 samples, the other of a sample: 5 numbers.
    assert_relative_eq!(found.as_f64().unwrap(), -(covariance + 5.0 * 400_f64.ln()), max_relative = 1e-9);
}

#[test]
fn law_the_rest_of_a_plan_has_the_rest_of_its_information() {
    let (folder, plan) = planned();
    let track = TableReader::open(folder.path().join("track.parquet"), "track", 1).unwrap();
    let table = track.read_block(0, &["t", "longitude", "latitude"]).unwrap();
    let value = |column: usize, row: usize| table.columns[column].value_at(row).unwrap();
    let row = |row: usize| format!("{},{},{}", value(0, row), value(1, row), value(2, row));
    let rows: Vec<String> = (0..track.rows()).step_by(5).map(row).collect();
    let again = otter();
    std::fs::copy(folder.path().join("plan.json"), again.path().join("plan.json")).unwrap();
    std::fs::copy(folder.path().join("track.parquet"), again.path().join("track.parquet")).unwrap();
    std::fs::create_dir(again.path().join("rest")).unwrap();
    let follow = |rows: &[String]| {
        let head = "time,longitude_deg,latitude_deg\n".to_owned();
        put(&again, "positions.csv", &rows.iter().fold(head, |text, row| text + row + "\n"));
        let line = PLAN.replace("--out plan.json", "--out rest/plan.json");
        run(&again, &format!("{line} --rest-of plan.json --from positions.csv")).succeeds();
        json(&again, "rest/plan.json")["data"]["begun"].take()
    };
    let whole = follow(&rows);
    assert_relative_eq!(whole["information"]["share"].as_f64().unwrap(), 1.0, max_relative = 1e-9);
    assert_relative_eq!(whole["information"]["efficiency"].as_f64().unwrap(), 1.0, max_relative = 1e-9);
    let part = follow(&rows[..rows.len() * 7 / 10]);
    let share = part["information"]["share"].as_f64().unwrap();
    assert!(share > 0.1 && share < 0.9, "{part}");
    assert!(!plan["counts"].as_object().unwrap().is_empty());
}

#[test]
fn law_threads_do_not_change_the_plan_of_a_ship_with_forces() {
    let (folder, _) = planned();
    let again = otter();
    run(&again, &format!("{PLAN} --threads 2")).succeeds();
    for name in ["plan.json", "track.parquet", "map.json"] {
        assert!(bytes(&again, name) == bytes(folder, name), "{name}");
    }
}

#[test]
#[ignore = "long: `make nightly` runs it"]
fn law_half_of_the_errors_need_no_more_moves() {
    let (_, plan) = planned();
    let folder = otter();
    edit(&folder, "mine/plan.toml", "standard_errors = 1.2 ", "standard_errors = 0.6 ");
    run(&folder, PLAN).succeeds();
    let narrow = &json(&folder, "plan.json")["data"];
    assert!(narrow["cost"].as_f64() <= plan["cost"].as_f64());
    assert!(narrow["voyage"]["duration_s"].as_f64() <= plan["voyage"]["duration_s"].as_f64());
}

#[test]
fn an_error_in_per_cent_stays_within_the_bounds_of_numbers() {
    let folder = otter();
    edit(&folder, "mine/plan.toml", "standard_errors = 1.2 ", "parameter_error = 0.2 ");
    edit(&folder, "mine/vessel.toml", "prior = 23.3", "prior = 23.3, bounds = [-80.0, -75.0]");
    run(&folder, DICTIONARY).succeeds();
    run(&folder, PLAN).succeeds();
    let check = &json(&folder, "plan.json")["data"]["voyage"]["check"];
    assert_eq!(check["errors_from"], Value::Null);
    for who in ["nearest", "farthest"] {
        let numbers = &check["worst"][who]["numbers"];
        assert!((-80.0..=-75.0).contains(&numbers["X_u"].as_f64().unwrap()), "{numbers}");
        assert!((numbers["Y_v"].as_f64().unwrap() / -162.0 - 1.0).abs() < 0.2 + 1e-9, "{numbers}");
    }
}

#[test]
fn what_does_not_fit_a_ship_with_forces_is_refused_by_name() {
    let changed = |file: &str, from: &str, to: &str| {
        let folder = otter();
        edit(&folder, file, from, to);
        folder
    };
    let text = String::from_utf8(bytes(&otter(), "mine/plan.toml")).unwrap();
    let (_, rest) = text.split_once("[measurement]").unwrap();
    let (table, _) = rest.split_once("[approach]").unwrap();
    let folder = changed("mine/plan.toml", &format!("[measurement]{table}"), "");
    refused(&folder, 3, PLAN, &["plan.toml", "[measurement]", "none", "`std_u_m_s`", "campaign.toml"]);
    let folder = changed("mine/plan.toml", "std_v_m_s = 0.03", "std_v_m_s = 0.0");
    refused(&folder, 3, PLAN, &["plan.toml", "`measurement.std_v_m_s`", "above 0"]);
    let folder = changed("mine/vessel.toml", ", prior = 48.8", "");
    run(&folder, DICTIONARY).succeeds();
    refused(&folder, 3, PLAN, &["vessel.toml", "parameter `Y_v`", "no prior", "parameter_error"]);
    let folder = small();
    let text = String::from_utf8(bytes(&folder, "plan.toml")).unwrap();
    put(&folder, "plan.toml", &format!("{text}\n[measurement]{table}"));
    let words = ["plan.toml", "[measurement]", "a vessel with terms per sample", "leave it out"];
    refused(&folder, 3, crate::planned::PLAN, &words);
}

#[test]
fn a_number_off_a_nominal_0_is_named_by_its_value() {
    let folder = otter();
    edit(
        &folder,
        "mine/vessel.toml",
        "sway = [",
        "sway = [\n  { parameter = \"Y_0\", term = \"U^2\", nominal = 0.0, prior = 900.0 },",
    );
    run(&folder, DICTIONARY).succeeds();
    refused(&folder, 3, PLAN, &["plan.toml", "`safety.standard_errors`", "Y_0 = ", "cannot be steered"]);
}

#[test]
fn a_ship_with_a_rudder_alone_is_refused_by_what_she_lacks() {
    let folder = otter();
    std::fs::remove_dir_all(folder.path().join("mine")).unwrap();
    let text = bytes(&otter(), "mine/plan.toml");
    run(&folder, "new mine --vessel mariner").succeeds();
    std::fs::write(folder.path().join("mine/plan.toml"), text).unwrap();
    edit(&folder, "mine/plan.toml", "length_m = 2.0", "length_m = 160.93");
    run(&folder, DICTIONARY).succeeds();
    refused(&folder, 3, PLAN, &["plan.toml", "inputs", "1 independent", "2 for surge and yaw"]);
}
