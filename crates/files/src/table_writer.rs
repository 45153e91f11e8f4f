//! Writing a table block by block.

use std::fmt;
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::{
    ColumnChunkMetaData, FileMetaData, KeyValue, ParquetMetaData, ParquetMetaDataWriter, RowGroupMetaData,
};
use parquet::file::reader::ChunkReader;
use parquet::file::writer::TrackedWrite;
use parquet::schema::types::SchemaDescPtr;
use tempfile::NamedTempFile;

use crate::columns::{Column, ColumnSpec, TableSchema};
use crate::encode::{Chunk, EncodedBlock, check_piece, check_rows};
use crate::error::{Error, Result};
use crate::footer::Footer;
use crate::layout::{self, KEY, TableMetadata, descriptor, write_error};
use crate::provenance::Provenance;
use crate::seal::Digest;
use crate::staged::{Staged, create_temporary, fault};

/// Bytes that are hashed and written at a time: hashing is several times faster on long blocks.
const BUFFER: usize = 1 << 18;

/// The first bytes of a Parquet file, its version, and its producer.
const MAGIC: &[u8] = b"PAR1";
const FORMAT: i32 = 1;
const CREATOR: &str = "seatrial";

/// A table being written, under a temporary name beside its target. Dropped before
/// [`TableWriter::finish`], the file disappears. Holds no more than one block in memory.
pub struct TableWriter {
    path: PathBuf,
    columns: Vec<ColumnSpec>,
    metadata: TableMetadata,
    descriptor: SchemaDescPtr,
    to: TrackedWrite<BufWriter<Hashed>>,
    /// The blocks for the footer.
    groups: Vec<RowGroupMetaData>,
    /// Whether a block was refused after a part of it was written.
    cut_short: bool,
}

impl TableWriter {
    /// Starts a table that will stand at `path`.
    ///
    /// # Errors
    /// [`Error::Refused`] if the schema has a column without name or unit, with a duplicate name, or nullable
    /// and not f64; [`Error::Io`] if the file cannot be created.
    pub fn create(path: impl AsRef<Path>, schema: &TableSchema, provenance: &Provenance) -> Result<Self> {
        let path = path.as_ref();
        provenance.check_output(path)?;
        let descriptor = descriptor(path, &schema.columns)?;
        let metadata = TableMetadata::new(schema, provenance);
        let file = Hashed { file: create_temporary(path)?, hasher: blake3::Hasher::new() };
        let buffered = BufWriter::with_capacity(BUFFER, file);
        let mut to = TrackedWrite::new(buffered);
        to.write_all(MAGIC).map_err(|e| Error::io(path, "write", e))?;
        let (path, columns) = (path.to_owned(), schema.columns.clone());
        Ok(Self { path, columns, metadata, descriptor, to, groups: Vec::new(), cut_short: false })
    }

    /// Names the document beside the table that vouches for it (see [`crate::stage_set_document`]).
    #[must_use]
    pub fn with_document(mut self, document: &Path) -> Self {
        let name = document.file_name().unwrap_or_default();
        self.metadata.document = Some(name.to_string_lossy().into_owned());
        self
    }

    /// Appends a block. Blocks are in the file in the order in which they are pushed; one without rows leaves
    /// no trace.
    ///
    /// # Errors
    /// [`Error::Refused`] if the block was encoded for other columns; [`Error::Io`] if the file
    /// cannot be written.
    pub fn push(&mut self, block: EncodedBlock) -> Result<()> {
        self.check_columns(&block.columns)?;
        if block.rows == 0 {
            return Ok(());
        }
        let start = self.to.bytes_written() as i64;
        let chunks = block.chunks.iter().map(|chunk| moved(chunk, start));
        let written = chunks.collect::<ParquetResult<_>>().and_then(|chunks| {
            self.to.write_all(&block.bytes)?;
            self.complete_group(start, block.rows, chunks)
        });
        written.map_err(|e| write_error(&self.path, e))
    }

    /// Appends a block of `rows` rows as [`crate::encode_block`] and [`TableWriter::push`] would, without
    /// ever having it in memory: `column` yields the pieces of the column at an index of the schema. All but
    /// the last must have [`crate::PIECE_ROWS`] rows, or pages would end elsewhere.
    ///
    /// # Errors
    /// As theirs.
    pub fn write<'t>(
        &mut self,
        schema: &TableSchema,
        rows: usize,
        column: impl Fn(usize) -> Box<dyn Iterator<Item = Column> + 't>,
    ) -> Result<()> {
        self.check_columns(&schema.columns)?;
        if rows == 0 {
            return Ok(());
        }
        self.cut_short = true;
        let file = Path::new(schema.id);
        let failed = |e| write_error(&self.path, e);
        let start = self.to.bytes_written() as i64;
        let mut chunks = Vec::with_capacity(schema.columns.len());
        for (i, spec) in schema.columns.iter().enumerate() {
            let chunk = Chunk::new(spec.kind, self.descriptor.column(i), &mut self.to);
            let mut chunk = chunk.map_err(failed)?;
            let mut written = 0;
            for piece in column(i) {
                check_piece(file, spec, &piece, written)?;
                chunk.push(&piece).map_err(failed)?;
                written += piece.len();
            }
            check_rows(file, spec, written, rows)?;
            chunks.push(chunk.close().map_err(failed)?);
        }
        self.complete_group(start, rows, chunks).map_err(|e| write_error(&self.path, e))?;
        self.cut_short = false;
        Ok(())
    }

    /// Records a block for the footer: its columns are in the file from `start` on.
    fn complete_group(
        &mut self,
        start: i64,
        rows: usize,
        chunks: Vec<ColumnChunkMetaData>,
    ) -> ParquetResult<()> {
        let mut group = RowGroupMetaData::builder(self.descriptor.clone())
            .set_total_byte_size(chunks.iter().map(ColumnChunkMetaData::uncompressed_size).sum())
            .set_column_metadata(chunks)
            .set_num_rows(rows as i64)
            .set_file_offset(start);
        // Block numbers are optional, and there may be more blocks than numbers.
        if let Ok(number) = i16::try_from(self.groups.len()) {
            group = group.set_ordinal(number);
        }
        self.groups.push(group.build()?);
        Ok(())
    }

    fn check_columns(&self, columns: &[ColumnSpec]) -> Result<()> {
        if columns == self.columns {
            return Ok(());
        }
        let (found, expected) = ("a block with other columns", "the columns of the table's schema");
        Err(Error::refuse(&self.path, "block", found, expected, "encode it with that schema"))
    }

    /// Replaces the inputs, if more is known about them than at the start.
    pub fn set_inputs(&mut self, provenance: &Provenance) {
        self.metadata.inputs.clone_from(&provenance.inputs);
        self.metadata.settings.clone_from(&provenance.settings);
    }

    /// Appends a row group of `rows` rows whose column chunks are in `source`.
    pub(crate) fn append(
        &mut self,
        source: &impl ChunkReader,
        rows: usize,
        chunks: &[ColumnChunkMetaData],
    ) -> Result<()> {
        let copied = self.copy_chunks(source, chunks).and_then(|(start, chunks)| {
            // Chunks are contiguous, so the first one's position is the block's.
            self.complete_group(start, rows, chunks)
        });
        copied.map_err(|e| write_error(&self.path, e))
    }

    fn copy_chunks(
        &mut self,
        source: &impl ChunkReader,
        chunks: &[ColumnChunkMetaData],
    ) -> ParquetResult<(i64, Vec<ColumnChunkMetaData>)> {
        let start = self.to.bytes_written() as i64;
        let mut copied = Vec::with_capacity(chunks.len());
        for chunk in chunks {
            let (from, length) = chunk.byte_range();
            copied.push(moved(chunk, self.to.bytes_written() as i64 - from as i64)?);
            let written = io::copy(&mut source.get_read(from)?.take(length), &mut self.to)?;
            if written != length {
                return Err(ParquetError::EOF(format!("{written} bytes of a column of {length}")));
            }
        }
        Ok((start, copied))
    }

    /// Completes and seals the file and flushes it to the disk; [`crate::commit`] gives it its name.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be written.
    pub fn finish(mut self) -> Result<Staged> {
        let path = self.path;
        let metadata = serde_json::to_string(&self.metadata);
        let metadata = metadata.map_err(|e| Error::io(&path, "write", e.into()))?;
        if self.cut_short {
            let what = io::Error::other("a block that was not written to its end");
            return Err(Error::io(&path, "write", what));
        }
        let rows = self.groups.iter().map(RowGroupMetaData::num_rows).sum();
        let units = KeyValue::new(layout::ARROW_KEY.to_owned(), layout::arrow_schema(&self.columns));
        let notes = vec![KeyValue::new(KEY.to_owned(), metadata), units];
        let creator = Some(CREATOR.to_owned());
        let file = FileMetaData::new(FORMAT, rows, creator, Some(notes), self.descriptor, None);
        let mut footer = Vec::new();
        ParquetMetaDataWriter::new(&mut footer, &ParquetMetaData::new(file, self.groups))
            .finish()
            .and_then(|()| Ok(self.to.write_all(&footer)?))
            .map_err(|e| write_error(&path, e))?;
        let buffered = self.to.into_inner().map_err(|e| write_error(&path, e))?;
        let Hashed { mut file, hasher } =
            buffered.into_inner().map_err(|e| Error::io(&path, "write", e.into_error()))?;
        let footer = Footer::read(&path, file.as_file_mut())?;
        let at = footer
            .seal_digits_at(&path, Digest::ZERO)?
            .unwrap_or_else(|| unreachable!("the envelope has a blank seal"));
        let seal = Digest::from(hasher.finalize());
        patch(file.as_file_mut(), at, &seal.hex()).map_err(|e| Error::io(&path, "write", e))?;
        Staged::complete(file, &path)
    }
}

impl fmt::Debug for TableWriter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TableWriter").field("path", &self.path).finish_non_exhaustive()
    }
}

/// The footer's description of a column, moved by `by` bytes.
fn moved(chunk: &ColumnChunkMetaData, by: i64) -> ParquetResult<ColumnChunkMetaData> {
    chunk
        .clone()
        .into_builder()
        .set_data_page_offset(chunk.data_page_offset() + by)
        .set_dictionary_page_offset(chunk.dictionary_page_offset().map(|offset| offset + by))
        .build()
}

fn patch(file: &mut File, at: u64, text: &str) -> io::Result<()> {
    fault::point("seal")?;
    file.seek(SeekFrom::Start(at))?;
    file.write_all(text.as_bytes())
}

/// A temporary file that is hashed while it is written.
struct Hashed {
    file: NamedTempFile,
    hasher: blake3::Hasher,
}

impl Write for Hashed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        fault::point("write")?;
        let written = self.file.as_file_mut().write(bytes)?;
        self.hasher.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_file_mut().flush()
    }
}
