//! The pages of a column for the parquet crate: none whose header announces more than is allowed.

use std::io::{self, BufReader, Read};
use std::sync::atomic::{AtomicU64, Ordering};

use bytes::Bytes;
use flate2::read::MultiGzDecoder;
use parquet::basic::CompressionCodec;
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::reader::{ChunkReader, Length};
use parquet::file::serialized_reader::SerializedPageReader;

use crate::source::{ReaderAt, Source};
use crate::thrift::{BROKEN, PageSizes, most_bytes, page};

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
            Ok::<_, ParquetError>(page(&bytes))
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
            Ok(found) if found > most => {
                Err(general("a page that is longer than its header says".to_owned()))
            }
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

fn general(what: String) -> ParquetError {
    ParquetError::General(what)
}
