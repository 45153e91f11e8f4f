use std::collections::BTreeMap;

use files::{Digest, Document, Units};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `run.json`: the stages that a study's results were made by, each with what it read and wrote.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunDocument {
    /// The stages by their names in `run --stage`.
    pub stages: BTreeMap<String, RunStage>,
}

/// A stage as it ran. `{study}` and `{out}` stand for the study's folder and its results; a brace of a name is written twice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunStage {
    /// The program and its version.
    pub program: String,
    /// Digest of the program's file.
    pub digest: Option<Digest>,
    /// Its command line.
    pub command: Vec<String>,
    /// Digests of what it read: files; names that fit a pattern in a folder (`names *.csv in {study}/logs`; a digit is `#`); the path
    /// of a folder without links (`place of {study}/cells`). None where there was no such file or folder.
    pub inputs: BTreeMap<String, Option<Digest>>,
    /// Digests of the files that it wrote.
    pub outputs: BTreeMap<String, Digest>,
}

impl Document for RunDocument {
    const ID: &'static str = "run";
    const VERSION: u32 = 2;
    const UNITS: Units = &[];
}
