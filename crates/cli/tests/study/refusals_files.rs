//! Tables and documents that are refused: for their contents, and after damage.

use std::fs;

use tempfile::TempDir;

use crate::support::*;

/// Rewrites a table of the study, in place.
fn rewrite(folder: &TempDir, name: &str, change: impl FnOnce(craft::Whole) -> craft::Whole) {
    let path = folder.path().join(name);
    change(craft::read(&path, "trajectories")).write(&path);
}

#[test]
fn a_column_in_another_unit_is_refused_with_both_units() {
    let folder = with(&["dictionary.parquet", "campaign.parquet"]);
    for (name, stage) in [("dictionary.parquet", MOMENTS), ("campaign.parquet", ESTIMATE)] {
        rewrite(&folder, name, |mut table| {
            table.column("y_u").unit = "kn".into();
            table
        });
        let pieces = [name, "column `y_u`", "in unit kn", "in unit m/s", "convert"];
        refused(&folder, 3, stage, &pieces);
    }
}

#[test]
fn missing_columns_are_named_all_at_once() {
    let folder = with(&["dictionary.parquet", "validation.parquet", "estimates.parquet"]);
    for (name, stage) in [("dictionary.parquet", MOMENTS), ("validation.parquet", VALIDATE)] {
        rewrite(&folder, name, |table| table.without(&["tau2", "y_u", "segment"]));
        refused(
            &folder,
            3,
            stage,
            &[name, "columns", "also `segment`, `tau2`, `y_u`", "write the file again"],
        );
    }
}

#[test]
fn columns_that_no_stage_needs_may_be_missing() {
    let folder = with(&["dictionary.parquet"]);
    rewrite(&folder, "dictionary.parquet", |table| table.without(&["x", "y", "psi"]));
    run(&folder, MOMENTS).succeeds();
}

#[test]
fn values_that_are_not_finite_are_refused_with_column_and_row() {
    for (value, found) in [(f64::NAN, "NaN"), (f64::INFINITY, "inf"), (f64::NEG_INFINITY, "-inf")] {
        for column in ["y_r", "tau1", "t"] {
            let folder = with(&["dictionary.parquet"]);
            let path = folder.path().join("dictionary.parquet");
            craft::read(&path, "trajectories").write_foreign(&path, column, 77, value);
            let pieces =
                ["dictionary.parquet", &format!("column `{column}`, row 77"), found, "a finite number"];
            refused(&folder, 3, MOMENTS, &pieces);
        }
    }
}

#[test]
fn runs_of_one_number_are_refused_whichever_blocks_they_stand_in() {
    let folder = with(&["campaign.parquet", "estimates.parquet", "validation.parquet"]);
    rewrite(&folder, "campaign.parquet", |mut table| {
        let again = craft::read(&folder.path().join("campaign.parquet"), "trajectories");
        table.blocks.extend(again.blocks);
        table
    });
    // Which design is named depends on which blocks are read first.
    let pieces = ["campaign.parquet: design ", ", run 0: found it twice, from rows "];
    refused(&folder, 3, ESTIMATE, &pieces);
    let path = folder.path().join("estimates.parquet");
    let (mut table, again) = (craft::read(&path, "estimates"), craft::read(&path, "estimates"));
    table.blocks.extend(again.blocks);
    table.write(&path);
    fs::remove_file(folder.path().join("estimate.json")).ok();
    let pieces = ["estimates.parquet", "design optimized, run 0", "its estimate by iv twice"];
    refused(&folder, 3, VALIDATE, &pieces);
}

#[test]
fn a_table_without_rows_is_refused() {
    let folder = with(&["dictionary.parquet"]);
    rewrite(&folder, "dictionary.parquet", |mut table| {
        table.blocks.clear();
        table
    });
    refused(&folder, 3, MOMENTS, &["dictionary.parquet", "rows: found none", "at least one run"]);
}

#[test]
fn shards_without_a_seal_are_read_before_they_are_copied() {
    let folder = with(&["design.json"]);
    for k in [1, 2] {
        let name = format!("part-{k}.parquet");
        run(&folder, &format!("{CAMPAIGN} --shard {k}/2").replace("campaign.parquet", &name)).succeeds();
        let path = folder.path().join(&name);
        let value = if k == 1 { 0.5 } else { f64::NAN };
        craft::read(&path, "trajectories").write_foreign(&path, "y_u", 3, value);
    }
    let line = "simulate campaign --gather part-1.parquet part-2.parquet --out all.parquet";
    refused(&folder, 3, line, &["part-2.parquet", "column `y_u`, row 3", "found NaN"]);
}

#[test]
fn what_a_document_says_twice_or_without_keys_is_refused() {
    let changed = |from: &str, to: &str| {
        let folder = with(&["design.json"]);
        craft::unsealed(&folder.path().join("design.json"), from, to);
        folder
    };
    let twice = changed("\"shares\": {", "\"shares\": {\"accelerate\": 0.0,");
    refused(&twice, 3, CAMPAIGN, &["design.json", "key `accelerate` twice", "every key once"]);
    let list = changed("\"efficiency\": {", "\"efficiency\": [1.0, {}], \"old\": {");
    refused(&list, 3, CAMPAIGN, &["design.json", "found a list", "keys with values"]);
}

#[test]
fn shares_that_are_none_are_refused_by_every_reader() {
    let selection = "validate --vessel vessel.toml --trajectories dictionary.parquet --design design.json \
        --out s.parquet";
    let changed = |change: &dyn Fn(f64) -> f64, pieces: &[&str]| {
        let folder = with(&["design.json", "dictionary.parquet"]);
        let mut design = json(&folder, "design.json");
        design["seal"] = serde_json::Value::Null;
        let shares = design["data"]["shares"].as_object_mut().unwrap();
        shares.values_mut().for_each(|share| *share = change(share.as_f64().unwrap()).into());
        put(&folder, "design.json", &design.to_string());
        for line in [CAMPAIGN, selection] {
            refused(&folder, 3, line, &[&["design.json", "`data.shares`"], pieces].concat());
        }
    };
    changed(&|share| if share == 0.0 { -5.0 } else { share }, &["found -5", "a share from 0 to 1"]);
    changed(&|share| 7.0 * share, &["a share from 0 to 1"]);
    changed(&|share| 0.25 * share, &["sum of `data.shares`", "found 0.2", "expected 1;"]);
}

#[test]
fn an_unsealed_table_of_another_program_is_read() {
    let folder = with(&["dictionary.parquet"]);
    let path = folder.path().join("dictionary.parquet");
    let moments = json(&with(&["moments.json"]), "moments.json")["data"].clone();
    let table = craft::read(&path, "trajectories");
    let first = table.blocks[0].columns[9].as_f64().unwrap()[0];
    table.write_foreign(&path, "y_u", 0, first);
    run(&folder, MOMENTS).succeeds();
    assert_eq!(json(&folder, "moments.json")["data"], moments);
}

#[test]
fn a_later_version_is_refused_with_both_versions_and_the_remedy() {
    let folder = with(&[
        "dictionary.parquet",
        "moments.json",
        "design.json",
        "estimates.parquet",
        "validation.parquet",
    ]);
    let file = |name: &str| folder.path().join(name);
    for (name, id, version, stage) in [
        ("dictionary.parquet", "trajectories", 1, MOMENTS),
        ("moments.json", "moments", 1, DESIGN),
        ("design.json", "design", 2, CAMPAIGN),
        ("estimates.parquet", "estimates", 1, VALIDATE),
    ] {
        let later = version + 1;
        craft::patch(&file(name), &format!("{id}/{version}"), &format!("{id}/{later}"));
        let (found, expected) = (format!("found {id}/{later}"), format!("expected {id}/{version}"));
        refused(&folder, 3, stage, &[name, "schema", &found, &expected, "upgrade"]);
    }
}

#[test]
fn a_file_of_another_kind_is_refused() {
    let folder = with(&[
        "dictionary.parquet",
        "estimates.parquet",
        "moments.json",
        "design.json",
        "validation.parquet",
    ]);
    let line = MOMENTS.replace("dictionary.parquet", "estimates.parquet");
    refused(&folder, 3, &line, &["estimates.parquet", "found estimates/1", "expected trajectories/1"]);
    let line = DESIGN
        .replace("moments.json --out", "design.json --out")
        .replace("--out design.json", "--out other.json");
    refused(&folder, 3, &line, &["design.json", "found design/2", "expected moments/1"]);
    let line = VALIDATE.replace("estimates.parquet", "validation.parquet");
    refused(&folder, 3, &line, &["validation.parquet", "found trajectories/1", "expected estimates/1"]);
}

#[test]
fn fewer_samples_than_unknowns_are_refused() {
    let folder = with(&["design.json"]);
    edit(&folder, "dictionary.toml", "name = \"accelerate\"", "name = \"accelerate\"\nduration_s = 0.375");
    run(&folder, DICTIONARY).succeeds();
    let pieces = ["dictionary.parquet", "maneuver `accelerate`", "3 samples", "at least 5", "lengthen"];
    refused(&folder, 3, MOMENTS, &pieces);
    edit(&folder, "campaign.toml", "duration_s = 125.0", "duration_s = 0.375");
    edit(&folder, "campaign.toml", "segments = 5", "segments = 1");
    run(&folder, &format!("{CAMPAIGN} --allow=mixed")).succeeds();
    refused(&folder, 3, ESTIMATE, &["campaign.parquet", "run 0", "3 samples", "lengthen the run"]);
}

/// A dictionary that moves straight ahead only.
fn straight_ahead(folder: &TempDir) {
    put(
        folder,
        "dictionary.toml",
        "duration_s = 37.5\n[[maneuver]]\nname = \"decelerate\"\nkind = \"decelerate\"\nfrom_m_s = 1.0\nto_m_s = 0.0\n\
         [[maneuver]]\nname = \"accelerate\"\nkind = \"accelerate\"\nfrom_m_s = 0.0\nto_m_s = 1.0\n",
    );
}

#[test]
fn directions_that_nothing_excites_have_no_design_and_no_estimate() {
    let folder = with(&[]);
    straight_ahead(&folder);
    run(&folder, DICTIONARY).succeeds();
    run(&folder, MOMENTS).succeeds();
    refused(&folder, 4, DESIGN, &["moments.json", "parameter `Y_tau` (sway)", "`tau2` varies"]);
    let line = ESTIMATE.replace("campaign.parquet", "dictionary.parquet");
    refused(&folder, 4, &line, &["dictionary.parquet", "parameter `", "add a maneuver"]);
}

#[test]
fn noisy_runs_that_excite_too_little_have_no_estimate() {
    let folder = with(&["design.json"]);
    straight_ahead(&folder);
    let mut design = json(&folder, "design.json");
    design["seal"] = serde_json::Value::Null;
    design["data"]["shares"] = serde_json::json!({"accelerate": 0.5, "decelerate": 0.5});
    put(&folder, "design.json", &design.to_string());
    run(&folder, &format!("{CAMPAIGN} --allow=mixed")).succeeds();
    refused(&folder, 4, ESTIMATE, &["campaign.parquet", "parameter `", "add a maneuver"]);
}

#[test]
fn a_design_of_another_dictionary_is_refused() {
    let folder = with(&["design.json"]);
    edit(&folder, "dictionary.toml", "\"spiral-fast\"", "\"spiral-rapid\"");
    let pieces = ["design.json", "maneuver `spiral-fast`", "dictionary.toml", "make the design again"];
    refused(
        &folder,
        3,
        CAMPAIGN,
        &["design.json: provenance", "another dictionary than that of dictionary.toml"],
    );
    refused(&folder, 3, &format!("{CAMPAIGN} --allow=mixed"), &pieces);
}

/// Refuses a damaged file.
#[track_caller]
fn damaged(folder: &TempDir, name: &str, bytes: &[u8], stage: &str) {
    fs::write(folder.path().join(name), bytes).unwrap();
    refused(folder, 3, stage, &[name]);
}

/// The reader of each file.
const READERS: [(&str, &str); 5] = [
    ("dictionary.parquet", MOMENTS),
    ("moments.json", DESIGN),
    ("design.json", CAMPAIGN),
    ("estimates.parquet", VALIDATE),
    ("scores.parquet", REPORT),
];

/// Every file that is read.
const ALL: [&str; 6] = [
    "dictionary.parquet",
    "moments.json",
    "design.json",
    "estimates.parquet",
    "scores.parquet",
    "validation.parquet",
];

#[test]
fn truncated_files_are_refused() {
    for (name, stage) in READERS {
        let folder = with(&ALL);
        let whole = bytes(&folder, name);
        let n = whole.len();
        for length in [0, 1, 4, 11, 12, 100, n / 3, n / 2, n - 9, n - 8, n - 4, n - 2] {
            damaged(&folder, name, &whole[..length], stage);
        }
    }
}

#[test]
fn a_flipped_bit_anywhere_is_refused() {
    for (name, stage) in READERS {
        let folder = with(&ALL);
        let whole = bytes(&folder, name);
        let n = whole.len();
        let spread = (0..10).map(|i| 5 + i * (n - 20) / 10);
        for (i, at) in spread.chain([0, n - 1, n - 5, n - 12, n - 300]).enumerate() {
            let mut bytes = whole.clone();
            bytes[at] ^= 1 << (i % 8);
            damaged(&folder, name, &bytes, stage);
        }
    }
}

#[test]
fn empty_files_and_text_instead_of_tables_are_refused() {
    for (name, stage) in READERS {
        let folder = with(&ALL);
        damaged(&folder, name, b"", stage);
        damaged(&folder, name, b"u,v,r\n1,2,3\n", stage);
        damaged(&folder, name, &[0; 4096], stage);
        let other = if name.ends_with(".json") { "dictionary.parquet" } else { "moments.json" };
        damaged(&folder, name, study().bytes(other), stage);
    }
}

#[test]
fn absent_files_and_folders_instead_of_files_fail() {
    for (name, stage) in READERS {
        let folder = with(&ALL);
        fs::remove_file(folder.path().join(name)).unwrap();
        if stage != REPORT {
            refused(&folder, 1, stage, &[name, "read", "an existing file", "check the path"]);
        }
        fs::create_dir(folder.path().join(name)).unwrap();
        refused(&folder, 3, stage, &[name, "a folder", "an ordinary file", "name a file"]);
    }
    for name in WRITTEN {
        let folder = with(&ALL);
        fs::remove_file(folder.path().join(name)).unwrap();
        refused(&folder, 1, CAMPAIGN, &[name, "read", "an existing file"]);
    }
}
