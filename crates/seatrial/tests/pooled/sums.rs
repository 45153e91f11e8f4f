use serde_json::Value;

use crate::POOL;
use crate::support::*;

const MERGE: &str = "estimate pool --vessel vessel.toml";

/// The parameters of trust.json.
fn parameters(folder: &tempfile::TempDir) -> Vec<Value> {
    let trust = json(folder, "trust.json");
    let degrees = trust["data"]["degrees"].as_array().unwrap().clone();
    degrees.iter().flat_map(|d| d["parameters"].as_array().unwrap().clone()).collect()
}

#[test]
fn law_sums_of_parts_of_the_runs_give_the_estimate_of_all_in_any_order() {
    let folder = with(&["campaign.parquet", "design.json"]);
    let line = CAMPAIGN.replace("--out campaign.parquet", "");
    for k in 1..=2 {
        run(&folder, &format!("{line} --shard {k}/2 --out campaign-{k}.parquet")).succeeds();
        let sums = format!("{MERGE} --trajectories campaign-{k}.parquet --sums-only --out sums-{k}.json");
        run(&folder, &sums).succeeds();
    }
    run(&folder, &format!("{POOL} --runs random/0,random/1 --sums-only --out few.json")).succeeds();
    run(&folder, &format!("{POOL} --leave-out random/0,random/1 --sums-only --out rest.json")).succeeds();
    run(&folder, &format!("{POOL} --out estimates.parquet")).succeeds();
    let all = parameters(&folder);
    let merged = |files: &str| {
        let said = run(&folder, &format!("{MERGE} --sums {files} --out estimates.parquet")).succeeds();
        assert!(said.stdout.contains(&format!(" of {} runs", 2 * RUNS)), "{said}");
        ["estimates.parquet", "estimate.json", "trust.json", "model.json"].map(|name| bytes(&folder, name))
    };
    assert!(merged("few.json,rest.json") == merged("rest.json,few.json"));
    let dealt = ["trust.json", "estimate.json", "model.json"].map(|name| json(&folder, name)["data"].clone());
    assert!(merged("sums-1.json,sums-2.json") == merged("sums-2.json,sums-1.json"));
    let sharded =
        ["trust.json", "estimate.json", "model.json"].map(|name| json(&folder, name)["data"].clone());
    assert_eq!(dealt, sharded);
    for (one, merged) in all.iter().zip(parameters(&folder)) {
        let [a, b] = [one, &merged].map(|p| p["estimate"].as_f64().unwrap());
        assert!((a - b).abs() < 1e-9 * a.abs(), "{one} {merged}");
        assert!(merged["standard_error"].as_f64().unwrap() > 0.0 && merged["bootstrap_std"].is_null());
    }
    let said = dealt[0]["statements"][0].as_str().unwrap();
    assert!(said.starts_with("from sums alone: standard errors are those of white residuals"), "{said}");
    // What it delivers is a model like any other.
    let line = "simulate dictionary --model model.json --dictionary dictionary.toml --out dictionary.parquet";
    run(&folder, line).succeeds();
}

#[test]
fn sums_that_do_not_belong_together_are_refused() {
    let folder = with(&["campaign.parquet"]);
    let made = |flags: &str, out: &str| {
        run(&folder, &format!("{POOL} {flags} --sums-only --out {out}")).succeeds();
    };
    made("--runs random/0,random/1", "a.json");
    made("--runs random/2,random/1", "twice.json");
    made("--runs random/2 --estimator ls", "ls.json");
    made("--runs random/2 --part-s 25", "parts.json");
    made("--runs random/2 --mean-removal none", "none.json");
    run(&folder, &format!("{POOL} --runs random/5 --out estimates.parquet")).succeeds();
    made("--runs random/2 --nominal estimate.json", "nominal.json");
    for (files, said) in [
        ("a.json,a.json", ["`runs`", "found run number"]),
        ("a.json,twice.json", ["`runs`", "name each run's sums once"]),
        ("a.json,ls.json", ["`estimator`: found ", "made alike"]),
        ("a.json,parts.json", ["`part_s`: found ", "made alike"]),
        ("a.json,none.json", ["`mean_removal`: found ", "made alike"]),
        ("a.json,nominal.json", ["`nominal`: found ", "made alike"]),
        ("ls.json", ["ls.json: settings: found ls, expected iv", "ask for what"]),
        ("estimate.json", ["estimate.json", "sums"]),
    ] {
        refused(&folder, 3, &format!("{MERGE} --sums {files} --out x.parquet"), &said);
    }
    let other = std::fs::read_to_string(repository().join("pipelines/paper/vessel.toml")).unwrap();
    put(&folder, "vessel.toml", &other);
    refused(&folder, 3, &format!("{MERGE} --sums a.json --out x.parquet"), &["a.json", "vessel"]);
    for (flags, said) in [
        ("--estimator refined-iv --sums-only", "--estimator: found refined-iv, expected ls or iv"),
        ("--mean-removal batch --sums-only", "--mean-removal: found batch"),
        ("--nominal least-squares --sums-only", "--nominal: found least-squares, expected given"),
        ("--bootstrap 9 --sums-only", "--bootstrap"),
        ("--sums a.json", "--sums"),
    ] {
        refused(&folder, 2, &format!("{POOL} {flags} --out x.json"), &[said]);
    }
}
