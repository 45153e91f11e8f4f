//! One column of one block as it stands in the file: its pages, each compressed, and what the footer says about them.

use std::io::Write;
use std::ops::Range;

use parquet::basic::{Compression, Encoding, PageType, ZstdLevel};
use parquet::column::page::{CompressedPage, Page, PageWriter};
use parquet::errors::Result as ParquetResult;
use parquet::file::metadata::{ColumnChunkMetaData, PageEncodingStats};
use parquet::file::writer::{SerializedPageWriter, TrackedWrite};
use parquet::schema::types::ColumnDescPtr;
use zstd::bulk::Compressor;

use crate::bits::{Runs, width_of};
use crate::columns::{Column, Labels};
use crate::{deltas, streams};

/// Rows of a page: a block of usual size is one page per column.
pub(crate) const PAGE_ROWS: usize = 1 << 16;

const LEVEL: i32 = 1;

/// What all columns of a block are compressed with.
pub(crate) fn compressor() -> ParquetResult<Compressor<'static>> {
    Ok(Compressor::new(LEVEL)?)
}

/// A column being written. Floats are split into byte streams, integers told by their differences, texts by numbers of labels.
pub(crate) struct Chunk<'a, W: Write + Send> {
    descriptor: ColumnDescPtr,
    compressor: &'a mut Compressor<'static>,
    to: SerializedPageWriter<'a, W>,
    /// A page before it is compressed.
    body: Vec<u8>,
    labels: Labels,
    /// Pages of text, which stand after the labels.
    waiting: Vec<CompressedPage>,
    rows: usize,
    bytes: [i64; 2],
    labels_at: Option<i64>,
    pages_at: Option<i64>,
    encodings: Vec<PageEncodingStats>,
}

impl<'a, W: Write + Send> Chunk<'a, W> {
    /// The column that `descriptor` describes, written to `to`.
    pub fn new(
        descriptor: ColumnDescPtr,
        compressor: &'a mut Compressor<'static>,
        to: &'a mut TrackedWrite<W>,
    ) -> Self {
        Self {
            descriptor,
            compressor,
            to: SerializedPageWriter::new(to),
            body: Vec::new(),
            labels: Labels::default(),
            waiting: Vec::new(),
            rows: 0,
            bytes: [0; 2],
            labels_at: None,
            pages_at: None,
            encodings: Vec::new(),
        }
    }

    /// Appends `column`, in pages of its own.
    pub fn push(&mut self, column: &Column) -> ParquetResult<()> {
        let starts = (0..column.len()).step_by(PAGE_ROWS);
        for rows in starts.map(|start| start..column.len().min(start + PAGE_ROWS)) {
            self.page(column, rows)?;
        }
        Ok(())
    }

    fn page(&mut self, column: &Column, rows: Range<usize>) -> ParquetResult<()> {
        self.body.clear();
        self.rows += rows.len();
        let num_values = rows.len() as u32;
        let encoding = match column {
            Column::F64(_) => self.floats(column, rows),
            Column::I32(_) => {
                deltas::put(&column.as_i32().unwrap_or_default()[rows], &mut self.body);
                Encoding::DELTA_BINARY_PACKED
            }
            Column::Text(_) => self.texts(column, rows),
        };
        let page = Page::DataPage {
            buf: self.compressed()?.into(),
            num_values,
            encoding,
            def_level_encoding: Encoding::RLE,
            rep_level_encoding: Encoding::RLE,
            statistics: None,
        };
        let page = CompressedPage::new(page, self.body.len());
        if encoding == Encoding::RLE_DICTIONARY {
            self.waiting.push(page);
            return Ok(());
        }
        self.write(page)
    }

    fn floats(&mut self, column: &Column, rows: Range<usize>) -> Encoding {
        let values = &column.as_f64().unwrap_or_default()[rows.clone()];
        if self.descriptor.max_def_level() == 0 {
            streams::split(values, &mut self.body);
            return Encoding::BYTE_STREAM_SPLIT;
        }
        let runs = column.presence(rows);
        self.body.extend([0; 4]);
        let mut levels = Runs::new(&mut self.body, 1);
        runs.iter().for_each(|(present, times)| levels.push(u32::from(*present), *times));
        levels.finish();
        let length = self.body.len() as u32 - 4;
        self.body[..4].copy_from_slice(&length.to_le_bytes());
        if let [(true, _)] = runs[..] {
            streams::split(values, &mut self.body);
        } else {
            let mut present = Vec::with_capacity(values.len());
            let mut start = 0;
            for (is_present, times) in runs {
                present.extend_from_slice(if is_present { &values[start..start + times] } else { &[] });
                start += times;
            }
            streams::split(&present, &mut self.body);
        }
        Encoding::BYTE_STREAM_SPLIT
    }

    fn texts(&mut self, column: &Column, rows: Range<usize>) -> Encoding {
        let (labels, codes) = column.text_codes().unwrap_or_default();
        let runs: Vec<(u32, usize)> = codes[rows]
            .chunk_by(|one, other| one == other)
            .map(|run| (self.labels.number(&labels[run[0] as usize]), run.len()))
            .collect();
        let width = width_of(self.labels.len().saturating_sub(1) as u32).max(1);
        self.body.push(width as u8);
        let mut numbers = Runs::new(&mut self.body, width);
        runs.iter().for_each(|(number, times)| numbers.push(*number, *times));
        numbers.finish();
        Encoding::RLE_DICTIONARY
    }

    fn compressed(&mut self) -> ParquetResult<Vec<u8>> {
        let mut compressed = Vec::with_capacity(zstd::zstd_safe::compress_bound(self.body.len()));
        self.compressor.compress_to_buffer(&self.body, &mut compressed)?;
        Ok(compressed)
    }

    fn write(&mut self, page: CompressedPage) -> ParquetResult<()> {
        let (page_type, encoding) = (page.page_type(), page.encoding());
        let written = self.to.write_page(page)?;
        self.bytes[0] += written.uncompressed_size as i64;
        self.bytes[1] += written.compressed_size as i64;
        let at = match page_type {
            PageType::DICTIONARY_PAGE => &mut self.labels_at,
            _ => &mut self.pages_at,
        };
        at.get_or_insert(written.offset as i64);
        match self.encodings.last_mut().filter(|last| last.page_type == page_type) {
            Some(last) => last.count += 1,
            None => self.encodings.push(PageEncodingStats { page_type, encoding, count: 1 }),
        }
        Ok(())
    }

    /// The labels of a column of text, then its pages.
    fn write_waiting(&mut self) -> ParquetResult<()> {
        if self.waiting.is_empty() {
            return Ok(());
        }
        self.body.clear();
        for label in self.labels.all() {
            self.body.extend((label.len() as u32).to_le_bytes());
            self.body.extend(label.as_bytes());
        }
        let num_values = self.labels.len() as u32;
        let buf = self.compressed()?.into();
        let page = Page::DictionaryPage { buf, num_values, encoding: Encoding::PLAIN, is_sorted: false };
        self.write(CompressedPage::new(page, self.body.len()))?;
        std::mem::take(&mut self.waiting).into_iter().try_for_each(|page| self.write(page))
    }

    /// Completes the column.
    pub fn close(mut self) -> ParquetResult<ColumnChunkMetaData> {
        self.write_waiting()?;
        let mut encodings = vec![Encoding::RLE];
        encodings.extend(self.encodings.iter().map(|stats| stats.encoding));
        ColumnChunkMetaData::builder(self.descriptor)
            .set_compression(Compression::ZSTD(ZstdLevel::try_new(LEVEL)?))
            .set_encodings(encodings)
            .set_page_encoding_stats(self.encodings)
            .set_total_uncompressed_size(self.bytes[0])
            .set_total_compressed_size(self.bytes[1])
            .set_num_values(self.rows as i64)
            .set_data_page_offset(self.pages_at.unwrap_or_default())
            .set_dictionary_page_offset(self.labels_at)
            .build()
    }
}
