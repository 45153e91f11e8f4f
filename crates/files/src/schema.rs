//! The columns of tables.

use std::fmt;

use serde::{Deserialize, Serialize};

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
