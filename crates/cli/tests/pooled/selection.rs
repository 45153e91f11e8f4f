use serde_json::{Value, json};

use crate::support::*;
use crate::{SELECTION, pick, picking};

#[test]
fn realizations_pick_what_the_counts_say() {
    let folder = picking();
    run(&folder, &format!("{SELECTION} --out scores.parquet")).succeeds();
    let data = json(&folder, "validation.json")["data"]["picks"].clone();
    assert_eq!((&data["picks"], &data["counts"]["decelerate"]), (&5.into(), &2.into()));
    let names: Vec<&Value> = data["designs"].as_array().unwrap().iter().map(|d| &d["design"]).collect();
    assert_eq!(names, ["optimized", "random"]);
    let table = craft::read(&folder.path().join("scores.parquet"), "scores");
    let picked = |row: usize| {
        let text = table.blocks[row / 64].columns[2].text_at(row % 64).unwrap();
        text.split(' ').map(|n| n.parse::<u64>().unwrap()).collect::<Vec<u64>>()
    };
    for row in 0..80 {
        let picked = picked(row);
        assert_eq!(picked.len(), 5);
        assert!(picked.windows(2).all(|w| w[0] < w[1]) && picked[4] < data["parts"].as_u64().unwrap());
    }
    assert_ne!(picked(0), picked(1));
}

#[test]
fn law_another_seed_draws_others_and_the_same_seed_the_same() {
    let folder = picking();
    let made = |seed: u32| {
        run(&folder, &format!("{SELECTION} --seed {seed} --out scores.parquet")).succeeds();
        bytes(&folder, "scores.parquet")
    };
    assert_eq!(made(4), made(4));
    assert_ne!(made(4), made(5));
}

#[test]
fn law_shards_gather_to_the_bytes_of_the_whole() {
    let folder = picking();
    let line = SELECTION.replace("40", "70");
    run(&folder, &format!("{line} --out scores.parquet --threads 1")).succeeds();
    let all = || (bytes(&folder, "scores.parquet"), bytes(&folder, "validation.json"));
    let whole = all();
    for k in 1..=2 {
        run(&folder, &format!("{line} --shard {k}/2 --threads 3 --out part-{k}.parquet")).succeeds();
    }
    run(&folder, &format!("{line} --gather part-2.parquet part-1.parquet --out scores.parquet")).succeeds();
    assert_eq!(all(), whole);
    let line = SELECTION.replace("40", "71");
    let other = format!("{line} --gather part-1.parquet part-2.parquet --out refused.parquet");
    run(&folder, &other).refuses(3, &["part-1.parquet", "`realizations`", "found 70", "71"]);
    // Runs left out of the shards are another setting too.
    let other = other.replace("71", "70").replace("--gather", "--leave-out random/1 --gather");
    run(&folder, &other).refuses(3, &["part-1.parquet", "`leave_out`", "found nothing", "random/1"]);
}

#[test]
fn a_design_without_counts_is_refused() {
    let folder = with(&["campaign.parquet", "design.json"]);
    let line =
        "validate --vessel vessel.toml --trajectories campaign.parquet --design design.json --realizations 8";
    refused(
        &folder,
        3,
        &format!("{line} --out scores.parquet"),
        &["design.json", "counts: found none", "--segments"],
    );
}

#[test]
fn the_report_shows_the_histograms() {
    let folder = picking();
    run(&folder, &format!("{SELECTION} --out scores.parquet")).succeeds();
    run(&folder, &format!("{REPORT} --allow=mixed")).succeeds();
    let page = String::from_utf8(bytes(&folder, "report.html")).unwrap();
    for piece in ["<section id=\"selection\">", "href=\"#selection\"", "2 × decelerate", "degenerate"] {
        assert!(page.contains(piece), "{piece}");
    }
    for name in ["selection-error", "selection-surge", "selection-sway", "selection-yaw"] {
        assert!(folder.path().join(format!("figures/{name}.svg")).is_file(), "{name}");
    }
}

#[test]
fn counts_are_bounded() {
    let folder = picking();
    for counts in [json!({"decelerate": 2000}), json!({"decelerrate": 1})] {
        let name = counts.as_object().unwrap().keys().next().unwrap().clone();
        pick(&folder, counts);
        refused(
            &folder,
            3,
            &format!("{SELECTION} --out scores.parquet"),
            &["picks.json: counts", &name, "at most"],
        );
    }
    refused(
        &folder,
        2,
        &format!("{SELECTION} --counts decelerate=2 --out s.parquet"),
        &["--counts", "--design has"],
    );
}
