//! Columns in memory. The only file that names arrow2, so that another store would only replace this file.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use arrow2::array::{Array, PrimitiveArray};
use arrow2::bitmap::Bitmap;
use serde::{Deserialize, Serialize};

/// One block of a table: its columns, all of the same length.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Columns in schema order; on reading, in the requested order.
    pub columns: Vec<Column>,
}

/// Values of one column. Clones share the values.
#[derive(Clone, Debug)]
pub enum Column {
    /// Floating-point values, some perhaps absent.
    F64(FloatColumn),
    /// Integers.
    I32(IntegerColumn),
    /// Labels.
    Text(TextColumn),
}

/// Values of a [`Column::F64`]; NaN where absent.
#[derive(Clone, Debug)]
pub struct FloatColumn(PrimitiveArray<f64>);

/// Values of a [`Column::I32`].
#[derive(Clone, Debug)]
pub struct IntegerColumn(PrimitiveArray<i32>);

/// Values of a [`Column::Text`]: distinct labels, and per row the index of its label.
#[derive(Clone, Debug)]
pub struct TextColumn {
    labels: Arc<[String]>,
    codes: PrimitiveArray<u32>,
}

/// A text column under construction: labels are numbered in order of appearance.
#[derive(Debug, Default)]
pub struct Labels {
    known: HashMap<String, u32>,
    labels: Vec<String>,
    rows: Vec<u32>,
}

impl Labels {
    /// Appends `rows` rows of `label`.
    pub fn push(&mut self, label: &str, rows: usize) {
        let last = self.rows.last().copied().filter(|code| self.labels[*code as usize] == label);
        let code = last.unwrap_or_else(|| self.number(label));
        self.rows.extend(std::iter::repeat_n(code, rows));
    }

    /// The number of a label, assigned on first use.
    fn number(&mut self, label: &str) -> u32 {
        self.known.get(label).copied().unwrap_or_else(|| {
            let new = self.labels.len() as u32;
            self.labels.push(label.to_owned());
            self.known.insert(label.to_owned(), new);
            new
        })
    }

    /// All rows.
    pub fn column(self) -> Column {
        Column::text(self.labels, self.rows)
    }
}

impl Column {
    /// A column without absent values. The vector is taken over, not copied.
    pub fn f64(values: Vec<f64>) -> Self {
        Self::F64(FloatColumn(PrimitiveArray::from_vec(values)))
    }

    /// A column whose value at row i is present where `validity[i]`; a row without a flag is absent.
    /// Values of absent rows are replaced by NaN.
    pub fn nullable_f64(mut values: Vec<f64>, validity: Vec<bool>) -> Self {
        let flags = validity.into_iter().chain(std::iter::repeat(false));
        let bits: Bitmap = flags.take(values.len()).collect();
        for (value, valid) in values.iter_mut().zip(bits.iter()) {
            *value = if valid { *value } else { f64::NAN };
        }
        let array = PrimitiveArray::from_vec(values);
        let bits = (bits.unset_bits() > 0).then_some(bits);
        Self::F64(FloatColumn(array.with_validity(bits)))
    }

    /// A column of integers. The vector is taken over, not copied.
    pub fn i32(values: Vec<i32>) -> Self {
        Self::I32(IntegerColumn(PrimitiveArray::from_vec(values)))
    }

    /// A column whose text at row i is `labels[codes[i]]`. A code without a label reads as no
    /// text, and is refused on writing.
    pub fn text(labels: Vec<String>, codes: Vec<u32>) -> Self {
        Self::Text(TextColumn { labels: labels.into(), codes: PrimitiveArray::from_vec(codes) })
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::F64(column) => column.0.len(),
            Self::I32(column) => column.0.len(),
            Self::Text(column) => column.codes.len(),
        }
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Type of the values.
    pub fn kind(&self) -> Kind {
        match self {
            Self::F64(_) => Kind::F64,
            Self::I32(_) => Kind::I32,
            Self::Text(_) => Kind::Text,
        }
    }

    /// The values of an f64 column, NaN where absent.
    pub fn as_f64(&self) -> Option<&[f64]> {
        match self {
            Self::F64(column) => Some(column.0.values().as_slice()),
            _ => None,
        }
    }

    /// The values of an i32 column.
    pub fn as_i32(&self) -> Option<&[i32]> {
        match self {
            Self::I32(column) => Some(column.0.values().as_slice()),
            _ => None,
        }
    }

    /// The labels of a text column, and per row the index of its label.
    pub fn text_codes(&self) -> Option<(&[String], &[u32])> {
        match self {
            Self::Text(column) => Some((&column.labels, column.codes.values().as_slice())),
            _ => None,
        }
    }

    /// The text at `row` of a text column.
    pub fn text_at(&self, row: usize) -> Option<&str> {
        let (labels, codes) = self.text_codes()?;
        labels.get(*codes.get(row)? as usize).map(String::as_str)
    }

    /// The value at `row` of an f64 column; none where absent.
    pub fn value_at(&self, row: usize) -> Option<f64> {
        self.as_f64()?.get(row).copied().filter(|_| !self.is_null(row))
    }

    /// Number of absent values.
    pub fn nulls(&self) -> usize {
        match self {
            Self::F64(column) => column.0.null_count(),
            _ => 0,
        }
    }

    /// Whether the value at `row` is absent.
    pub fn is_null(&self, row: usize) -> bool {
        match self {
            Self::F64(column) => column.0.validity().is_some_and(|bits| bits.get(row) == Some(false)),
            _ => false,
        }
    }

    /// The first row whose value is present and NaN or infinite.
    pub(crate) fn first_not_finite(&self) -> Option<usize> {
        /// Rows that are checked together, which is faster than stopping early.
        const TOGETHER: usize = 512;
        let values = self.as_f64()?;
        let doubtful = |some: &[f64]| some.iter().fold(false, |doubt, value| doubt | !value.is_finite());
        let chunks = (0..).step_by(TOGETHER).zip(values.chunks(TOGETHER));
        chunks.filter(|(_, some)| doubtful(some)).find_map(|(start, some)| {
            let wrong = |row: &usize| !values[*row].is_finite() && !self.is_null(*row);
            (start..start + some.len()).find(wrong)
        })
    }
}

/// Type of a column's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// 64-bit floating point, finite.
    F64,
    /// 32-bit signed integer.
    I32,
    /// UTF-8 text, cheap where labels repeat.
    Text,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::F64 => "f64",
            Self::I32 => "i32",
            Self::Text => "text",
        })
    }
}

/// Name, unit and type of a column.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ColumnSpec {
    /// Name: not empty, no quotes, backslashes, dots or control characters.
    pub name: String,
    /// Unit in SI notation (`m/s`, `rad`); `1` for a number without unit and for text; never empty.
    pub unit: String,
    /// Type of the values.
    pub kind: Kind,
    /// Whether values may be absent; only [`Kind::F64`] columns may.
    pub nullable: bool,
}

impl ColumnSpec {
    /// A column of these properties.
    pub fn new(name: impl Into<String>, unit: impl Into<String>, kind: Kind, nullable: bool) -> Self {
        Self { name: name.into(), unit: unit.into(), kind, nullable }
    }
}

/// Kind of a table: its id, version and columns in order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TableSchema {
    /// Name of this kind of table, like `trajectories`.
    pub id: &'static str,
    /// Version of this kind of table, from 1.
    pub version: u32,
    /// Columns in file order.
    pub columns: Vec<ColumnSpec>,
}
