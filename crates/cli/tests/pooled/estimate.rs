use serde_json::Value;

use crate::POOL;
use crate::support::*;

fn degrees(folder: &tempfile::TempDir) -> Vec<Value> {
    json(folder, "estimate.json")["data"]["trust"]["degrees"].as_array().unwrap().clone()
}

/// Name, estimate, standard error of every parameter.
fn parameters(folder: &tempfile::TempDir) -> Vec<(String, f64, f64)> {
    let own = |p: &Value| {
        let number = |key: &str| p[key].as_f64().unwrap();
        (p["name"].as_str().unwrap().to_owned(), number("estimate"), number("standard_error"))
    };
    degrees(folder)
        .iter()
        .flat_map(|d| d["parameters"].as_array().unwrap().iter().map(own).collect::<Vec<_>>())
        .collect()
}

#[test]
fn one_estimate_comes_from_all_runs_and_lies_near_the_truth() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{POOL} --bootstrap 50 --out pooled/estimates.parquet")).refuses(1, &["pooled"]);
    run(&folder, &format!("{POOL} --bootstrap 50 --out estimates.parquet")).succeeds();
    let table = craft::read(&folder.path().join("estimates.parquet"), "estimates");
    assert_eq!((table.blocks.len(), table.blocks[0].columns[1].as_i32().unwrap()), (1, &[0][..]));
    assert_eq!(table.blocks[0].columns[3].text_at(0), Some("identified"));
    let summary = json(&folder, "estimate.json");
    let truth = summary["data"]["designs"][0]["parameters"].as_array().unwrap().clone();
    assert_eq!(summary["data"]["structure"]["chosen"], "own");
    for ((name, estimate, error), truth) in parameters(&folder).iter().zip(&truth) {
        assert_eq!(truth["name"], name.as_str());
        assert_eq!(truth["mean"], *estimate);
        let truth = truth["truth"].as_f64().unwrap();
        let off = (estimate - truth).abs();
        assert!(off < 5.0 * error, "{name}: {off} against {error}");
    }
    let trust = &summary["data"]["trust"];
    assert_eq!(trust["runs"].as_array().unwrap().len(), 3 * RUNS as usize);
    assert_eq!(trust["samples"], 3 * RUNS * 1000);
    assert!(trust["degrees"][0]["parameters"][0]["bootstrap_std"].as_f64().unwrap() > 0.0);
}

#[test]
fn law_leaving_out_is_taking_the_others() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{POOL} --runs random/0,random/1 --out a/")).refuses(1, &["a"]);
    std::fs::create_dir(folder.path().join("a")).unwrap();
    let few = "--runs random/0,random/1,random/2";
    run(&folder, &format!("{POOL} {few} --leave-out random/1 --out estimates.parquet")).succeeds();
    let left = parameters(&folder);
    run(&folder, &format!("{POOL} --runs random/0,random/2 --out estimates.parquet")).succeeds();
    assert_eq!(left, parameters(&folder));
}

#[test]
fn a_previous_estimate_is_a_nominal_model_and_a_strong_prior_holds_to_it() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{POOL} --runs random/0,random/1 --out estimates.parquet")).succeeds();
    let first = parameters(&folder);
    std::fs::rename(folder.path().join("estimate.json"), folder.path().join("first.json")).unwrap();
    let pulled = format!("{POOL} --runs random/5 --nominal first.json --prior 1e6 --out estimates.parquet");
    run(&folder, &pulled).succeeds();
    for ((_, a, _), (name, b, _)) in first.iter().zip(parameters(&folder)) {
        assert!((a - b).abs() < 1e-6 * a.abs(), "{name}: {a} {b}");
    }
    run(&folder, &format!("{POOL} --nominal campaign.parquet --out estimates.parquet"))
        .refuses(3, &["campaign.parquet"]);
}

#[test]
fn results_do_not_depend_on_threads() {
    let folder = crate::picking();
    for line in [
        format!(
            "{POOL} --runs random/0,random/1 --estimator output-error --nominal least-squares --bootstrap 20 --out estimates.parquet"
        ),
        format!("{} --estimator ls,auto --out scores.json", crate::CROSS),
        format!("{} --out scores.parquet", crate::SELECTION),
    ] {
        let made = |threads: u32| {
            run(&folder, &format!("{line} --threads {threads}")).succeeds();
            let files =
                ["estimates.parquet", "estimate.json", "scores.json", "scores.parquet", "validation.json"];
            files.map(|name| std::fs::read(folder.path().join(name)).ok())
        };
        assert!(made(1) == made(3), "{line}");
    }
}

#[test]
fn law_resamples_in_shards_give_the_bytes_of_the_whole() {
    let folder = with(&["campaign.parquet"]);
    let few = "--runs random/0,random/1 --part-s 25 --bootstrap 12 --seed 3";
    for (flags, shards) in [("iv", 3), ("output-error --nominal least-squares", 2)] {
        let line = format!("{POOL} {few} --estimator {flags}");
        let all = || ["estimates.parquet", "estimate.json", "model.json"].map(|name| bytes(&folder, name));
        run(&folder, &format!("{line} --threads 1 --out estimates.parquet")).succeeds();
        let whole = all();
        for k in 1..=shards {
            run(&folder, &format!("{line} --shard {k}/{shards} --threads 2 --out part-{k}.parquet"))
                .succeeds();
        }
        let parts: Vec<String> = (1..=shards).rev().map(|k| format!("part-{k}.parquet")).collect();
        run(&folder, &format!("{line} --gather {} --out estimates.parquet", parts.join(" "))).succeeds();
        assert!(all() == whole, "{flags}");
    }
    let table = craft::read(&folder.path().join("part-1.parquet"), "resamples");
    let numbers: Vec<i32> =
        table.blocks.iter().flat_map(|block| block.columns[0].as_i32().unwrap().to_vec()).collect();
    assert_eq!(numbers, (0..8).collect::<Vec<i32>>());
}

#[test]
fn resamples_that_are_not_those_asked_for_are_refused() {
    let folder = with(&["campaign.parquet", "dictionary.parquet"]);
    let line = format!("{POOL} --estimator ls --runs random/0,random/1 --part-s 25");
    for k in 1..=2 {
        run(&folder, &format!("{line} --bootstrap 20 --shard {k}/2 --out part-{k}.parquet")).succeeds();
    }
    let both = "--gather part-1.parquet part-2.parquet --out estimates.parquet";
    for (line, said) in [
        (
            format!("{line} --bootstrap 20 --gather part-2.parquet --out estimates.parquet"),
            vec!["part-2.parquet: shards: found no shard 1/2", "write the missing shards"],
        ),
        (
            format!(
                "{line} --bootstrap 20 --gather part-1.parquet part-2.parquet part-1.parquet --out estimates.parquet"
            ),
            vec!["shards: found shard 1/2 in part-1.parquet and in part-1.parquet"],
        ),
        (format!("{line} --bootstrap 21 {both}"), vec!["part-1.parquet", "`bootstrap`", "found 20", "21"]),
        (format!("{line} --bootstrap 20 --seed 5 {both}"), vec!["part-1.parquet", "`seed`", "found 1", "5"]),
        // A setting that is only noted if given.
        (
            format!("{POOL} --estimator ls --bootstrap 20 --part-s 25 {both}"),
            vec!["part-1.parquet: settings.runs: found [\"random/0,random/1\"], expected nothing"],
        ),
        (
            format!("{line} --bootstrap 20 {both}")
                .replace("campaign.parquet", "dictionary.parquet")
                .replace("--runs random/0,random/1", ""),
            vec!["dictionary.parquet: provenance: found another trajectories than that of part-1.parquet"],
        ),
        (
            format!("{POOL} --gather campaign.parquet --bootstrap 20 --out x.parquet"),
            vec!["campaign.parquet"],
        ),
        (
            "estimate --structure own --vessel vessel.toml --trajectories part-1.parquet --out x.parquet"
                .to_owned(),
            vec!["part-1.parquet", "found resamples"],
        ),
    ] {
        refused(&folder, 3, &line, &said);
    }
    refused(&folder, 2, &format!("{line} --shard 1/2 --out x.parquet"), &["--bootstrap"]);
    refused(&folder, 2, &format!("{line} {both}"), &["--bootstrap"]);
}

/// In 8 MiB runs of 2 MB are not held in memory: each pass reads them again.
#[test]
fn runs_that_are_read_again_give_the_same_bytes() {
    let folder = with(&["campaign.parquet"]);
    let path = folder.path().join("campaign.parquet");
    craft::read(&path, "trajectories").in_blocks_of(3 * 1001).write(&path);
    for flags in ["iv --mean-removal batch", "iv --nominal least-squares --part-s 20 --bootstrap 2"] {
        let made = |memory: &str| {
            let line = format!("{POOL} --allow=mixed --estimator {flags} {memory} --out estimates.parquet");
            run(&folder, &line).succeeds();
            ["estimates.parquet", "estimate.json"]
                .map(|name| std::fs::read(folder.path().join(name)).unwrap())
        };
        assert!(made("--threads 1") == made("--memory-mib 8 --threads 2"), "{flags}");
    }
}

#[test]
fn estimates_that_do_not_fit_into_memory_are_refused_before_the_work() {
    let folder = with(&["campaign.parquet"]);
    let path = folder.path().join("campaign.parquet");
    let mut campaign = craft::read(&path, "trajectories").in_blocks_of(1001);
    campaign.blocks.truncate(2 * RUNS as usize);
    campaign.write(&path);
    let tiny = "--part-s 0.125 --allow=mixed --memory-mib 12 --threads 1";
    for (line, amount) in [
        (format!("{POOL} --bootstrap 9"), "48 runs of 48000 samples in all"),
        (crate::CROSS.to_owned(), "4 runs of 4000 samples in all"),
    ] {
        let said = [&format!("campaign.parquet: rows: found {amount}"), "fits the 12 MiB of --memory-mib"];
        refused(&folder, 3, &format!("{line} {tiny} --out out"), &said);
    }
}

/// A duplicate term in surge cannot be distinguished from itself; the dictionary's first two maneuvers go straight
/// ahead.
#[test]
fn what_is_not_excited_is_not_answered_and_the_rest_is() {
    let folder = with(&["dictionary.parquet", "campaign.parquet"]);
    let line = "estimate --structure own --vessel vessel.toml --trajectories dictionary.parquet --out estimates.parquet";
    refused(&folder, 4, &format!("{line} --runs 0,1"), &["`X_vr` is not excited", "sway", "yaw", "--prior"]);
    let vessel = std::fs::read_to_string(repository().join("pipelines/paper/vessel.toml")).unwrap();
    let twice = "\n[[surge]]\nparameter = \"X_again\"\nterm = \"u |u|\"\nnominal = -0.01\n";
    put(&folder, "vessel.toml", &(vessel + twice));
    let said =
        run(&folder, &format!("{POOL} --runs random/0,random/1 --allow=mixed --out estimates.parquet"))
            .succeeds();
    assert!(said.stdout.contains("not identifiable: surge: "), "{said}");
    let status: Vec<Value> = degrees(&folder).iter().map(|d| d["status"].clone()).collect();
    assert_eq!(status, ["not identifiable", "identified", "identified"]);
    let table = craft::read(&folder.path().join("estimates.parquet"), "estimates");
    assert_eq!(table.blocks[0].columns[3].text_at(0), Some("not identifiable"));
    let summary = json(&folder, "estimate.json");
    let parameters = summary["data"]["designs"][0]["parameters"].as_array().unwrap();
    assert!(parameters[0]["mean"].is_null() && parameters.last().unwrap()["mean"].is_f64());
}
