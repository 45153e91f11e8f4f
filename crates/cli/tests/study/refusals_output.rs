//! Command lines, shards and outputs that are refused or fail, and the files they leave.

use std::fs;

use tempfile::TempDir;

use crate::support::*;

/// The inputs of each stage.
const READ: [&str; 7] = [
    "dictionary.parquet",
    "moments.json",
    "design.json",
    "campaign.parquet",
    "validation.parquet",
    "estimates.parquet",
    "scores.parquet",
];

#[test]
fn command_lines_that_say_too_little_or_too_much_are_refused() {
    let folder = with(&READ);
    for stage in STAGES {
        let (line, _) = stage.rsplit_once(" --out ").unwrap();
        refused(&folder, 2, line, &["required arguments", "--out", "--help"]);
        refused(&folder, 2, &format!("{stage} --colour"), &["--colour", "--help"]);
        refused(&folder, 2, &format!("{stage} --threads 0"), &["--threads", "0"]);
        refused(&folder, 2, &format!("{stage} --seed x"), &["--seed", "x"]);
    }
    run(&folder, "simulate").refuses(2, &["subcommand"]);
    refused(&folder, 2, "simulate dictionry", &["dictionry", "dictionary"]);
    refused(&folder, 2, &format!("{DESIGN} --duration-s 0"), &["--duration-s", "above 0"]);
    refused(&folder, 2, &format!("{DESIGN} --duration-s nan"), &["--duration-s", "NaN"]);
    refused(&folder, 2, &format!("{DESIGN} --segments 5"), &["--segment-samples"]);
    refused(&folder, 2, &format!("{DESIGN} --segments 0 --segment-samples 200"), &["--segments", "0"]);
}

/// Stages, each with one of its inputs.
const INPUTS: [(&str, &str); 6] = [
    (DICTIONARY, "vessel.toml"),
    (MOMENTS, "dictionary.parquet"),
    (DESIGN, "moments.json"),
    (CAMPAIGN, "design.json"),
    (ESTIMATE, "campaign.parquet"),
    (VALIDATE, "estimates.parquet"),
];

#[test]
fn an_output_that_is_also_an_input_is_refused() {
    let folder = with(&READ);
    for (stage, input) in INPUTS {
        let (line, _) = stage.rsplit_once(" --out ").unwrap();
        refused(&folder, 2, &format!("{line} --out {input}"), &["--out", input, "also an input"]);
    }
}

#[test]
fn an_output_that_is_named_as_another_kind_of_file_is_refused() {
    let folder = with(&READ);
    for stage in STAGES {
        let (line, out) = stage.rsplit_once(" --out ").unwrap();
        let (name, own) = out.rsplit_once('.').unwrap();
        for other in ["json", "parquet", "csv", "toml", "PARQUET"] {
            if !other.eq_ignore_ascii_case(own) {
                let (found, better) = (format!("{name}2.{other}"), format!("write --out {name}2.{own}"));
                refused(&folder, 2, &format!("{line} --out {found}"), &["--out", &found, &better]);
            }
        }
    }
}

#[cfg(unix)]
#[test]
fn names_that_are_no_text_are_read_and_written() {
    use std::os::unix::ffi::OsStringExt;
    let folder = with(&READ);
    let odd = |name: &str| {
        let bytes = name.bytes().map(|b| if b == b'?' { 0xff } else { b }).collect();
        std::ffi::OsString::from_vec(bytes)
    };
    for (stage, input) in INPUTS {
        let (line, out) = stage.rsplit_once(" --out ").unwrap();
        let (name, end) = input.split_once('.').unwrap();
        let renamed = odd(&format!("{name}?.{end}"));
        fs::copy(folder.path().join(input), folder.path().join(&renamed)).unwrap();
        let out = odd(&out.replacen('.', "?.", 1));
        for json in [None, Some("--json")] {
            let words = line.split_whitespace().map(|word| match word == input {
                true => renamed.clone(),
                false => word.into(),
            });
            let mut command = std::process::Command::new(SEATRIAL);
            command.args(words).arg("--out").arg(&out).args(json).current_dir(&folder);
            let ended = command.output().unwrap();
            let said = String::from_utf8_lossy(&ended.stderr).into_owned();
            assert_eq!(ended.status.code(), Some(0), "{stage}: {said}");
            assert!(std::str::from_utf8(&ended.stdout).is_ok());
            assert!(folder.path().join(&out).is_file(), "{stage}");
        }
        let mut command = std::process::Command::new(SEATRIAL);
        let absent = odd("absent?.toml");
        let words =
            line.split_whitespace().map(|word| if word == input { absent.clone() } else { word.into() });
        let ended = command.args(words).arg("--out").arg("x").current_dir(&folder).output().unwrap();
        let said = String::from_utf8(ended.stderr).unwrap();
        assert_eq!((ended.status.code(), said.lines().count()), (Some(1), 1), "{stage}: {said}");
        assert!(said.contains("absent\u{fffd}.toml"), "{said}");
    }
}

#[test]
fn impossible_shards_are_refused() {
    let folder = with(&READ);
    for stage in [DICTIONARY, MOMENTS, CAMPAIGN, ESTIMATE, VALIDATE] {
        for shard in ["5/4", "0/4", "1/0", "1", "a/b", "-1/4", "1/4/4", "1/99999999999"] {
            refused(&folder, 2, &format!("{stage} --shard={shard}"), &["--shard", shard, "1 <= K <= N"]);
        }
        let both = format!("{stage} --shard 1/2 --gather part.parquet");
        refused(&folder, 2, &both, &["--shard", "--gather"]);
    }
    for stage in [DESIGN, VALIDATION, REPORT] {
        refused(&folder, 2, &format!("{stage} --shard 1/2"), &["--shard"]);
    }
}

/// A folder with campaign shards 1 to 3 of 3, 1 of 3 with another seed, and 1 of 2.
fn shards() -> TempDir {
    let folder = with(&READ);
    let (line, _) = CAMPAIGN.split_once(" --out ").unwrap();
    let shard =
        |name: &str, flags: &str| drop(run(&folder, &format!("{line} --out {name} {flags}")).succeeds());
    shard("a.parquet", "--shard 1/3");
    shard("b.parquet", "--shard 2/3");
    shard("c.parquet", "--shard 3/3");
    shard("seed.parquet", "--shard 1/3 --seed 2");
    shard("half.parquet", "--shard 1/2");
    folder
}

#[test]
fn sets_of_shards_that_do_not_fit_are_refused() {
    let folder = shards();
    let gather = |files: &str| format!("simulate campaign --out all.parquet --gather {files}");
    refused(&folder, 3, &gather("a.parquet c.parquet"), &["a.parquet", "shard", "2", "3 shards"]);
    refused(&folder, 3, &gather("b.parquet"), &["b.parquet", "1", "3", "3 shards"]);
    let twice = gather("a.parquet b.parquet b.parquet c.parquet");
    refused(&folder, 3, &twice, &["a.parquet", "2", "3 shards"]);
    let seed = gather("seed.parquet b.parquet c.parquet");
    refused(&folder, 3, &seed, &["settings.seed", "1", "2", "one computation"]);
    let half = gather("half.parquet b.parquet c.parquet");
    refused(&folder, 3, &half, &["number of shards", "one computation"]);
    let whole = gather("campaign.parquet a.parquet b.parquet");
    refused(&folder, 3, &whole, &["campaign.parquet", "a whole file", "--shard"]);
    let kind = gather("estimates.parquet");
    refused(&folder, 3, &kind, &["estimates.parquet", "estimates/1", "trajectories/1"]);
    refused(&folder, 1, &gather("a.parquet none.parquet"), &["none.parquet", "an existing file"]);
}

#[test]
fn a_shard_in_the_place_of_the_whole_is_refused() {
    let folder = shards();
    let line = ESTIMATE.replace("campaign.parquet", "a.parquet");
    refused(&folder, 3, &line, &["a.parquet", "shard 1/3", "--gather"]);
    let (estimate, _) = ESTIMATE.split_once(" --out ").unwrap();
    run(&folder, &format!("{estimate} --out part.parquet --shard 1/2")).succeeds();
    let line = VALIDATE.replace("estimates.parquet", "part.parquet");
    refused(&folder, 3, &line, &["part.parquet", "shard 1/2", "--gather"]);
    let line = MOMENTS.replace("dictionary.parquet", "a.parquet");
    refused(&folder, 3, &line, &["a.parquet", "shard 1/3", "--gather"]);
    let line = VALIDATE.replace("validation.parquet", "a.parquet");
    refused(&folder, 3, &line, &["a.parquet", "shard 1/3", "--gather"]);
}

#[test]
fn outputs_that_cannot_be_written_fail() {
    let folder = with(&READ);
    put(&folder, "file", "");
    for stage in STAGES {
        let (line, name) = stage.rsplit_once(' ').unwrap();
        refused(
            &folder,
            1,
            &format!("{line} none/{name}"),
            &["none", "an existing folder", "create the folder"],
        );
        refused(&folder, 1, &format!("{line} file/{name}"), &["file", "create"]);
        refused(&folder, 1, &format!("{line} file/"), &["file", "create"]);
    }
}

#[test]
fn a_second_output_that_cannot_be_written_takes_the_first_with_it() {
    for (stage, second) in [(ESTIMATE, "estimate.json"), (VALIDATE, "validation.json")] {
        let folder = with(&READ);
        let out = stage.rsplit_once(' ').unwrap().1;
        if out == "scores.parquet" {
            fs::remove_file(folder.path().join(out)).unwrap();
        }
        fs::create_dir(folder.path().join(second)).unwrap();
        refused(&folder, 1, stage, &[second, "name a file"]);
    }
}

#[test]
fn a_full_disk_fails_and_leaves_nothing() {
    let folder = with(&READ);
    for stage in [DICTIONARY, CAMPAIGN, VALIDATION, REPORT] {
        let before = listing(folder.path());
        let ran = run_on_full_disk(&folder, &format!("{stage} --quiet"));
        let ran = ran.refuses(1, &["write", "room on the disk"]);
        assert!(!ran.stderr.contains("unfinished"), "{ran}");
        assert_eq!(listing(folder.path()), before, "the folder changed{ran}");
    }
}

#[test]
fn estimates_without_a_known_truth_are_scored_by_simulation_alone() {
    let folder = with(&READ);
    let vessel = fs::read_to_string(repository().join("pipelines/paper/vessel.toml")).unwrap();
    let kept: Vec<&str> = vessel.lines().filter(|line| !line.starts_with("value =")).collect();
    put(&folder, "vessel.toml", &kept.join("\n"));
    run(&folder, &format!("{ESTIMATE} --allow=mixed")).succeeds();
    run(&folder, &format!("{VALIDATE} --allow=mixed")).succeeds();
    let estimate = json(&folder, "estimate.json");
    assert!(estimate["data"]["designs"][0]["parameters"][0]["truth"].is_null());
    let scores = craft::read(&folder.path().join("scores.parquet"), "scores");
    let columns = &scores.blocks[0].columns;
    let place = |name: &str| scores.schema.columns.iter().position(|c| c.name == name).unwrap();
    assert_eq!(columns[place("parameter_error")].nulls(), 3 * RUNS as usize);
    let validation = json(&folder, "validation.json");
    let designs = validation["data"]["scored"]["designs"].as_array().unwrap();
    let diverged: u64 = designs.iter().map(|design| design["diverged"].as_u64().unwrap()).sum();
    assert_eq!(columns[place("simulation_error")].nulls() as u64, diverged);
    assert!(diverged < RUNS / 2);
    let design = &designs[0];
    assert!(design["parameter_error"]["median"].is_null() && design["rmse_u"]["median"].is_number());
    refused(&folder, 3, &format!("{CAMPAIGN} --allow=mixed"), &["vessel.toml", "no `value`", "`X_u`"]);
}
