//! Compares the columns of a file with the wanted ones.

use std::path::Path;

use parquet::schema::types::{ColumnDescriptor, SchemaDescriptor};
use refusal::{foreign, nearest};

use crate::columns::{ColumnSpec, Kind};
use crate::error::{Error, Result};
use crate::layout::{ColumnEntry, physical};

/// The columns of a file, if its envelope agrees with its Parquet schema.
pub(crate) fn columns(
    path: &Path,
    entries: Vec<ColumnEntry>,
    schema: &SchemaDescriptor,
) -> Result<Vec<ColumnSpec>> {
    let agree = entries.len() == schema.num_columns()
        && entries.iter().zip(schema.columns()).all(|(entry, descriptor)| fits(entry, descriptor));
    if !agree {
        let (found, expected) = ("columns other than those in the metadata", "the same columns in both");
        return Err(Error::refuse(path, "columns", found, expected, "write the file again"));
    }
    let spec = |(entry, descriptor): (ColumnEntry, &std::sync::Arc<ColumnDescriptor>)| {
        let ColumnEntry { name, unit, kind } = entry;
        ColumnSpec { name, unit, kind, nullable: descriptor.max_def_level() > 0 }
    };
    Ok(entries.into_iter().zip(schema.columns()).map(spec).collect())
}

fn fits(entry: &ColumnEntry, descriptor: &ColumnDescriptor) -> bool {
    let deepest = if entry.kind == Kind::F64 { 1 } else { 0 };
    descriptor.path().parts() == [entry.name.as_str()]
        && descriptor.physical_type() == physical(entry.kind)
        && descriptor.max_rep_level() == 0
        && descriptor.max_def_level() <= deepest
}

/// Refuses if a wanted column is missing (all are named), or has another unit or type.
pub(crate) fn require(path: &Path, found: &[ColumnSpec], wanted: &[ColumnSpec]) -> Result<()> {
    let names: Vec<&str> = wanted.iter().map(|column| column.name.as_str()).collect();
    let places = places(path, found, &names)?;
    let mut differ = [const { Vec::new() }; 3];
    for (wanted, found) in wanted.iter().zip(places.into_iter().map(|place| &found[place])) {
        if (&wanted.unit, wanted.kind) != (&found.unit, found.kind) {
            let parts = [format!("`{}`", wanted.name), what(found), what(wanted)];
            differ.iter_mut().zip(parts).for_each(|(list, part)| list.push(part));
        }
    }
    if differ[0].is_empty() {
        return Ok(());
    }
    let [thing, found, expected] = differ.map(|list| list.join(", "));
    let remedy = "convert the values, correct the unit and write the file again";
    Err(Error::refuse(path, format!("column {thing}"), found, expected, remedy))
}

fn what(column: &ColumnSpec) -> String {
    format!("{} in unit {}", column.kind, foreign(&column.unit))
}

/// The indices of the named columns; a refusal names all that are missing.
pub(crate) fn places(path: &Path, columns: &[ColumnSpec], names: &[&str]) -> Result<Vec<usize>> {
    let place = |name: &&str| columns.iter().position(|column| column.name == **name);
    let missing: Vec<&str> = names.iter().filter(|name| place(name).is_none()).copied().collect();
    if missing.is_empty() {
        return Ok(names.iter().filter_map(place).collect());
    }
    let known = || columns.iter().map(|column| column.name.as_str());
    let near: Vec<&str> = missing.iter().filter_map(|name| nearest(name, known())).collect();
    let remedy = format!("write the file again with them (nearest in the file: {})", list(&near));
    let known: Vec<&str> = known().collect();
    Err(Error::refuse(path, "columns", list(&known), format!("also {}", list(&missing)), remedy))
}

fn list(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{}`", foreign(name))).collect();
    if quoted.is_empty() { "none".to_owned() } else { quoted.join(", ") }
}
