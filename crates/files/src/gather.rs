//! Merges the shards of a table.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Debug;
use std::path::{Path, PathBuf};

use refusal::foreign as quoted;

use crate::columns::TableSchema;
use crate::error::{Error, Result};
use crate::provenance::{MIXED, Provenance, Shard};
use crate::staged::Staged;
use crate::table_reader::TableReader;
use crate::table_writer::TableWriter;

/// Most missing shards that a message names.
const MOST_NAMED: usize = 8;

/// Merges the shards of a table in the order of their numbers, regardless of the order of `shards`. Blocks
/// are copied byte for byte: the result has the bytes that the table would have had without shards.
/// `document` is the one beside it that will vouch for it.
///
/// # Errors
/// As [`TableReader::open`] for every shard; [`Error::Refused`] if a shard is missing (all missing numbers
/// are named), occurs twice, comes from another computation (the difference is named), or has no seal and a
/// number that is not finite; [`Error::Io`] if a file cannot be read or written.
pub fn gather(
    shards: &[PathBuf],
    out: &Path,
    document: Option<&Path>,
    id: &'static str,
    version: u32,
) -> Result<Staged> {
    let readers = shards_of(shards, id, version)?;
    let Some(first) = readers.first() else {
        return Err(Error::refuse(out, "shards", "none", "all shards of a table", "name the shards"));
    };
    let schema = TableSchema { id, version, columns: first.columns().to_vec() };
    let provenance = Provenance { shard: None, ..first.provenance().clone() };
    let mut writer = TableWriter::create(out, &schema, &provenance)?;
    if let Some(document) = document {
        writer = writer.with_document(document);
    }
    for reader in &readers {
        for group in reader.row_groups() {
            let rows = usize::try_from(group.num_rows()).unwrap_or_default();
            writer.append(reader.source(), rows, group.columns())?;
        }
    }
    writer.finish()
}

/// The files of all `shards` of a table, in the order of their numbers.
///
/// # Errors
/// As [`gather`].
pub fn shards_of(shards: &[PathBuf], id: &'static str, version: u32) -> Result<Vec<TableReader>> {
    let mut readers = Vec::with_capacity(shards.len());
    for path in shards {
        let reader = TableReader::open(path, id, version)?;
        readers.push((number(path, reader.provenance())?, reader));
    }
    readers.sort_by_key(|(shard, _)| *shard);
    let readers: Vec<TableReader> = readers.into_iter().map(|(_, reader)| reader).collect();
    check_shards(readers.iter().map(|reader| (reader.path(), reader.provenance())))?;
    let Some(first) = readers.first() else { return Ok(readers) };
    readers.iter().try_for_each(|reader| refuse_other_columns(first, reader))?;
    readers.iter().try_for_each(TableReader::check_unsealed)?;
    Ok(readers)
}

/// Refuses the shard at `path` if it was made with a setting that is not `given`, or without one that is.
///
/// # Errors
/// Names the setting.
pub fn check_settings(given: &Provenance, path: &Path, made: &Provenance) -> Result<()> {
    let compared = |settings: &BTreeMap<String, serde_json::Value>| {
        let entries = settings.iter().filter(|(name, _)| *name != MIXED);
        entries.map(|(name, value)| (name.clone(), value.clone())).collect::<BTreeMap<_, _>>()
    };
    let difference = differing_entry("settings", &compared(&given.settings), &compared(&made.settings));
    difference.map_or(Ok(()), |difference| Err(otherwise_requested(path, difference)))
}

/// Refuses the shard at `path` if its inputs or settings differ from the given ones. Where mixtures are
/// allowed, differing inputs label `given` instead.
///
/// # Errors
/// Names the input's file, or the setting.
pub fn check_given(given: &mut Provenance, path: &Path, made: &Provenance) -> Result<()> {
    let other = |role: &&String| made.inputs.get(*role).is_some_and(|digest| *digest != given.inputs[*role]);
    let others: Vec<String> = given.inputs.keys().filter(other).cloned().collect();
    if let Some(role) = others.first().filter(|_| !given.allow_mixed) {
        let file = given.reported_by.get(role).map_or(path, |file| file);
        let (found, expected) = (
            format!("another {role} than that of {}", path.display()),
            "the files that the shards were made of",
        );
        let remedy = "name that file, make the shards again, or add --allow=mixed";
        return Err(Error::refuse(file, "provenance", found, expected, remedy));
    }
    others.iter().for_each(|role| given.label(role));
    let other = |(name, value): &(&String, &serde_json::Value)| {
        *name != MIXED && made.settings.get(*name) != Some(*value)
    };
    given.settings.iter().find(other).map_or(Ok(()), |(name, value)| {
        let difference = [format!("`{name}`"), value.to_string(), shown(made.settings.get(name))];
        Err(otherwise_requested(path, difference))
    })
}

/// Refuses the shard at `path`, which was made with another setting than requested.
fn otherwise_requested(path: &Path, [thing, expected, found]: [String; 3]) -> Error {
    let expected = format!("{expected}, as requested now");
    Error::refuse(path, thing, found, expected, "request the same, or make the shards again")
}

/// Refuses files, in the order of their numbers, that are not all shards of one computation.
///
/// # Errors
/// A file that is not a shard, or comes from another computation (the difference is named); a shard that is
/// missing (all missing numbers are named) or duplicate.
pub fn check_shards<'a>(files: impl Iterator<Item = (&'a Path, &'a Provenance)>) -> Result<()> {
    let parts =
        files.map(|(path, provenance)| Ok(Part { path, provenance, shard: number(path, provenance)? }));
    let mut parts = parts.collect::<Result<Vec<Part>>>()?;
    parts.sort_by_key(|part| part.shard);
    let Some(first) = parts.first() else { return Ok(()) };
    parts.iter().try_for_each(|part| refuse_foreign(first, part))?;
    refuse_incomplete(first.path, &parts)
}

/// A file that is a shard.
struct Part<'a> {
    path: &'a Path,
    provenance: &'a Provenance,
    shard: Shard,
}

fn number(path: &Path, provenance: &Provenance) -> Result<Shard> {
    provenance.shard.ok_or_else(|| {
        let remedy = "name only files written with --shard";
        Error::refuse(path, "shard", "a whole file", "a shard K/N", remedy)
    })
}

fn refuse_other_columns(first: &TableReader, other: &TableReader) -> Result<()> {
    differs("columns", &first.columns(), &other.columns())
        .map_or(Ok(()), |difference| Err(foreign(first.path(), other.path(), difference)))
}

fn foreign(first: &Path, other: &Path, [thing, expected, found]: [String; 3]) -> Error {
    let expected = format!("{expected} as in {}", first.display());
    Error::refuse(other, thing, found, expected, "name the shards of one computation only")
}

/// Refuses a shard that differs from the first in more than its number.
fn refuse_foreign(first: &Part, other: &Part) -> Result<()> {
    let (one, two) = (first.provenance, other.provenance);
    let count = |p: &Provenance| p.shard.map_or(0, |shard| shard.count);
    let difference = differs("number of shards", &count(one), &count(two))
        .or_else(|| differs("producer", &one.producer, &two.producer))
        .or_else(|| differing_entry("inputs", &one.inputs, &two.inputs))
        .or_else(|| differing_entry("origins", &one.origins, &two.origins))
        .or_else(|| differing_entry("settings", &one.settings, &two.settings));
    difference.map_or(Ok(()), |difference| Err(foreign(first.path, other.path, difference)))
}

/// Name, first and second value, if the values differ.
fn differs<T: PartialEq + Debug>(name: &str, one: &T, two: &T) -> Option<[String; 3]> {
    (one != two).then(|| [name.to_owned(), format!("{one:?}"), format!("{two:?}")])
}

/// Name, first and second value of the first entry that differs.
fn differing_entry<T: PartialEq + ToString>(
    name: &str,
    one: &BTreeMap<String, T>,
    two: &BTreeMap<String, T>,
) -> Option<[String; 3]> {
    let key = one.keys().chain(two.keys()).find(|key| one.get(*key) != two.get(*key))?;
    Some([format!("{name}.{}", quoted(key)), shown(one.get(key)), shown(two.get(key))])
}

/// A value as text.
fn shown(value: Option<&impl ToString>) -> String {
    value.map_or("nothing".to_owned(), |value| quoted(&value.to_string()))
}

/// Refuses a set that lacks a shard or has one twice; `first` is the path of its first.
fn refuse_incomplete(first: &Path, parts: &[Part]) -> Result<()> {
    let count = parts.first().map_or(0, |part| part.shard.count);
    let refuse = |found: String, remedy: &str| {
        Err(Error::refuse(first, "shards", found, format!("each of the {count} shards once"), remedy))
    };
    let missing = missing(count, parts);
    if !missing.is_empty() {
        return refuse(format!("no shard {missing}"), "write the missing shards");
    }
    let repeated: Vec<String> = parts.windows(2).filter_map(twice).collect();
    if repeated.is_empty() { Ok(()) } else { refuse(repeated.join(", "), "name each shard once") }
}

/// The numbers of the missing shards, as text.
fn missing(count: u32, parts: &[Part]) -> String {
    let present: BTreeSet<u32> = parts.iter().map(|part| part.shard.index).collect();
    let absent = (1..=count).filter(|index| !present.contains(index));
    let named: Vec<String> = absent.take(MOST_NAMED).map(|index| format!("{index}/{count}")).collect();
    let rest = (count as usize).saturating_sub(present.len() + named.len());
    let rest = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    named.join(", ") + &rest
}

/// Both paths, if two neighbours have the same number.
fn twice(pair: &[Part]) -> Option<String> {
    let [one, two] = pair else { return None };
    let shown = || format!("shard {} in {} and in {}", one.shard, one.path.display(), two.path.display());
    (one.shard == two.shard).then(shown)
}
