//! Recordings that lack a kind of files.

use std::fs;

use tempfile::TempDir;

use crate::runner::*;

const CONFIG: [&str; 2] = ["--config", "ingest.toml"];

/// Two recordings, of which one has the roll in a file of its own.
fn two_kinds(optional: &str, names: &[&str]) -> TempDir {
    let text = config("").replace("pattern =", "run_from_file = \"{run}.csv\"\npattern =");
    let roll = format!(
        "[[file]]\npattern = [\"*.roll\"]\nrun_from_file = \"{{run}}.roll\"\n{optional}\
         time = {{ column = \"t\", unit = \"s\" }}\nchannel = [{{ column = \"roll\", channel = \"roll\", unit = \"deg\" }}]\n"
    );
    let row = |t: usize| format!("{t},{}\n", 5.0 + (t % 7) as f64);
    let rolls = "t,roll\n".to_owned() + &(0..20).map(row).collect::<String>();
    let folder = folder(&[("ingest.toml", &(text + &roll)), ("a.csv", &log(20)), ("b.csv", &log(20))]);
    names.iter().for_each(|name| fs::write(folder.path().join(name), &rolls).unwrap());
    folder
}

#[test]
fn a_kind_that_a_recording_lacks_is_named_where_it_is_optional() {
    let remedy = ["ingest.toml: run `b`", "none of `*.roll`", "set `optional = true`"];
    refused_in(two_kinds("", &["a.roll"]).path(), &[], &remedy);
    let made = ingest(two_kinds("optional = true\n", &["a.roll"]).path(), &CONFIG);
    let recordings = &made.summary.recordings;
    assert_eq!((made.rows, recordings.len()), (40, 2), "{}", made.line);
    let said =
        |at: usize| recordings[at].warnings.iter().any(|own| own.text.contains("no files of `*.roll`"));
    assert!(!said(0) && said(1), "{}", made.line);
    let is_null = |row: usize| made.columns["roll"].is_null(row) || made.f64("roll")[row].is_nan();
    assert!(!is_null(3) && (20..40).all(is_null));
    // Nor need any recording have them.
    let none = ingest(two_kinds("optional = true\n", &[]).path(), &CONFIG);
    assert_eq!(none.rows, 40);
    assert!((0..40).all(|row| none.columns["roll"].is_null(row) || none.f64("roll")[row].is_nan()));
}

#[test]
fn what_a_vessel_needs_and_what_all_recordings_lack_is_refused() {
    let text = config("").replace("[[file]]\n", "[[file]]\noptional = true\n");
    refused(&text, &log(20), &["ingest.toml: `optional`", "it in every [[file]]"]);
    let needed = two_kinds("optional = true\n", &["a.roll"]);
    let vessel = "name = \"a\"\nsample_rate_hz = 1.0\ninput = [{ name = \"roll\", unit = \"rad\" }]\n\
         surge = [{ parameter = \"a\", term = \"u\", nominal = -0.1 }, { parameter = \"b\", term = \"roll\", nominal = 0.1 }]\n\
         sway = [{ parameter = \"c\", term = \"v\", nominal = -0.1 }]\nyaw = [{ parameter = \"d\", term = \"r\", nominal = -0.1 }]\n";
    fs::write(needed.path().join("vessel.toml"), vessel).unwrap();
    refused_in(needed.path(), &["--vessel", "vessel.toml"], &["run `b`", "`roll`"]);
}
