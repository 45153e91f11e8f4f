//! Cases that were reported once, as reported, unless tests of another topic have them.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use flate2::Compression;
use flate2::write::GzEncoder;
use parquet::basic::{Repetition, Type as Physical};
use parquet::column::writer::ColumnCloseResult;
use parquet::data_type::DoubleType;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use tempfile::TempDir;

use crate::planned::{PLAN, small_with};
use crate::support::*;

const INGEST: &str = "ingest --config ingest.toml --out trajectories.parquet --memory-mib 512";

/// A folder with an `ingest.toml` for files that `pattern` names, in the columns t, u, v, r, n.
fn logged(pattern: &str, more: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let channel = |(column, channel, unit): (&str, &str, &str)| {
        format!("[[file.channel]]\ncolumn = \"{column}\"\nchannel = \"{channel}\"\nunit = \"{unit}\"\n")
    };
    let channels = [("u", "y_u", "m/s"), ("v", "y_v", "m/s"), ("r", "y_r", "rad/s"), ("n", "n", "rpm")];
    let file = format!("[[file]]\npattern = [\"{pattern}\"]\ntime = {{ column = \"t\", unit = \"s\" }}\n");
    let text =
        format!("sample_rate_hz = 1.0\nmax_gap_s = 1.5\n{file}{}{more}", channels.map(channel).concat());
    put(&folder, "ingest.toml", &text);
    folder
}

#[track_caller]
fn refused_in_little_memory(folder: &TempDir, line: &str, pieces: &[&str]) {
    let before = listing(folder.path());
    run_in_little_memory(folder, line).refuses(3, pieces);
    assert_eq!(listing(folder.path()), before);
}

#[test]
fn three_gigabytes_in_one_line_of_a_compressed_file_are_refused() {
    let folder = logged("*.csv.gz", "");
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(&vec![b'1'; 3 << 20]).unwrap();
    let packed = packed.finish().unwrap().repeat(1024);
    assert!(packed.len() < 4 << 20);
    fs::write(folder.path().join("a.csv.gz"), packed).unwrap();
    refused_in_little_memory(&folder, INGEST, &["a.csv.gz", "line 1", "without an end"]);
}

#[test]
fn sixty_million_rows_in_a_small_parquet_file_are_refused() {
    let folder = logged("*.parquet", "");
    let file = folder.path().join("a.parquet");
    repeated(&file, &["t", "u", "v", "r", "n"], 600_000, 100);
    assert!(fs::metadata(file).unwrap().len() < 1 << 20);
    refused_in_little_memory(&folder, INGEST, &["a.parquet"]);
}

/// Writes a Parquet file of `groups` times the same `rows` rows that are 0.0 and then 1.0
fn repeated(path: &Path, columns: &[&str], rows: usize, groups: usize) {
    let field = |name: &&str| {
        let kind = Type::primitive_type_builder(name, Physical::DOUBLE);
        Arc::new(kind.with_repetition(Repetition::REQUIRED).build().unwrap())
    };
    let fields = columns.iter().map(field).collect();
    let root = Arc::new(Type::group_type_builder("schema").with_fields(fields).build().unwrap());
    let one = path.with_extension("one");
    let writer = |path: &Path| {
        SerializedFileWriter::new(File::create(path).unwrap(), root.clone(), Arc::default()).unwrap()
    };
    let mut first = writer(&one);
    let mut group = first.next_row_group().unwrap();
    let values: Vec<f64> = (0..rows).map(|row| (2 * row / rows) as f64).collect();
    while let Some(mut column) = group.next_column().unwrap() {
        column.typed::<DoubleType>().write_batch(&values, None, None).unwrap();
        column.close().unwrap();
    }
    group.close().unwrap();
    first.close().unwrap();
    let file = File::open(&one).unwrap();
    let reader = SerializedFileReader::new(file.try_clone().unwrap()).unwrap();
    let mut all = writer(path);
    for _ in 0..groups {
        let mut group = all.next_row_group().unwrap();
        for chunk in reader.metadata().row_group(0).columns() {
            let chunk = ColumnCloseResult {
                bytes_written: chunk.compressed_size().unsigned_abs(),
                rows_written: rows as u64,
                metadata: chunk.clone(),
                bloom_filter: None,
                column_index: None,
                offset_index: None,
            };
            group.append_column(&file, chunk).unwrap();
        }
        group.close().unwrap();
    }
    all.close().unwrap();
    fs::remove_file(one).unwrap();
}

#[test]
fn a_thrusters_speed_in_metres_is_refused() {
    let position = "[[file.channel]]\ncolumn = \"x\"\nchannel = \"x\"\nunit = \"m\"\n";
    let thruster =
        "[[thruster]]\nkind = \"tunnel\"\nspeed = \"x\"\ncoefficient = 0.05\nposition_m = [2.0, 0.0]\n";
    let folder = logged("*.csv", &format!("{position}{thruster}"));
    let row = |t: i32| format!("{t},1,0,0,60,{t}\n");
    put(&folder, "a.csv", &("t,u,v,r,n,x\n".to_owned() + &(0..9).map(row).collect::<String>()));
    refused(&folder, 3, INGEST, &["ingest.toml", "unit of channel `x`", "found `m`", "converts to 1/s"]);
}

#[test]
fn a_check_of_a_hundred_thousand_runs_ends_with_the_time_limit() {
    let folder = small_with(&[("runs = 4", "runs = 100000")]);
    refused(&folder, 4, &format!("{PLAN} --time-limit-s 1"), &["plan.toml", "none in time", "`safety.runs`"]);
}

#[test]
fn fill_values_are_no_deep_water() {
    let row = |r: usize, fill: &str| {
        let cell = |c: usize| {
            if (r, c) == (3, 3) {
                fill
            } else if (r, c) == (8, 8) {
                "-2"
            } else {
                "20"
            }
        };
        (0..16).map(cell).collect::<Vec<_>>().join(" ") + "\n"
    };
    let header =
        "ncols 16\nnrows 16\nxllcorner 386100\nyllcorner 6650600\ncellsize 300\nNODATA_value -9999\n";
    for fill in ["9.97e36", "-32768"] {
        let charts = "file = \"own.asc\"\nkind = \"depth\"\ncrs = \"EPSG:32635\"";
        let folder = small_with(&[("file = \"land.geojson\"\nkind = \"land\"", charts)]);
        put(&folder, "own.asc", &(header.to_owned() + &(0..16).map(|r| row(r, fill)).collect::<String>()));
        refused(&folder, 3, PLAN, &["own.asc", "at most 12000 m"]);
        let charts = "file = \"areas.geojson\"\nkind = \"depth\"";
        let folder = small_with(&[("file = \"land.geojson\"\nkind = \"land\"", charts)]);
        let depth = format!("\"properties\": {{\"DRVAL1\": {fill}}}");
        put(&folder, "areas.geojson", &crate::planned::ISLAND.replace("\"properties\": {}", &depth));
        refused(&folder, 3, PLAN, &["areas.geojson", "`DRVAL1`", "at most 12000 m"]);
    }
}

#[test]
fn scores_of_two_estimates_have_two_documents() {
    let folder = with(&["estimates.parquet", "estimate.json", "validation.parquet"]);
    for k in [1, 2] {
        run(&folder, &VALIDATE.replace("scores.parquet", &format!("scores-{k}.parquet"))).succeeds();
    }
    let there = |name: &str| folder.path().join(name).is_file();
    assert!(there("validation-1.json") && there("validation-2.json") && !there("validation.json"));
}

#[test]
fn shards_tell_how_many_runs_they_hold() {
    let folder = with(&["design.json", "campaign.parquet", "estimates.parquet", "validation.parquet"]);
    for (stage, all) in [(CAMPAIGN, 3 * RUNS), (ESTIMATE, 3 * RUNS), (VALIDATE, 3 * RUNS)] {
        let (line, _) = stage.rsplit_once(" --out ").unwrap();
        let told = |shard: &str| -> u64 {
            let ran = run(&folder, &format!("{line} --out part.parquet --shard {shard} --json")).succeeds();
            serde_json::from_str::<serde_json::Value>(&ran.stdout).unwrap()["runs"].as_u64().unwrap()
        };
        assert_eq!(told("900/1000"), 0, "{stage}");
        assert_eq!(told("1/2") + told("2/2"), all, "{stage}");
    }
}

#[cfg(unix)]
#[test]
fn a_pipe_is_never_replaced() {
    use std::os::unix::fs::FileTypeExt;
    let folder = with(&["moments.json"]);
    let pipe = folder.path().join("design.json");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    run(&folder, DESIGN).refuses(3, &["design.json: output: found a device or pipe", "name a file"]);
    assert!(fs::symlink_metadata(pipe).unwrap().file_type().is_fifo());
}

#[cfg(unix)]
#[test]
fn names_that_are_not_utf8_are_no_panic() {
    use std::os::unix::ffi::OsStrExt;
    let strange = OsStr::from_bytes(b"r\xe9sum\xe9.json");
    let folder = with(&["moments.json", "design.json"]);
    fs::copy(folder.path().join("moments.json"), folder.path().join(strange)).unwrap();
    let ends = |words: &[&OsStr]| {
        let mut command = Command::new(SEATRIAL);
        let output = command.arg("design").args(words).current_dir(&folder).output().unwrap();
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!told.contains("panicked"), "{words:?}: {told}");
        (output.status.code(), told.lines().count())
    };
    let [moments, out, json] = ["--moments", "--out", "--json"].map(OsStr::new);
    let made = [OsStr::new("moments.json"), OsStr::new("made.json")];
    assert_eq!(ends(&[moments, strange, out, made[1]]), (Some(0), 0));
    assert_eq!(ends(&[moments, made[0], out, OsStr::from_bytes(b"\xff.json")]), (Some(0), 0));
    assert_eq!(ends(&[moments, made[0], out, OsStr::from_bytes(b"\xfe.json"), json]), (Some(0), 0));
    assert_eq!(ends(&[moments, OsStr::from_bytes(b"\xff.none"), out, made[1]]), (Some(1), 1));
    assert_eq!(ends(&[OsStr::from_bytes(b"--\xff"), out, made[1]]), (Some(2), 1));
}
