//! The envelope of a table: a JSON text under the key `seatrial` in the Parquet footer.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::digest::Digest;
use crate::identity::schema_id;
use crate::provenance::Provenance;
use crate::schema::{ColumnSpec, Kind, TableSchema};
use crate::seal;
use crate::shard::Shard;

/// The key in the footer.
pub(crate) const KEY: &str = "seatrial";

/// Schema, provenance, seal and units of a table.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TableMetadata {
    schema: String,
    producer: String,
    #[serde(deserialize_with = "seal::required")]
    seal: Option<Digest>,
    /// Its inputs.
    pub inputs: BTreeMap<String, Digest>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    origins: BTreeMap<String, Digest>,
    pub(crate) settings: BTreeMap<String, Value>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    shard: Option<Shard>,
    /// The document beside the table that vouches for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub document: Option<String>,
    /// Columns in file order.
    pub columns: Vec<ColumnEntry>,
}

/// A column; the Parquet schema states whether it may contain nulls.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ColumnEntry {
    pub name: String,
    pub unit: String,
    pub kind: Kind,
}

impl TableMetadata {
    /// The envelope of a table yet to be sealed.
    pub fn new(schema: &TableSchema, provenance: &Provenance) -> Self {
        let Provenance { producer, inputs, origins, settings, shard, .. } = provenance.clone();
        Self {
            schema: schema_id(schema.id, schema.version),
            producer,
            seal: Some(Digest::ZERO),
            inputs,
            origins,
            settings,
            shard,
            document: None,
            columns: schema.columns.iter().map(ColumnEntry::from).collect(),
        }
    }

    /// The columns, and the origin of the table.
    pub fn into_parts(self) -> (Vec<ColumnEntry>, Provenance) {
        let Self { producer, inputs, origins, settings, shard, columns, .. } = self;
        (columns, Provenance { producer, inputs, origins, settings, shard, ..Provenance::default() })
    }
}

impl From<&ColumnSpec> for ColumnEntry {
    fn from(column: &ColumnSpec) -> Self {
        Self { name: column.name.clone(), unit: column.unit.clone(), kind: column.kind }
    }
}
