//! Writing a table block by block.

use std::fmt;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use parquet::column::writer::ColumnCloseResult;
use parquet::errors::Result as ParquetResult;
use parquet::file::metadata::KeyValue;
use parquet::file::reader::ChunkReader;
use parquet::file::writer::SerializedFileWriter;
use tempfile::NamedTempFile;

use crate::columns::Column;
use crate::digest::Digest;
use crate::encode::{EncodedBlock, check_piece, check_rows, write_values};
use crate::error::{Error, Result};
use crate::fault;
use crate::footer::Footer;
use crate::layout::{Layout, write_error};
use crate::metadata::{KEY, TableMetadata};
use crate::provenance::Provenance;
use crate::schema::{ColumnSpec, TableSchema};
use crate::staged::{Staged, create_temporary};

/// Rows of the pieces that columns are given in: a multiple of what the encoder looks at before it ends a page.
pub const PIECE_ROWS: usize = 1 << 16;

/// Bytes that are hashed and written at a time: the hash is several times faster on long pieces.
const PIECE: usize = 1 << 18;

/// A table being written, under a temporary name beside its target. Dropped before
/// [`TableWriter::finish`], the file disappears. Holds no more than one block in memory.
pub struct TableWriter {
    path: PathBuf,
    columns: Vec<ColumnSpec>,
    metadata: TableMetadata,
    writer: SerializedFileWriter<BufWriter<Hashed>>,
}

impl TableWriter {
    /// Starts a table that will stand at `path`.
    ///
    /// # Errors
    /// [`Error::Refused`] if the schema has a column without name or unit, of a name that
    /// occurs twice, or nullable and not f64; [`Error::Io`] if the file cannot be created.
    pub fn create(path: impl AsRef<Path>, schema: &TableSchema, provenance: &Provenance) -> Result<Self> {
        let path = path.as_ref();
        provenance.check_output(path)?;
        let layout = Layout::new(path, &schema.columns)?;
        let metadata = TableMetadata::new(schema, provenance);
        let file = Hashed { file: create_temporary(path)?, hasher: blake3::Hasher::new() };
        let pieces = BufWriter::with_capacity(PIECE, file);
        let writer = SerializedFileWriter::new(pieces, layout.root, layout.properties);
        let writer = writer.map_err(|e| write_error(path, e))?;
        Ok(Self { path: path.to_owned(), columns: schema.columns.clone(), metadata, writer })
    }

    /// Names the document beside the table that vouches for it (see [`crate::stage_set_document`]).
    #[must_use]
    pub fn with_document(mut self, document: &Path) -> Self {
        let name = document.file_name().unwrap_or_default();
        self.metadata.document = Some(name.to_string_lossy().into_owned());
        self
    }

    /// Appends a block. Blocks stand in the file in the order in which they are pushed; one without
    /// rows leaves no trace.
    ///
    /// # Errors
    /// [`Error::Refused`] if the block was encoded for other columns; [`Error::Io`] if the file
    /// cannot be written.
    pub fn push(&mut self, block: EncodedBlock) -> Result<()> {
        self.check_columns(&block.columns)?;
        if block.rows == 0 {
            return Ok(());
        }
        self.append(&block.bytes, block.chunks)
    }

    /// Appends a block of `rows` rows as [`crate::encode_block`] and [`TableWriter::push`] would, without ever having it in
    /// memory: `column` gives the pieces of the column at a place of the schema. All but the last must be of
    /// [`PIECE_ROWS`] rows, or pages would end elsewhere.
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
        let file = Path::new(schema.id);
        let failed = |e| write_error(&self.path, e);
        let mut group = self.writer.next_row_group().map_err(failed)?;
        for (i, spec) in schema.columns.iter().enumerate() {
            let Some(mut writer) = group.next_column().map_err(failed)? else { break };
            let mut written = 0;
            for piece in column(i) {
                check_piece(file, spec, &piece, written)?;
                write_values(writer.untyped(), spec, &piece).map_err(failed)?;
                written += piece.len();
            }
            check_rows(file, spec, written, rows)?;
            writer.close().map_err(failed)?;
        }
        group.close().map(drop).map_err(failed)
    }

    fn check_columns(&self, found: &[ColumnSpec]) -> Result<()> {
        if found == self.columns {
            return Ok(());
        }
        let (found, expected) = ("a block with other columns", "the columns of the table's schema");
        Err(Error::refuse(&self.path, "block", found, expected, "encode it with that schema"))
    }

    /// What the table was made of, where more is known of that than at its start.
    pub fn set_inputs(&mut self, provenance: &Provenance) {
        self.metadata.inputs.clone_from(&provenance.inputs);
    }

    /// Appends a row group whose column chunks lie in `source`.
    pub(crate) fn append(&mut self, source: &impl ChunkReader, chunks: Vec<ColumnCloseResult>) -> Result<()> {
        let copied = append_chunks(&mut self.writer, source, chunks);
        copied.map_err(|e| write_error(&self.path, e))
    }

    /// Completes and seals the file and flushes it to the disk; [`crate::commit`] gives it its name.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be written.
    pub fn finish(mut self) -> Result<Staged> {
        let path = self.path;
        let metadata = serde_json::to_string(&self.metadata);
        let metadata = metadata.map_err(|e| Error::io(&path, "write", e.into()))?;
        self.writer.append_key_value_metadata(KeyValue::new(KEY.to_owned(), metadata));
        let pieces = self.writer.into_inner().map_err(|e| write_error(&path, e))?;
        let Hashed { mut file, hasher } =
            pieces.into_inner().map_err(|e| Error::io(&path, "write", e.into_error()))?;
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

fn append_chunks(
    writer: &mut SerializedFileWriter<BufWriter<Hashed>>,
    source: &impl ChunkReader,
    chunks: Vec<ColumnCloseResult>,
) -> ParquetResult<()> {
    let mut group = writer.next_row_group()?;
    for chunk in chunks {
        group.append_column(source, chunk)?;
    }
    group.close()?;
    Ok(())
}

fn patch(file: &mut File, at: u64, text: &str) -> io::Result<()> {
    fault::point("seal")?;
    file.seek(SeekFrom::Start(at))?;
    file.write_all(text.as_bytes())
}

/// A temporary file that is hashed as it is written.
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
