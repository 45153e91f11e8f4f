//! The stages' files against numbers computed independently: `fixtures/oracle/oracle.json` and `runs.parquet`.

use std::path::{Path, PathBuf};
use std::process::Command;

use files::{Provenance, TableReader, read_document};
use serde_json::Value;
use ship::model::Vessel;
use study::documents::{DesignDocument, MomentsDocument};
use study::estimates::{self, Row, covariances};
use study::files::read_vessel;
use tempfile::TempDir;

use crate::support::SEATRIAL;

const ORACLE: &str = include_str!("../../../../fixtures/oracle/oracle.json");
const REMOVALS: [&str; 3] = ["complete", "batch", "none"];

/// A file of the repository.
fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

fn oracle(key: &str) -> Value {
    serde_json::from_str::<Value>(ORACLE).unwrap()[key].take()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// A stage's command line; paths are quoted by being arguments of their own.
struct Stage(Command);

impl Stage {
    fn new(words: &[&str]) -> Self {
        let mut command = Command::new(SEATRIAL);
        command.args(words).arg("--quiet");
        Self(command)
    }

    fn words(mut self, words: &[&str]) -> Self {
        self.0.args(words);
        self
    }

    fn file(mut self, flag: &str, path: &Path) -> Self {
        self.0.arg(flag).arg(path);
        self
    }

    fn run(mut self) {
        let output = self.0.output().unwrap();
        let streams =
            [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        assert!(output.status.success(), "{:?}\n{}\n{}", self.0, streams[0], streams[1]);
    }
}

fn vessel() -> Vessel {
    read_vessel(&repository("pipelines/paper/vessel.toml"), &mut Provenance::default()).unwrap()
}

/// `estimate` over the oracle's runs.
fn estimate(folder: &Path, estimator: &str, removal: &str) -> Vec<Row> {
    let out = folder.join(format!("{estimator}-{removal}.parquet"));
    Stage::new(&["estimate"])
        .file("--vessel", &repository("pipelines/paper/vessel.toml"))
        .file("--trajectories", &repository("fixtures/oracle/runs.parquet"))
        .words(&["--estimator", estimator, "--mean-removal", removal])
        .file("--out", &out)
        .run();
    let (reader, vessel) = (TableReader::open(&out, estimates::ID, estimates::VERSION).unwrap(), vessel());
    let rows = |block: usize| estimates::rows(&reader, &vessel, &out, block).unwrap();
    (0..reader.blocks()).flat_map(rows).collect()
}

/// To `tolerance` relative.
fn assert_all_close(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        let bound = tolerance * expected.abs().max(1e-12);
        assert!((found - expected).abs() <= bound, "{what}, entry {i}: found {found}, expected {expected}");
    }
}

#[test]
fn oracle_estimates_standard_errors_and_conditions_of_every_run() {
    let (folder, runs) = (TempDir::new().unwrap(), oracle("runs"));
    let runs = runs.as_array().unwrap();
    assert_eq!(runs.len(), 20);
    for estimator in ["iv", "ls"] {
        for removal in REMOVALS {
            let rows = estimate(folder.path(), estimator, removal);
            assert_eq!(rows.len(), runs.len());
            for (row, run) in rows.iter().zip(runs) {
                let what = format!("{estimator} {removal} run {}", row.run);
                assert_eq!(i64::from(row.run), run["run"].as_i64().unwrap());
                assert_eq!(row.estimator.name(), estimator);
                compare(row, &run["estimates"][estimator][removal], &what);
            }
        }
    }
}

#[test]
fn oracle_covariances_of_every_run_by_regression() {
    const EXPECTED: &str = include_str!("../../../../fixtures/oracle/covariances.json");
    let (folder, vessel) = (TempDir::new().unwrap(), vessel());
    let expected: Value = serde_json::from_str(EXPECTED).unwrap();
    for estimator in ["iv", "ls"] {
        Stage::new(&["estimate"])
            .file("--vessel", &repository("pipelines/paper/vessel.toml"))
            .file("--trajectories", &repository("fixtures/oracle/runs.parquet"))
            .words(&["--estimator", estimator, "--keep", "covariance"])
            .file("--out", &folder.path().join("estimates.parquet"))
            .run();
        let file = folder.path().join("covariances.parquet");
        let reader = TableReader::open(&file, covariances::ID, covariances::VERSION).unwrap();
        let read = |block| covariances::rows(&reader, &vessel, block).unwrap();
        let rows: Vec<covariances::CovarianceRow> = (0..reader.blocks()).flat_map(read).collect();
        assert_eq!(rows.len(), 20);
        for (row, degrees) in rows.iter().zip(expected[estimator].as_array().unwrap()) {
            assert_eq!(row.estimator.name(), estimator);
            compare_covariance(row.covariance.as_deref().unwrap(), degrees, row.run);
        }
    }
}

/// The blocks of degrees of freedom, to the tolerance of standard errors; zeros elsewhere.
fn compare_covariance(found: &[f64], degrees: &Value, run: i32) {
    let blocks: Vec<Vec<f64>> = degrees.as_array().unwrap().iter().map(numbers).collect();
    let all = found.len().isqrt();
    let mut expected = vec![0.0; all * all];
    let mut first = 0;
    for block in &blocks {
        let p = block.len().isqrt();
        (0..p * p).for_each(|k| expected[(first + k / p) * all + first + k % p] = block[k]);
        first += p;
    }
    assert_eq!(first, all);
    for (k, (found, own)) in found.iter().zip(&expected).enumerate() {
        let (i, j) = (k / all, k % all);
        let bound = 1e-5 * (expected[i * all + i] * expected[j * all + j]).sqrt();
        assert!((found - own).abs() <= bound, "run {run}, {i}, {j}: found {found}, expected {own}");
    }
}

fn compare(row: &Row, expected: &Value, what: &str) {
    let Some((theta, errors)) = &row.estimate else { panic!("{what}: not identified") };
    assert_all_close(theta, &numbers(&expected["theta"]), 1e-9, &format!("{what}, parameters"));
    let expected_errors = numbers(&expected["standard_error"]);
    assert_all_close(errors, &expected_errors, 1e-5, &format!("{what}, standard errors"));
    let condition = numbers(&expected["condition"]);
    assert_all_close(&row.condition, &condition, 1e-6, &format!("{what}, condition numbers"));
}

/// `simulate dictionary` and `moments` over the paper's study.
fn moments(folder: &Path) -> PathBuf {
    let (trajectories, out) = (folder.join("dictionary.parquet"), folder.join("moments.json"));
    let vessel = repository("pipelines/paper/vessel.toml");
    Stage::new(&["simulate", "dictionary"])
        .file("--vessel", &vessel)
        .file("--dictionary", &repository("pipelines/scenarios/dictionary.toml"))
        .file("--out", &trajectories)
        .run();
    Stage::new(&["moments"])
        .file("--vessel", &vessel)
        .file("--trajectories", &trajectories)
        .file("--out", &out)
        .run();
    out
}

/// Entries below a thousandth of what their row and column could give are compared at that scale.
#[test]
fn oracle_moments_and_designs_of_the_papers_study() {
    let folder = TempDir::new().unwrap();
    let file = moments(folder.path());
    let found = read_document::<MomentsDocument>(&file).unwrap().data.0.maneuvers;
    let expected = oracle("moments");
    assert_eq!(found.len(), expected.as_array().unwrap().len());
    for (found, expected) in found.iter().zip(expected.as_array().unwrap()) {
        assert_eq!(found.name, expected["name"]);
        assert_eq!(found.samples, expected["samples"].as_u64().unwrap());
        for (d, degree) in found.degrees.iter().enumerate() {
            let expected = numbers(&expected["degrees"][d]["M"]);
            let what = format!("{} {}", found.name, degree.name);
            assert_matrix_close(degree.shape[0] as usize, &degree.m, &expected, &what);
        }
    }
    for removal in REMOVALS {
        check_design(&file, &folder.path().join(format!("{removal}.json")), removal);
    }
}

/// To 1e-9 of the entry or of a thousandth of its row's largest times its column's over the whole matrix' largest.
fn assert_matrix_close(n: usize, found: &[f64], expected: &[f64], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let largest =
        |places: &dyn Fn(usize) -> usize| (0..n).map(|k| expected[places(k)].abs()).fold(0.0, f64::max);
    let whole = expected.iter().map(|x| x.abs()).fold(0.0, f64::max);
    for (k, (found, value)) in found.iter().zip(expected).enumerate() {
        let size = largest(&|j| k / n * n + j) * largest(&|i| i * n + k % n) / whole;
        let bound = 1e-9 * value.abs().max(1e-3 * size);
        assert!((found - value).abs() <= bound, "{what}, entry {k}: found {found}, expected {value}");
    }
}

fn check_design(moments: &Path, out: &Path, removal: &str) {
    Stage::new(&["design"])
        .file("--moments", moments)
        .words(&["--mean-removal", removal])
        .file("--out", out)
        .run();
    let found = read_document::<DesignDocument>(out).unwrap().data;
    let expected = &oracle("designs")[removal];
    assert_eq!(found.dimension, expected["dimension"].as_u64());
    let gap = found.relative_gap.unwrap();
    assert!(gap <= 1e-10, "{removal}: {gap}");
    let (own, log_det) = (found.log_det.unwrap(), expected["log_det"].as_f64().unwrap());
    assert!((own - log_det).abs() <= 1e-9 * log_det.abs(), "{removal}: {own}");
    for (key, values) in [("shares", &found.shares), ("sensitivities", &found.sensitivities)] {
        assert_eq!(values.len(), found.order.len());
        for (name, value) in values {
            let expected = expected[key][name].as_f64().unwrap();
            assert!((value - expected).abs() <= 1e-6, "{removal} {key} {name}: {value}, expected {expected}");
        }
    }
}
