use std::collections::BTreeMap;

use artifact::{Digest, Document, Units};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `run.json`: the stages that a study's results were made by, each with what it read and wrote.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunDocument {
    /// The stages by their names in `run --stage`.
    pub stages: BTreeMap<String, RunStage>,
}

/// A stage as it ran. `{study}`, `{dictionary}`, `{logs}` and `{out}` stand for the study's folder, its maneuvers, its logs and its
/// results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunStage {
    /// The program and its version.
    pub program: String,
    /// Digest of the program's file.
    pub digest: Option<Digest>,
    /// Its command line.
    pub command: Vec<String>,
    /// Digests of the files that it read.
    pub inputs: BTreeMap<String, Digest>,
    /// Digests of the files that it wrote.
    pub outputs: BTreeMap<String, Digest>,
}

impl Document for RunDocument {
    const ID: &'static str = "run";
    const VERSION: u32 = 1;
    const UNITS: Units = &[];
}
