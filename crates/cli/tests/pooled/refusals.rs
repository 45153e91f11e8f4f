use crate::support::*;
use crate::{CROSS, POOL, SELECTION};

#[test]
fn flags_of_a_pooled_estimate_need_it() {
    let folder = with(&["campaign.parquet"]);
    for flag in ["--bootstrap 9", "--prior 0.1", "--nominal given"] {
        let name = flag.split(' ').next().unwrap();
        refused(
            &folder,
            2,
            &format!("{ESTIMATE} {flag}"),
            &[name, "an estimate of each run", "--fit together"],
        );
    }
    // Only resamples are drawn in shards.
    refused(
        &folder,
        2,
        &format!("{POOL} --shard 1/2 --out estimates.parquet"),
        &["--shard", "no resamples", "--bootstrap"],
    );
}

#[test]
fn runs_that_there_are_not_are_refused() {
    let folder = with(&["campaign.parquet"]);
    let line = format!("{POOL} --out estimates.parquet");
    refused(&folder, 3, &format!("{line} --runs random/99"), &["run `random/99`", "did you mean `random/9"]);
    refused(&folder, 3, &format!("{line} --runs random/3 --leave-out random/3"), &["none left"]);
}

#[test]
fn numbers_out_of_range_are_refused() {
    let folder = with(&["campaign.parquet", "design.json"]);
    refused(&folder, 2, &format!("{POOL} --prior=-1 --out estimates.parquet"), &["--prior", "-1"]);
    refused(&folder, 2, &format!("{POOL} --part-s 0.001 --out estimates.parquet"), &["--part-s", "0.125"]);
    refused(
        &folder,
        3,
        &format!("{} --out c.json", CROSS.replace("--window-s 25", "--window-s 2500")),
        &["--window-s"],
    );
    refused(
        &folder,
        3,
        &format!("{} --out c.json", CROSS.replace(",random/1,optimized/2,optimized/3", "")),
        &["left out"],
    );
    refused(
        &folder,
        2,
        &format!("{SELECTION} --estimator output-error --out scores.parquet"),
        &["output-error", "possible values: ls, iv, auto"],
    );
}

#[test]
fn a_nominal_file_that_is_none_is_refused() {
    let folder = with(&["campaign.parquet", "estimate.json"]);
    let line = |nominal: &str| format!("{POOL} --runs random/0 --nominal {nominal} --out estimates.parquet");
    refused(&folder, 1, &line("least-sqares"), &["least-sqares", "existing file"]);
    refused(&folder, 3, &line("estimate.json"), &["estimate.json", "data.designs", "3 designs"]);
    run(&folder, &format!("{POOL} --runs random/0,random/1 --out estimates.parquet")).succeeds();
    put(&folder, "vessel.toml", include_str!("../../../../pipelines/kvlcc2/vessel.toml"));
    let mixed = format!("{} --allow=mixed", line("estimate.json"));
    refused(&folder, 3, &mixed, &["estimate.json", "no estimate"]);
    put(&folder, "vessel.toml", "preset = \"ljungberg-model-ship\"\n");
    refused(&folder, 2, &format!("{POOL} --prior=inf --out estimates.parquet"), &["--prior", "inf"]);
}

#[test]
fn a_nominal_model_that_diverges_is_told_with_part_and_sample() {
    let folder = with(&["campaign.parquet"]);
    put(&folder, "vessel.toml", "preset = \"ljungberg-model-ship\"\n[nominal]\nX_u = 2.5\n");
    let pieces = ["of random/0 diverges at sample", "surge", "--part-s", "--estimator ls"];
    refused(&folder, 4, &format!("{POOL} --runs random/0 --allow=mixed --out estimates.parquet"), &pieces);
    run(&folder, &format!("{POOL} --runs random/0 --allow=mixed --estimator auto --out estimates.parquet"))
        .succeeds();
    let said = json(&folder, "estimate.json")["data"]["trust"]["statements"][0].clone();
    assert!(said.as_str().unwrap().contains("diverges"), "{said}");
}

#[test]
fn validate_still_wants_estimates_without_a_subcommand() {
    let folder = with(&["campaign.parquet"]);
    let one = "<--campaign <campaign.toml>|--model <model.json|vessel.toml>|--design <design.json>>";
    refused(&folder, 2, "validate --out scores.parquet", &[one]);
    refused(&folder, 2, "validate", &[one]);
    let line = "validate --trajectories campaign.parquet --out v.json";
    for (flags, says) in [
        ("--model m.json --design d.json --vessel v.toml", ["'--model", "cannot be used with"]),
        ("--campaign c.toml --vessel v.toml --validation v.parquet", ["'--campaign", "cannot be used with"]),
        ("--design d.json", ["not provided", "--vessel"]),
        ("--model m.json --realizations 5", ["'--model", "'--realizations"]),
        ("--vessel v.toml --design d.json --window-s 5", ["'--design", "'--window-s"]),
    ] {
        refused(&folder, 2, &format!("{line} {flags}"), &says);
    }
    for (gone, says) in [("compare", "`validate --model"), ("selection", "`validate --design")] {
        refused(&folder, 2, &format!("validate {gone} --out v.json"), &["it is gone", says]);
    }
    refused(&folder, 2, "estimate --out c.json", &["--vessel", "--trajectories"]);
    let help = run(&folder, "validate --help").succeeds();
    for piece in
        ["Estimates of simulated runs:", "Models on recordings:", "Picks from recordings:", "--validation"]
    {
        assert!(help.stdout.contains(piece), "{help}");
    }
}
