//! `monte-carlo`: the stages' runs without their files, and counts that merge.

use estimation::{EstimateStatus, RunEstimate, RunScore};
use files::{Column, TableReader};
use study::documents::{CountedRuns, ValidationDocument};
use study::files::read_vessel;
use study::{estimates, scores};
use tempfile::TempDir;

use crate::support::*;

const LINE: &str = "monte-carlo --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml \
                    --design design.json";
const EVERY: &str = "ls,iv,output-error,prediction-error";

fn designed(runs: u64) -> TempDir {
    let folder = written(runs);
    [DICTIONARY, MOMENTS, DESIGN].iter().for_each(|stage| drop(run(&folder, stage).succeeds()));
    folder
}

fn estimated(folder: &TempDir, name: &str) -> Vec<RunEstimate> {
    let vessel = read_vessel(&folder.path().join("vessel.toml"), &mut files::Provenance::default()).unwrap();
    let path = folder.path().join(name);
    let reader = TableReader::open(&path, estimates::ID, estimates::VERSION).unwrap();
    let blocks = (0..reader.blocks()).map(|i| estimates::rows(&reader, &vessel, &path, i).unwrap());
    blocks.collect::<Vec<_>>().concat()
}

fn scored(folder: &TempDir, name: &str) -> Vec<RunScore> {
    scores::rows(&TableReader::open(folder.path().join(name), scores::ID, scores::VERSION).unwrap()).unwrap()
}

/// A value of any kind, to the bit.
fn cell(column: &Column, row: usize) -> (Option<u64>, Option<i32>, Option<String>) {
    let whole = column.as_i32().map(|numbers| numbers[row]);
    (column.value_at(row).map(f64::to_bits), whole, column.text_at(row).map(str::to_owned))
}

fn tally(folder: &TempDir, name: &str) -> CountedRuns {
    document::<ValidationDocument>(folder, name).data.counted.unwrap()
}

#[test]
fn law_runs_in_memory_are_the_runs_of_the_files_by_every_estimator() {
    let folder = designed(12);
    [CAMPAIGN, VALIDATION].iter().for_each(|stage| drop(run(&folder, stage).succeeds()));
    run(&folder, &format!("{ESTIMATE} --estimator {EVERY} --campaign campaign.toml")).succeeds();
    run(&folder, VALIDATE).succeeds();
    std::fs::create_dir(folder.path().join("memory")).unwrap();
    run(&folder, &format!("{LINE} --estimator {EVERY} --keep trajectories --out memory/validation.json"))
        .succeeds();
    // Runs in memory are not asked what the model lacks.
    let mut of_files = estimated(&folder, "estimates.parquet");
    let rejected = of_files.iter_mut().filter(|row| row.status == EstimateStatus::Rejected);
    rejected.for_each(|row| row.status = EstimateStatus::Identified);
    assert!(of_files == estimated(&folder, "memory/estimates.parquet"));
    assert!(scored(&folder, "scores.parquet") == scored(&folder, "memory/scores.parquet"));
    let trajectories = |name: &str| {
        let whole = craft::read(&folder.path().join(name), "trajectories");
        let columns = whole.blocks.iter().flat_map(|block| &block.columns);
        columns.flat_map(|column| (0..column.len()).map(|row| cell(column, row))).collect::<Vec<_>>()
    };
    assert!(trajectories("campaign.parquet") == trajectories("memory/campaign.parquet"));
    let said =
        |name: &str| serde_json::to_value(document::<ValidationDocument>(&folder, name).data.scored).unwrap();
    assert_eq!(said("validation.json"), said("memory/validation.json"));
}

#[test]
fn law_scores_are_the_same_whether_runs_are_kept_or_not() {
    // More runs than are simulated at once, and a few that are left.
    let folder = designed(43);
    for keep in ["scores", "estimates"] {
        std::fs::create_dir(folder.path().join(keep)).unwrap();
        run(&folder, &format!("{LINE} --keep {keep} --out {keep}/validation.json")).succeeds();
    }
    let rows = scored(&folder, "scores/scores.parquet");
    assert_eq!(rows.len(), 129);
    assert!(rows == scored(&folder, "estimates/scores.parquet"));
    let tallies =
        ["scores", "estimates"].map(|keep| tally(&folder, &format!("{keep}/validation.json")).tally);
    assert!(tallies[0] == tallies[1]);
}

#[test]
fn law_a_tally_counts_what_the_scores_say() {
    let folder = designed(20);
    run(&folder, &format!("{LINE} --estimator iv,ls --keep scores --out validation.json")).succeeds();
    let tally = tally(&folder, "validation.json");
    let validation = document::<ValidationDocument>(&folder, "validation.json").data.scored.unwrap();
    let compared = validation.compared.unwrap();
    assert_eq!(tally.scores.len(), 2);
    for (counted, whole) in tally.scores.iter().zip(&compared) {
        assert_eq!(counted.estimator, whole.estimator);
        for (counted, whole) in counted.designs.iter().zip(&whole.designs) {
            let shares = |s: &study::documents::DesignScores| {
                (s.runs, s.parameter_error_share_interval, s.simulation_error_share_interval, s.diverged)
            };
            assert_eq!(shares(counted), shares(whole));
            let quantiles = [
                (counted.parameter_error, whole.parameter_error),
                (counted.simulation_error, whole.simulation_error),
                (counted.rmse_r, whole.rmse_r),
            ];
            for (counted, whole) in quantiles {
                assert_eq!((counted.min, counted.max), (whole.min, whole.max));
                let [counted, whole] =
                    [counted, whole].map(|q| [q.q10.unwrap(), q.median.unwrap(), q.q90.unwrap()]);
                for (counted, whole) in counted.iter().zip(whole) {
                    assert!((counted / whole - 1.0).abs() <= tally.quantile_error, "{counted} for {whole}");
                }
            }
        }
    }
    let rows = scored(&folder, "scores.parquet");
    for (pair, counts) in tally.paired.iter().zip(&tally.tally.pairs) {
        let own =
            |estimator| rows.iter().filter(move |r| r.design == pair.design && r.estimator == estimator);
        let both = own(pair.one).zip(own(pair.other));
        let ratio =
            |(one, other): (&RunScore, &RunScore)| Some(other.parameter_error? / one.parameter_error?);
        let mut ratios: Vec<f64> = both.map(|pair| ratio(pair).unwrap()).collect();
        ratios.sort_by(f64::total_cmp);
        let median = 0.5 * (ratios[9] + ratios[10]);
        assert!((pair.median_ratio.unwrap() / median - 1.0).abs() <= tally.quantile_error);
        assert_eq!(counts.ratio.count(), 20);
    }
    for counted in &tally.tally.counted {
        let own = rows.iter().filter(|r| r.design == counted.design && r.estimator == counted.estimator);
        let errors: Vec<f64> = own.map(|r| r.parameter_error.unwrap()).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!((counted.parameter_error.mean().unwrap() - mean).abs() < 1e-11);
    }
}

#[test]
fn law_shards_merge_to_the_bytes_of_the_whole_in_any_order_and_on_any_threads() {
    let folder = designed(20);
    run(&folder, &format!("{LINE} --estimator iv,ls --threads 1 --out whole.json")).succeeds();
    // 3 designs of 3 groups of at most 8 runs.
    for k in 1..=9 {
        run(&folder, &format!("{LINE} --estimator iv,ls --shard {k}/9 --threads 3 --out part-{k}.json"))
            .succeeds();
        let part = files::read_part::<ValidationDocument>(&folder.path().join(format!("part-{k}.json")));
        let runs: u64 = part.unwrap().data.counted.unwrap().tally.counted.iter().map(|c| c.runs).sum();
        assert!(runs > 0, "shard {k} is empty");
    }
    let gather = |order: [u32; 9], out: &str| {
        let names = order.map(|k| format!("part-{k}.json")).join(" ");
        run(&folder, &format!("monte-carlo --gather {names} --out {out}")).succeeds();
    };
    gather([1, 2, 3, 4, 5, 6, 7, 8, 9], "ascending.json");
    gather([5, 2, 8, 6, 1, 9, 4, 3, 7], "mixed.json");
    assert!(bytes(&folder, "whole.json") == bytes(&folder, "ascending.json"));
    assert!(bytes(&folder, "whole.json") == bytes(&folder, "mixed.json"));
}

#[test]
fn until_goes_on_until_every_interval_is_as_narrow() {
    let folder = designed(2);
    run(&folder, &format!("{LINE} --until 0.03 --out validation.json")).succeeds();
    let found = tally(&folder, "validation.json");
    for scores in &found.scores[0].designs {
        assert!(scores.runs % 512 == 0 && scores.runs > 500, "{}", scores.runs);
        for [low, high] in [scores.parameter_error_share_interval, scores.simulation_error_share_interval]
            .map(Option::unwrap)
        {
            assert!(0.5 * (high - low) <= 0.03, "{low} to {high}");
        }
    }
    assert_eq!(found.realizations, found.scores[0].designs[0].runs);
}

#[test]
fn what_cannot_be_tallied_is_refused() {
    let folder = designed(20);
    for k in 1..=3 {
        run(&folder, &format!("{LINE} --shard {k}/3 --out part-{k}.json")).succeeds();
    }
    run(&folder, &format!("{LINE} --seed 7 --shard 2/3 --out other.json")).succeeds();
    run(&folder, &format!("{LINE} --out whole.json")).succeeds();
    let refused = |line: &str, code: i32, says: &[&str]| refused(&folder, code, line, says);
    refused("monte-carlo --gather part-1.json part-3.json --out refused.json", 3, &["no shard 2/3"]);
    refused(
        "monte-carlo --gather part-1.json part-2.json part-3.json part-2.json --out refused.json",
        3,
        &["shard 2/3", "part-2.json"],
    );
    refused(
        "monte-carlo --gather part-1.json other.json part-3.json --out refused.json",
        3,
        &["other.json", "settings.seed", "found 7"],
    );
    refused("monte-carlo --gather whole.json --out refused.json", 3, &["whole.json", "a shard K/N"]);
    let old = String::from_utf8(bytes(&folder, "part-1.json")).unwrap().replace("validation/2", "tally/1");
    put(&folder, "old.json", &old);
    let says = ["found tally/1, expected validation/2", "made again by: seatrial monte-carlo"];
    refused("monte-carlo --gather old.json --out refused.json", 3, &says);
    refused(
        &format!("{LINE} --unknown-current earth --out refused.json"),
        2,
        &["--unknown-current earth", "`output-error`"],
    );
    refused(
        &format!("{LINE} --intercepts none --out refused.json"),
        2,
        &["--intercepts none", "--mean-removal"],
    );
    refused(&format!("{LINE} --until 1e-9 --out refused.json"), 2, &["--until", "1e-9", "2147483647 runs"]);
    refused(&format!("{LINE} --until 0.7 --out refused.json"), 2, &["--until", "below 0.5"]);
    refused(&format!("{LINE} --until 0.1 --shard 1/2 --out refused.json"), 2, &["--until"]);
    refused(&format!("{LINE} --realizations 3000000000 --out refused.json"), 2, &["--realizations"]);
    edit(&folder, "campaign.toml", "realizations = 20", "realizations = 9223372036854775808");
    refused(&format!("{LINE} --out refused.json"), 3, &["campaign.toml", "realizations"]);
}

/// A true value of 0 has no relative error: the estimate itself counts, and the summary says so.
#[test]
fn a_true_value_of_zero_is_no_reason_to_call_every_estimate_bad() {
    let folder = designed(8);
    let flags = "--allow=mixed --set vessel.sway.1.value=0.0 --out zero.json";
    run(&folder, "new mine --vessel model-ship").succeeds();
    let line = LINE.replacen("vessel.toml", "mine/vessel.toml", 1);
    let ran = run(&folder, &format!("{line} --estimator iv {flags}")).succeeds();
    assert!(ran.stdout.contains("in the parameter error `Y_ur` with a true value of 0 counts as"), "{ran}");
    let counted = &tally(&folder, "zero.json").tally.counted[0];
    assert!(counted.parameter_errors_below > 0 && counted.parameter_error.sum.value() > 0.0, "{counted:?}");
    let ran = run(&folder, &format!("{LINE} --estimator iv --out validation.json")).succeeds();
    assert!(!ran.stdout.contains("true value of 0"), "{ran}");
}
