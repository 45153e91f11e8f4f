//! Values that are read, left out and counted.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use study::documents::WarningKind;

use crate::runner::*;

const CONFIG: [&str; 2] = ["--config", "ingest.toml"];

#[test]
fn units_signs_scales_and_offsets_are_applied() {
    let text = config("").replace(
        "column = \"n\"\nchannel = \"n\"\nunit = \"rpm\"",
        "column = \"n\"\nchannel = \"n\"\nunit = \"rpm\"\nsign = -1\nscale = 2.0\noffset = 0.5",
    );
    let made = ingest(folder(&[("ingest.toml", &text), ("a.csv", &log(11))]).path(), &CONFIG);
    approx::assert_relative_eq!(made.f64("n")[6], -2.0 * (66.0 / 60.0) + 0.5, max_relative = 1e-14);
    assert_eq!(made.units["n"], "1/s");
    assert_eq!((made.rows, made.summary.samples, made.summary.runs), (11, 10, 1));
    assert!(
        made.line.contains("1 runs, 10 samples, 1 maneuvers from 1 recordings; 0 rows dropped"),
        "{}",
        made.line
    );
    assert_eq!(made.maneuvers()[0], "a");
}

#[test]
fn empty_repeated_and_cut_rows_are_left_out_and_counted() {
    let mut text = log(8);
    text = text.replace("3,0.13", ",,,,\n\n3,0.13").replace("5,0.15", "4,9.0,9.0,9.0,9\n5,0.15");
    text.push_str(",0.3,0.3,0.3,70\n8,0.1");
    let made = ingest(folder(&[("ingest.toml", &config("")), ("a.csv", &text)]).path(), &CONFIG);
    let rows = made.summary.recordings[0].rows;
    assert_eq!(
        (rows.read, rows.empty, rows.repeated, rows.without_time, rows.cut),
        (13, 2, 1, 1, 1),
        "{rows:?}"
    );
    assert_eq!(made.rows, 8);
    assert_eq!(made.f64("y_u")[4], 0.14);
}

#[test]
fn a_missing_value_is_a_gap_of_its_channel_only() {
    let text = log(12).replace("5,0.15,0.02,0.001,65", "5,nan,0.02,0.001,65");
    let files = [("ingest.toml", config("")), ("a.csv", text)];
    let files = files.each_ref().map(|(name, text)| (*name, text.as_str()));
    let made = ingest(folder(&files).path(), &CONFIG);
    let recording = &made.summary.recordings[0];
    assert_eq!((recording.splits, recording.runs.len()), (1, 2));
    let u = recording.channels.iter().find(|c| c.name == "y_u").unwrap();
    assert_eq!((u.missing, u.gaps), (1, 1));
    assert_eq!(made.i32("run"), [0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1]);
    assert_eq!(made.f64("t")[5], 0.0, "every run starts at 0");
    let wide = config("").replace("max_gap_s = 1.5", "max_gap_s = 3");
    let files = [("ingest.toml", wide.as_str()), files[1]];
    let made = ingest(folder(&files).path(), &CONFIG);
    approx::assert_relative_eq!(made.f64("y_u")[5], 0.15, max_relative = 1e-12);
}

#[test]
fn optional_channels_split_nothing_and_are_null_where_absent() {
    let text = config("") + "optional = true\n";
    let csv = log(8).replace("4,0.14,0.02,0.001,64", "4,0.14,0.02,0.001,").replace(",63\n", ",\n");
    let made = ingest(folder(&[("ingest.toml", &text), ("a.csv", &csv)]).path(), &CONFIG);
    assert_eq!(made.rows, 8);
    assert!(made.columns["n"].is_null(3) && made.columns["n"].is_null(4) && !made.columns["n"].is_null(7));
}

#[test]
fn time_that_goes_backwards_is_sorted_or_dropped_where_asked() {
    let swapped = "t,u,v,r,n\n0,1,0,0,6\n2,3,0,0,6\n1,2,0,0,6\n3,4,0,0,6\n";
    for (policy, gap, u) in
        [("sort", "1.5", vec![1.0, 2.0, 3.0, 4.0]), ("drop", "2.5", vec![1.0, 2.0, 3.0, 4.0])]
    {
        let text = config(&format!("non_monotonic = \"{policy}\""))
            .replace("max_gap_s = 1.5", &format!("max_gap_s = {gap}"));
        let made = ingest(folder(&[("ingest.toml", &text), ("a.csv", swapped)]).path(), &CONFIG);
        assert_eq!(made.f64("y_u"), u);
        assert_eq!(made.summary.recordings[0].rows.backwards, 1, "{policy}");
    }
}

#[test]
fn compressed_files_quotes_and_other_separators_are_read() {
    let folder =
        folder(&[("ingest.toml", &config("").replace("*.csv\"]", "*.csv.gz\"]\nseparator = \"\\t\""))]);
    let text = "\u{feff}\"t\"\tu\tv\tr\t\"n\"\r\n0\t\"1\"\t0\t0\t6\r\n1\t2\t0\t0\t6\r\n";
    let file = std::fs::File::create(folder.path().join("a.csv.gz")).unwrap();
    let mut encoder = GzEncoder::new(file, Compression::default());
    encoder.write_all(text.as_bytes()).unwrap();
    encoder.finish().unwrap();
    assert_eq!(ingest(folder.path(), &CONFIG).f64("y_u"), [1.0, 2.0]);
}

#[test]
fn velocities_are_made_from_positions_by_either_method() {
    let header = "t,x,y,psi,n\n".to_owned();
    let row = |t: i32| format!("{t},{},{},{},60\n", 2 * t, -t, 90);
    let csv = header + &(0..20).map(row).collect::<String>();
    let channels = "[[file.channel]]\ncolumn = \"x\"\nchannel = \"x\"\nunit = \"m\"\n[[file.channel]]\ncolumn = \"y\"\n\
         channel = \"y\"\nunit = \"m\"\n[[file.channel]]\ncolumn = \"psi\"\nchannel = \"psi\"\nunit = \"deg\"\n";
    let base = "sample_rate_hz = 1.0\nmax_gap_s = 1.5\n[[file]]\npattern = [\"*.csv\"]\n\
         time = { column = \"t\", unit = \"s\" }\n";
    for (method, rows) in [("euler", 19), ("smoother", 20)] {
        let text = format!("{base}{channels}[velocities]\nmethod = \"{method}\"\n");
        let made = ingest(folder(&[("ingest.toml", &text), ("a.csv", &csv)]).path(), &CONFIG);
        assert_eq!(made.rows, rows, "{method}");
        for k in 0..rows {
            approx::assert_abs_diff_eq!(made.f64("y_u")[k], -1.0, epsilon = 1e-9);
            approx::assert_abs_diff_eq!(made.f64("y_v")[k], -2.0, epsilon = 1e-9);
            approx::assert_abs_diff_eq!(made.f64("y_r")[k], 0.0, epsilon = 1e-9);
        }
        assert_eq!(made.f64("x")[3], 6.0);
    }
}

#[test]
fn what_is_odd_but_usable_is_counted_and_told() {
    let row = |t: i32| {
        let jump = if t == 12 { 1.5 } else { 0.0 };
        format!(
            "{t},0.5,{},0.001,60,{},{},{}\n",
            if t % 2 == 0 { 0.1 } else { 0.2 },
            0.01 * f64::from(t) + jump,
            40,
            // Goes round four times within a turn; without jumps it is more than a turn.
            f64::from(t).rem_euclid(std::f64::consts::TAU)
        )
    };
    let csv = "t,u,v,r,n,psi,azimuth,wind\n".to_owned() + &(0..30).map(row).collect::<String>();
    let mut text = config("").replace("sample_rate_hz = 1.0", "sample_rate_hz = 2.0");
    for column in ["psi", "azimuth", "wind"] {
        text += &format!("[[file.channel]]\ncolumn = \"{column}\"\nchannel = \"{column}\"\nunit = \"rad\"\n");
    }
    let made = ingest(folder(&[("ingest.toml", &text), ("a.csv", &csv)]).path(), &CONFIG);
    let warnings = &made.summary.recordings[0].warnings;
    let of = |kind: WarningKind| -> Vec<(&str, u64)> {
        warnings.iter().filter(|w| w.kind == kind).map(|w| (w.channel.as_str(), w.count)).collect()
    };
    assert_eq!(of(WarningKind::Constant), [("y_u", 1), ("y_r", 1), ("n", 1), ("azimuth", 1)]);
    assert_eq!(of(WarningKind::Jump), [("psi", 2)]);
    assert_eq!(of(WarningKind::Unit), [("azimuth", 1)]);
    assert_eq!(of(WarningKind::Rate).len(), 7);
    assert!(made.line.contains("; 14 warnings, see ingest.json"), "{}", made.line);
}

/// For a log whose speed and revolutions rise and rise.
fn in_wide_ranges() -> String {
    config("max_speed_m_s = 2000.0").replace("unit = \"rpm\"", "unit = \"rpm\"\nvalid = [0.0, 1e6]")
}

#[test]
fn what_a_long_recording_puts_aside_changes_no_byte_and_leaves_no_file() {
    let folder = folder(&[("ingest.toml", &in_wide_ranges()), ("a.csv", &log(140_000))]);
    let made = |more: &[&str]| {
        let ran = run(folder.path(), &[&CONFIG[..], &["--out", "made.parquet"], more].concat());
        assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
        ["made.parquet", "made-ingest.json"].map(|name| std::fs::read(folder.path().join(name)).unwrap())
    };
    // One fits the memory limit; the other needs twelve chunks of half a megabyte.
    assert!(made(&[]) == made(&["--memory-mib", "48"]));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4);
}
