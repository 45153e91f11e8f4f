//! One column of one block in its file format, written by the parquet crate.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, ZstdLevel};
use parquet::column::writer::{ColumnWriter, get_column_writer};
use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesPtr};
use parquet::file::writer::{SerializedPageWriter, TrackedWrite};
use parquet::schema::types::ColumnDescPtr;

use crate::columns::Column;
use crate::schema::Kind;

/// Rows of a page: a block of usual size is one page per column.
pub(crate) const PAGE_ROWS: usize = 1 << 16;

const LEVEL: i32 = 1;

/// The encodings by kind of column: floats are split into byte streams, integers stored as differences, texts
/// as label numbers.
fn properties(kind: Kind) -> ParquetResult<WriterPropertiesPtr> {
    let all = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(LEVEL)?))
        .set_statistics_enabled(EnabledStatistics::None)
        .set_offset_index_disabled(true)
        .set_data_page_row_count_limit(PAGE_ROWS)
        .set_data_page_size_limit(usize::MAX)
        .set_write_batch_size(PAGE_ROWS);
    let own = match kind {
        Kind::F64 => all.set_dictionary_enabled(false).set_encoding(Encoding::BYTE_STREAM_SPLIT),
        Kind::I32 => all.set_dictionary_enabled(false).set_encoding(Encoding::DELTA_BINARY_PACKED),
        Kind::Text => all.set_dictionary_enabled(true).set_dictionary_page_size_limit(usize::MAX),
    };
    Ok(Arc::new(own.build()))
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
                    let present: Vec<f64> = values
                        .iter()
                        .zip(&levels)
                        .filter(|(_, level)| **level > 0)
                        .map(|(x, _)| *x)
                        .collect();
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
            _ => {
                return Err(ParquetError::General(
                    "a column of another kind than its schema says".to_owned(),
                ));
            }
        }
        Ok(())
    }

    /// Completes the column.
    pub fn close(self) -> ParquetResult<ColumnChunkMetaData> {
        Ok(self.0.close()?.metadata)
    }
}
