//! JSON documents: an envelope with schema, provenance, seal and units around the data.

use std::collections::BTreeMap;
use std::path::Path;

use refusal::Invalid;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::digest::Digest;
use crate::error::{Error, Result};
use crate::finite::first_not_finite;
use crate::identity;
use crate::pretty::pretty;
use crate::provenance::Provenance;
use crate::seal;
use crate::set;
use crate::shard::Shard;
use crate::staged::Staged;

/// The contents of a kind of JSON document.
///
/// Structs inside should refuse unknown fields (`#[serde(deny_unknown_fields)]`), so that a misspelt key is
/// reported with the nearest known one.
pub trait Document: Serialize + DeserializeOwned + JsonSchema {
    /// Name of this kind of document, like `design`.
    const ID: &'static str;
    /// Version of this kind of document, from 1.
    const VERSION: u32;
    /// Units of all numeric fields; the values of a map have the unit of the map's field.
    const UNITS: Units;

    /// Refuses meaningless values. Every reader of the document calls it.
    ///
    /// # Errors
    /// Names the value.
    fn check(&self) -> std::result::Result<(), Invalid> {
        Ok(())
    }
}

/// Units with the names of the fields that have them, blanks between: `("m/s", "std_u std_v")`.
pub type Units = &'static [(&'static str, &'static str)];

/// The unit of every numeric field of a kind of document, by the field's name.
pub fn units<D: Document>() -> BTreeMap<String, String> {
    let named = |&(unit, fields): &(&str, &'static str)| {
        let unit = unit.to_owned();
        fields.split(' ').map(move |field| (field.to_owned(), unit.clone()))
    };
    D::UNITS.iter().flat_map(named).collect()
}

/// A document as read from its file.
#[derive(Clone, Debug)]
pub struct Loaded<D> {
    /// The contents.
    pub data: D,
    /// Digest of the file.
    pub digest: Digest,
    /// Where the document comes from.
    pub provenance: Provenance,
    /// Digests of the files that were written together with it, by their names beside it.
    pub members: BTreeMap<String, Digest>,
}

/// The whole file.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Envelope<D> {
    /// Kind of document and its version.
    schema: String,
    /// Program that wrote the document, and its version.
    producer: String,
    /// BLAKE3 of the file with these 64 digits replaced by zeros; null if the document was edited by hand.
    #[serde(deserialize_with = "seal::required")]
    seal: Option<Digest>,
    /// Digests of the input files, by role.
    inputs: BTreeMap<String, Digest>,
    /// Digests of the files that the inputs were made of, by role.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    origins: BTreeMap<String, Digest>,
    /// Settings that determine the contents.
    settings: BTreeMap<String, Value>,
    /// Which part of the whole this is, if it is a part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    shard: Option<Shard>,
    /// Digests of the files that were written together with this one, by their names beside it.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    members: BTreeMap<String, Digest>,
    /// Unit of each numeric field, by field name.
    units: BTreeMap<String, String>,
    /// The contents.
    data: D,
}

impl<D> Envelope<D> {
    /// The files that were written together with this one.
    pub fn members(&self) -> &BTreeMap<String, Digest> {
        &self.members
    }

    /// The units of the fields.
    pub fn units(&self) -> &BTreeMap<String, String> {
        &self.units
    }

    /// The contents of a file with this digest, and where they come from.
    pub fn loaded(self, digest: Digest) -> Loaded<D> {
        let Self { producer, inputs, origins, settings, shard, members, data, .. } = self;
        let provenance = Provenance { producer, inputs, origins, settings, shard, ..Provenance::default() };
        Loaded { data, digest, provenance, members }
    }
}

/// Writes a document beside its target, under a temporary name.
///
/// # Errors
/// [`Error::Refused`] if a number is NaN or infinite (with its field path) or the data cannot be
/// put into JSON; [`Error::Io`] if the file cannot be written.
pub fn stage_document<D: Document>(
    path: impl AsRef<Path>,
    provenance: &Provenance,
    data: &D,
) -> Result<Staged> {
    stage_set_document(path, provenance, data, &[])
}

/// As [`stage_document`], for a document that vouches for `files` of its set: it contains their digests,
/// which [`crate::read_document`] compares with the files beside it.
///
/// # Errors
/// As [`stage_document`]; [`Error::Io`] if one of `files` cannot be read.
pub fn stage_set_document<D: Document>(
    path: impl AsRef<Path>,
    provenance: &Provenance,
    data: &D,
    files: &[Staged],
) -> Result<Staged> {
    let path = path.as_ref();
    provenance.check_output(path)?;
    if let Some((field, value)) = first_not_finite(data) {
        let remedy = "leave the field out or correct the computation";
        return Err(Error::refuse(path, format!("data.{field}"), value, "a finite number", remedy));
    }
    let envelope = Envelope {
        schema: identity::schema_id(D::ID, D::VERSION),
        producer: provenance.producer.clone(),
        seal: Some(Digest::ZERO),
        inputs: provenance.inputs.clone(),
        origins: provenance.origins.clone(),
        settings: provenance.settings.clone(),
        shard: provenance.shard,
        members: set::members(path, files)?,
        units: units::<D>(),
        data,
    };
    let value = serde_json::to_value(&envelope).map_err(|e| {
        Error::refuse(path, "data", e.to_string(), "data that JSON can hold", "report this to the developers")
    })?;
    Staged::bytes(path, &seal::sealed(path, pretty(&value))?)
}

/// JSON Schema of the whole file, envelope and data.
pub fn json_schema<D: Document>() -> Value {
    let mut schema = schemars::schema_for!(Envelope<D>).to_value();
    schema["title"] = format!("{} document", D::ID).into();
    schema["properties"]["schema"]["const"] = identity::schema_id(D::ID, D::VERSION).into();
    schema["properties"]["units"]["const"] = serde_json::json!(units::<D>());
    schema["required"] =
        serde_json::json!(["schema", "producer", "seal", "inputs", "settings", "units", "data"]);
    schema
}
