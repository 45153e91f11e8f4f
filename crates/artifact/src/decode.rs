//! Decoding one column of one block.

use std::cell::Cell;
use std::error::Error;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::{ByteArray, DataType};
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::RowGroupMetaData;
use parquet::file::serialized_reader::SerializedPageReader;
use parquet::schema::types::ColumnDescPtr;

use crate::columns::{Column, Labels};
use crate::pages;
use crate::source::Source;

/// Rows for which memory is set aside before they have been decoded.
pub(crate) const TRUSTED_ROWS: usize = 1 << 20;

/// Why something is not decoded.
pub(crate) enum Undecoded {
    /// The system does not give the bytes.
    Unreadable(io::Error),
    /// What is wrong with them.
    Damaged(String),
}

thread_local! {
    static DECODING: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread is decoding bytes that nothing vouches for. The decoder may panic on them, which is told as a damaged
/// file: a panic hook need not tell it as well.
pub fn decoding() -> bool {
    DECODING.get()
}

/// Runs the decoder. A file may have bytes that nothing vouches for, on which the decoder may panic: that too is told as a
/// damaged file.
pub(crate) fn decoded<T>(decode: impl FnOnce() -> ParquetResult<T>) -> Result<T, Undecoded> {
    let before = DECODING.replace(true);
    let ended = catch_unwind(AssertUnwindSafe(decode));
    DECODING.set(before);
    match ended {
        Ok(Ok(decoded)) => Ok(decoded),
        Ok(Err(error)) => Err(match inner_io(error) {
            Ok(io) => Undecoded::Unreadable(io),
            Err(other) => Undecoded::Damaged(other.to_string()),
        }),
        Err(_) => Err(Undecoded::Damaged("bytes that cannot be decoded".to_owned())),
    }
}

/// The operating system's error inside an error of the parquet crate, or that error as it is.
pub(crate) fn inner_io(error: ParquetError) -> Result<io::Error, Box<dyn Error + Send + Sync>> {
    match error {
        ParquetError::External(inner) => inner.downcast::<io::Error>().map(|io| *io),
        other => Err(other.into()),
    }
}

/// Decodes column `i` of a row group with `rows` rows.
pub(crate) fn decode_column(
    source: &Source,
    group: &RowGroupMetaData,
    i: usize,
    rows: usize,
) -> ParquetResult<Column> {
    let chunk = group.column(i);
    let pages = || SerializedPageReader::new(Arc::new(source.clone()), chunk, rows, None);
    let descriptor = chunk.column_descr_ptr();
    match pages::decode(&mut pages()?, &descriptor, rows)? {
        Some(column) => Ok(column),
        None => decode_any(pages()?, descriptor, rows),
    }
}

/// Decodes a column in any encoding, such as other programs write and as stood in tables before.
fn decode_any(
    pages: SerializedPageReader<Source>,
    descriptor: ColumnDescPtr,
    rows: usize,
) -> ParquetResult<Column> {
    let nullable = descriptor.max_def_level() > 0;
    match get_column_reader(descriptor, Box::new(pages)) {
        ColumnReader::DoubleColumnReader(reader) if nullable => decode_nullable(reader, rows),
        ColumnReader::DoubleColumnReader(reader) => decode_all(reader, rows).map(Column::f64),
        ColumnReader::Int32ColumnReader(reader) => decode_all(reader, rows).map(Column::i32),
        ColumnReader::ByteArrayColumnReader(reader) => intern(&decode_all(reader, rows)?),
        _ => Err(ParquetError::General("a column of a type that no table has".to_owned())),
    }
}

fn decode_all<T: DataType>(mut reader: ColumnReaderImpl<T>, rows: usize) -> ParquetResult<Vec<T::T>> {
    let mut values = Vec::with_capacity(rows.min(TRUSTED_ROWS));
    let (records, _, _) = reader.read_records(rows, None, None, &mut values)?;
    if records == rows && values.len() == rows { Ok(values) } else { Err(too_few(values.len(), rows)) }
}

fn decode_nullable<T: DataType<T = f64>>(
    mut reader: ColumnReaderImpl<T>,
    rows: usize,
) -> ParquetResult<Column> {
    let mut present = Vec::with_capacity(rows.min(TRUSTED_ROWS));
    let mut levels = Vec::with_capacity(rows.min(TRUSTED_ROWS));
    reader.read_records(rows, Some(&mut levels), None, &mut present)?;
    let count = levels.iter().filter(|&&level| level > 0).count();
    if levels.len() != rows || present.len() != count {
        return Err(too_few(levels.len(), rows));
    }
    if count == rows {
        return Ok(Column::f64(present));
    }
    let mut present = present.into_iter();
    let spaced =
        levels.iter().map(|&level| if level > 0 { present.next().unwrap_or(f64::NAN) } else { f64::NAN });
    let values = spaced.collect();
    Ok(Column::nullable_f64(values, levels.iter().map(|&level| level > 0).collect()))
}

/// Refuses a column of another length than its block.
pub(crate) fn too_few(found: usize, expected: usize) -> ParquetError {
    ParquetError::General(format!("{found} values in a block of {expected} rows"))
}

/// The distinct texts in order of appearance, and per row the index of its text.
fn intern(texts: &[ByteArray]) -> ParquetResult<Column> {
    let mut labels = Labels::default();
    for text in texts {
        labels.push(std::str::from_utf8(text.data())?, 1);
    }
    Ok(labels.column())
}
