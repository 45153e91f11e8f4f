//! Reading a table block by block.

use std::fmt;
use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};

use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataOptions, RowGroupMetaData};
use parquet::schema::types::{ColumnDescriptor, SchemaDescriptor};
use refusal::{foreign, nearest};
use serde::de::DeserializeOwned;

use crate::access::{Source, open};
use crate::budget::{Work, budget};
use crate::columns::{Column, ColumnSpec, Kind, Table};
use crate::decode::{decode_column, guarded};
use crate::document::check_companion;
use crate::error::{Complaint, Error, Result};
use crate::footer::{self, Footer};
use crate::layout::{ColumnEntry, TableMetadata, physical};
use crate::provenance::Provenance;
use crate::seal::{self, Digest, Header};

/// A table whose kind, version, seal and schema have been checked.
pub struct TableReader {
    path: PathBuf,
    source: Source,
    metadata: ParquetMetaData,
    columns: Vec<ColumnSpec>,
    provenance: Provenance,
    digest: Digest,
    /// Rows of each block within the file.
    blocks: Vec<Range<usize>>,
    sealed: bool,
}

impl TableReader {
    /// Opens the table at `path`, which must be of kind `id` in version `version`.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read; [`Error::Refused`] if it is not Parquet, not of this kind
    /// and version, does not match its seal, or is not the table that the document beside it was written
    /// with.
    pub fn open(path: impl AsRef<Path>, id: &'static str, version: u32) -> Result<Self> {
        let path = path.as_ref();
        let Whole { file, footer, header, envelope, digest } = Whole::open(path, Some((id, version)))?;
        let (entries, provenance) = envelope.into_parts();
        // Statistics are kept as stored, so that a copied block has the same bytes.
        let options = ParquetMetaDataOptions::new().with_encoding_stats_as_mask(false);
        let metadata = guarded(path, damaged, || footer::metadata(&footer.bytes, &options))?;
        let columns = agreed_columns(path, entries, metadata.file_metadata().schema_descr())?;
        let blocks = block_rows(path, metadata.row_groups())?;
        let source = Source::new(file).map_err(|e| Error::io(path, "read", e))?;
        let (path, sealed) = (path.to_owned(), header.seal().is_some());
        Ok(Self { path, source, metadata, columns, provenance, digest, blocks, sealed })
    }

    /// Checks that the table has these columns, with these units and types.
    ///
    /// Whether a column may hold nulls is not compared: absent values read as NaN, and
    /// [`Column::nulls`] counts them.
    ///
    /// # Errors
    /// [`Error::Refused`] naming all missing columns at once, or else all that differ.
    pub fn require(&self, columns: &[ColumnSpec]) -> Result<()> {
        require_columns(&self.path, &self.columns, columns)
    }

    /// Columns in file order.
    pub fn columns(&self) -> &[ColumnSpec] {
        &self.columns
    }

    /// The origin of the table.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// Digest of the file.
    pub fn digest(&self) -> Digest {
        self.digest
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.blocks.last().map_or(0, |block| block.end)
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Number of rows in block `i`; 0 if there is no such block.
    pub fn block_rows(&self, i: usize) -> usize {
        self.blocks.get(i).map_or(0, Range::len)
    }

    /// Reads the named columns of block `i`, and no others, in the order of `names`. May be called
    /// from many threads at once.
    ///
    /// # Errors
    /// [`Error::Refused`] if there is no such block or column, if a value is NaN or infinite (with
    /// column and row in the file), or if the bytes cannot be decoded; [`Error::Io`] if they cannot
    /// be read.
    pub fn read_block(&self, i: usize, names: &[&str]) -> Result<Table> {
        let Some(rows) = self.blocks.get(i).cloned() else {
            let (found, expected) = (format!("block {i}"), format!("a block below {}", self.blocks()));
            return Err(Error::refuse(&self.path, "block", found, expected, "ask for a block of the file"));
        };
        let places = column_places(&self.path, &self.columns, names)?;
        let width = |place: &usize| match self.columns[*place].kind {
            Kind::F64 => size_of::<f64>(),
            Kind::I32 | Kind::Text => size_of::<u32>(),
        };
        self.check_memory(rows.len(), places.iter().map(width).sum())?;
        let group = self.metadata.row_group(i);
        let mut columns = Vec::with_capacity(places.len());
        for place in places {
            let decode = || decode_column(&self.source, group.column(place), rows.len());
            let column = guarded(&self.path, damaged, decode)?;
            self.check_values(place, &column, rows.start)?;
            columns.push(column);
        }
        Ok(Table { columns })
    }

    /// Checks all values of an unsealed table, whose blocks are to be copied unchanged.
    pub(crate) fn check_unsealed(&self) -> Result<()> {
        let names: Vec<&str> = self.columns.iter().map(|column| column.name.as_str()).collect();
        let blocks = if self.sealed { 0 } else { self.blocks() };
        (0..blocks).try_for_each(|i| self.read_block(i, &names).map(drop))
    }

    /// The path, for messages.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file, for copying blocks byte for byte.
    pub(crate) fn source(&self) -> &Source {
        &self.source
    }

    /// The footer's description of the blocks.
    pub(crate) fn row_groups(&self) -> &[RowGroupMetaData] {
        self.metadata.row_groups()
    }

    /// Refuses rows of `bytes` each that exceed the memory: few bytes of a file can represent many rows.
    pub(crate) fn check_memory(&self, rows: usize, bytes: usize) -> Result<()> {
        let amount = format!("{rows} rows");
        let remedy = "write the table in smaller parts, or raise --memory-mib";
        let work = Work { file: &self.path, thing: "rows", found: &amount, remedy };
        budget().memory(work, bytes as f64 * rows as f64)
    }

    fn check_values(&self, place: usize, column: &Column, start: usize) -> Result<()> {
        let Some(row) = column.first_not_finite() else {
            return Ok(());
        };
        let thing = format!("column `{}`, row {}", self.columns[place].name, start + row);
        let value = column.as_f64().map(|values| values[row].to_string()).unwrap_or_default();
        Err(Error::refuse(&self.path, thing, value, "a finite number", "write the file again"))
    }
}

/// A table that matches its seal and the document beside it; its rows are not checked yet.
pub(crate) struct Whole {
    file: File,
    footer: Footer,
    pub header: Header,
    pub envelope: TableMetadata,
    pub digest: Digest,
}

impl Whole {
    /// Opens the table at `path`, of `kind` (id and version) if one is requested.
    pub fn open(path: &Path, kind: Option<(&'static str, u32)>) -> Result<Self> {
        let unreadable = |e| Error::io(path, "read", e);
        let mut file = open(path)?;
        let footer = Footer::read(path, &mut file)?;
        let text = footer.envelope(path)?;
        let header: Header = parse(path, text)?;
        kind.map_or(Ok(()), |(id, version)| header.check(path, id, version))?;
        let digits_at = header.seal().map(|seal| footer.seal_digits_at(path, seal)).transpose()?.flatten();
        let digests = seal::digests(&mut file, digits_at).map_err(unreadable)?;
        seal::check_seal(path, header.seal(), digests)?;
        let envelope: TableMetadata = parse(path, text)?;
        check_companion(path, digests.digest, envelope.document.as_deref())?;
        Ok(Self { file, footer, header, envelope, digest: digests.digest })
    }
}

impl fmt::Debug for TableReader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TableReader").field("path", &self.path).finish_non_exhaustive()
    }
}

fn parse<T: DeserializeOwned>(path: &Path, envelope: &str) -> Result<T> {
    serde_json::from_str(envelope).map_err(|e| {
        let full = e.to_string();
        let message = full.rsplit_once(" at line ").map_or(full.as_str(), |(message, _)| message);
        Complaint { path, place: None, key: Some("metadata".to_owned()), message }.refusal()
    })
}

/// Rows of each block within the file.
fn block_rows(path: &Path, groups: &[RowGroupMetaData]) -> Result<Vec<Range<usize>>> {
    let mut end: usize = 0;
    let next = |group: &RowGroupMetaData| {
        let start = end;
        end = end.checked_add(usize::try_from(group.num_rows()).ok()?)?;
        Some(start..end)
    };
    let blocks = groups.iter().map(next).collect::<Option<_>>();
    blocks.ok_or_else(|| damaged(path, "an impossible number of rows"))
}

fn damaged(path: &Path, fault: &str) -> Error {
    Error::refuse(path, "contents", fault, "a readable table", "the file is damaged: write it again")
}

/// The columns of a file, if its envelope agrees with its Parquet schema.
fn agreed_columns(
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
fn require_columns(path: &Path, found: &[ColumnSpec], wanted: &[ColumnSpec]) -> Result<()> {
    let names: Vec<&str> = wanted.iter().map(|column| column.name.as_str()).collect();
    let places = column_places(path, found, &names)?;
    let mut differ = [const { Vec::new() }; 3];
    for (wanted, found) in wanted.iter().zip(places.into_iter().map(|place| &found[place])) {
        if (&wanted.unit, wanted.kind) != (&found.unit, found.kind) {
            let parts = [format!("`{}`", wanted.name), kind_of(found), kind_of(wanted)];
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

fn kind_of(column: &ColumnSpec) -> String {
    format!("{} in unit {}", column.kind, foreign(&column.unit))
}

/// The indices of the named columns; a refusal names all that are missing.
fn column_places(path: &Path, columns: &[ColumnSpec], names: &[&str]) -> Result<Vec<usize>> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::TableSchema;
    use crate::document::commit;
    use crate::encode::encode_checked;
    use crate::layout::descriptor;
    use crate::table_writer::TableWriter;

    /// A file such as only another program could write: the second block has a NaN in row 3.
    #[test]
    fn numbers_that_are_not_finite_are_refused_with_their_row_in_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t");
        let (name, unit) = ("u".to_owned(), "m/s".to_owned());
        let columns = vec![ColumnSpec { name, unit, kind: Kind::F64, nullable: true }];
        let schema = TableSchema { id: "t", version: 1, columns };
        let layout = descriptor(&path, &schema.columns).unwrap();
        let mut writer = TableWriter::create(&path, &schema, &Provenance::default()).unwrap();
        for value in [0.5, f64::NAN] {
            let columns = vec![Column::f64(vec![1.0, 2.0, 3.0, value])];
            writer.push(encode_checked(&schema, &layout, &Table { columns }).unwrap()).unwrap();
        }
        commit(vec![writer.finish().unwrap()]).unwrap();
        let reader = TableReader::open(&path, "t", 1).unwrap();
        reader.read_block(0, &["u"]).unwrap();
        let line = reader.read_block(1, &["u"]).unwrap_err().to_string();
        assert!(line.contains("t: column `u`, row 7: found NaN, expected a finite number"), "{line}");
    }
}
