//! Simulated logs, through the real binaries: `simulate logs` to the report.

#[path = "../support/mod.rs"]
mod support;

mod golden;
mod logs;
mod refusals;
mod study;

use std::fs;
use std::sync::OnceLock;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::*;

/// Simulates the logs of the small trial.
pub const LOGS: &str =
    "simulate logs --vessel vessel.toml --dictionary dictionary.toml --logs logs.toml --out logs/";
/// Reads them.
pub const INGEST: &str =
    "ingest --config ingest.toml --vessel vessel.toml --logs logs --out trajectories.parquet";

/// The stages of a study on simulated logs, in order.
pub const STAGES: [&str; 7] = [
    LOGS,
    INGEST,
    "moments --vessel vessel.toml --trajectories trajectories.parquet --nominal least-squares --out moments.json",
    "design --moments moments.json --segments 4 --segment-samples 75 --available ingest.json --out design.json",
    "estimate --structure own --vessel vessel.toml --trajectories trajectories.parquet --nominal least-squares --bootstrap 20 \
     --out estimates.parquet",
    "validate --vessel vessel.toml --trajectories trajectories.parquet \
     --design design.json --reference reference.toml --estimator iv --realizations 16 --out scores.parquet",
    "report --study . --results . --out report.html",
];

/// The hand-written files of the study of the model ship.
const WRITTEN: [&str; 5] = ["vessel.toml", "dictionary.toml", "logs.toml", "ingest.toml", "reference.toml"];

/// The study of the model ship with two repeats.
pub fn small() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let study = repository().join("pipelines/model-ship");
    for name in WRITTEN {
        fs::copy(study.join(name), folder.path().join(name)).unwrap();
    }
    edit(&folder, "logs.toml", "repeats = 5", "repeats = 2");
    folder
}

/// [`small`] with all that its stages write.
pub fn made() -> &'static Study {
    static MADE: OnceLock<Study> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = small();
        STAGES.iter().for_each(|stage| drop(run(&folder, &format!("{stage} --threads 3")).succeeds()));
        assert!(folder.path().join("figures/published-norm.svg").is_file());
        Study::of(&folder)
    })
}

/// A document of [`made`].
pub fn told(name: &str) -> Value {
    serde_json::from_slice(made().bytes(name)).unwrap()
}
