//! Sub-experiments.

use crate::runner::*;

const CONFIG: [&str; 2] = ["--config", "ingest.toml"];

fn made(top: &str, more: &str, files: &[(&str, &str)]) -> Made {
    let text = config(top) + more;
    let all = [&[("ingest.toml", text.as_str())], files].concat();
    ingest(folder(&all).path(), &CONFIG)
}

/// Per run: maneuver, first u, rows.
fn runs(made: &Made) -> Vec<(String, f64, usize)> {
    (0..made.summary.runs as i32)
        .map(|run| {
            let rows = made.rows_of(run);
            (made.maneuvers()[rows[0]].to_owned(), made.f64("y_u")[rows[0]], rows.len())
        })
        .collect()
}

#[test]
fn windows_are_runs_of_their_own_named_by_kind_and_speed() {
    let log = log(36);
    let top = "maneuver_from_file = \"{kind}/*\"\nwindow_s = 10\ntail_s = 10\nspeed_classes_m_s = [0.2, 0.3]\neach_segment_is_a_run = true";
    let text = config(top).replace("*.csv", "*/*.csv");
    let made = ingest(folder(&[("ingest.toml", &text), ("zigzag/1.csv", &log)]).path(), &CONFIG);
    let name = |speed: &str| format!("zigzag/{speed}");
    assert_eq!(runs(&made), [(name("slow"), 0.1, 11), (name("medium"), 0.2, 11), (name("fast"), 0.3, 11)]);
    assert_eq!(made.summary.recordings[0].short_segments, 1, "five seconds are left over");
    assert_eq!(made.i32("sample")[11], 0);
    assert!(made.columns["n"].is_null(10) && !made.columns["n"].is_null(11));
}

#[test]
fn windows_may_be_segments_of_one_run() {
    let made = made("window_s = 10", "", &[("a.csv", &log(31))]);
    assert_eq!((made.summary.runs, made.rows), (1, 31));
    assert_eq!(made.i32("segment")[..12], [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1]);
    assert_eq!(made.i32("segment")[30], 2, "the last row belongs to the last segment");
}

#[test]
fn a_tail_that_is_long_enough_is_a_last_shorter_window() {
    for (tail, rows, short) in [("tail_s = 5", 36, 0), ("tail_s = 5.5", 31, 1), ("", 36, 0)] {
        let made = made(&format!("window_s = 10\n{tail}"), "", &[("a.csv", &log(36))]);
        let recording = &made.summary.recordings[0];
        assert_eq!((made.rows, recording.short_segments), (rows, short), "{tail}");
        assert_eq!(recording.left_out_s, 5.0 * short as f64, "{tail}");
        assert!(made.line.contains(&format!("{} s in no run", 5 * short)), "{}", made.line);
        assert_eq!(made.i32("segment")[30..].last(), Some(&(2 + i32::from(short == 0))));
    }
    // Two seconds are less than a quarter of a window.
    assert_eq!(made("window_s = 10", "", &[("a.csv", &log(33))]).summary.recordings[0].left_out_s, 2.0);
}

#[test]
fn intervals_are_cut_out_by_name_of_the_recording() {
    let segment = |run: &str, from: u32, to: u32, maneuver: &str| {
        format!("[[segment]]\nrun = \"{run}\"\nfrom_s = {from}\nto_s = {to}\nmaneuver = \"{maneuver}\"\n")
    };
    let more = segment("b", 20, 25, "late")
        + &segment("b", 5, 10, "early")
        + &segment("b", 10, 12, "next")
        + &segment("a", 0, 1, "short");
    let made = made("min_s = 2", &more, &[("a.csv", &log(31)), ("b.csv", &log(31))]);
    let expected = [("early".to_owned(), 0.15, 8), ("late".to_owned(), 0.3, 6)];
    assert_eq!(runs(&made), expected);
    assert_eq!(made.maneuvers()[6], "next");
    assert_eq!(made.summary.recordings[0].short_segments, 1);
    assert!(made.summary.recordings[0].runs.is_empty());
}

#[test]
fn a_recording_is_named_by_its_file_unless_said_otherwise() {
    let files = [("b.csv", log(5)), ("a.csv", log(5))];
    let files = files.each_ref().map(|(name, text)| (*name, text.as_str()));
    assert_eq!(
        made("", "", &files).summary.maneuvers.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(),
        ["a", "b"]
    );
    assert_eq!(made("maneuver = \"drift\"", "", &files).summary.maneuvers[0].segments, 2);
}
