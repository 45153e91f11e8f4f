//! Clocks that restart, have a second 60, are set late or printed without zeros; recordings in several files.

use crate::known::*;
use crate::runner::*;

/// The healthy table with other times, read by the keys `time` of its clock and `top` before the files.
fn timed(time: &str, top: &str, of: impl Fn(usize) -> String) -> Made {
    let config = table_config("*.csv", time, top);
    read(folder(&[("ingest.toml", &config), ("a.csv", &csv(60, of))]).path())
}

/// `hh:mm:ss` of a second of the day.
fn of_day(second: usize) -> String {
    let second = second % 86_400;
    format!("{:02}:{:02}:{:02}", second / 3600, second / 60 % 60, second % 60)
}

#[test]
fn times_of_a_day_pass_midnight() {
    for top in ["", "non_monotonic = \"drop\"", "non_monotonic = \"sort\""] {
        let made = timed("format = \"%H:%M:%S\"", top, |k| of_day(86_380 + k));
        healthy(&made, 61);
        assert_eq!(made.summary.recordings[0].rows.rollovers, 1);
        assert!(
            made.line.contains("; 0 rows dropped") && made.line.contains("clock rollovers"),
            "{}",
            made.line
        );
    }
    // A row that comes late across midnight is put in order, and 61 rows are there.
    let late = |k: usize| of_day(86_380 + [k, 20, 19][if k == 19 { 1 } else { 2 * usize::from(k == 20) }]);
    let swapped = timed("format = \"%H:%M:%S\"", "non_monotonic = \"sort\"", late);
    assert_eq!((swapped.rows, swapped.summary.recordings[0].rows.sorted), (61, 1));
    let config = table_config("*.csv", "format = \"%H:%M:%S\"", "");
    refused(&config, &csv(60, late), &["a.csv: line", "column `t`", "time that does not go backwards"]);
    let back = csv(60, |k| of_day(if k < 30 { 40_000 + k } else { 39_000 + k }));
    refused(&config, &back, &["a.csv: line 32", "time that does not go backwards"]);
}

#[test]
fn counters_that_begin_anew_are_counted_on() {
    let bits = |bits: u32| 1_u64 << bits;
    for (unit, per_second, period) in [
        ("ms", 1000, bits(32)),
        ("ms", 1000, bits(31)),
        ("us", 1_000_000, bits(32)),
        ("us", 1_000_000, bits(31)),
        ("ms", 1000, bits(16)),
        ("s", 1, bits(16)),
        ("s", 1, bits(32)),
        ("s", 1, 604_800),
        ("ms", 1000, 604_800_000),
        ("s", 1, 86_400),
    ] {
        let now = |k: usize| period - 30 * per_second + k as u64 * per_second;
        for top in ["", "non_monotonic = \"drop\""] {
            let made = timed(&format!("unit = \"{unit}\""), top, |k| (now(k) % period).to_string());
            println!("{unit}, {period}");
            healthy(&made, 61);
            assert_eq!(made.summary.recordings[0].rows.rollovers, 1);
        }
        let half = period as i64 / 2;
        let signed = |k: usize| (now(k) as i64 + half).rem_euclid(period as i64) - half;
        healthy(&timed(&format!("unit = \"{unit}\""), "", |k| signed(k).to_string()), 61);
    }
}

#[test]
fn rows_that_go_backwards_are_counted_as_dropped() {
    let back = |k: usize| if k < 30 { k.to_string() } else { (k - 25).to_string() };
    let made = timed("unit = \"s\"", "non_monotonic = \"drop\"", back);
    assert_eq!((made.rows, made.summary.recordings[0].rows.backwards), (36, 24));
    assert!(made.line.contains("; 25 rows dropped"), "{}", made.line);
}

#[test]
fn a_second_60_is_a_second_of_its_own() {
    let stamp = |k: usize, day: bool| {
        let (date, time) = match k {
            ..20 => ("2016-12-31T", of_day(86_380 + k)),
            20 => ("2016-12-31T", "23:59:60".to_owned()),
            _ => ("2017-01-01T", of_day(k - 21)),
        };
        if day { format!("{date}{time}Z") } else { time }
    };
    for made in [
        timed("unit = \"iso8601\"", "", |k| stamp(k, true)),
        timed("format = \"%Y-%m-%dT%H:%M:%SZ\"", "", |k| stamp(k, true)),
        timed("format = \"%H:%M:%S\"", "", |k| stamp(k, false)),
    ] {
        healthy(&made, 61);
        assert_eq!(made.summary.recordings[0].rows.leap_seconds, 1);
        assert!(made.line.contains("1 leap seconds"), "{}", made.line);
    }
    // Decimals of 60 are none.
    let made = timed("unit = \"iso8601\"", "", |k| {
        format!("2016-12-31T23:58:{:02}.60", k.min(59)).replace(":59.60", ":59.61")
    });
    assert_eq!(made.summary.recordings[0].rows.leap_seconds, 0);
}

#[test]
fn a_leap_second_that_another_file_of_the_recording_does_not_have_is_refused() {
    let stamp = |k: usize| match k {
        ..20 => format!("2016-12-31T{}Z", of_day(86_380 + k)),
        20 => "2016-12-31T23:59:60Z".to_owned(),
        _ => format!("2017-01-01T{}Z", of_day(k - 21)),
    };
    let config = table_config("u_*.csv", "unit = \"iso8601\"", "")
        .replace("time =", "run_from_file = \"u_{run}.csv\"\ntime =")
        + "[[file]]\npattern = [\"w_*.csv\"]\nrun_from_file = \"w_{run}.csv\"\ntime = { column = \"t\", unit = \"iso8601\" }\n\
           channel = [{ column = \"w\", channel = \"w\", unit = \"m/s\" }]\n";
    let winds: String = (0..60).map(|k| format!("2017-01-01T{}Z,{k}\n", of_day(86_380 + k))).collect();
    let winds = "t,w\n".to_owned() + &winds.replace("2017-01-01T23", "2016-12-31T23");
    let folder = folder(&[("ingest.toml", &config), ("u_a.csv", &csv(60, stamp)), ("w_a.csv", &winds)]);
    refused_in(folder.path(), &[], &["run `a`", "second 60", "cut"]);
}

#[test]
fn decimals_without_leading_zeros_are_read_as_numbers() {
    for unit in [1_000_000_000_u64, 1_000_000, 1000] {
        // Some milliseconds off a tenth of a second.
        let now = |k: usize| (1_700_000_000 + k as u64) * unit + (k as u64 * 7 % 13) * unit / 500;
        let printed = |k: usize| format!("{}.{}", now(k) / unit, now(k) % unit);
        let made = timed("unit = \"s\"", "", printed);
        healthy(&made, 61);
        assert!(made.summary.recordings[0].rows.unpadded > 10 && made.line.contains("without leading zeros"));
        let of_day = |k: usize| format!("{}.{}", of_day(40_000 + k), now(k) % unit);
        let made = timed("format = \"%H:%M:%S.%f\"", "", of_day);
        healthy(&made, 61);
        assert!(made.summary.recordings[0].rows.unpadded > 10);
    }
    let short = timed("unit = \"s\"", "", |k| format!("{}", 10.0 + k as f64 + [0.0, 0.001, 0.01][k % 3]));
    assert_eq!(short.summary.recordings[0].rows.unpadded, 0);
    healthy(&short, 61);
}

#[test]
fn rows_before_the_clock_is_set_are_left_out_and_counted() {
    for (keys, unset, set) in [
        ("unit = \"iso8601\"", "1970-01-01T00:00:", "2025-04-11T12:08:"),
        ("unit = \"iso8601\"", "1980-01-06T00:00:", "2025-04-11T12:08:"),
    ] {
        let made = timed(keys, "", |k| match k {
            ..10 => format!("{unset}{:02}Z", k + 10),
            _ => format!("{set}{:02}Z", k.min(69) - 10),
        });
        let rows = made.summary.recordings[0].rows;
        assert_eq!((made.rows, rows.unset, rows.without_time), (51, 10, 0));
        let [u, v, r] = off(&made, 10.0);
        assert!(
            u < 0.02 && v < 0.02 && r < 0.002 && made.line.contains("; 10 rows dropped"),
            "{}",
            made.line
        );
    }
    let made =
        timed("unit = \"s\"", "", |k| if k < 10 { k.to_string() } else { (1_744_373_300 + k).to_string() });
    assert_eq!((made.rows, made.summary.recordings[0].rows.unset), (51, 10));
    let config = table_config("*.csv", "unit = \"s\"", "");
    let years = csv(60, |k| (1_500_000_000 + k + if k < 30 { 0 } else { 100_000_000 }).to_string());
    refused(&config, &years, &["a.csv: line 32", "years later", "cut the file there"]);
}

/// The healthy table cut into files after these seconds.
fn parts(ends: &[usize], time: impl Fn(usize) -> String) -> Vec<String> {
    let table = csv(60, time);
    let (header, rows) = table.split_once('\n').unwrap();
    let rows: Vec<&str> = rows.lines().collect();
    let starts = [0].into_iter().chain(ends.iter().copied());
    let ends = ends.iter().copied().chain([61]);
    starts.zip(ends).map(|(a, b)| format!("{header}\n{}\n", rows[a..b].join("\n"))).collect()
}

#[test]
fn files_of_one_run_are_one_recording() {
    let config = |time: &str| {
        table_config("*.csv", time, "").replace("time =", "run_from_file = \"{run}_*.csv\"\ntime =")
    };
    for (time, of) in [
        ("unit = \"s\"", (|k: usize| k.to_string()) as fn(usize) -> String),
        ("format = \"%H:%M:%S\"", |k| of_day(86_380 + k)),
        ("unit = \"ms\"", |k| ((4_294_937_296 + 1000 * k as u64) % 4_294_967_296).to_string()),
    ] {
        let parts = parts(&[7, 20, 41], of);
        // Not in the order of their letters.
        let names = ["trial_9.csv", "trial_10.csv", "trial_11.csv", "trial_100.csv"];
        let mut files = vec![("ingest.toml", config(time))];
        files.extend(names.into_iter().zip(parts));
        let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (*name, text.as_str())).collect();
        let made = read(folder(&files).path());
        healthy(&made, 61);
        let recordings = &made.summary.recordings;
        assert_eq!(
            (recordings.len(), recordings[0].name.as_str(), recordings[0].files.len()),
            (1, "trial", 4)
        );
    }
    // Names in another order than the times.
    let parts = parts(&[30], |k| k.to_string());
    let config = config("unit = \"s\"");
    let other = [("ingest.toml", config.as_str()), ("trial_b.csv", &parts[0]), ("trial_a.csv", &parts[1])];
    healthy(&read(folder(&other).path()), 61);
    let wrong = parts[1].replacen(",1.", ",x1.", 1);
    let other = [("ingest.toml", config.as_str()), ("trial_0.csv", &parts[0]), ("trial_1.csv", &wrong)];
    refused_in(folder(&other).path(), &[], &["trial_1.csv: line 2, column `u`"]);
}

#[test]
fn files_of_one_run_that_were_logged_side_by_side_are_refused() {
    let config = table_config("*.csv", "unit = \"s\"", "non_monotonic = \"drop\"")
        .replace("time =", "run_from_file = \"{run}_*.csv\"\ntime =");
    let table = csv(60, |k| k.to_string());
    let files = [("ingest.toml", config.as_str()), ("a_0.csv", &table), ("a_1.csv", &table)];
    refused_in(folder(&files).path(), &[], &["files of one recording", "`a_1.csv`", "follow each other"]);
}
