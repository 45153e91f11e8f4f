//! Properties of estimates: bias, mean removal, and runs that are not identifiable.

use serde_json::Value;
use tempfile::TempDir;

use crate::support::*;

/// The summary of design `name` in a document.
fn design<'a>(document: &'a Value, name: &str) -> &'a Value {
    let data = &document["data"];
    let designs = data.get("scored").unwrap_or(data)["designs"].as_array().unwrap();
    designs.iter().find(|d| d["design"] == name).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// The study's estimates and scores, made with `flags`.
fn estimated(flags: &str) -> TempDir {
    let folder = with(&["campaign.parquet", "validation.parquet"]);
    run(&folder, &format!("{ESTIMATE} {flags}")).succeeds();
    run(&folder, VALIDATE).succeeds();
    folder
}

fn median_error(folder: &TempDir, name: &str) -> f64 {
    number(&design(&json(folder, "validation.json"), name)["parameter_error"]["median"])
}

/// Per parameter, the deviation of the mean estimate from the truth in standard errors.
fn bias(folder: &TempDir) -> Vec<f64> {
    let estimate = json(folder, "estimate.json");
    let parameters = design(&estimate, "optimized")["parameters"].as_array().unwrap().clone();
    let off = |p: &Value| {
        let error = number(&p["spread"]) / (RUNS as f64).sqrt();
        (number(&p["mean"]) - number(&p["truth"])).abs() / error
    };
    parameters.iter().map(off).collect()
}

#[test]
fn law_least_squares_is_biased_by_noise_and_instrumental_variables_are_not() {
    let (iv, ls) = (estimated("--estimator iv"), estimated("--estimator ls"));
    let (iv_bias, ls_bias) = (bias(&iv), bias(&ls));
    assert!(iv_bias.iter().all(|b| *b < 5.0), "iv: {iv_bias:?}");
    assert!(ls_bias.iter().filter(|b| **b > 20.0).count() >= 3, "ls: {ls_bias:?}");
    for name in ["optimized", "random"] {
        let (iv, ls) = (median_error(&iv, name), median_error(&ls, name));
        assert!(ls > 3.0 * iv, "{name}: ls {ls}, iv {iv}");
    }
}

#[test]
fn law_removing_the_mean_per_segment_costs_precision() {
    let complete = median_error(&estimated("--mean-removal complete"), "optimized");
    let batch = median_error(&estimated("--mean-removal batch"), "optimized");
    assert!(batch > 1.5 * complete, "batch {batch}, complete {complete}");
}

#[test]
fn the_settings_of_the_estimator_are_written_down() {
    let folder = estimated("--estimator ls --mean-removal batch");
    let estimate = json(&folder, "estimate.json");
    assert_eq!(
        (&estimate["data"]["estimator"], &estimate["data"]["mean_removal"]),
        (&"ls".into(), &"batch".into())
    );
    let table = craft::read(&folder.path().join("estimates.parquet"), "estimates");
    assert_eq!(table.blocks[0].columns[2].text_at(0), Some("ls"));
    assert_eq!(table.provenance.settings["estimator"], "ls");
    assert_eq!(table.provenance.settings["mean_removal"], "batch");
}

/// Undisturbed runs, one per maneuver: those straight ahead have no information about sway and yaw; the others,
/// without noise, give the truth exactly.
#[test]
fn law_runs_straight_ahead_are_not_identifiable_and_rich_ones_without_noise_give_the_truth() {
    let folder = with(&["dictionary.parquet", "validation.parquet"]);
    let names = json(&with(&["design.json"]), "design.json")["data"]["order"].clone();
    run(&folder, &ESTIMATE.replace("campaign.parquet", "dictionary.parquet")).succeeds();
    let table = craft::read(&folder.path().join("estimates.parquet"), "estimates");
    let place = |name: &str| table.schema.columns.iter().position(|c| c.name == name).unwrap();
    let columns = &table.blocks[0].columns;
    let truth =
        [("X_u", -0.06), ("X_vr", 0.08), ("Y_v", -0.1), ("Y_ur", -0.006), ("N_r", -0.35), ("N_tau", 3e-4)];
    for row in 0..11 {
        let name = names[row].as_str().unwrap();
        let status = columns[place("status")].text_at(row).unwrap();
        let straight = ["decelerate", "accelerate"].contains(&name);
        assert_eq!(status, if straight { "not identifiable" } else { "identified" }, "{name}");
        for (parameter, value) in truth {
            let (column, error) = (&columns[place(parameter)], &columns[place(&format!("{parameter}_se"))]);
            assert_eq!(
                (column.is_null(row), error.is_null(row)),
                (straight, straight),
                "{name}: {parameter}"
            );
            if !straight {
                let found = column.as_f64().unwrap()[row];
                assert!((found / value - 1.0).abs() < 1e-3, "{name}: {parameter} = {found}, truth {value}");
            }
        }
    }
    let summary = json(&folder, "estimate.json");
    assert_eq!(design(&summary, "dictionary")["runs"], 11);
    assert_eq!(design(&summary, "dictionary")["identified"], 9);
    run(&folder, VALIDATE).succeeds();
    let scores = json(&folder, "validation.json");
    assert_eq!(design(&scores, "dictionary")["not_identifiable"], 2);
    assert!(number(&design(&scores, "dictionary")["simulation_error"]["median"]) < 1e-6);
}

#[test]
fn every_run_has_its_row_in_order() {
    let folder = with(&["estimates.parquet", "scores.parquet"]);
    for (file, id) in [("estimates.parquet", "estimates"), ("scores.parquet", "scores")] {
        let table = craft::read(&folder.path().join(file), id);
        let rows = table.blocks.iter().flat_map(|block| {
            let (design, run) = (&block.columns[0], block.columns[1].as_i32().unwrap());
            (0..run.len()).map(|row| (design.text_at(row).unwrap().to_owned(), run[row])).collect::<Vec<_>>()
        });
        let expected = ["optimized", "random", "practice"]
            .into_iter()
            .flat_map(|d| (0..RUNS as i32).map(move |r| (d.to_owned(), r)));
        assert_eq!(rows.collect::<Vec<_>>(), expected.collect::<Vec<_>>(), "{file}");
    }
}
