//! Reading JSON documents: syntax, kind, version, seal, then the strict contents.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::fmt;
use std::path::Path;

use refusal::{Contents, PathStep, Unreadable};
use schemars::JsonSchema;
use serde::de::{DeserializeOwned, DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::Value;
use serde_json::error::Category;

use crate::access::{REMEDY, read};
use crate::budget::{Work, budget};
use crate::document::{Document, Envelope, Loaded, check_members, units};
use crate::error::{Complaint, Error, Result};
use crate::hand_written::text_of;
use crate::provenance::Provenance;
use crate::seal::{self, Digest, Header};
use crate::table_reader::Whole;

/// Reads a document.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read; [`Error::Refused`] if it is not JSON, is of another kind or
/// version, does not match its seal, has unknown, missing, duplicate or mistyped keys, other units or
/// meaningless values, if the files beside it are not those written with it, or if it is a shard.
pub fn read_document<D: Document>(path: impl AsRef<Path>) -> Result<Loaded<D>> {
    let path = path.as_ref();
    let loaded = read_part(path)?;
    match loaded.provenance.shard {
        None => Ok(loaded),
        Some(shard) => {
            let (expected, remedy) = ("the whole document", "put all shards together with --gather first");
            Err(Error::refuse(path, "file", format!("shard {shard}"), expected, remedy))
        }
    }
}

/// Reads a document that may be a shard.
///
/// # Errors
/// See [`read_document`].
pub fn read_part<D: Document>(path: &Path) -> Result<Loaded<D>> {
    let (text, header) = opened(path)?;
    header.check(path, D::ID, D::VERSION)?;
    let digest = seal::check_text(path, &text, header.seal())?.digest;
    let envelope: Envelope<D> = parsed(path, &text)?;
    check_units(path, &units::<D>(), &envelope.units, &text)?;
    check_members(path, &envelope.members, |_| None)?;
    let loaded = envelope.loaded(digest);
    loaded.data.check().map_err(|invalid| Error::invalid(path, invalid))?;
    Ok(loaded)
}

/// Reads a hand-written JSON file.
///
/// # Errors
/// [`Error::Io`] if it cannot be read; [`Error::Refused`] if it is not JSON, or has unknown, missing,
/// duplicate or mistyped keys.
pub fn read_json<T: DeserializeOwned + JsonSchema>(path: impl AsRef<Path>) -> Result<(T, Digest)> {
    let path = path.as_ref();
    let text = text_at(path)?;
    Ok((parsed(path, &text)?, Digest::of_bytes(text.as_bytes())))
}

/// Reads JSON; messages name the file `path`.
fn parsed<T: DeserializeOwned + JsonSchema>(path: &Path, text: &str) -> Result<T> {
    let contents: Contents = serde_json::from_str(text).map_err(|e| refusal(path, text, &e))?;
    contents.read().map_err(|Unreadable { message, way, is_key, invalid }| {
        let way = Way { steps: &way, is_key, message: &message };
        let Err(placed) = way.deserialize(&mut serde_json::Deserializer::from_str(text));
        let Some(mut invalid) = invalid else { return refusal(path, text, &placed) };
        invalid.found += &format!(" (line {})", placed.line());
        Error::Refused { file: path.into(), invalid: *invalid }
    })
}

/// Reads along the way to a fault, and fails there: the error has its line.
#[derive(Clone, Copy)]
struct Way<'a> {
    steps: &'a [PathStep],
    is_key: bool,
    message: &'a str,
}

impl Way<'_> {
    fn fault<E: serde::de::Error>(&self) -> Result<Infallible, E> {
        Err(E::custom(self.message))
    }
}

impl<'de> DeserializeSeed<'de> for Way<'_> {
    type Value = Infallible;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Infallible, D::Error> {
        deserializer.deserialize_any(self)
    }
}

macro_rules! fails {
    ($($method:ident($($type:ty)?)),+) => {
        $(fn $method<E: serde::de::Error>(self, $(_: $type)?) -> Result<Infallible, E> {
            self.fault()
        })+
    };
}

impl<'de> Visitor<'de> for Way<'_> {
    type Value = Infallible;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("what was read before")
    }

    fails! { visit_bool(bool), visit_i64(i64), visit_u64(u64), visit_f64(f64), visit_str(&str), visit_unit() }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Infallible, A::Error> {
        let Some((PathStep::Item(place), steps)) = self.steps.split_first() else { return self.fault() };
        for _ in 0..*place {
            items.next_element::<IgnoredAny>()?;
        }
        items.next_element_seed(Self { steps, ..self })?;
        self.fault()
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Infallible, A::Error> {
        while let Some(key) = entries.next_key::<String>()? {
            match self.steps.split_first() {
                Some((PathStep::Key(wanted), steps)) if *wanted == key => {
                    if steps.is_empty() && self.is_key {
                        return self.fault();
                    }
                    entries.next_value_seed(Self { steps, ..self })?;
                }
                _ => drop(entries.next_value::<IgnoredAny>()?),
            }
        }
        self.fault()
    }
}

/// The text of a file whose contents fit in memory.
fn text_at(path: &Path) -> Result<String> {
    let text = text_of(path, read(path)?)?;
    check_memory(path, &text)?;
    Ok(text)
}

/// The text of a document, and its header.
fn opened(path: &Path) -> Result<(String, Header)> {
    let text = text_at(path)?;
    let header = serde_json::from_str(&text).map_err(|e| refusal(path, &text, &e))?;
    Ok((text, header))
}

/// A field that the document's version did not have yet has no unit, and does not occur.
fn check_units(
    path: &Path,
    units: &BTreeMap<String, String>,
    stated: &BTreeMap<String, String>,
    text: &str,
) -> Result<()> {
    for (field, unit) in units {
        if !stated.contains_key(field) && !occurs(field, text) {
            continue;
        }
        if stated.get(field) != Some(unit) {
            let stated = stated.get(field).map_or("no unit", String::as_str);
            let remedy = "convert the values and correct the unit";
            return Err(Error::refuse(path, format!("units.{field}"), stated, unit.as_str(), remedy));
        }
    }
    stated.keys().find(|field| !units.contains_key(*field)).map_or(Ok(()), |field| {
        Err(Error::refuse(path, format!("units.{field}"), "a unit", "no such field", "remove it"))
    })
}

/// Whether a field of this name (the last part of a path) occurs in the document's data.
fn occurs(field: &str, text: &str) -> bool {
    fn within(value: &Value, name: &str) -> bool {
        match value {
            Value::Object(fields) => fields.iter().any(|(key, value)| key == name || within(value, name)),
            Value::Array(entries) => entries.iter().any(|entry| within(entry, name)),
            _ => false,
        }
    }
    let name = field.rsplit('.').next().unwrap_or(field);
    let whole: Value = serde_json::from_str(text).unwrap_or_default();
    whole.get("data").is_some_and(|data| within(data, name))
}

fn refusal(path: &Path, text: &str, error: &serde_json::Error) -> Error {
    let line = error.line();
    let full = error.to_string();
    let message = full.rsplit_once(" at line ").map_or(full.as_str(), |(message, _)| message);
    match error.classify() {
        Category::Data => {
            // The key on a line of pretty JSON.
            let key = text.lines().nth(line.saturating_sub(1)).and_then(|text| {
                let (key, _) = text.trim_start().strip_prefix('"')?.split_once("\":")?;
                Some(key.to_owned())
            });
            Complaint { path, place: Some(format!("line {line}")), key, message }.refusal()
        }
        _ => {
            let fault = format!("{message} (line {line}, column {})", error.column());
            let remedy = "the file is truncated or damaged: write it again";
            Error::refuse(path, "JSON", fault, "a whole JSON document", remedy)
        }
    }
}

/// Memory of a map of one key, of a list of one value, and of a value with its key \[bytes\].
const MAP: usize = 640;
const LIST: usize = 160;
const VALUE: usize = 96;

/// Refuses a text, read from `path`, whose contents do not fit in memory: a few of its bytes can represent a hundred times as many.
fn check_memory(path: &Path, text: &str) -> Result<()> {
    // Most texts are so short that they need not be counted.
    if (text.len() * MAP) as f64 <= budget().bytes() {
        return Ok(());
    }
    let amount = format!("{} bytes", text.len());
    let work = Work { file: path, thing: "contents", found: &amount, remedy: REMEDY };
    budget().memory(work, memory_of(text.as_bytes()) as f64)
}

/// Approximate memory of the text and its contents \[bytes\].
fn memory_of(text: &[u8]) -> usize {
    let (mut taken, mut quoted, mut escaped) = (2 * text.len() + VALUE, false, false);
    for byte in text {
        match byte {
            _ if escaped => escaped = false,
            b'\\' => escaped = quoted,
            b'"' => quoted = !quoted,
            b'{' if !quoted => taken += MAP,
            b'[' if !quoted => taken += LIST,
            b',' if !quoted => taken += VALUE,
            _ => {}
        }
    }
    taken
}

/// A file that was written as a document or table.
#[derive(Clone, Debug)]
pub struct Inspected {
    /// Kind and version, like `design/1`.
    pub schema: String,
    /// Digest of the file.
    pub digest: Digest,
    /// Whether it has a seal, which then matches.
    pub sealed: bool,
    /// The origin of its contents.
    pub provenance: Provenance,
    /// Digests of the files that were written together with it, by their names beside it.
    pub members: BTreeMap<String, Digest>,
}

/// Inspects the file at `path`; `None` if it is neither document nor table. [`crate::check_members`] checks
/// the files that were written with a document.
///
/// # Errors
/// [`Error::Io`] if it cannot be read; [`Error::Refused`] if it does not match its seal, or a table its
/// document.
pub fn inspect(path: &Path) -> Result<Option<Inspected>> {
    match path.extension().and_then(|end| end.to_str()) {
        Some("json") => document(path),
        Some("parquet") => table(path).map(Some),
        _ => Ok(None),
    }
}

fn document(path: &Path) -> Result<Option<Inspected>> {
    let (text, header) = opened(path)?;
    let Some(schema) = header.schema().map(str::to_owned) else { return Ok(None) };
    let digests = seal::check_text(path, &text, header.seal())?;
    let loaded = match serde_json::from_str::<Envelope<IgnoredAny>>(&text) {
        Ok(envelope) => envelope.loaded(digests.digest),
        // Of other programs, which have schemas, too
        Err(_) if header.seal().is_none() => return Ok(None),
        Err(e) => return Err(refusal(path, &text, &e)),
    };
    let (sealed, provenance, members) = (header.seal().is_some(), loaded.provenance, loaded.members);
    Ok(Some(Inspected { schema, digest: loaded.digest, sealed, provenance, members }))
}

fn table(path: &Path) -> Result<Inspected> {
    let Whole { header, envelope, digest, .. } = Whole::open(path, None)?;
    Ok(Inspected {
        schema: header.schema().unwrap_or_default().to_owned(),
        digest,
        sealed: header.seal().is_some(),
        provenance: envelope.into_parts().1,
        members: BTreeMap::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_in_texts_takes_no_more_than_they_have() {
        let text = br#"{"a,[\"{": "\\", "b": [1, 2]}"#;
        assert_eq!(memory_of(text), 2 * text.len() + VALUE + MAP + LIST + 2 * VALUE);
    }
}
