//! Reads columns of Parquet files that other programs wrote: no seal, no units, any simple type.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, ConvertedType, LogicalType, TimeUnit, Type};
use parquet::column::reader::ColumnReader::{
    self, BoolColumnReader, ByteArrayColumnReader, DoubleColumnReader, FixedLenByteArrayColumnReader,
    FloatColumnReader, Int32ColumnReader, Int64ColumnReader, Int96ColumnReader,
};
use parquet::column::reader::{ColumnReaderImpl, get_column_reader};
use parquet::data_type::{AsBytes, ByteArray, DataType};
use parquet::errors::Result as ParquetResult;
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataOptions, RowGroupMetaData};
use parquet::schema::types::ColumnDescPtr;

use crate::access::{Source, open};
use crate::decode::{guarded, pages};
use crate::error::{Error, Result};
use crate::footer;
use crate::layout::general;

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
        let metadata = guarded(path, damaged, || footer::metadata(&footer, &ParquetMetaDataOptions::new()))?;
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
                DoubleColumnReader(r) => numbers_of(r, levels, rows, each, |v| *v),
                FloatColumnReader(r) => numbers_of(r, levels, rows, each, |v| f64::from(*v)),
                Int32ColumnReader(r) => {
                    numbers_of(r, levels, rows, each, |v| meaning.integer(i64::from(*v), 32))
                }
                Int64ColumnReader(r) => numbers_of(r, levels, rows, each, |v| meaning.integer(*v, 64)),
                BoolColumnReader(r) => numbers_of(r, levels, rows, each, |v| f64::from(u8::from(*v))),
                FixedLenByteArrayColumnReader(r) if is_number => bytes_of(r, levels, rows, each, meaning),
                ByteArrayColumnReader(r) if is_number => bytes_of(r, levels, rows, each, meaning),
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
                Int32ColumnReader(r) => numbers_of(r, levels, rows, each, |v| meaning.seconds(i64::from(*v))),
                Int64ColumnReader(r) => numbers_of(r, levels, rows, each, |v| meaning.seconds(*v)),
                Int96ColumnReader(r) => numbers_of(r, levels, rows, each, |v| meaning.seconds(v.to_nanos())),
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
            ByteArrayColumnReader(r) if meaning == Meaning::Plain => Some(spread(r, levels, rows, &mut text)),
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
            let block = guarded(&self.path, damaged, || {
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
            let unknown = || general(format!("a number of {} bytes", bytes.len()));
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
            return Err(general(format!("{} values in a block of {rows} rows", done + records)));
        }
        let mut values = present.iter();
        levels.iter().try_for_each(|level| each(if *level == max_level { values.next() } else { None }))?;
        done += some;
    }
    Ok(())
}

fn damaged(path: &Path, fault: &str) -> Error {
    let remedy = "the file is truncated, damaged or of another format: export it again";
    Error::refuse(path, "file", fault, "a whole Parquet file", remedy)
}

/// The meaning of a column's values, beyond their storage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meaning {
    /// The values themselves.
    Plain,
    /// Integers without a sign.
    Unsigned,
    /// Floating point of 16 bits.
    Half,
    /// Integers scaled by so many decimals.
    Decimal(i32),
    /// Times.
    Timed(Timed),
}

/// The kind of times in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timed {
    /// Moments since 1970-01-01, so many to a second: in UTC, or in local time.
    Moments {
        /// How many.
        per_second: i64,
        /// Whether of UTC.
        is_utc: bool,
    },
    /// Times of a day, so many to a second.
    OfDay {
        /// How many.
        per_second: i64,
    },
    /// Days without a time.
    Days,
}

/// The meaning of a column's values by its type.
fn meaning(descriptor: &ColumnDescPtr) -> Meaning {
    if descriptor.physical_type() == Type::INT96 {
        return Meaning::Timed(Timed::Moments { per_second: 1_000_000_000, is_utc: true });
    }
    match descriptor.logical_type_ref() {
        Some(LogicalType::Timestamp(kind)) => Meaning::Timed(Timed::Moments {
            per_second: per_second(&kind.unit),
            is_utc: kind.is_adjusted_to_u_t_c,
        }),
        Some(LogicalType::Time(kind)) => Meaning::Timed(Timed::OfDay { per_second: per_second(&kind.unit) }),
        Some(LogicalType::Date) => Meaning::Timed(Timed::Days),
        Some(LogicalType::Decimal(_)) => Meaning::Decimal(descriptor.type_scale()),
        Some(LogicalType::Integer(kind)) if !kind.is_signed => Meaning::Unsigned,
        Some(LogicalType::Float16) => Meaning::Half,
        _ => converted(descriptor),
    }
}

/// By the converted type, as in the first version of the format.
fn converted(descriptor: &ColumnDescPtr) -> Meaning {
    match descriptor.converted_type() {
        ConvertedType::TIMESTAMP_MILLIS => Meaning::Timed(Timed::Moments { per_second: 1000, is_utc: true }),
        ConvertedType::TIMESTAMP_MICROS => {
            Meaning::Timed(Timed::Moments { per_second: 1_000_000, is_utc: true })
        }
        ConvertedType::TIME_MILLIS => Meaning::Timed(Timed::OfDay { per_second: 1000 }),
        ConvertedType::TIME_MICROS => Meaning::Timed(Timed::OfDay { per_second: 1_000_000 }),
        ConvertedType::DATE => Meaning::Timed(Timed::Days),
        ConvertedType::DECIMAL => Meaning::Decimal(descriptor.type_scale()),
        ConvertedType::UINT_8 | ConvertedType::UINT_16 | ConvertedType::UINT_32 | ConvertedType::UINT_64 => {
            Meaning::Unsigned
        }
        _ => Meaning::Plain,
    }
}

fn per_second(unit: &TimeUnit) -> i64 {
    match unit {
        TimeUnit::MILLIS => 1000,
        TimeUnit::MICROS => 1_000_000,
        TimeUnit::NANOS => 1_000_000_000,
    }
}

impl Meaning {
    /// The number that an integer of `bits` represents.
    pub(crate) fn integer(self, value: i64, bits: u32) -> f64 {
        match self {
            Self::Unsigned if bits == 32 => f64::from(value as u32),
            Self::Unsigned => value as u64 as f64,
            Self::Decimal(scale) => decimal(i128::from(value), scale),
            _ => value as f64,
        }
    }

    /// The number that bytes of a fixed length represent; `None` if they are not a number.
    pub(crate) fn bytes(self, bytes: &[u8]) -> Option<f64> {
        match (self, bytes) {
            (Self::Half, [low, high]) => Some(half(u16::from_le_bytes([*low, *high]))),
            (Self::Decimal(scale), [first, ..]) if bytes.len() <= 16 => {
                let mut all = [if *first < 0x80 { 0 } else { 0xFF }; 16];
                all[16 - bytes.len()..].copy_from_slice(bytes);
                Some(decimal(i128::from_be_bytes(all), scale))
            }
            _ => None,
        }
    }

    /// Seconds since 1970, or since midnight, of a time that is stored as an integer.
    pub(crate) fn seconds(self, value: i64) -> f64 {
        match self {
            Self::Timed(Timed::Moments { per_second, .. } | Timed::OfDay { per_second }) => {
                let rest = value.rem_euclid(per_second) as f64;
                value.div_euclid(per_second) as f64 + rest / per_second as f64
            }
            _ => f64::NAN,
        }
    }
}

fn decimal(value: i128, scale: i32) -> f64 {
    value as f64 / 10_f64.powi(scale)
}

/// Floating point of 16 bits (IEEE 754).
fn half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1F), f64::from(bits & 0x3FF));
    sign * match exponent {
        0 => fraction * 2_f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1024.0 + fraction) * 2_f64.powi(exponent - 25),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_16_bits_and_decimals_are_what_they_are_stored_as() {
        for (bits, value) in
            [(0x3C00, 1.0), (0xC000, -2.0), (0x7BFF, 65_504.0), (1, 5.960_464_477_539_063e-8)]
        {
            assert_eq!(half(bits), value);
        }
        assert!(half(0x7E00).is_nan() && half(0xFC00) == f64::NEG_INFINITY);
        let decimal = Meaning::Decimal(2);
        assert_eq!([decimal.integer(-1250, 32), decimal.bytes(&[0xFB, 0x1E]).unwrap()], [-12.5; 2]);
        assert_eq!(Meaning::Unsigned.integer(-1, 32), 4_294_967_295.0);
        let moments = Meaning::Timed(Timed::Moments { per_second: 1000, is_utc: true });
        assert_eq!(moments.seconds(-500), -0.5);
    }
}
