//! Maneuvers whose inputs stand in tables: played at the times of the table, whole, never stretched.

use std::ops::Range;

use tempfile::TempDir;

use crate::support::*;

const RECORDED: &str =
    "\n[[maneuver]]\nname = \"recorded\"\nkind = \"inputs\"\nfile = \"log.csv\"\nspeed_m_s = 0.6\n";

/// Rows of a table: forces that jump, reverse and oscillate.
fn rows(count: usize) -> Vec<[f64; 3]> {
    let row = |k: usize| {
        let side = if k % 31 < 16 { 1.0 } else { -1.0 };
        [1500.0 + 20.0 * (k % 50) as f64, 300.0 * side, 250.0 * (k as f64 * 0.21).sin()]
    };
    (0..count).map(row).collect()
}

/// The rows with their times, `step` seconds apart.
fn timed(rows: &[[f64; 3]], step: f64) -> String {
    let row = |(k, [x, y, n]): (usize, &[f64; 3])| format!("{},{x},{y},{n}\n", 7.0 + k as f64 * step);
    format!("t,tau1,tau2,tau3\n{}", rows.iter().enumerate().map(row).collect::<String>())
}

/// The small study with a maneuver that plays `table`.
fn with_table(table: &str, more: &str) -> TempDir {
    let folder = with(&[]);
    let dictionary = String::from_utf8(bytes(&folder, "dictionary.toml")).unwrap();
    put(&folder, "dictionary.toml", &format!("{dictionary}{RECORDED}{more}"));
    put(&folder, "log.csv", table);
    folder
}

/// The inputs that every segment of `recorded` plays.
fn played(folder: &TempDir, name: &str) -> Vec<Vec<[f64; 3]>> {
    let whole = craft::read(&folder.path().join(name), "trajectories");
    let place = |name: &str| whole.schema.columns.iter().position(|c| c.name == name).unwrap();
    let (mut found, mut last): (Vec<Vec<[f64; 3]>>, _) = (Vec::new(), None);
    for block in &whole.blocks {
        let integer = |name: &str, row: usize| block.columns[place(name)].as_i32().unwrap()[row];
        let inputs = ["tau1", "tau2", "tau3"].map(|name| &block.columns[place(name)]);
        for row in 0..block.columns[0].len() {
            // The last row of a run has no inputs.
            if block.columns[place("maneuver")].text_at(row) != Some("recorded") || inputs[0].is_null(row) {
                continue;
            }
            let design = block.columns[place("design")].text_at(row).unwrap_or("").to_owned();
            let key = Some((design, integer("run", row), integer("segment", row)));
            if last != key {
                found.push(Vec::new());
                last = key;
            }
            found.last_mut().unwrap().push(inputs.map(|column| column.as_f64().unwrap()[row]));
        }
    }
    found
}

/// The design becomes one of `recorded`, with this share, and of a zig-zag.
fn shared(folder: &TempDir, share: f64) {
    let mut design = json(folder, "design.json");
    let shares = design["data"]["shares"].as_object_mut().unwrap();
    shares.values_mut().for_each(|value| *value = 0.0.into());
    shares.insert("zig-zag-slow-flat".into(), (1.0 - share).into());
    shares.insert("recorded".into(), share.into());
    design["seal"] = serde_json::Value::Null;
    put(folder, "design.json", &design.to_string());
}

fn stages(folder: &TempDir, stages: &[&str]) {
    stages.iter().for_each(|stage| drop(run(folder, stage).succeeds()));
}

#[test]
fn law_a_tables_played_inputs_are_the_files_in_dictionary_campaign_and_validation() {
    // As long as a segment of random trials, so that it is drawn for them, too.
    let rows = rows(200);
    let folder = with_table(&timed(&rows, 0.125), "");
    let telegraph = "[[validation.maneuver]]";
    let own = RECORDED.replace("[[maneuver]]", telegraph);
    edit(&folder, "campaign.toml", telegraph, &format!("{own}\n{telegraph}"));
    stages(&folder, &[DICTIONARY, MOMENTS, DESIGN, VALIDATION]);
    for name in ["dictionary.parquet", "validation.parquet"] {
        assert_eq!(played(&folder, name), std::slice::from_ref(&rows), "{name}");
    }
    shared(&folder, 0.47);
    let said = run(&folder, CAMPAIGN).succeeds().stdout;
    assert!(
        said.contains(
            "recorded, a table of 25 s, is played 2 times: 40.0 % of the time for a share of 47.0 %"
        ),
        "{said}"
    );
    let campaign = played(&folder, "campaign.parquet");
    assert!(campaign.len() > 2 * RUNS as usize, "{}", campaign.len());
    assert!(campaign.iter().all(|own| *own == rows), "a segment plays something else");
}

#[test]
fn random_trials_go_without_tables_of_another_length_and_say_so() {
    let folder = with_table(&timed(&rows(90), 0.125), "");
    stages(&folder, &[DICTIONARY, MOMENTS, DESIGN]);
    shared(&folder, 0.1);
    let said = run(&folder, CAMPAIGN).succeeds().stdout;
    assert!(said.contains("tables are not cut to segments of 200 samples: recorded (90 samples)"), "{said}");
    let campaign = played(&folder, "campaign.parquet");
    assert_eq!(campaign, vec![rows(90); RUNS as usize]);
}

#[test]
fn a_practice_that_the_ship_cannot_sail_is_named_and_left_out() {
    // A round of practice that fits into a run, with a table that random trials go without.
    let mild = rows(300);
    let folder = with_table(&timed(&mild, 0.125), "");
    edit(&folder, "dictionary.toml", "duration_s = 37.5", "duration_s = 6.0");
    stages(&folder, &[DICTIONARY, MOMENTS, DESIGN]);
    shared(&folder, 0.0);
    let sailed = run(&folder, CAMPAIGN).succeeds().stdout;
    assert!(sailed.starts_with(&format!("campaign.parquet: {} runs", 3 * RUNS)), "{sailed}");
    assert_eq!(played(&folder, "campaign.parquet"), vec![mild.clone(); RUNS as usize]);
    let wild: Vec<[f64; 3]> = mild.iter().map(|row| row.map(|force| 1e6 * force)).collect();
    put(&folder, "log.csv", &timed(&wild, 0.125));
    let said = run(&folder, &format!("{CAMPAIGN} --allow=mixed")).succeeds().stdout;
    assert!(said.starts_with(&format!("campaign.parquet: {} runs", 2 * RUNS)), "{said}");
    assert!(
        said.contains(
            "no practice trials, since the ship diverges in maneuver `recorded`, 66.1 s after their start"
        ),
        "{said}"
    );
    let noted = craft::read(&folder.path().join("campaign.parquet"), "trajectories");
    assert!(!noted.blocks.iter().any(|block| block.columns[0].text_at(0) == Some("practice")));
}

#[test]
fn a_dictionary_of_one_maneuver_has_no_practice_and_says_so() {
    let folder = with(&["design.json"]);
    let dictionary = String::from_utf8(bytes(&folder, "dictionary.toml")).unwrap();
    let first = dictionary.match_indices("[[maneuver]]").nth(1).unwrap().0;
    put(&folder, "dictionary.toml", &dictionary[..first]);
    stages(&folder, &[DICTIONARY]);
    let mut design = json(&folder, "design.json");
    design["data"]["shares"] = serde_json::json!({"decelerate": 1.0});
    design["seal"] = serde_json::Value::Null;
    put(&folder, "design.json", &design.to_string());
    let said = run(&folder, &format!("{CAMPAIGN} --allow=mixed")).succeeds().stdout;
    assert!(said.contains("no practice trials, since they take two hand-written maneuvers or more, and the dictionary has only `decelerate`"), "{said}");
}

#[test]
fn a_run_that_whole_plays_do_not_fill_is_refused_unless_others_have_a_share() {
    let folder = with_table(&timed(&rows(90), 0.125), "");
    stages(&folder, &[DICTIONARY, MOMENTS, DESIGN]);
    shared(&folder, 1.0);
    let pieces =
        ["campaign.toml", "`duration_s`", "runs of 1000 samples", "11 of recorded (11.25 s)", "whole plays"];
    refused(&folder, 3, CAMPAIGN, &pieces);
}

#[test]
fn a_table_of_another_rate_than_the_vessels_is_refused_unless_it_is_resampled() {
    let rows = rows(40);
    let folder = with_table(&timed(&rows, 1.0), "");
    let pieces =
        ["log.csv: line 3, column `t`", "1 s after the first row", "0.125 s", "8 Hz", "`resample = true`"];
    refused(&folder, 3, DICTIONARY, &pieces);
    let folder = with_table(&timed(&rows, 1.0), "resample = true\n");
    let said = run(&folder, DICTIONARY).succeeds().stdout;
    assert!(
        said.contains("log.csv is played in 39.125 s, resampled from 1 to 8 Hz on straight lines"),
        "{said}"
    );
    let found = played(&folder, "dictionary.parquet").remove(0);
    assert_eq!(found.len(), 39 * 8 + 1);
    for (k, row) in found.iter().enumerate() {
        let (before, share) = (k / 8, (k % 8) as f64 / 8.0);
        for (i, found) in row.iter().enumerate() {
            let expected = (1.0 - share) * rows[before][i] + share * rows[(before + 1).min(39)][i];
            approx::assert_relative_eq!(*found, expected, epsilon = 1e-9, max_relative = 1e-12);
        }
    }
}

#[test]
fn a_table_without_times_is_said_to_be_played_at_the_vessels_rate() {
    let table = timed(&rows(80), 1.0);
    let without: String =
        table.lines().map(|line| line.split_once(',').unwrap().1.to_owned() + "\n").collect();
    let folder = with_table(&without, "");
    let said = run(&folder, DICTIONARY).succeeds().stdout;
    assert!(
        said.contains("recorded: log.csv is played in 10 s, a row per sample of 8 Hz (it has no column `t`)"),
        "{said}"
    );
    put(&folder, "log.csv", &table.replacen("t,", "Time [s],", 1));
    refused(&folder, 3, DICTIONARY, &["log.csv: header", "column `Time [s]`", "rename it"]);
    put(&folder, "log.csv", &without);
    let folder = with_table(&without, "resample = true\n");
    refused(&folder, 3, DICTIONARY, &["log.csv: header", "no column `t`", "`resample`"]);
}

#[test]
fn times_that_are_uneven_repeated_missing_or_go_back_are_refused_by_row() {
    let changed = |line: usize, cell: &str| {
        let table = timed(&rows(40), 0.125);
        let edited = |(n, text): (usize, &str)| {
            let rest = text.split_once(',').unwrap().1;
            if n + 1 == line { format!("{cell},{rest}\n") } else { format!("{text}\n") }
        };
        table.lines().enumerate().map(edited).collect::<String>()
    };
    // Line 12 has 8.25 s, the one before 8.125 s.
    for cell in ["", "8.125", "7.5", "8.2", "nan", "8.375"] {
        for more in ["", "resample = true\n"] {
            let folder = with_table(&changed(12, cell), more);
            refused(&folder, 3, DICTIONARY, &["log.csv: line 12, column `t`"]);
        }
    }
    let gap: String = with_gap(&timed(&rows(40), 0.125), 20..23);
    let folder = with_table(&gap, "");
    refused(
        &folder,
        3,
        DICTIONARY,
        &["log.csv: line 21, column `t`", "0.5 s after the row before", "0.125 s"],
    );
}

fn with_gap(table: &str, missing: Range<usize>) -> String {
    let kept = table.lines().enumerate().filter(|(n, _)| !missing.contains(n));
    kept.map(|(_, line)| format!("{line}\n")).collect()
}

#[test]
fn a_duration_that_is_not_the_tables_is_refused() {
    let folder = with_table(&timed(&rows(80), 0.125), "duration_s = 20.0\n");
    refused(
        &folder,
        3,
        DICTIONARY,
        &["maneuver `recorded`, `duration_s`", "found 20 s", "expected 10 s", "log.csv"],
    );
    let folder = with_table(&timed(&rows(80), 0.125), "duration_s = 10.0\n");
    run(&folder, DICTIONARY).succeeds();
}
