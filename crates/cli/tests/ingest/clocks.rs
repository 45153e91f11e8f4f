//! Clocks as logs have them: text in any format, two columns, stamps coarser than the rows.

use crate::runner::*;

const CONFIG: [&str; 2] = ["--config", "ingest.toml"];

/// A configuration whose time is declared by `keys`.
fn timed(keys: &str) -> String {
    config("")
        .replace("time = { column = \"t\", unit = \"s\" }", &format!("time = {{ column = \"t\", {keys} }}"))
}

/// [`log`] of `rows` seconds with times as `stamp` writes them.
fn stamped(rows: usize, stamp: impl Fn(usize) -> String) -> String {
    let line = |(k, line): (usize, &str)| match line.split_once(',') {
        Some((_, rest)) if k > 0 => format!("{},{rest}\n", stamp(k - 1)),
        _ => format!("{line}\n"),
    };
    log(rows).lines().enumerate().map(line).collect()
}

fn made(config: &str, csv: &str) -> Made {
    ingest(folder(&[("ingest.toml", config), ("a.csv", csv)]).path(), &CONFIG)
}

#[test]
fn times_in_a_stated_format_are_read() {
    for (keys, head) in [
        ("format = \"%Y/%m/%d %H:%M:%S%.f\"", "2025/04/11 12:08:"),
        ("format = \"%d.%m.%Y %H:%M:%S\", zone = \"Europe/Helsinki\"", "11.04.2025 12:08:"),
        ("unit = \"iso8601\", zone = \"+03:00\"", "2025-04-11T12:08:"),
    ] {
        let made = made(&timed(keys), &stamped(8, |t| format!("{head}{:02}", 20 + t)));
        assert_eq!((made.rows, made.f64("y_u")[7]), (8, 0.17), "{keys}");
    }
}

#[test]
fn a_time_that_fits_its_format_only_in_part_is_refused() {
    let text = timed("format = \"%Y/%m/%d %H:%M:%S\"");
    let csv = stamped(8, |t| format!("2025/04/11 12:08:{:02}{}", 20 + t, if t == 4 { ".5" } else { "" }));
    let pieces =
        ["a.csv: line 6, column `t`", "`2025/04/11 12:08:24.5`", "fits `%Y/%m/%d %H:%M:%S` as a whole"];
    refused(&text, &csv, &pieces);
    let csv =
        stamped(8, |t| if t == 2 { "2025/04/11".to_owned() } else { format!("2025/04/11 12:08:{t:02}") });
    refused(&text, &csv, &["line 4, column `t`", "found `2025/04/11`", "the time's `format`"]);
}

#[test]
fn local_times_across_a_change_of_clocks_are_refused() {
    let text = timed("format = \"%Y-%m-%d %H:%M:%S\", zone = \"Europe/Helsinki\"");
    for (day, said) in [("2025-10-26", "showed twice: they were set back"), ("2025-03-30", "never showed")] {
        let csv = stamped(8, |t| format!("{day} {:02}:59:{:02}", if t < 4 { 2 } else { 3 }, 56 + t % 4));
        let stamp = format!("`{day} 03:59:56`");
        refused(&text, &csv, &["a.csv: line 6", &stamp, said, "Europe/Helsinki", "offset", "UTC"]);
    }
    let spring =
        stamped(8, |t| format!("2025-03-30 0{}:{:02}", if t < 4 { "2:59" } else { "4:00" }, (56 + t) % 60));
    assert_eq!(made(&text, &spring).rows, 8, "an hour that nobody's clock showed is no gap");
}

#[test]
fn formats_and_zones_without_meaning_are_refused() {
    let log = log(5);
    for (keys, pieces) in [
        ("format = \"%Y-%m-%d\"", ["`format`", "no time of day"]),
        ("format = \"%Y-%Q-%J %H\"", ["`format`", "no meaning"]),
        ("unit = \"iso8601\", zone = \"Europe/Helsinky\"", ["`zone`", "did you mean `Europe/Helsinki`?"]),
        ("unit = \"iso8601\", zone = \"+3h\"", ["`zone`", "+03:00"]),
        ("unit = \"s\", zone = \"UTC\"", ["`time`", "`zone` of a time that is a number"]),
        ("unit = \"s\", format = \"%H\"", ["`time`", "both `unit` and `format`"]),
        ("offset_s = 1.0", ["`time`", "no `unit`"]),
        ("unit = \"ms\", nanoseconds = \"n\"", ["`time`", "another unit than seconds"]),
    ] {
        refused(&timed(keys), &log, &[&["ingest.toml"], &pieces[..]].concat());
    }
}

#[test]
fn seconds_and_nanoseconds_in_two_columns_are_one_time() {
    let row = |k: usize| format!("{},{},{},0,0,60\n", 1_744_373_300 + k / 4, k % 4 * 250_000_000, k);
    let csv = "t,ns,u,v,r,n\n".to_owned() + &(0..40).map(row).collect::<String>();
    let text = timed("unit = \"s\", nanoseconds = \"ns\"")
        .replace("sample_rate_hz = 1.0", "sample_rate_hz = 4.0\nmax_speed_m_s = 50.0");
    let made = made(&text, &csv);
    assert_eq!((made.rows, made.summary.recordings[0].rows.repeated), (40, 0));
    for (k, u) in made.f64("y_u").iter().enumerate() {
        assert!((u - k as f64).abs() < 1e-5, "{k}: {u}");
    }
    let wrong = csv.replace(",750000000,7,", ",1750000000,7,");
    refused(&text, &wrong, &["a.csv: line 9, column `ns`", "found 1750000000", "nanoseconds of a second"]);
}

/// 20 Hz with whole seconds: u is the time.
fn whole_seconds() -> String {
    let row = |k: usize| format!("{},{},0,0,60\n", k / 20, 0.05 * k as f64);
    "t,u,v,r,n\n".to_owned() + &(7..207).map(row).collect::<String>()
}

#[test]
fn stamps_coarser_than_the_rows_are_refused_unless_asked_for() {
    let csv = whole_seconds();
    let pieces =
        ["a.csv: column `t`", "in 189 of 200 rows", "`repeated` in [file.time]", "\"spread\"", "\"drop\""];
    refused(&timed("unit = \"s\""), &csv, &pieces);
    let spread = made(&timed("unit = \"s\", repeated = \"spread\""), &csv);
    let recording = &spread.summary.recordings[0];
    assert_eq!((recording.rows.spread, recording.rows.repeated), (189, 0));
    assert!(
        (recording.channels.iter().find(|c| c.name == "y_u").unwrap().rate_hz.unwrap() - 20.0).abs() < 1e-6
    );
    for (k, u) in spread.f64("y_u").iter().enumerate() {
        assert!((u - (0.35 + k as f64)).abs() < 1e-9, "{k}: {u}");
    }
    let dropped = made(&timed("unit = \"s\", repeated = \"drop\""), &csv);
    assert_eq!(dropped.summary.recordings[0].rows.repeated, 189);
    assert_eq!(dropped.f64("y_u")[1..3], [1.0, 2.0]);
}
