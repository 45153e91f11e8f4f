//! Refusals: one line that names file, thing, found, expected and remedy; nothing is written.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::DoubleType;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::runner::*;

#[test]
fn unknown_keys_choices_and_units_are_refused_with_the_nearest() {
    let log = log(5);
    refused(&config("max_gaps_s = 2"), &log, &["ingest.toml", "`max_gaps_s`", "did you mean `max_gap_s`?"]);
    refused(&config("frame = \"nde\""), &log, &["`nde`", "did you mean `ned`?"]);
    for (unit, near) in [("RPM", "rpm"), ("knots", "knot"), ("kmh", "km/h")] {
        let text = config("").replace("\"rpm\"", &format!("\"{unit}\""));
        let (thing, near) = (format!("unit `{unit}`"), format!("did you mean `{near}`?"));
        refused(&text, &log, &[&thing, &near, "deg/s", "kN m"]);
    }
    let text = config("").replace("channel = \"y_u\"\nunit = \"m/s\"", "channel = \"y_u\"\nunit = \"deg\"");
    refused(&text, &log, &["unit of channel `y_u`", "found `deg`", "converts to m/s"]);
    let text = config("").replace("unit = \"rpm\"", "unit = \"rpm\"\ndelay = 0.1");
    refused(&text, &log, &["`delay`", "did you mean `delay_s`?"]);
}

#[test]
fn missing_columns_are_named_all_at_once() {
    let csv = log(5).replace("t,u,v,r,n", "time,u [m/s],v,r,n");
    refused(
        &config(""),
        &csv,
        &["a.csv", "columns", "no `t`, `u`", "`time` instead of `t`?", "`u [m/s]` instead of `u`?"],
    );
    let text = config("").replace("time =", "label_column = \"mode\"\ntime =");
    refused(&text, &log(5), &["a.csv", "column: found no `mode`", "`n`"]);
}

#[test]
fn cells_and_rows_that_cannot_be_read_are_named_by_line() {
    let log = log(5);
    refused(
        &config(""),
        &log.replace("3,0.13", "3,0x13"),
        &["a.csv: line 5, column `u`", "found `0x13`", "a number"],
    );
    refused(
        &config(""),
        &log.replace("3,0.13", "3,0.13,9"),
        &["line 5", "found 6 cells", "expected 5, as in the header"],
    );
    refused(&config(""), &log.replace("0.02,0.001,62", "0.02"), &["line 4", "found 3 cells"]);
    let comma = log.replace(',', ";").replace("0.13", "0,13");
    let text = config("").replace("time =", "separator = \";\"\ntime =");
    refused(&text, &comma, &["line 5", "`0,13`", "`decimal = \",\"`"]);
    let text = config("").replace("unit = \"s\"", "unit = \"iso8601\"");
    refused(&text, &log, &["line 2, column `t`", "found `0`", "2020-07-31T13:04:24.5Z"]);
}

#[test]
fn time_that_goes_backwards_is_refused() {
    let csv = log(5).replace("3,0.13", "1.5,0.13");
    refused(&config(""), &csv, &["a.csv: line 5, column `t`", "1.5 s after 2 s", "`non_monotonic`"]);
}

#[test]
fn files_without_rows_or_overlap_are_refused() {
    refused(&config(""), "t,u,v,r,n\n", &["a.csv", "no rows with a time (0 read, 0 empty)"]);
    refused(&config(""), "", &["a.csv", "no `t`, `u`, `v`, `r`, `n`"]);
    refused(&config(""), "t,u,v,r,n\n,,,,\n", &["(1 read, 1 empty)"]);
    let sparse = "t,u,v,r,n\n0,1,1,1,1\n10,1,1,1,1\n20,1,1,1,1\n";
    refused(&config(""), sparse, &["a.csv", "run `a`", "`max_gap_s`", "10.000 s in"]);
    let never = "t,u,v,r,n\n0,1,,1,1\n1,1,nan,1,1\n";
    refused(&config(""), never, &["run `a`", "no value in channel `y_v`"]);
    refused(&config("min_s = 100"), &log(5), &["sub-experiments", "none of 1 recordings", "`min_s`"]);
}

#[test]
fn patterns_and_templates_without_files_are_refused() {
    let log = log(5);
    refused(
        &config("").replace("*.csv", "*.cvs"),
        &log,
        &["pattern `*.cvs`", "no file", "--logs", "`a.csv`?"],
    );
    refused(&config("maneuver_from_file = \"{knd}_*\""), &log, &["`maneuver_from_file`", "`{kind}_*.csv`"]);
    refused(&config("maneuver_from_file = \"{kind}_*\""), &log, &["file name", "`a.csv`", "`{kind}_*`"]);
    let folder = folder(&[("ingest.toml", &config(""))]);
    refused_in(folder.path(), &["--logs", "nowhere"], &["pattern `*.csv`", "nowhere"]);
}

#[test]
fn recordings_that_lack_a_file_of_a_group_are_refused() {
    let group = config("")
        .replace("pattern = [\"*.csv\"]", "pattern = [\"*_m.csv\"]\nrun_from_file = \"{run}_m.csv\"");
    let other = "[[file]]\npattern = [\"*_n.csv\"]\nrun_from_file = \"{run}_n.csv\"\ntime = { column = \"t\", unit = \"s\" }\n";
    let log = log(5);
    let folder =
        folder(&[("ingest.toml", &(group + other)), ("a_m.csv", &log), ("a_n.csv", &log), ("b_m.csv", &log)]);
    refused_in(folder.path(), &[], &["run `b`", "none of `*_n.csv`"]);
}

#[test]
fn damaged_files_are_refused() {
    let logs = repository("fixtures/logs");
    let copy = |damage: &str, bytes: &dyn Fn(Vec<u8>) -> Vec<u8>| {
        let folder = folder(&[]);
        for entry in fs::read_dir(&logs).unwrap() {
            let path = entry.unwrap().path();
            fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
        }
        let path = folder.path().join(damage);
        fs::write(&path, bytes(fs::read(&path).unwrap())).unwrap();
        folder
    };
    let half = |bytes: Vec<u8>| bytes[..bytes.len() / 2].to_vec();
    let cut = copy("a_gnss.csv.gz", &half);
    refused_in(cut.path(), &[], &["a_gnss.csv.gz", "an end within the compressed data", "copy it again"]);
    let noise = copy("a_gnss.csv.gz", &|_| b"lat;lon\n".to_vec());
    refused_in(noise.path(), &[], &["a_gnss.csv.gz", "a file compressed with gzip"]);
    let cut = copy("b_thruster.parquet", &half);
    refused_in(cut.path(), &[], &["b_thruster.parquet", "a whole Parquet file"]);
    let flipped = copy("b_thruster.parquet", &|mut bytes| {
        bytes.iter_mut().skip(4).step_by(3).for_each(|b| *b ^= 0xff);
        bytes
    });
    refused_in(flipped.path(), &[], &["b_thruster.parquet"]);
    let latin = copy("a_imu.csv", &|mut bytes| {
        bytes[40] = 0xe9;
        bytes
    });
    refused_in(latin.path(), &[], &["a_imu.csv", "not UTF-8"]);
}

#[test]
fn channels_that_nothing_provides_are_refused_all_at_once() {
    let log = log(5);
    let vessel = |inputs: &[(&str, &str)], rate: &str| {
        let input =
            |(name, unit): &(&str, &str)| format!("[[input]]\nname = \"{name}\"\nunit = \"{unit}\"\n");
        let terms = ["surge", "sway", "yaw"]
            .map(|d| format!("[[{d}]]\nparameter = \"{d}_u\"\nterm = \"u\"\nnominal = 1.0\n"));
        format!(
            "name = \"x\"\nsample_rate_hz = {rate}\n{}{}",
            inputs.iter().map(input).collect::<String>(),
            terms.concat()
        )
    };
    let text = config("");
    for (inputs, rate, pieces) in [
        (
            vec![("n", "1/s"), ("delta", "rad"), ("n2", "1/s")],
            "1.0",
            vec!["`delta`, `n2`, which vessel.toml needs", "`n2` by `n`?"],
        ),
        (vec![("n", "rad")], "1.0", vec!["unit of channel `n`", "found `1/s`", "expected `rad`"]),
        (vec![("n", "1/s")], "2.0", vec!["`sample_rate_hz`", "found 1 Hz", "expected 2 Hz"]),
    ] {
        let folder =
            folder(&[("ingest.toml", &text), ("a.csv", &log), ("vessel.toml", &vessel(&inputs, rate))]);
        refused_in(folder.path(), &["--vessel", "vessel.toml"], &pieces);
    }
    let lacking = text
        .replace("channel = \"y_v\"", "channel = \"w\"")
        .replace("channel = \"y_r\"\nunit = \"rad/s\"", "channel = \"q\"\nunit = \"rad/s\"");
    refused(&lacking, &log, &["nothing that provides `y_v`, `y_r`", "psi"]);
    let text = text + "[[derived]]\nchannel = \"back\"\nformula = \"negative(m)\"\nunit = \"1/s\"\n";
    refused(&text, &log, &["source of channel `back`", "`m`", "did you mean `n`?"]);
    refused(
        &text.replace("negative(m)", "negativ(n)"),
        &log,
        &["`formula` of channel `back`", "the function `negativ`"],
    );
    refused(&text.replace("\"back\"", "\"u\""), &log.clone(), &["did you mean `n`?"]);
    refused(&text.replace("\"back\"", "\"u\"").replace("(m)", "(n)"), &log, &["channel `u`", "called y_u"]);
}

#[test]
fn keys_without_meaning_are_refused() {
    let log = log(5);
    for (top, pieces) in [
        ("average_s = -1.0", ["`average_s`", "1e-9 to 100000 s"]),
        ("speed_classes_m_s = [0.1]", ["`speed_classes_m_s`", "no `window_s`"]),
        ("tail_s = 5", ["`tail_s`", "no `window_s`"]),
        ("window_s = 2\ntail_s = 3", ["`tail_s`", "windows of 2 s"]),
        ("window_s = 2\ntail_s = -1", ["`tail_s`", "1e-9 to 1e7 s"]),
        ("window_s = 2\nspeed_classes_m_s = [0.3, 0.1]", ["`speed_classes_m_s`", "increase"]),
        ("window_s = 2\nspeed_classes_m_s = [0.1, 0.2, 0.3]", ["`speed_class_names`", "4, one more"]),
        ("maneuver = \"x\"\nmaneuver_from_file = \"{kind}\"", ["`maneuver`", "one of the two"]),
    ] {
        refused(&config(top), &log, &pieces);
    }
    let segment = "[[segment]]\nrun = \"b\"\nfrom_s = 0\nto_s = 2\nmaneuver = \"x\"\n";
    refused(&(config("") + segment), &log, &["[[segment]]", "`b`", "did you mean `a`?"]);
    refused(&(config("window_s = 2") + segment), &log, &["more than one of [[segment]], `window_s`"]);
    let twice = segment.replace("\"b\"", "\"a\"");
    refused(&(config("") + &twice + &twice), &log, &["without overlap"]);
}

#[test]
fn an_output_that_is_also_an_input_is_refused() {
    let folder = folder(&[("ingest.toml", &config("")), ("a.csv", &log(5))]);
    let ran = run(folder.path(), &["--config", "ingest.toml", "--out", "a.csv"]);
    assert_eq!(ran.code, Some(2), "{}", ran.stderr);
    assert!(ran.stderr.contains("which is also an input"), "{}", ran.stderr);
    assert_eq!(fs::read_to_string(folder.path().join("a.csv")).unwrap(), log(5));
}

#[test]
fn what_separates_the_cells_is_found_where_it_is_another() {
    let log = log(5).replace(',', ";");
    refused(&config(""), &log, &["a.csv: line 1", "5 cells separated by ';'", "`separator = \";\"`"]);
    let comma = log.replace([';', '.'], ",");
    refused(&config(""), &comma, &["a.csv: line 2", "8 cells", "decimal commas"]);
}

/// A log with heading, at 10 Hz: yaw rate 0.3 cos(0.6 t), heading its integral from `start`, both in radians; position of
/// a vessel at 2 m/s.
fn turning(start: f64, angle: f64, rate: f64, speed: f64) -> (String, String) {
    let heading = |t: f64| start + 0.5 * (0.6 * t).sin();
    let (mut x, mut y) = (0.0, 0.0);
    let mut csv = "t,u,v,r,n,x,y,psi\n".to_owned();
    for k in 0..600 {
        let t = 0.1 * f64::from(k);
        let (psi, r) = (heading(t), 0.3 * (0.6 * t).cos());
        let u = 2.0 + 0.5 * (0.4 * t).sin();
        csv += &format!(
            "{t},{},0,{},60,{x},{y},{}\n",
            speed * u,
            rate * r,
            angle * psi.rem_euclid(std::f64::consts::TAU)
        );
        x += 0.1 * u * psi.cos();
        y += 0.1 * u * psi.sin();
    }
    let mut text = config("").replace("sample_rate_hz = 1.0", "sample_rate_hz = 10.0");
    for (column, unit) in [("x", "m"), ("y", "m"), ("psi", "rad")] {
        text +=
            &format!("[[file.channel]]\ncolumn = \"{column}\"\nchannel = \"{column}\"\nunit = \"{unit}\"\n");
    }
    (text, csv)
}

#[test]
fn units_that_the_motion_contradicts_are_refused() {
    let (text, csv) = turning(1.0, 1.0, 1.0, 1.0);
    ingest(folder(&[("ingest.toml", &text), ("a.csv", &csv)]).path(), &["--config", "ingest.toml"]);
    let degrees = 180.0 / std::f64::consts::PI;
    let (text, csv) = turning(1.0, 1.0, degrees, 1.0);
    refused(&text, &csv, &["channel `y_r`", "possible for yaw rates", "correct its `unit`"]);
    let (text, csv) = turning(1.0, degrees, 1.0, 1.0);
    refused(&text, &csv, &["unit of channel `y_r`", "0.017", "`psi` may be in deg:"]);
    let (text, csv) = turning(1.0, 1.0, 1.0, 1.9438);
    refused(&text, &csv, &["unit of channel `y_u`", "1.9", "`y_u` may be in knot"]);
    // A heading about north wraps within a step.
    let (text, csv) = turning(0.1, degrees, 1.0, 1.0);
    refused(&text, &csv, &["column `psi`", "a turn in deg", "`unit = \"deg\"`"]);
    let (text, csv) = turning(0.1, 1.0, 1.0, 1.0);
    let text = text.replace("channel = \"psi\"\nunit = \"rad\"", "channel = \"psi\"\nunit = \"deg\"");
    refused(&text, &csv, &["column `psi`", "a turn in rad", "angles in deg", "`unit = \"rad\"`"]);
}

#[cfg(unix)]
#[test]
fn a_log_whose_name_is_no_text_is_refused_and_not_passed_over() {
    use std::os::unix::ffi::OsStringExt;
    let made = folder(&[("ingest.toml", &config("")), ("a.csv", &log(3))]);
    let name = std::ffi::OsString::from_vec(b"b\xff.csv".to_vec());
    fs::write(made.path().join(name), log(3)).unwrap();
    refused_in(made.path(), &[], &["log `b\u{fffd}.csv`", "not UTF-8", "rename it"]);
}

#[test]
fn a_line_without_end_is_refused_however_small_its_file() {
    let folder = folder(&[("ingest.toml", &config("").replace("*.csv", "*.csv.gz"))]);
    let file = fs::File::create(folder.path().join("a.csv.gz")).unwrap();
    let mut file = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
    let cells = vec![b'1'; 1 << 20];
    (0..64).for_each(|_| file.write_all(&cells).unwrap());
    file.finish().unwrap();
    let pieces = ["a.csv.gz", "line 1", "1048576 bytes without an end", "not CSV"];
    refused_in(folder.path(), &["--memory-mib", "256"], &pieces);
}

#[test]
fn more_rows_than_the_memory_holds_are_refused() {
    let text = config("");
    let made = folder(&[("ingest.toml", &text), ("a.csv", &log(20_000))]);
    refused_in(
        made.path(),
        &["--memory-mib", "1"],
        &["a.csv", "rows: found about", "at most", "raise --memory-mib"],
    );
    // A clock that jumps by most of a year.
    let jumps = log(4).replace("\n2,", "\n30000000,").replace("\n3,", "\n30000001,");
    let made = folder(&[("ingest.toml", &text), ("a.csv", &jumps)]);
    let pieces = ["a.csv", "run `a`", "30000003 rows", "check the clocks for jumps"];
    refused_in(made.path(), &["--memory-mib", "512"], &pieces);
}

#[test]
fn a_small_parquet_file_of_very_many_rows_is_refused() {
    let text = config("").replace("*.csv", "*.parquet");
    let folder = folder(&[("ingest.toml", &text)]);
    let file = folder.path().join("a.parquet");
    constant(&file, &["t", "u", "v", "r", "n"], 600_000);
    assert!(fs::metadata(file).unwrap().len() < 1 << 16);
    let pieces = ["a.parquet", "rows: found 600000", "at most", "raise --memory-mib"];
    refused_in(folder.path(), &["--memory-mib", "8"], &pieces);
}

/// Writes a Parquet file of `rows` rows of zeros.
fn constant(path: &Path, columns: &[&str], rows: usize) {
    let field = |name: &&str| {
        let kind = Type::primitive_type_builder(name, Physical::DOUBLE);
        Arc::new(kind.with_repetition(Repetition::REQUIRED).build().unwrap())
    };
    let fields = columns.iter().map(field).collect();
    let root = Type::group_type_builder("schema").with_fields(fields).build().unwrap();
    let file = fs::File::create(path).unwrap();
    let mut writer = SerializedFileWriter::new(file, Arc::new(root), Arc::default()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    while let Some(mut column) = group.next_column().unwrap() {
        column.typed::<DoubleType>().write_batch(&vec![0.0; rows], None, None).unwrap();
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
}

#[test]
fn a_thruster_whose_speed_is_none_is_refused() {
    let thruster =
        "[[thruster]]\nkind = \"tunnel\"\nspeed = \"y_u\"\ncoefficient = 0.05\nposition_m = [2.0, 0.0]\n";
    let pieces = ["ingest.toml", "unit of channel `y_u`", "found `m/s`", "converts to 1/s, for a thruster"];
    refused(&(config("") + thruster), &log(5), &pieces);
    let azimuth = thruster.replace("tunnel", "azimuth").replace("\"y_u\"", "\"n\"\nangle = \"y_u\"");
    refused(&(config("") + &azimuth), &log(5), &["unit of channel `y_u`", "converts to rad"]);
}
