//! Which kind of file, in which version: `trajectories/1`.

use std::collections::BTreeMap;
use std::path::Path;

use refusal::foreign;
use serde::Deserialize;
use serde_json::Value;

use crate::error::{Error, Result};
use crate::seal::Digest;

/// The text that names a kind of file and its version.
pub(crate) fn schema_id(id: &str, version: u32) -> String {
    format!("{id}/{version}")
}

/// Refuses another kind of file, and another version of the same kind.
fn check(path: &Path, found: &str, id: &str, version: u32) -> Result<()> {
    let expected = schema_id(id, version);
    if found == expected {
        return Ok(());
    }
    let remedy = match found.split_once('/') {
        Some((kind, number)) if kind == id => version_remedy(number, version),
        _ => format!("name a file of kind {id}"),
    };
    Err(Error::refuse(path, "schema", foreign(found), expected, remedy))
}

fn version_remedy(found: &str, expected: u32) -> String {
    let again = "write the file again with this version";
    match found.parse::<u64>() {
        Ok(found) if found > u64::from(expected) => format!("upgrade seatrial or {again}"),
        _ => again.to_owned(),
    }
}

/// The part that is read before the contents are trusted; the rest of the envelope is skipped.
#[derive(Deserialize)]
pub(crate) struct Header {
    #[serde(default)]
    schema: Value,
    #[serde(default)]
    seal: Value,
    #[serde(default)]
    members: Value,
}

impl Header {
    /// Refuses a file of unknown kind, of another kind, and of another version.
    pub fn check(&self, path: &Path, id: &str, version: u32) -> Result<()> {
        match self.schema.as_str() {
            Some(found) => check(path, found, id, version),
            None => Err(absent(path, id, version)),
        }
    }

    /// Kind and version, if stated.
    pub fn schema(&self) -> Option<&str> {
        self.schema.as_str()
    }

    /// The seal. If it is missing or not a digest, the strict reading of the envelope will refuse that.
    pub fn seal(&self) -> Option<Digest> {
        self.seal.as_str().and_then(|text| text.parse().ok())
    }

    /// The digests of the files that were written together with this one.
    pub fn members(self) -> BTreeMap<String, Digest> {
        serde_json::from_value(self.members).unwrap_or_default()
    }
}

/// Refuses a file that does not state its kind.
pub(crate) fn absent(path: &Path, id: &str, version: u32) -> Error {
    let remedy = format!("name a file of kind {id}");
    Error::refuse(path, "schema", "no schema id", schema_id(id, version), remedy)
}
