//! Decoding one column of one block, from pages whose headers announce no more than is allowed.

use std::cell::Cell;
use std::io::{self, BufReader, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use bytes::Bytes;
use flate2::read::MultiGzDecoder;
use parquet::basic::CompressionCodec;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::{ByteArray, DataType};
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::reader::{ChunkReader, Length};
use parquet::file::serialized_reader::SerializedPageReader;

use crate::access::{ReaderAt, Source};
use crate::budget::budget;
use crate::columns::{Column, Labels};
use crate::error::{Error, Result};
use crate::footer::{BROKEN, PageSizes, most_bytes, page_sizes};
use crate::layout::{general, inner_io};

thread_local! {
    static DECODING: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread is decoding unverified bytes. The decoder may panic on them, which is reported as a
/// damaged file: a panic hook need not report it as well.
pub fn decoding() -> bool {
    DECODING.get()
}

/// Runs the decoder of the file at `path`. It may panic on unverified bytes: that too is refused as a `damaged` file.
pub(crate) fn guarded<T>(
    path: &Path,
    damaged: fn(&Path, &str) -> Error,
    decode: impl FnOnce() -> ParquetResult<T>,
) -> Result<T> {
    let before = DECODING.replace(true);
    let ended = catch_unwind(AssertUnwindSafe(decode));
    DECODING.set(before);
    match ended {
        Ok(Ok(decoded)) => Ok(decoded),
        Ok(Err(error)) => Err(match inner_io(error) {
            // Decompressors and truncated input have errors of the same type that are not the system's.
            Ok(io) if io.raw_os_error().is_some() => Error::io(path, "read", io),
            Ok(other) => damaged(path, &other.to_string()),
            Err(other) => damaged(path, &other.to_string()),
        }),
        Err(_) => Err(damaged(path, "bytes that cannot be decoded")),
    }
}

/// Most rows for which memory is reserved before they have been decoded.
const TRUSTED_ROWS: usize = 1 << 20;

/// Memory of a text before repetitions are known \[bytes\].
const TEXT_BYTES: f64 = 48.0;

/// Decodes a column of `rows` rows, in any encoding.
pub(crate) fn decode_column(
    source: &Source,
    chunk: &ColumnChunkMetaData,
    rows: usize,
) -> ParquetResult<Column> {
    let (pages, descriptor) = (pages(source, chunk, rows)?, chunk.column_descr_ptr());
    let nullable = descriptor.max_def_level() > 0;
    match get_column_reader(descriptor, Box::new(pages)) {
        ColumnReader::DoubleColumnReader(reader) if nullable => decode_nullable(reader, rows),
        ColumnReader::DoubleColumnReader(reader) => decode_all(reader, rows).map(Column::f64),
        ColumnReader::Int32ColumnReader(reader) => decode_all(reader, rows).map(Column::i32),
        ColumnReader::ByteArrayColumnReader(reader) if rows as f64 * TEXT_BYTES < budget().bytes() => {
            intern(&decode_all(reader, rows)?)
        }
        ColumnReader::ByteArrayColumnReader(_) => {
            Err(general(format!("{rows} texts, more than fit in memory")))
        }
        _ => Err(general("a column of a type that no table has")),
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
    let valid: Vec<bool> = levels.iter().map(|&level| level > 0).collect();
    let value = |valid: &bool| if *valid { present.next().unwrap_or(f64::NAN) } else { f64::NAN };
    Ok(Column::nullable_f64(valid.iter().map(value).collect(), valid))
}

/// Refuses a column of another length than its block.
fn too_few(values: usize, rows: usize) -> ParquetError {
    general(format!("{values} values in a block of {rows} rows"))
}

/// The distinct texts in order of appearance, and per row the index of its text.
fn intern(texts: &[ByteArray]) -> ParquetResult<Column> {
    let mut labels = Labels::default();
    for text in texts {
        labels.push(std::str::from_utf8(text.data())?, 1);
    }
    Ok(labels.column())
}

/// A header has some ten numbers; with the least and the greatest value of a text it may be longer.
const USUAL_HEADER: u64 = 512;
const LONGEST_HEADER: u64 = 1 << 20;

/// Reads the pages of a column, whose blocks have `rows` rows.
pub(crate) fn pages(
    source: &Source,
    chunk: &ColumnChunkMetaData,
    rows: usize,
) -> ParquetResult<SerializedPageReader<PageBytes>> {
    let codec = chunk.compression_codec();
    let [uncompressed, levels] = [0, 0].map(AtomicU64::new);
    let bytes = PageBytes { source: source.clone(), codec, uncompressed, levels };
    SerializedPageReader::new(bytes.into(), chunk, rows, None)
}

/// A file where every read begins with the header of a page.
pub(crate) struct PageBytes {
    source: Source,
    codec: CompressionCodec,
    /// Bytes of the page whose header was read last.
    uncompressed: AtomicU64,
    /// The uncompressed part of them, which comes first.
    levels: AtomicU64,
}

impl Length for PageBytes {
    fn len(&self) -> u64 {
        self.source.len()
    }
}

impl ChunkReader for PageBytes {
    type T = BufReader<ReaderAt>;

    fn get_read(&self, start: u64) -> ParquetResult<Self::T> {
        let header = |most: u64| {
            let mut bytes = Vec::new();
            self.source.get_read(start)?.take(most).read_to_end(&mut bytes)?;
            Ok::<_, ParquetError>(page_sizes(&bytes))
        };
        let short = header(USUAL_HEADER)?;
        let sizes = if short.is_some() { short } else { header(LONGEST_HEADER)? };
        let sizes = sizes.ok_or_else(|| general(format!("a page header with {BROKEN}")))?;
        self.uncompressed.store(check(sizes)?, Ordering::Relaxed);
        self.levels.store(sizes.levels.unsigned_abs(), Ordering::Relaxed);
        self.source.get_read(start)
    }

    fn get_bytes(&self, start: u64, length: usize) -> ParquetResult<Bytes> {
        let bytes = self.source.get_bytes(start, length)?;
        self.check_length(&bytes)?;
        Ok(bytes)
    }
}

impl PageBytes {
    /// Decompression of gzip and brotli does not stop at the end of the page.
    fn check_length(&self, bytes: &[u8]) -> ParquetResult<()> {
        const BUFFER: usize = 1 << 12;
        let most = self.uncompressed.load(Ordering::Relaxed);
        let levels = usize::try_from(self.levels.load(Ordering::Relaxed)).unwrap_or(usize::MAX);
        let bytes = bytes.get(levels..).unwrap_or_default();
        let mut counted: Box<dyn Read> = match self.codec {
            CompressionCodec::GZIP => Box::new(MultiGzDecoder::new(bytes)),
            CompressionCodec::BROTLI => Box::new(brotli::Decompressor::new(bytes, BUFFER)),
            _ => return Ok(()),
        };
        match io::copy(&mut counted.by_ref().take(most + 1), &mut io::sink()) {
            Ok(length) if length > most => Err(general("a page that is longer than its header says")),
            _ => Ok(()),
        }
    }
}

/// Bytes of a page with these sizes.
fn check(sizes: PageSizes) -> ParquetResult<u64> {
    let bytes = u64::try_from(sizes.uncompressed).unwrap_or(u64::MAX);
    if bytes > most_bytes() {
        return Err(general(format!("a page of {bytes} bytes, more than fit in memory")));
    }
    if u64::try_from(sizes.labels).unwrap_or(u64::MAX) > bytes {
        return Err(general(format!("a page of {} labels in {bytes} bytes", sizes.labels)));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::sync::Arc;

    use parquet::basic::{Compression, Encoding, ZstdLevel};
    use parquet::column::writer::ColumnWriter;
    use parquet::file::metadata::ParquetMetaData;
    use parquet::file::properties::{WriterProperties, WriterVersion};
    use parquet::file::writer::{SerializedFileWriter, TrackedWrite};

    use super::*;
    use crate::columns::{ColumnSpec, Kind};
    use crate::encode::Chunk;
    use crate::layout::descriptor;

    const ROWS: usize = 3000;

    fn specs() -> Vec<ColumnSpec> {
        let spec = |name: &str, kind, nullable| ColumnSpec::new(name, "1", kind, nullable);
        vec![
            spec("x", Kind::F64, false),
            spec("y", Kind::F64, true),
            spec("n", Kind::I32, false),
            spec("t", Kind::Text, false),
        ]
    }

    /// Numbers of all sizes, some absent alone and some side by side, integers that count and jump, labels that repeat.
    fn columns() -> Vec<Column> {
        let x: Vec<f64> = (0..ROWS).map(|i| (i as f64).sin() * 10_f64.powi(i as i32 % 50 - 25)).collect();
        let y = x.iter().map(|x| x * 3.0).collect();
        let present = (0..ROWS).map(|i| i % 7 > 0 && i % 1000 > 90).collect();
        let n = (0..ROWS as i32).map(|i| if i % 97 == 0 { i32::MIN + i } else { i % 500 }).collect();
        let labels = ["déjà vu", "", "sine", "spiral"].map(str::to_owned).to_vec();
        let codes = (0..ROWS).map(|i| if i < 1000 { i as u32 % 3 } else { (i / 400 % 3) as u32 }).collect();
        vec![Column::f64(x), Column::nullable_f64(y, present), Column::i32(n), Column::text(labels, codes)]
    }

    fn same(column: &Column, expected: &Column, what: &str) {
        for row in 0..ROWS {
            let bits = |column: &Column| column.value_at(row).map(f64::to_bits);
            assert_eq!(bits(column), bits(expected), "{what}");
            assert_eq!(column.text_at(row), expected.text_at(row), "{what}, row {row}");
        }
        assert_eq!((column.nulls(), column.as_i32()), (expected.nulls(), expected.as_i32()), "{what}");
    }

    /// Writes the columns by the parquet crate, a few rows at a time.
    fn written_by_others(file: File, properties: WriterProperties) -> ParquetMetaData {
        let layout = descriptor(Path::new("t"), &specs()).unwrap();
        let root = layout.root_schema_ptr();
        let mut writer = SerializedFileWriter::new(file, root, Arc::new(properties)).unwrap();
        let mut group = writer.next_row_group().unwrap();
        for column in columns() {
            let mut chunk = group.next_column().unwrap().unwrap();
            match chunk.untyped() {
                ColumnWriter::DoubleColumnWriter(to) => {
                    let values = (0..ROWS).filter_map(|row| column.value_at(row)).collect::<Vec<_>>();
                    let levels = (0..ROWS).map(|row| i16::from(!column.is_null(row))).collect::<Vec<_>>();
                    to.write_batch(&values, Some(&levels), None).unwrap()
                }
                ColumnWriter::Int32ColumnWriter(to) => {
                    to.write_batch(column.as_i32().unwrap(), None, None).unwrap()
                }
                ColumnWriter::ByteArrayColumnWriter(to) => {
                    let texts: Vec<ByteArray> =
                        (0..ROWS).map(|row| column.text_at(row).unwrap().into()).collect();
                    to.write_batch(&texts, None, None).unwrap()
                }
                _ => unreachable!("no table has other columns"),
            };
            chunk.close().unwrap();
        }
        group.close().unwrap();
        writer.close().unwrap()
    }

    #[test]
    fn pages_that_others_wrote_are_read() {
        let zstd = Compression::ZSTD(ZstdLevel::default());
        let any = || WriterProperties::builder().set_data_page_row_count_limit(700).set_write_batch_size(100);
        // Like tables before pages were encoded here: split floats, dictionaries of integers.
        let mut before = any().set_writer_version(WriterVersion::PARQUET_1_0).set_compression(zstd);
        for name in ["x", "y"] {
            before = before.set_column_dictionary_enabled(name.into(), false);
            before = before.set_column_encoding(name.into(), Encoding::BYTE_STREAM_SPLIT);
        }
        let later = any().set_writer_version(WriterVersion::PARQUET_2_0).set_compression(zstd);
        let ways = [
            before,
            any().set_compression(zstd),
            any().set_compression(Compression::SNAPPY),
            any().set_compression(zstd).set_dictionary_enabled(false),
            later.set_dictionary_enabled(false),
        ];
        for (way, properties) in ways.into_iter().enumerate() {
            let file = tempfile::tempfile().unwrap();
            let metadata = written_by_others(file.try_clone().unwrap(), properties.build());
            let source = Source::new(file).unwrap();
            for (i, expected) in columns().iter().enumerate() {
                let column = decode_column(&source, metadata.row_group(0).column(i), ROWS).unwrap();
                same(&column, expected, &format!("way {way}, column {i}"));
            }
        }
    }

    #[test]
    fn law_columns_are_read_as_they_were_written() {
        let layout = descriptor(Path::new("t"), &specs()).unwrap();
        for (i, expected) in columns().iter().enumerate() {
            let file = tempfile::tempfile().unwrap();
            let mut to = TrackedWrite::new(file.try_clone().unwrap());
            let mut chunk = Chunk::new(specs()[i].kind, layout.column(i), &mut to).unwrap();
            chunk.push(expected).unwrap();
            let chunk = chunk.close().unwrap();
            drop(to.into_inner().unwrap());
            let column = decode_column(&Source::new(file).unwrap(), &chunk, ROWS).unwrap();
            same(&column, expected, &format!("column {i}"));
        }
    }
}
