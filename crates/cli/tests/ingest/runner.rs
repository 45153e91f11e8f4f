//! Runs `ingest` and reads its output.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use files::{Column, TableReader, read_document};
use study::documents::IngestDocument;
use tempfile::TempDir;

/// Top of the repository.
pub fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

/// The output of the program.
pub struct Ran {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

/// Runs `ingest` in `folder`.
pub fn run(folder: &Path, arguments: &[&str]) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_seatrial"));
    let output = command
        .arg("ingest")
        .args(arguments)
        .current_dir(folder)
        .env("RUST_BACKTRACE", "0")
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    Ran { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

/// The written files.
pub struct Made {
    pub columns: BTreeMap<String, Column>,
    pub units: BTreeMap<String, String>,
    pub rows: usize,
    pub summary: IngestDocument,
    pub line: String,
}

impl Made {
    pub fn f64(&self, name: &str) -> &[f64] {
        self.columns[name].as_f64().unwrap()
    }

    pub fn i32(&self, name: &str) -> &[i32] {
        self.columns[name].as_i32().unwrap()
    }

    /// Maneuvers row by row.
    pub fn maneuvers(&self) -> Vec<&str> {
        (0..self.rows).map(|row| self.columns["maneuver"].text_at(row).unwrap()).collect()
    }

    /// Rows of a run.
    pub fn rows_of(&self, run: i32) -> Vec<usize> {
        (0..self.rows).filter(|row| self.i32("run")[*row] == run).collect()
    }
}

/// Runs `ingest` with `--config CONFIG` and more, writing into a separate folder, and reads all of it.
#[track_caller]
pub fn ingest(folder: &Path, more: &[&str]) -> Made {
    let out = tempfile::tempdir().unwrap();
    let target = out.path().join("trajectories.parquet");
    let arguments = [more, &["--out", target.to_str().unwrap()]].concat();
    let ran = run(folder, &arguments);
    assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
    assert_eq!(ran.stdout.lines().count(), 1, "{}", ran.stdout);
    made(&target, ran.stdout)
}

/// The files written into `target` and next to it, when the program printed `line`.
pub fn made(target: &Path, line: String) -> Made {
    let reader = TableReader::open(target, "trajectories", 1).unwrap();
    assert_eq!(reader.blocks(), 1);
    let names: Vec<&str> = reader.columns().iter().map(|c| c.name.as_str()).collect();
    let table = reader.read_block(0, &names).unwrap();
    let owned = || names.iter().map(|name| (*name).to_owned());
    Made {
        columns: owned().zip(table.columns).collect(),
        units: owned().zip(reader.columns().iter().map(|c| c.unit.clone())).collect(),
        rows: reader.rows(),
        summary: read_document::<IngestDocument>(target.with_file_name("ingest.json")).unwrap().data,
        line,
    }
}

/// A folder with these files.
pub fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    folder
}

/// A configuration at 1 Hz for files `*.csv` with columns t, u, v, r, n; `top` before the first table.
pub fn config(top: &str) -> String {
    let channel = |(column, channel, unit): (&str, &str, &str)| {
        format!("[[file.channel]]\ncolumn = \"{column}\"\nchannel = \"{channel}\"\nunit = \"{unit}\"\n")
    };
    let channels = [("u", "y_u", "m/s"), ("v", "y_v", "m/s"), ("r", "y_r", "rad/s"), ("n", "n", "rpm")];
    format!(
        "sample_rate_hz = 1.0\nmax_gap_s = 1.5\n{top}\n[[file]]\npattern = [\"*.csv\"]\n\
         time = {{ column = \"t\", unit = \"s\" }}\n{}",
        channels.map(channel).concat()
    )
}

/// `rows` seconds of t,u,v,r,n with u = 0.1 + 0.01 t and n = 60 + t rpm.
pub fn log(rows: usize) -> String {
    let row = |t: usize| format!("{t},{:.2},0.02,0.001,{}\n", 0.1 + 0.01 * t as f64, 60 + t);
    "t,u,v,r,n\n".to_owned() + &(0..rows).map(row).collect::<String>()
}

/// Must be refused with exit code 3 and `pieces`, and write nothing.
#[track_caller]
pub fn refused_in(folder: &Path, more: &[&str], pieces: &[&str]) {
    let names = || {
        let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let before = names();
    let usual = ["--config", "ingest.toml", "--quiet", "--out", "trajectories.parquet"];
    let ran = run(folder, &[&usual, more].concat());
    assert_eq!(ran.code, Some(3), "{}{}", ran.stdout, ran.stderr);
    assert_eq!((ran.stderr.lines().count(), ran.stdout.as_str()), (1, ""), "{}", ran.stderr);
    for piece in [&["error: ", ": found ", ", expected ", "; "], pieces].concat() {
        assert!(ran.stderr.contains(piece), "`{piece}` is missing: {}", ran.stderr);
    }
    assert_eq!(names(), before, "something was written");
}

/// Must be refused so with this configuration and the log `a.csv`.
#[track_caller]
pub fn refused(config: &str, csv: &str, pieces: &[&str]) {
    refused_in(folder(&[("ingest.toml", config), ("a.csv", csv)]).path(), &[], pieces);
}
