//! Decoding the pages of a column straight into the numbers that a table has.

use parquet::basic::{CompressionCodec, Encoding, Type as Physical};
use parquet::column::page::{Page, PageReader};
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::ColumnChunkMetaData;
use zstd::bulk::Decompressor;
use zstd::zstd_safe::get_frame_content_size;

use crate::bits::{broken, each_run, take};
use crate::columns::{Column, Labels};
use crate::page_bytes::{most_bytes, pages};
use crate::source::Source;
use crate::{deltas, streams};

/// Rows for which memory is set aside before they have been decoded.
pub(crate) const TRUSTED_ROWS: usize = 1 << 20;

/// Most bytes that a compressed one can stand for: a zstd block has at least four, and at most 128 kB.
const MOST_PER_BYTE: usize = 1 << 15;

/// What pages are decompressed with and into: one for many columns, as making one takes as long as a page does.
pub(crate) struct Press {
    zstd: Decompressor<'static>,
    /// A page as it was before it was compressed.
    body: Vec<u8>,
}

impl Press {
    /// A press that has decompressed nothing yet.
    pub fn new() -> ParquetResult<Self> {
        Ok(Self { zstd: Decompressor::new()?, body: Vec::new() })
    }

    /// The bytes of a page, if this is zstd that tells its length. The length is believed where so few bytes can have it.
    fn open(&mut self, page: &[u8]) -> Option<&[u8]> {
        let length = usize::try_from(get_frame_content_size(page).ok()??).ok()?;
        if length > page.len().saturating_mul(MOST_PER_BYTE) || length as u64 > most_bytes() {
            return None;
        }
        self.body.clear();
        self.body.try_reserve(length).ok()?;
        self.zstd.decompress_to_buffer(page, &mut self.body).ok()?;
        Some(&self.body)
    }
}

/// A page whose bytes have been decompressed.
struct Opened<'a> {
    page: &'a Page,
    bytes: &'a [u8],
    rows: usize,
}

/// Decodes a column of `rows` rows, if it is encoded as tables of this crate are; nothing if it is not.
pub(crate) fn decode(
    source: &Source,
    chunk: &ColumnChunkMetaData,
    press: &mut Press,
    rows: usize,
) -> ParquetResult<Option<Column>> {
    if chunk.compression_codec() != CompressionCodec::ZSTD {
        return Ok(None);
    }
    // Pages are decompressed here: the parquet crate would set up a press for each column.
    let as_they_are = chunk.clone().into_builder().set_compression_codec(CompressionCodec::UNCOMPRESSED);
    let pages = pages(source, &as_they_are.build()?, rows)?;
    let descriptor = chunk.column_descr();
    match (descriptor.physical_type(), descriptor.max_def_level()) {
        (Physical::DOUBLE, 0) => {
            let mut values = Vec::with_capacity(rows.min(TRUSTED_ROWS));
            let all = each_page(pages, press, rows, |page| floats(&page, &mut values))?;
            finished(all, values.len(), rows, || Column::f64(values))
        }
        (Physical::DOUBLE, 1) => {
            let mut spaced = Spaced::new(rows);
            let all = each_page(pages, press, rows, |page| spaced.page(&page))?;
            let found = spaced.values.len();
            finished(all, found, rows, || Column::with_presence(spaced.values, &spaced.runs))
        }
        (Physical::INT32, 0) => {
            let mut values = Vec::with_capacity(rows.min(TRUSTED_ROWS));
            let all = each_page(pages, press, rows, |page| {
                let delta = page.page.encoding() == Encoding::DELTA_BINARY_PACKED;
                delta.then(|| deltas::take_all(page.bytes, page.rows, &mut values)).transpose()
            })?;
            finished(all, values.len(), rows, || Column::i32(values))
        }
        (Physical::BYTE_ARRAY, 0) => {
            let mut texts = Texts::default();
            let all = each_page(pages, press, rows, |page| texts.page(&page))?;
            finished(all, texts.rows, rows, || texts.labels.column())
        }
        _ => Ok(None),
    }
}

/// The column of all pages, if all were decoded and have the block's rows.
fn finished(
    all: bool,
    found: usize,
    rows: usize,
    column: impl FnOnce() -> Column,
) -> ParquetResult<Option<Column>> {
    if !all {
        return Ok(None);
    }
    if found == rows { Ok(Some(column())) } else { Err(too_few(found, rows)) }
}

/// Gives `decode` page after page until it knows one of them not; whether it knew all.
fn each_page(
    mut pages: impl PageReader,
    press: &mut Press,
    rows: usize,
    mut decode: impl FnMut(Opened) -> ParquetResult<Option<()>>,
) -> ParquetResult<bool> {
    let mut done = 0;
    while done < rows {
        let Some(page) = pages.get_next_page()? else {
            return Ok(true);
        };
        let rows_of_page = match page {
            Page::DataPage { num_values, .. } => num_values as usize,
            Page::DictionaryPage { .. } => 0,
            Page::DataPageV2 { .. } => return Ok(false),
        };
        done += rows_of_page;
        if done > rows {
            return Err(too_few(done, rows));
        }
        let Some(bytes) = press.open(page.buffer()) else {
            return Ok(false);
        };
        if decode(Opened { page: &page, bytes, rows: rows_of_page })?.is_none() {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Appends the floats of a page that has all of them.
fn floats(page: &Opened, values: &mut Vec<f64>) -> ParquetResult<Option<()>> {
    if page.page.encoding() != Encoding::BYTE_STREAM_SPLIT {
        return Ok(None);
    }
    let expected = values.len() + page.rows;
    streams::join(page.bytes, values);
    if values.len() == expected {
        Ok(Some(()))
    } else {
        Err(broken("another number of values than a page has"))
    }
}

/// Floats of which some are absent.
struct Spaced {
    /// NaN where absent.
    values: Vec<f64>,
    /// Whether they are present, and for how many rows each time.
    runs: Vec<(bool, usize)>,
    /// The present ones of a page.
    present: Vec<f64>,
}

impl Spaced {
    fn new(rows: usize) -> Self {
        let values = Vec::with_capacity(rows.min(TRUSTED_ROWS));
        Self { values, runs: Vec::new(), present: Vec::new() }
    }

    fn page(&mut self, page: &Opened) -> ParquetResult<Option<()>> {
        let Page::DataPage { encoding, def_level_encoding, .. } = page.page else {
            return Ok(None);
        };
        if *encoding != Encoding::BYTE_STREAM_SPLIT || *def_level_encoding != Encoding::RLE {
            return Ok(None);
        }
        let mut bytes = page.bytes;
        let mut length = [0; 4];
        length.copy_from_slice(take(&mut bytes, 4)?);
        let levels = take(&mut bytes, u32::from_le_bytes(length) as usize)?;
        let first = self.runs.len();
        each_run(levels, 1, page.rows, |level, times| {
            let present = level > 0;
            match self.runs[first..].last_mut().filter(|last| last.0 == present) {
                Some(last) => last.1 += times,
                None => self.runs.push((present, times)),
            }
            Ok(())
        })?;
        self.present.clear();
        streams::join(bytes, &mut self.present);
        let mut present: &[f64] = &self.present;
        for (is_present, times) in &self.runs[first..] {
            if *is_present {
                let some = present.split_off(..*times);
                self.values.extend_from_slice(some.ok_or_else(|| broken("fewer values than rows have"))?);
            } else {
                self.values.resize(self.values.len() + times, f64::NAN);
            }
        }
        if present.is_empty() { Ok(Some(())) } else { Err(broken("more values than rows have")) }
    }
}

/// Texts by numbers of labels.
#[derive(Default)]
struct Texts {
    labels: Labels,
    /// The number in `labels` of each of the file's labels.
    numbers: Vec<u32>,
    rows: usize,
}

impl Texts {
    fn page(&mut self, page: &Opened) -> ParquetResult<Option<()>> {
        let mut bytes = page.bytes;
        match (page.page, page.page.encoding()) {
            (Page::DictionaryPage { num_values, .. }, Encoding::PLAIN | Encoding::PLAIN_DICTIONARY) => {
                for _ in 0..*num_values {
                    let mut length = [0; 4];
                    length.copy_from_slice(take(&mut bytes, 4)?);
                    let label = take(&mut bytes, u32::from_le_bytes(length) as usize)?;
                    self.numbers.push(self.labels.number(std::str::from_utf8(label)?));
                }
            }
            (Page::DataPage { .. }, Encoding::RLE_DICTIONARY | Encoding::PLAIN_DICTIONARY) => {
                let width = take(&mut bytes, 1)?[0];
                each_run(bytes, u32::from(width), page.rows, |number, times| {
                    let number = self.numbers.get(number as usize);
                    let number = number.ok_or_else(|| broken("the number of a label that is not there"))?;
                    self.labels.repeat(*number, times);
                    Ok(())
                })?;
                self.rows += page.rows;
            }
            _ => return Ok(None),
        }
        Ok(Some(()))
    }
}

/// Refuses a column of another length than its block.
pub(crate) fn too_few(found: usize, expected: usize) -> ParquetError {
    ParquetError::General(format!("{found} values in a block of {expected} rows"))
}
