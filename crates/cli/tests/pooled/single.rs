//! The model of a single run: delivered for the only run that is estimated.

use serde_json::Value;

use crate::support::*;

const ONE: &str =
    "estimate --vessel vessel.toml --trajectories campaign.parquet --runs optimized/3 --out one.parquet";
const OWN: &str = "validate --model one-model.json --trajectories campaign.parquet --runs optimized/3 --out validation.json";

fn numbers(model: &Value, of: &str) -> Vec<f64> {
    let degrees = model["data"]["degrees"].as_array().unwrap();
    let parameters = degrees.iter().flat_map(|degree| degree["parameters"].as_array().unwrap());
    parameters.map(|p| p[of].as_f64().unwrap()).collect()
}

#[track_caller]
fn near(a: &[f64], b: &[f64], what: &str) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() <= 1e-9 * a.abs(), "{what}: {a} {b}");
    }
}

#[test]
fn law_least_squares_of_one_run_delivers_the_model_that_pooling_it_alone_does() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{ONE} --estimator ls")).succeeds();
    let pool = "estimate --structure own --vessel vessel.toml --trajectories campaign.parquet --runs optimized/3 --out pooled.parquet";
    run(&folder, &format!("{pool} --estimator ls")).succeeds();
    let [own, pooled] = ["one-model.json", "pooled-model.json"].map(|name| json(&folder, name));
    near(&numbers(&own, "value"), &numbers(&pooled, "value"), "value");
    near(&numbers(&own, "least_squares"), &numbers(&pooled, "least_squares"), "least squares");
    let degrees = |model: &Value| model["data"]["degrees"].as_array().unwrap().clone();
    for (own, pooled) in degrees(&own).iter().zip(degrees(&pooled)) {
        for key in ["constant", "constant_least_squares", "increment_std", "output_rmse"] {
            near(&[own[key].as_f64().unwrap()], &[pooled[key].as_f64().unwrap()], key);
        }
    }
    assert_eq!(own["data"]["covered"], pooled["data"]["covered"]);
    assert_eq!((&own["data"]["covariance"], &own["data"]["rejected"]), (&Value::Null, &Value::Null));
}

#[test]
fn law_the_delivered_model_has_the_errors_that_the_document_tells_of_it() {
    let folder = with(&["design.json"]);
    edit(&folder, "campaign.toml", &format!("realizations = {RUNS}"), "realizations = 4");
    run(&folder, CAMPAIGN).succeeds();
    for estimator in ["iv", "output-error"] {
        run(&folder, &format!("{ONE} --estimator {estimator}")).succeeds();
        run(&folder, OWN).succeeds();
        let model = json(&folder, "one-model.json");
        let errors = &json(&folder, "validation.json")["data"]["recordings"]["models"][0]["errors"];
        let keys = ["rmse_u", "rmse_v", "rmse_r"];
        for (degree, key) in model["data"]["degrees"].as_array().unwrap().iter().zip(keys) {
            near(&[degree["output_rmse"].as_f64().unwrap()], &[errors[key].as_f64().unwrap()], estimator);
        }
        assert_eq!(model["data"]["estimator"], estimator);
    }
}

#[test]
fn the_only_run_of_a_table_delivers_its_model_and_others_simulate_it() {
    let folder = with(&["validation.parquet"]);
    let line = "estimate --vessel vessel.toml --trajectories validation.parquet --out alone.parquet";
    let said = run(&folder, line).succeeds();
    assert!(said.stdout.contains("a model"), "{said}");
    let line = "simulate validation --model alone-model.json --campaign campaign.toml --out again.parquet";
    run(&folder, line).succeeds();
}

#[test]
fn of_many_runs_those_that_are_named_are_estimated_and_one_alone_is_delivered() {
    let folder = with(&["campaign.parquet"]);
    let estimates = || -> Vec<(String, Option<f64>)> {
        let table = craft::read(&folder.path().join("estimates.parquet"), "estimates");
        let [design, parameter] = [0, 4].map(|index: usize| &table.blocks[0].columns[index]);
        (0..design.len())
            .map(|row| (design.text_at(row).unwrap().to_owned(), parameter.value_at(row)))
            .collect()
    };
    run(&folder, ESTIMATE).succeeds();
    assert!(!folder.path().join("model.json").exists());
    let all = estimates();
    let line = format!("{ESTIMATE} --runs optimized/3");
    run(&folder, &line).succeeds();
    let of_design = all.into_iter().filter(|(design, _)| design == "optimized");
    assert_eq!(estimates(), of_design.skip(3).take(1).collect::<Vec<_>>());
    let model = json(&folder, "model.json");
    assert_eq!(model["data"]["recordings"][0]["source"], "optimized/3");
    assert!(model["data"]["statements"][0].as_str().unwrap().contains("run optimized/3 alone"));
    run(&folder, "validate --model model.json --trajectories campaign.parquet --runs random/2 --out c.json")
        .succeeds();
    refused(
        &folder,
        3,
        &line.replace("ed/3", "ed/333"),
        &["campaign.parquet", "run `optimized/333`", "did you mean"],
    );
    refused(&folder, 2, &format!("{line} --shard 1/2"), &["--runs", "--shard"]);
    // The model of an earlier estimate does not belong to the next, of run 3 of every design.
    run(&folder, &line.replace("optimized/3", "3")).succeeds();
    assert_eq!(estimates().len(), 3);
    assert!(!folder.path().join("model.json").exists());
}

#[test]
fn a_model_that_others_wrote_stays_and_one_that_is_read_is_not_replaced() {
    let folder = with(&["campaign.parquet"]);
    put(&folder, "model.json", "mine");
    run(&folder, ESTIMATE).succeeds();
    assert_eq!(bytes(&folder, "model.json"), b"mine");
    run(&folder, &format!("{ESTIMATE} --runs optimized/3")).succeeds();
    for stage in ["estimate", "estimate --structure own"] {
        let line =
            format!("{stage} --model model.json --trajectories campaign.parquet --out estimates.parquet");
        refused(&folder, 2, &line, &["--out", "model.json", "also an input"]);
    }
}
