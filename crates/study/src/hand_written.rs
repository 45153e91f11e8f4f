//! JSON Schemas of the hand-written files of a study, from the types that read them.

use maneuver::DictionaryFile;
use schemars::{JsonSchema, schema_for};
use serde_json::Value;
use ship::model::VesselFile;

use crate::TermLists;
use crate::campaign_file::CampaignFile;
use crate::documents::Reference;
use crate::ingest_file::IngestFile;
use crate::logs_file::LogsFile;
use crate::plan::PlanFile;
use crate::sequential::SequentialFile;

/// A kind of file, and what writes its schema.
type Kind = (&'static str, fn() -> Value);

/// All of them.
const KINDS: [Kind; 9] = [
    ("vessel", schema::<VesselFile>),
    ("dictionary", schema::<DictionaryFile>),
    ("campaign", schema::<CampaignFile>),
    ("plan", schema::<PlanFile>),
    ("sequential", schema::<SequentialFile>),
    ("logs", schema::<LogsFile>),
    ("terms", schema::<TermLists>),
    ("reference", schema::<Reference>),
    ("ingest", schema::<IngestFile>),
];

/// The kinds of files with their schemas.
pub fn schemas() -> [(&'static str, Value); 9] {
    KINDS.map(|(kind, schema)| (kind, schema()))
}

fn schema<T: JsonSchema>() -> Value {
    schema_for!(T).to_value()
}

/// Name of the file with the schema of `kind`.
pub fn file_name(kind: &str) -> String {
    format!("{kind}-toml.schema.json")
}

/// The kind of a hand-written file by its name, which may go on after the kind: `plan-4-headings.toml` is a plan.
pub fn kind_of(name: &str) -> Option<&'static str> {
    let stem = name.strip_suffix(".toml")?;
    KINDS.into_iter().map(|(kind, _)| kind).find(|kind| stem.split('-').next() == Some(kind))
}
