//! The planned trial carried out: `simulate plan`, `estimate`, `validate`.

use crate::planned::*;
use crate::support::*;
use tempfile::TempDir;

const SIMULATE: &str =
    "simulate plan --vessel vessel.toml --campaign campaign.toml --plan plan.json --out planned.parquet";
const ESTIMATE_PLANNED: &str =
    "estimate --vessel vessel.toml --trajectories planned.parquet --out estimates.parquet";

fn sailed(runs: u32) -> TempDir {
    let folder =
        small_planned().study.with(&["plan.json", "track.parquet", "plan.toml", "dictionary.parquet"]);
    edit(&folder, "campaign.toml", "realizations = 200", &format!("realizations = {runs}"));
    folder
}

#[test]
fn the_planned_trial_is_simulated_estimated_and_validated() {
    let folder = sailed(6);
    run(&folder, SIMULATE).succeeds();
    run(&folder, VALIDATION).succeeds();
    run(&folder, ESTIMATE_PLANNED).succeeds();
    run(&folder, VALIDATE).succeeds();
    let validation = json(&folder, "validation.json")["data"].take();
    let text = validation.to_string();
    assert!(text.contains("planned"), "{text}");
    let estimates = craft::read(&folder.path().join("estimates.parquet"), "estimates");
    let rows: usize = estimates.blocks.iter().map(|b| b.columns[0].len()).sum();
    assert_eq!(rows, 6);
    assert!(
        estimates
            .blocks
            .iter()
            .all(|b| (0..b.columns[0].len()).all(|r| b.columns[0].text_at(r) == Some("planned")))
    );
}

#[test]
fn law_simulated_inputs_are_the_tracks_and_start_at_its_state() {
    let folder = sailed(3);
    run(&folder, SIMULATE).succeeds();
    let table = craft::read(&folder.path().join("planned.parquet"), "trajectories");
    let place = |name: &str| table.schema.columns.iter().position(|c| c.name == name).unwrap();
    let track = &small_planned().track;
    let (mut row, mut runs) = (0, 0);
    for block in &table.blocks {
        for at in 0..block.columns[0].len() {
            let value = |name: &str| block.columns[place(name)].value_at(at);
            if let Some(inputs) = track.inputs.get(row) {
                let own = ["tau1", "tau2", "tau3"].map(|name| value(name).unwrap());
                assert_eq!(own, *inputs, "row {row}");
                let maneuver = block.columns[place("maneuver")].text_at(at).unwrap();
                let expected = if track.informative[row] { track.maneuver[row].as_str() } else { "between" };
                assert_eq!(maneuver, expected, "row {row}");
            }
            if row == 0 {
                assert_eq!(["u", "v", "r"].map(|name| value(name).unwrap()), track.state[0]);
            }
            row = if row == track.inputs.len() {
                runs += 1;
                0
            } else {
                row + 1
            };
        }
    }
    assert_eq!((runs, row), (3, 0));
}

#[test]
fn law_shards_of_the_planned_trial_gather_to_the_same_bytes() {
    // More runs than one block has.
    let folder = sailed(150);
    run(&folder, SIMULATE).succeeds();
    let whole = bytes(&folder, "planned.parquet");
    let (line, _) = SIMULATE.split_once(" --out ").unwrap();
    for k in [3, 1, 2] {
        run(&folder, &format!("{line} --shard {k}/3 --out part-{k}.parquet")).succeeds();
    }
    let parts = "part-2.parquet part-3.parquet part-1.parquet";
    run(&folder, &format!("simulate plan --out gathered.parquet --gather {parts}")).succeeds();
    assert!(bytes(&folder, "gathered.parquet") == whole);
    run(&folder, &format!("{line} --threads 1 --out one.parquet")).succeeds();
    assert!(bytes(&folder, "one.parquet") == whole);
    let two = "part-2.parquet part-3.parquet";
    refused(&folder, 3, &format!("simulate plan --out g.parquet --gather {two}"), &["1/3"]);
}

#[test]
fn a_track_that_was_changed_is_refused() {
    let folder = sailed(2);
    let whole = bytes(&folder, "track.parquet");
    let path = folder.path().join("track.parquet");
    for at in [0, 4, whole.len() / 3, whole.len() / 2, whole.len() - 200, whole.len() - 1] {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x10;
        std::fs::write(&path, damaged).unwrap();
        refused(&folder, 3, SIMULATE, &["track.parquet"]);
    }
    for length in [0, 3, 100, whole.len() / 2, whole.len() - 1] {
        std::fs::write(&path, &whole[..length]).unwrap();
        refused(&folder, 3, SIMULATE, &["track.parquet"]);
    }
    std::fs::remove_file(&path).unwrap();
    refused(&folder, 1, SIMULATE, &["track.parquet"]);
}

#[test]
fn a_track_of_another_plan_is_refused() {
    let folder = sailed(2);
    let other = plan_small(&[("heading_deg = 0.0", "heading_deg = 90.0")]);
    std::fs::write(folder.path().join("track.parquet"), other.study.bytes("track.parquet")).unwrap();
    refused(&folder, 3, SIMULATE, &["track.parquet", "plan.json"]);
}

#[test]
fn other_files_in_the_plans_place_are_refused() {
    let folder = sailed(2);
    let copy =
        |from: &str, to: &str| std::fs::copy(folder.path().join(from), folder.path().join(to)).unwrap();
    copy("dictionary.parquet", "track.parquet");
    refused(&folder, 3, SIMULATE, &["track.parquet", "another file than the one written with plan.json"]);
    let folder = sailed(2);
    edit(&folder, "plan.json", "\"status\"", "\"stauts\"");
    refused(&folder, 3, SIMULATE, &["plan.json"]);
    let folder = sailed(2);
    put(&folder, "vessel.toml", "preset = \"ljungberg-model-ship\"\n");
    refused(&folder, 3, &format!("{SIMULATE} --allow=mixed"), &["track.parquet", "kN", "N"]);
    refused(&sailed(2), 2, &SIMULATE.replace("planned.parquet", "plan.json"), &["--out", "plan.json"]);
}

#[test]
fn the_track_is_not_overwritten() {
    refused(
        &sailed(2),
        2,
        &SIMULATE.replace("planned.parquet", "track.parquet"),
        &["--out", "track.parquet"],
    );
}

#[test]
fn a_plan_of_a_lattice_problem_cannot_be_sailed() {
    let folder = sailed(2);
    std::fs::remove_file(folder.path().join("track.parquet")).unwrap();
    std::fs::copy(repository().join("fixtures/lattice/channel.json"), folder.path().join("problem.json"))
        .unwrap();
    run(&folder, "plan --problem problem.json --out plan.json").succeeds();
    refused(&folder, 3, SIMULATE, &["plan.json", "voyage"]);
}
