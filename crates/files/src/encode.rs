//! Encoding one block of a table in memory, and one column of a block by the parquet crate.

use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, Type as Physical, ZstdLevel};
use parquet::column::writer::{ColumnWriter, get_column_writer};
use parquet::data_type::ByteArray;
use parquet::errors::Result as ParquetResult;
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesPtr};
use parquet::file::writer::{SerializedPageWriter, TrackedWrite};
use parquet::schema::types::{ColumnDescPtr, SchemaDescriptor};

use crate::columns::{Column, ColumnSpec, Kind, Table, TableSchema};
use crate::error::{Error, Result};
use crate::layout::{descriptor, general, write_error};

/// One block in its file format: a row group.
#[derive(Debug)]
pub struct EncodedBlock {
    pub(crate) columns: Vec<ColumnSpec>,
    pub(crate) rows: usize,
    pub(crate) bytes: Vec<u8>,
    pub(crate) chunks: Vec<ColumnChunkMetaData>,
}

/// Encodes one block of a table as one Parquet row group. Pure: call it from many threads and push the
/// results in the order of the file.
///
/// # Errors
/// [`Error::Refused`] if the columns are not those of the schema or not equally long, if a value
/// is NaN or infinite or absent where it may not be (with column and row in the block), or if a text
/// has no label.
pub fn encode_block(schema: &TableSchema, table: &Table) -> Result<EncodedBlock> {
    let file = Path::new(schema.id);
    let layout = descriptor(file, &schema.columns)?;
    check_shape(file, schema, table)?;
    let mut pairs = schema.columns.iter().zip(&table.columns);
    pairs.try_for_each(|(spec, column)| check_piece(file, spec, column, 0))?;
    encode_checked(schema, &layout, table).map_err(|e| write_error(file, e))
}

/// Encodes a block whose values have been checked.
pub(crate) fn encode_checked(
    schema: &TableSchema,
    layout: &SchemaDescriptor,
    table: &Table,
) -> ParquetResult<EncodedBlock> {
    let rows = table.columns.first().map_or(0, Column::len);
    // Of numbers, without compression.
    let width = |column: &ColumnDescPtr| if column.physical_type() == Physical::DOUBLE { 8 } else { 1 };
    let bytes = rows * layout.columns().iter().map(width).sum::<usize>();
    let mut sink = TrackedWrite::new(Vec::with_capacity(bytes));
    let mut chunks = Vec::with_capacity(table.columns.len());
    for (i, column) in table.columns.iter().enumerate() {
        let mut chunk = Chunk::new(column.kind(), layout.column(i), &mut sink)?;
        chunk.push(column)?;
        chunks.push(chunk.close()?);
    }
    Ok(EncodedBlock { columns: schema.columns.clone(), rows, bytes: sink.into_inner()?, chunks })
}

const REMEDY: &str = "give the block the columns of its schema";

/// Refuses a block that has other columns than the schema, or columns of different lengths.
fn check_shape(file: &Path, schema: &TableSchema, table: &Table) -> Result<()> {
    let (found, expected) = (table.columns.len(), schema.columns.len());
    if found != expected {
        let (found, expected) = (format!("{found} columns"), format!("{expected} columns"));
        return Err(Error::refuse(file, "block", found, expected, REMEDY));
    }
    let rows = table.columns.first().map_or(0, Column::len);
    for (spec, column) in schema.columns.iter().zip(&table.columns) {
        check_kind(file, spec, column)?;
        check_rows(file, spec, column.len(), rows)?;
    }
    Ok(())
}

fn check_kind(file: &Path, spec: &ColumnSpec, column: &Column) -> Result<()> {
    if column.kind() == spec.kind {
        return Ok(());
    }
    let (found, expected) = (column.kind().to_string(), spec.kind.to_string());
    Err(Error::refuse(file, format!("column `{}`", spec.name), found, expected, REMEDY))
}

/// Refuses a column of another length than the block.
pub(crate) fn check_rows(file: &Path, spec: &ColumnSpec, found: usize, rows: usize) -> Result<()> {
    if found == rows {
        return Ok(());
    }
    let (found, expected) = (format!("{found} rows"), format!("{rows} rows"));
    Err(Error::refuse(file, format!("column `{}`", spec.name), found, expected, REMEDY))
}

/// Refuses values that a column may not contain; `before` rows of the block precede them.
pub(crate) fn check_piece(file: &Path, spec: &ColumnSpec, column: &Column, before: usize) -> Result<()> {
    check_kind(file, spec, column)?;
    let refuse = |row: usize, found: String, expected: &str| {
        let thing = format!("column `{}`, row {} of the block", spec.name, before + row);
        Err(Error::refuse(file, thing, found, expected, "correct the computation"))
    };
    if let Some(row) = column.first_not_finite() {
        let value = column.as_f64().map(|values| values[row].to_string()).unwrap_or_default();
        return refuse(row, value, "a finite number");
    }
    if !spec.nullable && column.nulls() > 0 {
        let row = (0..column.len()).find(|&row| column.is_null(row)).unwrap_or_default();
        return refuse(row, "no value".to_owned(), "a value in every row");
    }
    if let Some((labels, codes)) = column.text_codes()
        && let Some(row) = codes.iter().position(|&code| code as usize >= labels.len())
    {
        return refuse(
            row,
            format!("label number {}", codes[row]),
            &format!("a number below {}", labels.len()),
        );
    }
    Ok(())
}

/// Rows per piece of a column: those of a page. A block of usual size is one page per column.
pub const PIECE_ROWS: usize = 1 << 16;

const LEVEL: i32 = 1;

/// The encodings by kind of column: floats are split into byte streams, integers stored as differences, texts
/// as label numbers.
fn properties(kind: Kind) -> ParquetResult<WriterPropertiesPtr> {
    let all = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(LEVEL)?))
        .set_statistics_enabled(EnabledStatistics::None)
        .set_offset_index_disabled(true)
        .set_data_page_row_count_limit(PIECE_ROWS)
        .set_data_page_size_limit(usize::MAX)
        .set_write_batch_size(PIECE_ROWS);
    let properties = match kind {
        Kind::F64 => all.set_dictionary_enabled(false).set_encoding(Encoding::BYTE_STREAM_SPLIT),
        Kind::I32 => all.set_dictionary_enabled(false).set_encoding(Encoding::DELTA_BINARY_PACKED),
        Kind::Text => all.set_dictionary_enabled(true).set_dictionary_page_size_limit(usize::MAX),
    };
    Ok(Arc::new(properties.build()))
}

/// A column being written.
pub(crate) struct Chunk<'a>(ColumnWriter<'a>);

impl<'a> Chunk<'a> {
    /// The column of this kind with this `descriptor`, written to `to`.
    pub fn new<W: Write + Send>(
        kind: Kind,
        descriptor: ColumnDescPtr,
        to: &'a mut TrackedWrite<W>,
    ) -> ParquetResult<Self> {
        let pages = Box::new(SerializedPageWriter::new(to));
        Ok(Self(get_column_writer(descriptor, properties(kind)?, pages)))
    }

    /// Appends `column`, in pages of its own.
    pub fn push(&mut self, column: &Column) -> ParquetResult<()> {
        match (&mut self.0, column) {
            (ColumnWriter::DoubleColumnWriter(to), Column::F64(_)) => {
                let values = column.as_f64().unwrap_or_default();
                if column.nulls() == 0 {
                    let levels = to.get_descriptor().max_def_level() > 0;
                    let present = levels.then(|| vec![1; values.len()]);
                    to.write_batch(values, present.as_deref(), None)?;
                } else {
                    let levels: Vec<i16> =
                        (0..values.len()).map(|row| i16::from(!column.is_null(row))).collect();
                    let present = values.iter().zip(&levels).filter(|(_, level)| **level > 0);
                    let present: Vec<f64> = present.map(|(x, _)| *x).collect();
                    to.write_batch(&present, Some(&levels), None)?;
                }
            }
            (ColumnWriter::Int32ColumnWriter(to), Column::I32(_)) => {
                to.write_batch(column.as_i32().unwrap_or_default(), None, None)?;
            }
            (ColumnWriter::ByteArrayColumnWriter(to), Column::Text(_)) => {
                let (labels, codes) = column.text_codes().unwrap_or_default();
                let labels: Vec<ByteArray> = labels.iter().map(|label| label.as_str().into()).collect();
                let texts: Vec<ByteArray> = codes.iter().map(|code| labels[*code as usize].clone()).collect();
                to.write_batch(&texts, None, None)?;
            }
            _ => return Err(general("a column of another kind than its schema says")),
        }
        Ok(())
    }

    /// Completes the column.
    pub fn close(self) -> ParquetResult<ColumnChunkMetaData> {
        Ok(self.0.close()?.metadata)
    }
}
