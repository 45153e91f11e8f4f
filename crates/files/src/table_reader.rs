//! Reading a table block by block.

use std::fmt;
use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};

use parquet::errors::Result as ParquetResult;
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataOptions, RowGroupMetaData};
use serde::de::DeserializeOwned;

use crate::access::{Source, open};
use crate::budget::{Work, budget};
use crate::columns::{Column, ColumnSpec, Kind, Table};
use crate::decode::{Undecoded, decode_column, decoded};
use crate::document::check_companion;
use crate::error::{Complaint, Error, Result};
use crate::footer::{self, Footer};
use crate::identity::Header;
use crate::layout::TableMetadata;
use crate::provenance::Provenance;
use crate::seal::{self, Digest};

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
        let metadata = guarded(path, || footer::metadata(&footer.bytes, &options))?;
        let columns = crate::agreement::columns(path, entries, metadata.file_metadata().schema_descr())?;
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
        crate::agreement::require(&self.path, &self.columns, columns)
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
        let places = crate::agreement::places(&self.path, &self.columns, names)?;
        let width = |place: &usize| match self.columns[*place].kind {
            Kind::F64 => size_of::<f64>(),
            Kind::I32 | Kind::Text => size_of::<u32>(),
        };
        self.check_memory(rows.len(), places.iter().map(width).sum())?;
        let group = self.metadata.row_group(i);
        let mut columns = Vec::with_capacity(places.len());
        for place in places {
            let decode = || decode_column(&self.source, group.column(place), rows.len());
            let column = guarded(&self.path, decode)?;
            self.check_values(place, &column, rows.start)?;
            columns.push(column);
        }
        Ok(Table { columns })
    }

    /// Checks all values of an unsealed table, whose blocks are to be copied unchanged.
    ///
    /// # Errors
    /// See [`TableReader::read_block`].
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
        let found = format!("{rows} rows");
        let remedy = "write the table in smaller parts, or raise --memory-mib";
        budget().memory(
            Work { file: &self.path, thing: "rows", found: &found, remedy },
            bytes as f64 * rows as f64,
        )
    }

    fn check_values(&self, place: usize, column: &Column, start: usize) -> Result<()> {
        let Some(row) = column.first_not_finite() else {
            return Ok(());
        };
        let thing = format!("column `{}`, row {}", self.columns[place].name, start + row);
        let found = column.as_f64().map(|values| values[row].to_string()).unwrap_or_default();
        Err(Error::refuse(&self.path, thing, found, "a finite number", "write the file again"))
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
        seal::check_kind(path, header.seal(), digests)?;
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
    groups
        .iter()
        .map(next)
        .collect::<Option<_>>()
        .ok_or_else(|| damaged(path, "an impossible number of rows"))
}

fn guarded<T>(path: &Path, decode: impl FnOnce() -> ParquetResult<T>) -> Result<T> {
    decoded(decode).map_err(|undecoded| match undecoded {
        Undecoded::Unreadable(io) => Error::io(path, "read", io),
        Undecoded::Damaged(found) => damaged(path, &found),
    })
}

fn damaged(path: &Path, found: &str) -> Error {
    Error::refuse(path, "contents", found, "a readable table", "the file is damaged: write it again")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::TableSchema;
    use crate::document::commit;
    use crate::encode::encode_checked;
    use crate::layout::Layout;
    use crate::table_writer::TableWriter;

    /// A file such as only another program could write: the second block has a NaN in row 3.
    #[test]
    fn numbers_that_are_not_finite_are_refused_with_their_row_in_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t");
        let (name, unit) = ("u".to_owned(), "m/s".to_owned());
        let columns = vec![ColumnSpec { name, unit, kind: Kind::F64, nullable: true }];
        let schema = TableSchema { id: "t", version: 1, columns };
        let layout = Layout::new(&path, &schema.columns).unwrap();
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
