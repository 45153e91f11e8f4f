//! `model.json`: the delivered model is the validated one, and every stage accepts it as a vessel.

use std::sync::OnceLock;

use serde_json::Value;
use tempfile::TempDir;

use crate::search::unsealed;
use crate::support::*;
use crate::{CROSS, POOL};

const MODEL: &str = "estimate --structure own --vessel vessel.toml --trajectories campaign.parquet \
     --runs random/1,optimized/2,optimized/3 --out estimates.parquet";
const COMPARE: &str = "validate --model model.json --trajectories campaign.parquet --runs random/0 --window-s 25 \
     --out validation.json";

/// The small study's campaign with a model of three runs.
fn modelled() -> TempDir {
    static MODELLED: OnceLock<Study> = OnceLock::new();
    let study = MODELLED.get_or_init(|| {
        let folder = with(&["campaign.parquet"]);
        run(&folder, MODEL).succeeds();
        Study::of(&folder)
    });
    study.with(&["campaign.parquet", "estimates.parquet", "estimate.json", "model.json"])
}

/// The values of a model with `change` made to each, its seal taken away.
fn with_values(folder: &TempDir, change: impl Fn(&str, f64) -> f64) {
    let mut model = json(folder, "model.json");
    model["seal"] = Value::Null;
    for degree in model["data"]["degrees"].as_array_mut().unwrap() {
        for parameter in degree["parameters"].as_array_mut().unwrap() {
            let value = change(parameter["name"].as_str().unwrap(), parameter["value"].as_f64().unwrap());
            parameter["value"] = value.into();
        }
    }
    put(folder, "model.json", &serde_json::to_string_pretty(&model).unwrap());
}

#[test]
fn law_the_delivered_model_has_the_fit_that_cross_validation_tells_of_the_same_split() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{CROSS} --out scores.json")).succeeds();
    let crossval = json(&folder, "scores.json");
    for estimator in ["ls", "iv", "output-error"] {
        run(&folder, &format!("{MODEL} --estimator {estimator}")).succeeds();
        run(&folder, COMPARE).succeeds();
        let all = crossval["data"]["left_out"]["estimators"].as_array().unwrap();
        let own = all.iter().find(|e| e["name"] == estimator).unwrap();
        let left_out = own["sources"].as_array().unwrap().iter().find(|s| s["source"] == "random/0").unwrap();
        let compared = json(&folder, "validation.json")["data"]["recordings"].clone();
        let model = &compared["models"][0];
        assert_eq!((&model["name"], &compared["windows"]), (&"model".into(), &5.into()));
        for number in ["fit_u", "fit_v", "fit_r", "rmse_u", "rmse_v", "rmse_r"] {
            let validated = left_out["errors"][number].as_f64().unwrap();
            let delivered = model["recordings"][0]["errors"][number].as_f64().unwrap();
            assert!((validated - delivered).abs() <= 1e-9 * validated.abs(), "{estimator} {number}");
        }
    }
}

#[test]
fn law_least_squares_of_the_document_is_the_model_that_least_squares_delivers() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{MODEL} --estimator ls")).succeeds();
    let simple = json(&folder, "model.json");
    run(&folder, &format!("{MODEL} --estimator output-error")).succeeds();
    let model = json(&folder, "model.json");
    for (simple, model) in
        simple["data"]["degrees"].as_array().unwrap().iter().zip(model["data"]["degrees"].as_array().unwrap())
    {
        assert_eq!(simple["constant"], model["constant_least_squares"]);
        assert_ne!(simple["constant"], model["constant"]);
        let values = |degree: &Value, of: &str| -> Vec<Value> {
            degree["parameters"].as_array().unwrap().iter().map(|p| p[of].clone()).collect()
        };
        assert_eq!(values(simple, "value"), values(model, "least_squares"));
    }
    let names = model["data"]["covariance"]["names"].as_array().unwrap().len();
    assert_eq!(model["data"]["covariance"]["entries"].as_array().unwrap().len(), names * names);
    assert!(model["data"]["covariance"]["joint"].as_bool().unwrap() && names == 10 + 3, "{names}");
}

#[test]
fn a_model_stands_for_a_vessel_in_every_stage() {
    let folder = modelled();
    run(
        &folder,
        "simulate dictionary --model model.json --dictionary dictionary.toml --out dictionary.parquet",
    )
    .succeeds();
    run(&folder, "moments --model model.json --trajectories dictionary.parquet --out moments.json")
        .succeeds();
    run(&folder, "design --moments moments.json --out design.json").succeeds();
    run(&folder, "simulate validation --model model.json --campaign campaign.toml --out v.parquet")
        .succeeds();
    run(&folder, "estimate --model model.json --trajectories v.parquet --estimator ls --out e.parquet")
        .succeeds();
    // Least squares of the same runs finds the same model, for any constant known before.
    let again = |model: &str, out: &str| {
        format!("{} --estimator ls", MODEL.replace("vessel.toml", model).replace("estimates", out))
    };
    run(&folder, &again("vessel.toml", "first")).succeeds();
    run(&folder, &format!("{} --allow=mixed", again("first-model.json", "second"))).succeeds();
    let degrees = |name: &str| json(&folder, name)["data"]["degrees"].as_array().unwrap().clone();
    for (first, second) in degrees("first-model.json").iter().zip(degrees("second-model.json")) {
        let number = |value: &Value| value.as_f64().unwrap();
        let pairs =
            first["parameters"].as_array().unwrap().iter().zip(second["parameters"].as_array().unwrap());
        for (a, b) in pairs.map(|(a, b)| (number(&a["value"]), number(&b["value"]))) {
            assert!((a - b).abs() < 1e-9 * a.abs(), "{a} {b}");
        }
        let (a, b) = (number(&first["constant"]), number(&second["constant"]));
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
}

#[test]
fn a_model_that_is_of_no_use_is_called_so() {
    let folder = modelled();
    let statements = |folder: &TempDir| -> Vec<String> {
        run(folder, COMPARE).succeeds();
        let data = json(folder, "validation.json")["data"]["recordings"].clone();
        data["statements"].as_array().unwrap().iter().map(|s| s.as_str().unwrap().to_owned()).collect()
    };
    assert!(statements(&folder)[0].starts_with("fit u"), "{:?}", statements(&folder));
    with_values(&folder, |name, value| if name.starts_with("N_tau") { 0.0 } else { value });
    assert!(statements(&folder)[0].starts_with("useless in"), "{:?}", statements(&folder));
    with_values(
        &folder,
        |name, value| if name.starts_with("X_u") { -3.0 * value.abs().max(1.0) } else { value },
    );
    let said = statements(&folder);
    assert!(said[0].starts_with("useless: ") && said[0].ends_with("windows diverge"), "{said:?}");
}

#[test]
fn where_a_model_leaves_what_it_was_fitted_on_is_told() {
    let folder = modelled();
    let mut model = json(&folder, "model.json");
    model["seal"] = Value::Null;
    model["data"]["covered"][0]["high"] = 0.9.into();
    model["data"]["covered"][0]["low"] = 0.8.into();
    put(&folder, "narrow.json", &serde_json::to_string_pretty(&model).unwrap());
    run(&folder, &COMPARE.replace("model.json", "narrow.json")).succeeds();
    let data = json(&folder, "validation.json")["data"]["recordings"].clone();
    let outside = data["outside"].as_array().unwrap();
    assert!(outside.iter().any(|o| o["name"] == "u" && o["samples"].as_u64().unwrap() > 0), "{outside:?}");
    let statements = data["statements"].to_string();
    // No trial is designed there unless requested, and then the results say so.
    let simulate = "simulate dictionary --dictionary dictionary.toml --out dictionary.parquet";
    let narrow = format!("{simulate} --vessel narrow.json");
    let pieces =
        ["maneuver `", "0.7980 to 0.9020, about what the logs of the model cover", "--allow=beyond-range"];
    refused(&folder, 3, &narrow, &pieces);
    let leaves = "u leaves the 0.8000 to 0.9000 m/s";
    let said = run(&folder, &format!("{narrow} --allow=beyond-range")).succeeds();
    assert!(said.stdout.contains(leaves), "{said}");
    run(&folder, "moments --model narrow.json --trajectories dictionary.parquet --out narrow-moments.json")
        .succeeds();
    run(&folder, "design --moments narrow-moments.json --out narrow-design.json").succeeds();
    for name in ["narrow-moments.json", "narrow-design.json"] {
        assert!(json(&folder, name)["data"]["beyond"].to_string().contains(leaves), "{name}");
    }
    let said = run(&folder, &format!("{simulate} --vessel vessel.toml")).succeeds();
    assert!(!said.stdout.contains("leaves the"), "{said}");
    run(&folder, REPORT).succeeds();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("The model on other recordings") && page.contains("u leaves the 0.8000 to"));
    assert!(
        statements.contains("u leaves the 0.8000 to 0.9000 m/s that the model was fitted on"),
        "{statements}"
    );
}

#[test]
fn models_and_logs_that_do_not_go_together_are_refused() {
    let folder = modelled();
    put(&folder, "other.toml", include_str!("../../../../pipelines/kvlcc2/vessel.toml"));
    refused(
        &folder,
        3,
        &format!("{COMPARE} --model other.toml"),
        &["other.toml: sampling rate: found 1 Hz, expected 8 Hz", "models of the same logs"],
    );
    let text = std::fs::read_to_string(folder.path().join("model.json")).unwrap();
    let seal = json(&folder, "model.json")["seal"].to_string();
    put(
        &folder,
        "model.json",
        &text.replace(&seal, "null").replace("\"sample_rate_hz\": 8.0", "\"sample_rate_hz\": 4.0"),
    );
    refused(&folder, 3, COMPARE, &["campaign.parquet", "step of 0.125 s", "0.25 s"]);
    put(
        &folder,
        "model.json",
        &text.replace(&seal, "null").replace("\"name\": \"tau3\"", "\"name\": \"tau_x\""),
    );
    refused(&folder, 3, COMPARE, &["model.json", "tau3"]);
    refused(&folder, 3, &COMPARE.replace("--window-s 25", "--window-s 2500"), &["model.json"]);
    put(&folder, "model.json", &text);
    refused(
        &folder,
        3,
        &COMPARE.replace("--window-s 25", "--window-s 2500"),
        &["no run as long as a window"],
    );
    refused(&folder, 3, &COMPARE.replace("random/0", "random/77"), &["run `random/77`"]);
    refused(&folder, 2, &COMPARE.replace("--model model.json", ""), &["--model"]);
}

#[test]
fn the_units_of_a_model_are_those_of_its_numbers() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{POOL} --runs random/0,random/1 --out estimates.parquet")).succeeds();
    let units = json(&folder, "model.json")["units"].clone();
    assert_eq!((&units["constant_u"], &units["value"]), (&"m/s".into(), &"the parameter's unit".into()));
}

#[test]
fn a_model_of_an_earlier_estimate_does_not_stay_beside_one_without() {
    let folder = with(&["campaign.parquet", "dictionary.parquet"]);
    run(&folder, MODEL).succeeds();
    assert!(folder.path().join("model.json").exists());
    let line = "estimate --structure own --vessel vessel.toml --trajectories dictionary.parquet --runs 0,1,2 --out estimates.parquet";
    run(&folder, line).succeeds();
    assert!(!folder.path().join("model.json").exists());
}

#[test]
fn logs_of_another_structure_say_which_channel_is_missing() {
    let folder = modelled();
    let text = std::fs::read_to_string(folder.path().join("model.json")).unwrap();
    let seal = json(&folder, "model.json")["seal"].to_string();
    // A model that needs a channel which the logs lack.
    put(&folder, "model.json", &text.replace(&seal, "null").replace("tau3", "rudder"));
    refused(&folder, 3, COMPARE, &["campaign.parquet", "rudder"]);
    for stage in [
        "moments --model model.json --trajectories campaign.parquet --out moments.json",
        "estimate --model model.json --trajectories campaign.parquet --out e.parquet",
        "estimate --structure own --model model.json --trajectories campaign.parquet --out e.parquet",
        "estimate --folds each --fit together --model model.json --trajectories campaign.parquet --out c.json",
    ] {
        refused(&folder, 3, stage, &["campaign.parquet", "rudder"]);
    }
    // One of another ship.
    put(&folder, "other.toml", include_str!("../../../../pipelines/kvlcc2/vessel.toml"));
    let line = "estimate --structure own --model other.toml --trajectories campaign.parquet --out e.parquet --allow=mixed";
    refused(&folder, 3, line, &["campaign.parquet", "column"]);
    // One of another unit.
    put(
        &folder,
        "model.json",
        &text.replace(&seal, "null").replace("\"unit\": \"N m\"", "\"unit\": \"kN m\""),
    );
    refused(&folder, 3, COMPARE, &["campaign.parquet", "tau3", "kN m"]);
}

#[test]
fn the_page_shows_what_is_left_of_errors_tracks_and_the_delivered_model() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{MODEL} --estimator iv,ls --folds each --window-s 25")).succeeds();
    run(&folder, COMPARE).succeeds();
    let data = json(&folder, "validation.json")["data"]["recordings"].clone();
    let correlations = data["correlations"].as_array().unwrap();
    let of: Vec<(&str, &str)> =
        correlations.iter().map(|c| (c["of"].as_str().unwrap(), c["state"].as_str().unwrap())).collect();
    let kinds = ["one-step residual", "free-run error"];
    assert_eq!(of, kinds.map(|kind| ["u", "v", "r"].map(|state| (kind, state))).concat());
    for own in correlations {
        // Measurement noise enters two increments: law, −1/2 without any other error.
        let first = own["own"][0].as_f64().unwrap();
        match own["of"] == kinds[0] {
            true => assert!((-0.6..-0.3).contains(&first), "{own}"),
            false => assert!(first.abs() < 1.0, "{own}"),
        }
        let samples = data["samples"].as_f64().unwrap();
        assert!((own["bound"].as_f64().unwrap() - 1.959_964 / samples.sqrt()).abs() < 1e-6);
        assert_eq!((own["own"].as_array().unwrap().len(), own["inputs"].as_array().unwrap().len()), (40, 3));
        assert!(
            own["inputs"].as_array().unwrap().iter().all(|i| i["crossed"].as_array().unwrap().len() == 41)
        );
    }
    run(&folder, REPORT).succeeds();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    let panels = drawn(&folder, "report.html");
    let windows = panels[0]["data"]["windows"].as_array().unwrap();
    assert_eq!((&panels[0]["id"], windows.len() as u64), (&"time".into(), data["windows"].as_u64().unwrap()));
    let samples = windows.iter().map(|own| own["simulated"][2].as_array().unwrap().len() as u64);
    // Each window ends with a state beyond its last sample.
    let states = data["samples"].as_u64().unwrap() + windows.len() as u64;
    assert_eq!(samples.sum::<u64>(), states);
    for said in [
        "What is left of the errors",
        "moving averages by construction",
        "Tracks as measured (black)",
        "The delivered model, by iv",
        "No estimator is recommended. This model is by iv",
        "Off by, standard errors",
        "surge constant",
    ] {
        assert!(page.contains(said), "{said}");
    }
    for figure in ["compared-tracks", "residual-correlations", "error-correlations"] {
        assert!(folder.path().join(format!("figures/{figure}.svg")).exists(), "{figure}");
    }
}

#[test]
fn law_estimates_that_correlate_and_are_badly_known_are_told_and_no_others() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{POOL} --runs optimized/0 --estimator output-error --out estimates.parquet"))
        .succeeds();
    let model = json(&folder, "model.json")["data"].clone();
    let numbers = |value: &Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let names = model["covariance"]["names"].as_array().unwrap().clone();
    let (entries, n) = (numbers(&model["covariance"]["entries"]), names.len());
    let degrees = model["degrees"].as_array().unwrap();
    let values: Vec<f64> = degrees
        .iter()
        .flat_map(|degree| {
            let parameters = degree["parameters"].as_array().unwrap().iter().map(|p| &p["value"]);
            parameters.chain([&degree["constant"]]).map(|x| x.as_f64().unwrap()).collect::<Vec<_>>()
        })
        .collect();
    let error = |i: usize| entries[i * n + i].sqrt();
    let unknown = |i: usize| error(i) > 0.05 * values[i].abs();
    let pairs = (0..n).flat_map(|j| (0..j).map(move |i| (i, j)));
    let alike = |(i, j): &(usize, usize)| {
        (entries[i * n + j] / (error(*i) * error(*j))).abs() >= 0.95 && unknown(*i) && unknown(*j)
    };
    let expected = pairs.filter(alike).count();
    let statements = json(&folder, "estimate.json")["data"]["trust"]["statements"].clone();
    let told = |s: &&Value| s.as_str().is_some_and(|s| s.contains("be told apart: correlation"));
    let told = statements.as_array().unwrap().iter().filter(told).count();
    assert!(expected > 0 && told == expected.min(4), "{expected} {told} {statements}");
}

/// Every run in its own current, whose estimates are in the model and on the page.
#[test]
fn unknown_currents_are_told_of_run_by_run() {
    let folder = with(&["campaign.parquet"]);
    let line = format!("{MODEL} --estimator output-error");
    run(&folder, &format!("{line} --unknown-current earth --intercepts none")).succeeds();
    let model = json(&folder, "model.json");
    assert_eq!(model["settings"]["unknown_current"], "earth");
    let around = model["data"]["surroundings"].as_array().unwrap();
    let sources: Vec<&str> = around.iter().map(|own| own["source"].as_str().unwrap()).collect();
    assert_eq!(sources, ["optimized/2", "optimized/3", "random/1"]);
    for own in around {
        let found = own["found"].as_array().unwrap();
        let names: Vec<&str> = found.iter().map(|one| one["name"].as_str().unwrap()).collect();
        assert_eq!(names, ["current along", "current across"]);
        for one in found {
            assert_eq!(one["unit"], "m/s");
            assert!(one["standard_error"].as_f64().unwrap() > 0.0, "{own}");
        }
    }
    assert!(model["data"]["degrees"][0]["constant"] == 0.0, "no intercepts");
    let told = |piece: &str| {
        model["data"]["statements"].as_array().unwrap().iter().any(|s| s.as_str().unwrap().contains(piece))
    };
    assert!(told("a current of its own in every run"), "{}", model["data"]["statements"]);
    refused(
        &folder,
        2,
        &format!("{MODEL} --estimator ls --unknown-current earth"),
        &["--unknown-current earth", "`output-error`"],
    );
}

#[test]
fn drifting_and_body_currents_and_unknown_winds_are_refused_with_what_to_do() {
    let folder = with(&["campaign.parquet"]);
    let drifts = "it is gone: take `--estimator prediction-error`, or `--unknown-current earth`";
    for (flag, pieces) in [
        ("--unknown-current drifting", ["'drifting'", "none, earth]", drifts]),
        ("--unknown-current body", ["'body'", "none, earth]", drifts]),
        ("--unknown-wind earth", ["'--unknown-wind'", "`[[measured]]`", "`--estimator prediction-error`"]),
    ] {
        refused(&folder, 2, &format!("{MODEL} --estimator output-error {flag}"), &pieces);
    }
}

#[test]
fn pooled_predictions_say_what_disturbances_they_found() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{MODEL} --estimator prediction-error")).succeeds();
    let model = json(&folder, "model.json")["data"].clone();
    assert_eq!(
        (&model["estimator"], &model["covariance"]["joint"]),
        (&"prediction-error".into(), &true.into())
    );
    let statements = model["statements"].as_array().unwrap();
    assert!(
        statements.iter().any(|s| s.as_str().unwrap().starts_with("most likely disturbances: noise of")),
        "{statements:?}"
    );
    assert!(model["surroundings"].is_null());
}

/// A plan for the vessels within two standard errors; its charts and maneuvers are read after the covariance.
const PLAN_TOML: &str = r#"cell_m = 120.0
headings = 4

[area]
west_deg = 24.98
south_deg = 59.99
east_deg = 25.02
north_deg = 60.01

[[chart]]
file = "land.geojson"
kind = "land"

[hull]
length_m = 30.0
beam_m = 8.0

[safety]
margin_m = 20.0
standard_errors = 2.0

[[speed_mode]]
name = "half"
speed_m_s = 1.0

[start]
longitude_deg = 24.985
latitude_deg = 60.0
heading_deg = 0.0

[goal]
kind = "home"
"#;

#[test]
fn a_covariance_that_is_not_positive_is_refused_for_a_plan() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{MODEL} --estimator output-error")).succeeds();
    put(&folder, "plan.toml", PLAN_TOML);
    let plan = |vessel: &str| {
        format!(
            "plan --vessel {vessel} --trajectories none.parquet --config plan.toml --allow=beyond-range --out plan.json"
        )
    };
    // Its own covariance is positive: only the maneuvers are missing.
    refused(&folder, 1, &plan("model.json"), &["none.parquet"]);
    let refuses = |change: &dyn Fn(&mut Value), pieces: &[&str]| {
        let mut data = json(&folder, "model.json")["data"].take();
        change(&mut data["covariance"]);
        unsealed(&folder, "model.json", "changed.json", data);
        refused(&folder, 3, &plan("changed.json"), pieces);
    };
    let negative = |covariance: &mut Value| {
        let entry = covariance["entries"][0].as_f64().unwrap();
        covariance["entries"][0] = (-entry).into();
    };
    refuses(&negative, &["changed.json", "`data.covariance`", "X_", "a positive definite matrix"]);
    refuses(
        &|covariance| *covariance = Value::Null,
        &["plan.toml", "`safety.standard_errors`", "which has none"],
    );
    refused(&folder, 3, &plan("vessel.toml"), &["plan.toml", "`safety.standard_errors`", "no model.json"]);
    edit(&folder, "plan.toml", "standard_errors = 2.0", "standard_errors = 2.0\nparameter_error = 0.1");
    refused(&folder, 3, &plan("model.json"), &["plan.toml", "`safety.standard_errors`", "one of both"]);
}
