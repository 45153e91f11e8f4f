use std::collections::BTreeMap;

use cli::inputs::counts;
use files::Provenance;
use serde_json::Value;

use crate::SELECTION;
use crate::support::*;

#[test]
fn realizations_pick_what_the_counts_say() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{SELECTION} --out selection.parquet")).succeeds();
    let data = json(&folder, "selection.json")["data"].clone();
    assert_eq!((&data["picks"], &data["counts"]["decelerate"]), (&5.into(), &2.into()));
    let names: Vec<&Value> = data["designs"].as_array().unwrap().iter().map(|d| &d["design"]).collect();
    assert_eq!(names, ["optimized", "random"]);
    let table = craft::read(&folder.path().join("selection.parquet"), "selection-realizations");
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
    let folder = with(&["campaign.parquet"]);
    let made = |seed: u32| {
        run(&folder, &format!("{SELECTION} --seed {seed} --out selection.parquet")).succeeds();
        bytes(&folder, "selection.parquet")
    };
    assert_eq!(made(4), made(4));
    assert_ne!(made(4), made(5));
}

#[test]
fn law_shards_gather_to_the_bytes_of_the_whole() {
    let folder = with(&["campaign.parquet"]);
    let line = SELECTION.replace("40", "70");
    run(&folder, &format!("{line} --out selection.parquet --threads 1")).succeeds();
    let all = || (bytes(&folder, "selection.parquet"), bytes(&folder, "selection.json"));
    let whole = all();
    for k in 1..=2 {
        run(&folder, &format!("{line} --shard {k}/2 --threads 3 --out part-{k}.parquet")).succeeds();
    }
    run(&folder, &format!("{line} --gather part-2.parquet part-1.parquet --out selection.parquet"))
        .succeeds();
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
    let line = "validate selection --vessel vessel.toml --trajectories campaign.parquet --design design.json --realizations 8";
    refused(
        &folder,
        3,
        &format!("{line} --out selection.parquet"),
        &["design.json", "counts: found none", "--segments"],
    );
}

#[test]
fn the_report_shows_the_histograms() {
    let folder = with(&["campaign.parquet", "design.json"]);
    run(&folder, &format!("{SELECTION} --out selection.parquet")).succeeds();
    run(&folder, REPORT).succeeds();
    let page = String::from_utf8(bytes(&folder, "report.html")).unwrap();
    for piece in ["<section id=\"selection\">", "href=\"#selection\"", "2 × decelerate", "degenerate"] {
        assert!(page.contains(piece), "{piece}");
    }
    for name in ["selection-error", "selection-surge", "selection-sway", "selection-yaw"] {
        assert!(folder.path().join(format!("figures/{name}.svg")).is_file(), "{name}");
    }
}

#[test]
fn counts_are_read_and_bounded() {
    let there = [("zigzag/fast", 4), ("turning/slow", 2)].map(|(name, n)| (name.to_owned(), n));
    let read = |texts: &[&str]| {
        let texts: Vec<String> = texts.iter().map(|text| (*text).to_owned()).collect();
        counts(None, &texts, &BTreeMap::from(there.clone()), &mut Provenance::default())
    };
    assert_eq!(read(&["zigzag/fast=4", "turning/slow=1"]).unwrap().len(), 2);
    for wrong in ["zigzag/fast", "zigzag/fast=5", "zigzag/fats=1", "turning/slow=0", "turning/slow=x"] {
        assert_eq!(read(&[wrong]).unwrap_err().exit_code(), 2, "{wrong}");
    }
}
