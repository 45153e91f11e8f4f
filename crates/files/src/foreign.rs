//! Reads columns of Parquet files that other programs wrote: no seal, no units, any simple type.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::{AsBytes, ByteArray, DataType};
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataOptions, RowGroupMetaData};

use crate::decode::{Undecoded, decoded};
use crate::error::{Error, Result};
use crate::footer;
use crate::meaning::{Meaning, Timed, meaning};
use crate::ordinary::open;
use crate::page_bytes::pages;
use crate::source::Source;

/// A Parquet file of any origin. Nothing in it is trusted.
pub struct ForeignTable {
    path: PathBuf,
    source: Source,
    metadata: ParquetMetaData,
    columns: Vec<String>,
}

impl ForeignTable {
    /// Opens the Parquet file at `path`.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read; [`Error::Refused`] if it is not a whole Parquet file.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let unreadable = |e| Error::io(path, "read", e);
        let mut file = open(path)?;
        let footer = footer::bytes_of(&mut file).map_err(unreadable)?;
        let (_, footer) = footer.ok_or_else(|| damaged(path, "no Parquet header or footer"))?;
        let source = Source::new(file).map_err(unreadable)?;
        let metadata = guarded(path, || footer::metadata(&footer, &ParquetMetaDataOptions::new()))?;
        let schema = metadata.file_metadata().schema_descr();
        let columns = schema.columns().iter().map(|column| column.path().string()).collect();
        Ok(Self { path: path.to_owned(), source, metadata, columns })
    }

    /// Names of the columns in file order; those inside a nested one with dots.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.metadata.row_groups().iter().map(rows_of).sum()
    }

    /// Passes the numbers of a column to `each`, in order: floating point, decimals, integers (time stamps as
    /// stored), Booleans as 0 and 1. NaN where absent.
    ///
    /// # Errors
    /// [`Error::Refused`] if there is no such column, if it contains something else, or if it cannot be
    /// decoded.
    pub fn numbers(&self, name: &str, mut each: impl FnMut(f64)) -> Result<()> {
        self.decode(name, "numbers", |reader, meaning, levels, rows| {
            let each = &mut each;
            let is_number = matches!(meaning, Meaning::Half | Meaning::Decimal(_));
            Some(match reader {
                ColumnReader::DoubleColumnReader(r) => numbers_of(r, levels, rows, each, |v| *v),
                ColumnReader::FloatColumnReader(r) => numbers_of(r, levels, rows, each, |v| f64::from(*v)),
                ColumnReader::Int32ColumnReader(r) => {
                    numbers_of(r, levels, rows, each, |v| meaning.integer(i64::from(*v), 32))
                }
                ColumnReader::Int64ColumnReader(r) => {
                    numbers_of(r, levels, rows, each, |v| meaning.integer(*v, 64))
                }
                ColumnReader::BoolColumnReader(r) => {
                    numbers_of(r, levels, rows, each, |v| f64::from(u8::from(*v)))
                }
                ColumnReader::FixedLenByteArrayColumnReader(r) if is_number => {
                    bytes_of(r, levels, rows, each, meaning)
                }
                ColumnReader::ByteArrayColumnReader(r) if is_number => {
                    bytes_of(r, levels, rows, each, meaning)
                }
                _ => return None,
            })
        })
    }

    /// The kind of times in a column, by its type; `None` if it has others, or does not exist.
    pub fn timed(&self, name: &str) -> Option<Timed> {
        let place = self.columns.iter().position(|column| column == name)?;
        match meaning(&self.metadata.file_metadata().schema_descr().column(place)) {
            Meaning::Timed(timed) => Some(timed),
            _ => None,
        }
    }

    /// Passes the times of a column whose type defines their unit to `each`, in order \[s\]: since 1970, or
    /// since midnight; NaN where absent.
    ///
    /// # Errors
    /// As [`ForeignTable::numbers`].
    pub fn seconds(&self, name: &str, mut each: impl FnMut(f64)) -> Result<()> {
        self.decode(name, "times", |reader, meaning, levels, rows| {
            let each = &mut each;
            Some(match reader {
                ColumnReader::Int32ColumnReader(r) => {
                    numbers_of(r, levels, rows, each, |v| meaning.seconds(i64::from(*v)))
                }
                ColumnReader::Int64ColumnReader(r) => {
                    numbers_of(r, levels, rows, each, |v| meaning.seconds(*v))
                }
                ColumnReader::Int96ColumnReader(r) => {
                    numbers_of(r, levels, rows, each, |v| meaning.seconds(v.to_nanos()))
                }
                _ => return None,
            })
        })
    }

    /// Passes the texts of a column to `each`, in order; empty ones where absent.
    ///
    /// # Errors
    /// As [`ForeignTable::numbers`].
    pub fn texts(&self, name: &str, mut each: impl FnMut(&str)) -> Result<()> {
        let mut text = |bytes: Option<&ByteArray>| {
            each(bytes.map_or(Ok(""), |bytes| std::str::from_utf8(bytes.data()))?);
            Ok(())
        };
        self.decode(name, "text", |reader, meaning, levels, rows| match reader {
            ColumnReader::ByteArrayColumnReader(r) if meaning == Meaning::Plain => {
                Some(spread(r, levels, rows, &mut text))
            }
            _ => None,
        })
    }

    fn decode(
        &self,
        name: &str,
        expected: &str,
        mut decode: impl FnMut(ColumnReader, Meaning, i16, usize) -> Option<ParquetResult<()>>,
    ) -> Result<()> {
        let refuse = |found: String| {
            let remedy = "name another column or write the file again";
            Err(Error::refuse(&self.path, format!("column `{name}`"), found, expected, remedy))
        };
        let Some(place) = self.columns.iter().position(|column| column == name) else {
            return refuse("no such column".to_owned());
        };
        let descriptor = self.metadata.file_metadata().schema_descr().column(place);
        if descriptor.max_rep_level() > 0 {
            return refuse("lists".to_owned());
        }
        self.check_compression(name, place)?;
        let meaning = meaning(&descriptor);
        for group in self.metadata.row_groups() {
            let rows = rows_of(group);
            let block = guarded(&self.path, || {
                let pages = pages(&self.source, group.column(place), rows)?;
                let reader = get_column_reader(Arc::clone(&descriptor), Box::new(pages));
                decode(reader, meaning, descriptor.max_def_level(), rows).transpose()
            })?;
            if block.is_none() {
                return refuse(format!("values of type {}", descriptor.physical_type()));
            }
        }
        Ok(())
    }

    /// Refuses a column, by its name, whose compression is not supported.
    fn check_compression(&self, name: &str, place: usize) -> Result<()> {
        let kinds = self.metadata.row_groups().iter().map(|group| group.column(place).compression());
        let other = |kind: &Compression| matches!(kind, Compression::LZO);
        match kinds.into_iter().find(other) {
            None => Ok(()),
            Some(kind) => Err(Error::refuse(
                &self.path,
                format!("compression of column `{name}`"),
                kind.to_string(),
                "zstd, Snappy, gzip, LZ4, brotli or none",
                "write the file again with zstd",
            )),
        }
    }
}

fn rows_of(group: &RowGroupMetaData) -> usize {
    usize::try_from(group.num_rows()).unwrap_or(0)
}

/// Passes the values of a row group through `number` to `each`; NaN where absent.
fn numbers_of<T: DataType>(
    reader: ColumnReaderImpl<T>,
    max_level: i16,
    rows: usize,
    each: &mut impl FnMut(f64),
    number: impl Fn(&T::T) -> f64,
) -> ParquetResult<()> {
    spread(reader, max_level, rows, |value| {
        each(value.map_or(f64::NAN, &number));
        Ok(())
    })
}

/// Passes the numbers that the bytes of a row group represent to `each`; NaN where absent.
fn bytes_of<T: DataType>(
    reader: ColumnReaderImpl<T>,
    max_level: i16,
    rows: usize,
    each: &mut impl FnMut(f64),
    meaning: Meaning,
) -> ParquetResult<()>
where
    T::T: AsBytes,
{
    spread(reader, max_level, rows, |value| {
        let number = |bytes: &[u8]| {
            let unknown = || ParquetError::General(format!("a number of {} bytes", bytes.len()));
            meaning.bytes(bytes).ok_or_else(unknown)
        };
        each(value.map_or(Ok(f64::NAN), |value| number(value.as_bytes()))?);
        Ok(())
    })
}

/// Rows that are decoded at a time.
const AT_A_TIME: usize = 1 << 16;

/// Passes all values of a row group to `each`, a block at a time.
fn spread<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    max_level: i16,
    rows: usize,
    mut each: impl FnMut(Option<&T::T>) -> ParquetResult<()>,
) -> ParquetResult<()> {
    let (mut present, mut levels) = (Vec::new(), Vec::new());
    let mut done = 0;
    while done < rows {
        let some = (rows - done).min(AT_A_TIME);
        present.clear();
        levels.clear();
        let (records, _, _) = reader.read_records(some, Some(&mut levels), None, &mut present)?;
        if max_level == 0 {
            levels.resize(present.len(), 0);
        }
        let count = levels.iter().filter(|&&level| level == max_level).count();
        if records != some || levels.len() != some || present.len() != count {
            return Err(ParquetError::General(format!(
                "{} values in a block of {rows} rows",
                done + records
            )));
        }
        let mut values = present.iter();
        levels.iter().try_for_each(|level| each(if *level == max_level { values.next() } else { None }))?;
        done += some;
    }
    Ok(())
}

fn guarded<T>(path: &Path, decode: impl FnOnce() -> ParquetResult<T>) -> Result<T> {
    decoded(decode).map_err(|undecoded| match undecoded {
        Undecoded::Unreadable(io) => Error::io(path, "read", io),
        Undecoded::Damaged(found) => damaged(path, &found),
    })
}

fn damaged(path: &Path, found: &str) -> Error {
    let remedy = "the file is truncated, damaged or of another format: export it again";
    Error::refuse(path, "file", found, "a whole Parquet file", remedy)
}
