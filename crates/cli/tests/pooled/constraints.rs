//! Parameters that are fixed, tied or bounded, and the constant as a term, through the binaries.

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::search::measured;
use crate::support::*;
use crate::{CROSS, POOL, candidates};

const PRESET: &str = include_str!("../../../ship/presets/ljungberg-model-ship.toml");
/// A few runs, scored with a vessel that they were not simulated with.
const FEW: &str = "--runs random/0,random/1,optimized/2 --allow=mixed";

/// Writes the preset that vessel.toml names, the lines after `term` of each parameter replaced.
fn written(folder: &TempDir, changes: &[(&str, &str)], more: &str) {
    let mut text = PRESET.to_owned();
    for (parameter, lines) in changes {
        let start = text.find(&format!("parameter = \"{parameter}\"")).unwrap();
        let start = start + text[start..].find("value =").unwrap();
        let end = text[start..].find("\n\n").map_or(text.len(), |end| start + end);
        text.replace_range(start..end, lines);
    }
    put(folder, "vessel.toml", &format!("{text}\n{more}"));
}

const CONSTRAINED: [(&str, &str); 3] = [
    ("X_uu", "value = -0.01\nfixed = true"),
    ("Y_ur", "tied_to = \"Y_v\"\nfactor = 0.06"),
    ("N_uv", "value = -0.03\nnominal = 0.0\nbounds = [0.0, inf]"),
];
const CONSTANT: &str = "[[sway]]\nparameter = \"Y_0\"\nterm = \"1\"\nvalue = 0.0\nnominal = 0.0\n";

fn parameter(model: &Value, name: &str) -> Value {
    let degrees = model["data"]["degrees"].as_array().unwrap();
    let all = || degrees.iter().flat_map(|degree| degree["parameters"].as_array().unwrap());
    all().find(|p| p["name"] == name).unwrap_or_else(|| panic!("{name}")).clone()
}

#[test]
fn a_model_carries_what_was_fixed_tied_and_at_a_bound_and_the_next_estimate_starts_from_it() {
    let folder = with(&["campaign.parquet"]);
    written(&folder, &CONSTRAINED, "");
    run(&folder, &format!("{POOL} {FEW} --estimator output-error --out estimates.parquet")).succeeds();
    let model = json(&folder, "model.json");
    let [fixed, to, tied, bound] = ["X_uu", "Y_v", "Y_ur", "N_uv"].map(|name| parameter(&model, name));
    assert_eq!(
        (&fixed["value"], &fixed["fixed"], &fixed["standard_error"]),
        (&json!(-0.01), &json!(true), &Value::Null)
    );
    assert_eq!((&tied["tied_to"], &tied["factor"]), (&json!("Y_v"), &json!(0.06)));
    for number in ["value", "standard_error", "least_squares"] {
        assert_eq!(
            tied[number].as_f64().unwrap().abs(),
            (0.06 * to[number].as_f64().unwrap()).abs(),
            "{number}"
        );
    }
    assert_eq!(
        (&bound["value"], &bound["at_bound"], &bound["bounds"]),
        (&json!(0.0), &json!(true), &json!([0.0, null]))
    );
    assert!(bound["standard_error"].is_null());
    let trust = json(&folder, "estimate.json");
    let told = trust["data"]["constrained"].as_array().unwrap();
    assert_eq!(told.iter().map(|p| p["name"].as_str().unwrap()).collect::<Vec<_>>(), ["X_uu", "Y_ur"]);
    assert_eq!((&told[1]["estimate"], &told[1]["standard_error"]), (&tied["value"], &tied["standard_error"]));
    assert!(trust["data"]["trust"]["statements"].to_string().contains("yaw: held at a bound"), "{trust}");
    assert_eq!(trust["data"]["trust"]["constrained"], trust["data"]["constrained"]);
    // From the model on: the same structure, the same constraints.
    std::fs::create_dir(folder.path().join("again")).unwrap();
    let again =
        format!("{POOL} {FEW} --estimator output-error --out again/").replace("vessel.toml", "model.json");
    run(&folder, &again).succeeds();
    let again = json(&folder, "again/model.json");
    for name in ["X_uu", "Y_ur", "N_uv"] {
        for key in ["fixed", "tied_to", "factor", "bounds", "at_bound"] {
            assert_eq!(parameter(&again, name)[key], parameter(&model, name)[key], "{name} {key}");
        }
    }
    run(
        &folder,
        "simulate dictionary --model model.json --dictionary dictionary.toml --allow=beyond-range --out d.parquet",
    )
    .succeeds();
    run(&folder, "moments --model model.json --trajectories d.parquet --out moments.json").succeeds();
    let regressors = json(&folder, "moments.json")["data"]["degrees"].to_string();
    assert!(!regressors.contains("X_uu") && !regressors.contains("Y_ur"), "{regressors}");
}

#[test]
fn runs_one_by_one_and_cross_validation_keep_to_the_constraints() {
    let folder = with(&["campaign.parquet"]);
    written(&folder, &CONSTRAINED, "");
    run(&folder, &format!("{ESTIMATE} --allow=mixed")).succeeds();
    let estimate = json(&folder, "estimate.json");
    for design in estimate["data"]["designs"].as_array().unwrap() {
        let parameters = design["parameters"].as_array().unwrap();
        assert_eq!(parameters.len(), 8);
        let bound = parameters.iter().find(|p| p["name"] == "N_uv").unwrap();
        let (at, runs) = (bound["at_bound"].as_u64().unwrap(), design["runs"].as_u64().unwrap());
        assert!(2 * at > runs && at <= runs && bound["mean"].as_f64().unwrap() >= 0.0, "{bound}");
        assert!(parameters.iter().all(|p| p["name"] == "N_uv" || p.get("at_bound").is_none()));
    }
    assert_eq!(estimate["data"]["constrained"][0]["estimate"], -0.01);
    run(&folder, &format!("{CROSS} --allow=mixed --out scores.json")).succeeds();
}

#[test]
fn the_constant_is_estimated_as_the_intercept_that_it_is() {
    let folder = with(&["campaign.parquet"]);
    for estimator in ["ls", "iv", "output-error"] {
        let line = format!("{POOL} {FEW} --estimator {estimator} --out estimates.parquet");
        written(&folder, &[], "");
        run(&folder, &line).succeeds();
        let expected = json(&folder, "model.json")["data"]["degrees"][1]["constant"].as_f64().unwrap();
        written(&folder, &[], CONSTANT);
        run(&folder, &line).succeeds();
        let model = json(&folder, "model.json");
        let (found, constant) = (parameter(&model, "Y_0"), &model["data"]["degrees"][1]["constant"]);
        let value = found["value"].as_f64().unwrap();
        assert!((value - expected).abs() < 1e-3 * expected.abs() + 1e-9, "{estimator} {value} {expected}");
        assert!(
            *constant == 0.0 && found["unit"] == "m/s" && found["standard_error"].as_f64().unwrap() > 0.0
        );
    }
    refused(
        &folder,
        3,
        &format!("{ESTIMATE} --allow=mixed --mean-removal batch"),
        &["`Y_0`", "every segment"],
    );
    refused(
        &folder,
        3,
        &format!("{POOL} {FEW} --mean-removal batch --out e.parquet"),
        &["`Y_0`", "--mean-removal complete"],
    );
    run(&folder, DICTIONARY).succeeds();
    refused(&folder, 3, MOMENTS, &["`Y_0`", "no design makes it better known", "`fixed = true`"]);
    written(&folder, &[], &CONSTANT.replace("value = 0.0\nnominal = 0.0", "value = 0.001\nfixed = true"));
    run(&folder, DICTIONARY).succeeds();
    run(&folder, MOMENTS).succeeds();
}

#[test]
fn constraints_that_cannot_be_are_refused() {
    let folder = with(&["campaign.parquet"]);
    let line = format!("{POOL} {FEW} --out estimates.parquet");
    for (parameter, lines, told) in [
        ("Y_ur", "tied_to = \"Y_vv\"", ["`Y_ur`", "did you mean `Y_v`?"]),
        ("Y_ur", "tied_to = \"N_r\"", ["`N_r`", "another degree of freedom"]),
        ("Y_ur", "tied_to = \"Y_ur\"", ["`Y_ur`", "tied to itself"]),
        ("N_uv", "nominal = 0.0\nbounds = [1.0, -1.0]", ["`N_uv`", "[1, -1]"]),
        ("N_uv", "nominal = 0.0\nbounds = [1.0, 2.0]", ["`nominal` 0", "exclude"]),
        ("N_uv", "value = 0.0\nfixed = true\nbounds = [1.0, 2.0]", ["its value 0", "exclude"]),
        ("N_uv", "fixed = true", ["`fixed` without a value", "add it"]),
        ("N_uv", "nominal = 0.0\nfixt = true", ["`fixt`", "fixed"]),
    ] {
        written(&folder, &[(parameter, lines)], "");
        refused(&folder, 3, &line, &[&["vessel.toml"], &told[..]].concat());
    }
    written(&folder, &[("Y_v", "tied_to = \"Y_ur\""), ("Y_ur", "tied_to = \"Y_v\"")], "");
    refused(&folder, 3, &line, &["`Y_v`", "in a circle"]);
    let fixed = |name| (name, "value = -0.1\nfixed = true");
    written(&folder, &["Y_v", "Y_ur", "Y_tau"].map(fixed), "");
    refused(&folder, 3, &line, &["[[sway]]", "every parameter fixed"]);
    let away = |name| (name, "nominal = 5.0\nbounds = [4.0, 6.0]");
    written(&folder, &["Y_v", "Y_ur", "Y_tau"].map(away), "");
    refused(
        &folder,
        4,
        &format!("{line} --estimator ls"),
        &["campaign.parquet", "sway", "`Y_v` between 4 and 6", "widen"],
    );
    written(&folder, &CONSTRAINED, "");
    refused(&folder, 3, &format!("{line} --prior 0.1"), &["`N_uv`", "`bounds` beside a prior"]);
}

const SEARCHED: &str = "estimate --structure library --vessel vessel.toml --trajectories campaign.parquet --fitted-window-s 20 \
     --window-s 25 --folds 3 --runs random/0,random/1,optimized/0 --allow=mixed --out estimate.json";
const TERMS: &str = "surge = [\"u |u|\", \"1\"]\nsway = [\"v |v|\", \"u r\"]\nyaw = [\"r |r|\"]\n";

/// Mean fit of the base structure over the recordings that were left out.
fn of_base(folder: &TempDir) -> f64 {
    let base = json(folder, "estimate.json")["data"]["search"]["nested"]["base"].clone();
    ["fit_u", "fit_v", "fit_r"].map(|fit| base[fit].as_f64().unwrap()).iter().sum::<f64>() / 3.0
}

#[test]
fn a_search_keeps_what_is_fixed_tied_and_bounded_to_the_bit() {
    let folder = with(&["campaign.parquet"]);
    written(&folder, &CONSTRAINED, CONSTANT);
    candidates(&folder, TERMS);
    for structure in ["library", "few"] {
        let said = run(&folder, &SEARCHED.replace("library", structure)).succeeds();
        assert!(said.stdout.contains("held at a bound: `N_uv`"), "{said}");
        let model = json(&folder, "model.json");
        let [fixed, to, tied, bound] = ["X_uu", "Y_v", "Y_ur", "N_uv"].map(|name| parameter(&model, name));
        assert_eq!((&fixed["value"], &fixed["fixed"]), (&json!(-0.01), &json!(true)));
        assert_eq!(tied["value"].as_f64().unwrap(), 0.06 * to["value"].as_f64().unwrap());
        assert_eq!((&bound["value"], &bound["at_bound"]), (&json!(0.0), &json!(true)));
        assert_eq!((&bound["bounds"], &bound["standard_error"]), (&json!([0.0, null]), &Value::Null));
        // Neither a ridge nor few terms give valid standard errors.
        assert!(to["standard_error"].is_null() && model["data"]["covariance"].is_null(), "{to}");
        let terms = |d: usize| model["data"]["degrees"][d]["parameters"].as_array().unwrap().clone();
        let count = |d: usize, term: &str| terms(d).iter().filter(|p| p["term"] == term).count();
        assert_eq!([count(0, "u |u|"), count(1, "u r"), count(1, "1")], [1; 3]);
        run(&folder, "simulate dictionary --model model.json --dictionary dictionary.toml --allow=beyond-range --out d.parquet")
            .succeeds();
    }
}

#[test]
fn every_fold_of_a_search_keeps_to_a_bound() {
    let folder = measured("0.01");
    let fit = |lines: &str| {
        written(&folder, &[("N_r", lines)], "");
        candidates(&folder, TERMS);
        run(&folder, SEARCHED).succeeds();
        of_base(&folder)
    };
    // If the parameter is at its bound in all folds, the base structure is as good as with it fixed there.
    let (bounded, fixed) = (fit("nominal = -0.5\nbounds = [-inf, -0.5]"), fit("value = -0.5\nfixed = true"));
    assert!((bounded - fixed).abs() < 0.01, "{bounded} {fixed}");
    let free = fit("nominal = -0.5");
    assert!((bounded - free).abs() > 0.1, "{bounded} {free}");
}

#[test]
fn law_bounds_that_hold_nothing_change_nothing() {
    let folder = with(&["campaign.parquet"]);
    let values = |bounds: &str| {
        written(&folder, &[("N_uv", &format!("value = -0.03\nnominal = 0.0{bounds}"))], "");
        candidates(&folder, TERMS);
        run(&folder, SEARCHED).succeeds();
        let data = json(&folder, "estimate.json")["data"]["search"].clone();
        (data["terms"].clone(), data["candidates"].clone(), data["nested"].clone())
    };
    let free = values("");
    assert_eq!(free, values("\nbounds = [-50.0, 50.0]"));
}
