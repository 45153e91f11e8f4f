//! The Parquet layout of this crate's tables: names and types.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::errors::ParquetError;
use parquet::schema::types::{SchemaDescPtr, SchemaDescriptor, Type};

use crate::error::{Error, Result};
use crate::schema::{ColumnSpec, Kind};

/// The Parquet side of a list of columns.
pub(crate) struct Layout {
    /// The columns, with levels.
    pub descriptor: SchemaDescPtr,
}

impl Layout {
    /// The layout of `columns`; messages name the table `file`.
    pub fn new(file: &Path, columns: &[ColumnSpec]) -> Result<Self> {
        check_columns(file, columns)?;
        let broken = |e: ParquetError| write_error(file, e);
        let fields = columns.iter().map(|c| parquet_type(c).map(Arc::new));
        let fields = fields.collect::<std::result::Result<_, _>>().map_err(broken)?;
        let root = Type::group_type_builder("schema").with_fields(fields).build().map_err(broken)?;
        Ok(Self { descriptor: Arc::new(SchemaDescriptor::new(Arc::new(root))) })
    }

    /// Bytes of so many rows of numbers without compression.
    pub fn most_bytes(&self, rows: usize) -> usize {
        let bytes = |kind: Physical| if kind == Physical::DOUBLE { 8 } else { 1 };
        rows * self.descriptor.columns().iter().map(|column| bytes(column.physical_type())).sum::<usize>()
    }
}

/// The error of an attempt to write `file`.
pub(crate) fn write_error(file: &Path, error: ParquetError) -> Error {
    Error::io(file, "write", inner_io(error).unwrap_or_else(std::io::Error::other))
}

/// The operating system's error inside an error of the parquet crate, or else that error.
pub(crate) fn inner_io(
    error: ParquetError,
) -> std::result::Result<std::io::Error, Box<dyn std::error::Error + Send + Sync>> {
    match error {
        ParquetError::External(inner) => inner.downcast::<std::io::Error>().map(|io| *io),
        other => Err(other.into()),
    }
}

fn check_columns(file: &Path, columns: &[ColumnSpec]) -> Result<()> {
    let mut names = HashSet::new();
    for column in columns {
        let thing = format!("column `{}`", column.name);
        let refuse = |found: &str, expected: &str| {
            Err(Error::refuse(file, thing.as_str(), found, expected, "correct the table's schema"))
        };
        let strange = |c: char| c.is_control() || matches!(c, '"' | '\\');
        if column.name.is_empty() || column.name.contains(strange) {
            return refuse("an invalid name", "a name without quotes, backslashes and control characters");
        }
        if column.unit.is_empty() {
            return refuse("no unit", "a unit, or 1 where there is none");
        }
        if column.nullable && column.kind != Kind::F64 {
            return refuse("a nullable column of another type", "absent values in f64 columns only");
        }
        if !names.insert(&column.name) {
            return refuse("two columns of this name", "one column per name");
        }
    }
    Ok(())
}

/// The type of values of this kind in Parquet.
pub(crate) fn physical(kind: Kind) -> Physical {
    match kind {
        Kind::F64 => Physical::DOUBLE,
        Kind::I32 => Physical::INT32,
        Kind::Text => Physical::BYTE_ARRAY,
    }
}

fn parquet_type(column: &ColumnSpec) -> std::result::Result<Type, ParquetError> {
    let repetition = if column.nullable { Repetition::OPTIONAL } else { Repetition::REQUIRED };
    let logical = (column.kind == Kind::Text).then_some(LogicalType::String);
    Type::primitive_type_builder(&column.name, physical(column.kind))
        .with_repetition(repetition)
        .with_logical_type(logical)
        .build()
}
