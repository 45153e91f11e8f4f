//! Criteria by the names that pages give them.

use design::CriterionName;
use schemars::{Schema, SchemaGenerator, json_schema};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serializer};

/// As a title.
pub(super) fn serialize<S: Serializer>(name: &CriterionName, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(name.title())
}

/// From a title.
pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<CriterionName, D::Error> {
    let found = String::deserialize(from)?;
    let titles = CriterionName::ALL.map(CriterionName::title).join("`, `");
    let known = CriterionName::ALL.into_iter().find(|name| name.title() == found);
    known.ok_or_else(|| D::Error::custom(format!("unknown variant `{found}`, expected one of `{titles}`")))
}

/// All titles.
pub(super) fn schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({"type": "string", "enum": CriterionName::ALL.map(CriterionName::title)})
}
