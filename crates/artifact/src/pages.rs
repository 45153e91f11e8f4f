//! Decoding the pages of a column straight into the numbers that a table has.

use parquet::basic::{Encoding, Type as Physical};
use parquet::column::page::{Page, PageReader};
use parquet::errors::Result as ParquetResult;
use parquet::schema::types::ColumnDescriptor;

use crate::bits::{broken, each_run, take};
use crate::columns::{Column, Labels};
use crate::decode::{TRUSTED_ROWS, too_few};
use crate::{deltas, streams};

/// Decodes a column of `rows` rows, if it is encoded as tables of this crate are; nothing if it is not.
pub(crate) fn decode(
    pages: &mut impl PageReader,
    descriptor: &ColumnDescriptor,
    rows: usize,
) -> ParquetResult<Option<Column>> {
    let (physical, levels) = (descriptor.physical_type(), descriptor.max_def_level());
    match (physical, levels) {
        (Physical::DOUBLE, 0) => {
            let mut values = Vec::with_capacity(rows.min(TRUSTED_ROWS));
            let all = each_page(pages, rows, |page, _| floats(&page, &mut values))?;
            finished(all, values.len(), rows, || Column::f64(values))
        }
        (Physical::DOUBLE, 1) => {
            let mut spaced = Spaced::new(rows);
            let all = each_page(pages, rows, |page, rows| spaced.page(&page, rows))?;
            let found = spaced.values.len();
            finished(all, found, rows, || Column::with_presence(spaced.values, &spaced.runs))
        }
        (Physical::INT32, 0) => {
            let mut values = Vec::with_capacity(rows.min(TRUSTED_ROWS));
            let all = each_page(pages, rows, |page, rows| {
                let delta = page.encoding() == Encoding::DELTA_BINARY_PACKED;
                delta.then(|| deltas::take_all(page.buffer(), rows, &mut values)).transpose()
            })?;
            finished(all, values.len(), rows, || Column::i32(values))
        }
        (Physical::BYTE_ARRAY, 0) => {
            let mut texts = Texts::default();
            let all = each_page(pages, rows, |page, rows| texts.page(&page, rows))?;
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

/// Gives `decode` page after page, with its number of rows, until it knows one of them not; whether it knew all.
fn each_page(
    pages: &mut impl PageReader,
    rows: usize,
    mut decode: impl FnMut(Page, usize) -> ParquetResult<Option<()>>,
) -> ParquetResult<bool> {
    let mut done = 0;
    while done < rows {
        let Some(page) = pages.get_next_page()? else {
            return Ok(true);
        };
        let of_page = match page {
            Page::DataPage { num_values, .. } => num_values as usize,
            Page::DictionaryPage { .. } => 0,
            Page::DataPageV2 { .. } => return Ok(false),
        };
        done += of_page;
        if done > rows {
            return Err(too_few(done, rows));
        }
        if decode(page, of_page)?.is_none() {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Appends the floats of a page that has all of them.
fn floats(page: &Page, values: &mut Vec<f64>) -> ParquetResult<Option<()>> {
    if page.encoding() != Encoding::BYTE_STREAM_SPLIT {
        return Ok(None);
    }
    let expected = values.len() + page.num_values() as usize;
    streams::join(page.buffer(), values);
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

    fn page(&mut self, page: &Page, rows: usize) -> ParquetResult<Option<()>> {
        let Page::DataPage { buf, encoding, def_level_encoding, .. } = page else {
            return Ok(None);
        };
        if *encoding != Encoding::BYTE_STREAM_SPLIT || *def_level_encoding != Encoding::RLE {
            return Ok(None);
        }
        let mut bytes: &[u8] = buf;
        let mut length = [0; 4];
        length.copy_from_slice(take(&mut bytes, 4)?);
        let levels = take(&mut bytes, u32::from_le_bytes(length) as usize)?;
        let first = self.runs.len();
        each_run(levels, 1, rows, |level, times| {
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
    fn page(&mut self, page: &Page, rows: usize) -> ParquetResult<Option<()>> {
        match (page, page.encoding()) {
            (Page::DictionaryPage { buf, num_values, .. }, Encoding::PLAIN | Encoding::PLAIN_DICTIONARY) => {
                let mut bytes: &[u8] = buf;
                for _ in 0..*num_values {
                    let mut length = [0; 4];
                    length.copy_from_slice(take(&mut bytes, 4)?);
                    let label = take(&mut bytes, u32::from_le_bytes(length) as usize)?;
                    self.numbers.push(self.labels.number(std::str::from_utf8(label)?));
                }
            }
            (Page::DataPage { buf, .. }, Encoding::RLE_DICTIONARY | Encoding::PLAIN_DICTIONARY) => {
                let mut bytes: &[u8] = buf;
                let width = take(&mut bytes, 1)?[0];
                each_run(bytes, u32::from(width), rows, |number, times| {
                    let number = self.numbers.get(number as usize);
                    let number = number.ok_or_else(|| broken("the number of a label that is not there"))?;
                    self.labels.repeat(*number, times);
                    Ok(())
                })?;
                self.rows += rows;
            }
            _ => return Ok(None),
        }
        Ok(Some(()))
    }
}
