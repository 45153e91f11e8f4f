//! Logs on which other programs failed, of `../shared/cases` and `../shared/cases-2`: without that folder these tests say so and pass. Other logs of the same
//! kinds are made in the tests of each kind.

use std::fs;
use std::path::PathBuf;

use tempfile::TempDir;

use crate::known::{COLUMNS, heading, motion, revolutions, rudder};
use crate::runner::*;

/// A copy of a case with `from` in its configuration replaced by `to`.
fn changed(case: &str, from: &str, to: &str) -> Option<TempDir> {
    let set = if case.contains('-') { "../shared/cases-2" } else { "../shared/cases" };
    copied(set, case, from, to)
}

fn copied(cases: &str, case: &str, from: &str, to: &str) -> Option<TempDir> {
    let own: PathBuf = repository(cases).join(case);
    if !own.is_dir() {
        eprintln!("skipped: there is no {}", own.display());
        return None;
    }
    let copy = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(own).unwrap() {
        let path = entry.unwrap().path();
        fs::write(copy.path().join(path.file_name().unwrap()), fs::read(&path).unwrap()).unwrap();
    }
    let config = copy.path().join("ingest.toml");
    let text = fs::read_to_string(&config).unwrap();
    assert!(text.contains(from), "case {case} has no `{from}`");
    fs::write(config, text.replacen(from, to, 1)).unwrap();
    Some(copy)
}

fn case(case: &str) -> Option<TempDir> {
    changed(case, "sample_rate_hz", "sample_rate_hz")
}

fn made(folder: &TempDir) -> Made {
    ingest(folder.path(), &["--config", "ingest.toml"])
}

/// What a channel should be at `t`.
fn truth(name: &str, t: f64) -> f64 {
    let [u, v, r] = motion(t);
    match name {
        "y_u" => u,
        "y_v" => v,
        "y_r" => r,
        "psi" => heading(t),
        "delta" => rudder(t).to_radians(),
        _ => revolutions(t) / 60.0,
    }
}

/// Every run must be the motion from some second on: states within 0.02 m/s and 0.002 rad/s, inputs within 2 % of
/// their range. Parts of the log have no quiet segments to compensate for fast ones: 0.03 m/s. Returns the second
/// from which each run is the motion.
#[track_caller]
fn the_motion(made: &Made) -> Vec<usize> {
    assert_eq!(COLUMNS.len(), 6);
    let own = |run: i32, speed: f64| {
        let rows = made.rows_of(run);
        let off = |name: &str, from: usize| {
            // Slopes of places are worse at the ends, with neighbours on one side only.
            let inner = &rows[2..rows.len() - 2];
            let known = inner.iter().filter(|row| made.f64(name)[**row].is_finite());
            let squares: Vec<f64> = known
                .map(|row| (made.f64(name)[*row] - truth(name, from as f64 + made.f64("t")[*row])).powi(2))
                .collect();
            (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
        };
        let all = |from: &usize| off("y_u", *from) + off("y_v", *from) + 10.0 * off("y_r", *from);
        let from = (0..=60).min_by(|a, b| all(a).total_cmp(&all(b))).unwrap();
        for (name, most) in [("y_u", speed), ("y_v", speed), ("y_r", 0.002), ("delta", 0.01), ("n", 0.04)] {
            assert!(off(name, from) < most, "run {run}: {name} is {} off\n{}", off(name, from), made.line);
        }
        from
    };
    let mut runs: Vec<i32> = made.i32("run").to_vec();
    runs.dedup();
    runs.iter().map(|run| own(*run, if runs.len() == 1 { 0.02 } else { 0.03 })).collect()
}

/// Read as the motion from its beginning to its end, in one run.
#[track_caller]
fn whole(folder: &TempDir) -> Made {
    let made = made(folder);
    assert_eq!(the_motion(&made), [0], "{}", made.line);
    assert_eq!(made.rows, 61, "{}", made.line);
    made
}

fn omitted(made: &Made) -> u64 {
    made.summary
        .recordings
        .iter()
        .flat_map(|recording| &recording.omitted)
        .map(|omission| omission.count)
        .sum()
}

#[test]
fn a_place_has_the_time_of_its_own_sentence_wherever_that_stands() {
    let Some(folder) = case("06") else { return };
    whole(&folder);
}

#[test]
fn two_talkers_of_a_heading_are_refused() {
    let Some(folder) = case("08") else { return };
    refused_in(folder.path(), &[], &["HEHDT", "GPHDT"]);
    let Some(folder) = changed("08", "HDT.heading", "HEHDT.heading") else { return };
    whole(&folder);
}

#[test]
fn a_magnetic_heading_is_refused_and_the_remedy_leads_to_the_true_one() {
    let Some(folder) = case("11") else { return };
    refused_in(folder.path(), &[], &["HDG.magnetic", "HDG.heading"]);
    let Some(folder) = changed("11", "HDG.magnetic", "HDG.heading") else { return };
    whole(&folder);
}

#[test]
fn places_of_dead_reckoning_are_left_out_and_counted() {
    let Some(folder) = case("12") else { return };
    let made = made(&folder);
    assert!(the_motion(&made).len() >= 2, "{}", made.line);
    assert!(omitted(&made) >= 24, "{}", made.line);
}

#[test]
fn fixes_off_africa_are_left_out_and_counted() {
    let Some(folder) = case("13") else { return };
    let made = made(&folder);
    the_motion(&made);
    assert!(omitted(&made) >= 3, "{}", made.line);
}

#[test]
fn what_stands_for_no_value_is_none() {
    for (case, column, key) in [("15", "psi", "65535"), ("17", "delta", "-9999")] {
        let Some(folder) = self::case(case) else { return };
        let ran = run(folder.path(), &["--config", "ingest.toml", "--out", "t.parquet"]);
        let told = format!("{}{}", ran.stdout, ran.stderr);
        assert!(ran.code == Some(3) || told.contains("left out"), "{told}");
        assert!(told.contains(column), "{told}");
        let line = format!("column = \"{column}\",");
        let Some(folder) = changed(case, &line, &format!("{line} missing = [{key}],")) else { return };
        let made = self::made(&folder);
        the_motion(&made);
        assert!(omitted(&made) > 0, "{}", made.line);
    }
}

#[test]
fn text_is_read_however_its_lines_end_and_whatever_has_no_checksum() {
    for case in ["18", "19", "26", "27", "35"] {
        let Some(folder) = self::case(case) else { return };
        whole(&folder);
    }
}

#[test]
fn times_of_day_pass_midnight() {
    let Some(folder) = case("20") else { return };
    whole(&folder);
    let Some(folder) = changed("20", "max_gap_s", "non_monotonic = \"drop\"\nmax_gap_s") else { return };
    whole(&folder);
}

#[test]
fn a_counter_that_wraps_goes_on_or_its_rows_are_counted() {
    let Some(folder) = case("22") else { return };
    let made = made(&folder);
    the_motion(&made);
    assert!(made.rows == 61 || made.line.contains("31 rows"), "{}", made.line);
}

#[test]
fn seconds_without_a_fix_are_a_gap() {
    let Some(folder) = case("23") else { return };
    let from = the_motion(&made(&folder));
    assert_eq!(from.len(), 2, "{from:?}");
}

#[test]
fn what_was_logged_before_the_clock_was_set_is_left_out() {
    let Some(folder) = case("25") else { return };
    let made = made(&folder);
    assert_eq!(the_motion(&made), [0]);
    let rows = made.summary.recordings[0].rows;
    assert!(rows.without_time > 0 || omitted(&made) > 0, "{rows:?}");
}

#[test]
fn a_sentence_from_before_midnight_that_comes_late_makes_no_day() {
    let Some(folder) = case("30") else { return };
    let made = made(&folder);
    the_motion(&made);
    assert!(made.rows >= 59 && made.summary.recordings[0].duration_s < 61.0, "{}", made.line);
}

#[test]
fn a_leap_second_is_a_second() {
    let Some(folder) = case("31") else { return };
    whole(&folder);
}

#[test]
fn typed_times_split_bags_and_any_compression_are_read() {
    for case in ["32", "37"] {
        let Some(folder) = self::case(case) else { return };
        whole(&folder);
    }
    // Its bags hold no heading.
    let Some(folder) = case("34") else { return };
    let made = made(&folder);
    assert_eq!((the_motion(&made), made.rows), (vec![0], 61), "{}", made.line);
}

#[test]
fn bags_of_elements_without_bytes_end() {
    for case in ["b-dynamic", "b-nothing", "u-nothing", "u-padding"] {
        let Some(folder) = copied("../shared/cases-2/faults", case, "sample", "sample") else { return };
        let pieces = [": message 1 of topic `", "elements without end", "elements that take bytes"];
        refused_in(folder.path(), &["--memory-mib", "256"], &pieces);
    }
    let Some(folder) = copied("../shared/cases-2/faults", "c-census", "sample", "sample") else { return };
    let bag = fs::read(folder.path().join("a.bag")).unwrap();
    let said = crate::bags::new_refuses("a.bag", &bag);
    assert!(said.contains("a.bag: definitions: found definitions of more elements"), "{said}");
}

#[test]
fn topics_whose_clocks_never_meet_are_refused_with_both_spans() {
    let Some(folder) = case("55-two-clocks") else { return };
    refused_in(folder.path(), &[], &["`delta`, `n` from 2025-", "from 1970-01-01", "log_time"]);
    let Some(folder) = changed("55-two-clocks", "header.stamp", "log_time") else { return };
    the_motion(&made(&folder));
}

#[test]
fn a_topic_that_covers_another_time_than_the_others_is_named_with_both_spans() {
    let Some(folder) = case("65-topic-20s-late") else { return };
    let made = made(&folder);
    for piece in ["40.0 s of 80.0 s (50 %)", "`delta`, `n` from 2025-", "are not covered by all"] {
        assert!(made.line.contains(piece), "{}", made.line);
    }
}

#[test]
fn a_bag_whose_recorder_died_is_refused_with_what_mends_it() {
    let Some(folder) = case("64-bag-active") else { return };
    refused_in(folder.path(), &[], &["a.bag.active", "rosbag reindex"]);
}

#[test]
fn a_unit_that_changes_within_a_log_is_named_with_its_place_and_ratio() {
    let Some(folder) = case("90-unit-changes-midway") else { return };
    let made = made(&folder);
    for piece in ["doubtful", "`delta` is 57.296 times smaller from 30.0 s"] {
        assert!(made.line.contains(piece), "{}", made.line);
    }
}

#[test]
fn a_compass_without_variation_is_refused_and_the_remedy_leads_to_the_heading() {
    let Some(folder) = case("91-hdg-variation-in-deviation") else { return };
    refused_in(folder.path(), &[], &["HDG.heading", "no variation", "HEHDG", "HDG.magnetic"]);
    let from = "HDG.heading\", channel = \"psi\", unit = \"deg\"";
    let to = "HDG.magnetic\", channel = \"psi\", unit = \"deg\", offset = -0.261799";
    let Some(folder) = changed("91-hdg-variation-in-deviation", from, to) else { return };
    whole(&folder);
}
