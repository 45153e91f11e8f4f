//! Tables of rows: each column is listed once, with its name, its unit, and accessors for its value in a row.

use std::borrow::Cow;
use std::fmt::{self, Display};

use serde::Serialize;
use serde::de::value::StrDeserializer;
use serde::de::{DeserializeOwned, IntoDeserializer};
use serde_json::Value;

use crate::columns::{Column, ColumnSpec, Kind, Labels, Table, TableSchema};
use crate::encode::{EncodedBlock, encode_block};
use crate::error::{Error, Result};
use crate::table_reader::TableReader;

/// The columns of a table whose rows are of type `Row`: its schema, its writer and its reader.
///
/// ```
/// use files::Columns;
/// #[derive(Clone, Default)]
/// struct Speed { place: String, run: i32, u: Option<f64> }
///
/// let columns = Columns::<Speed>::new("speeds", 1)
///     .text("place", |row| &row.place, |row, place| row.place = place.to_owned())
///     .integer("run", "1", |row| row.run, |row, run| row.run = run)
///     .optional("u", "m/s", |row| row.u, |row, u| row.u = u);
/// assert_eq!(columns.table(&[Speed::default()]).columns.len(), columns.schema().columns.len());
/// ```
pub struct Columns<Row> {
    schema: TableSchema,
    fields: Vec<Field<Row>>,
}

type Get<Row, T> = Box<dyn Fn(&Row) -> T + Send + Sync>;
type Set<Row, T> = Box<dyn Fn(&mut Row, T) + Send + Sync>;
type GetText<Row> = Box<dyn for<'a> Fn(&'a Row) -> Cow<'a, str> + Send + Sync>;
/// Returns what would have been expected if the text is unknown.
type SetText<Row> = Box<dyn Fn(&mut Row, &str) -> Result<(), Unknown> + Send + Sync>;

/// The accessors of one column.
enum Field<Row> {
    Text(GetText<Row>, SetText<Row>),
    Integer(Get<Row, i32>, Set<Row, i32>),
    Number(Get<Row, f64>, Set<Row, f64>),
    Optional(Get<Row, Option<f64>>, Set<Row, Option<f64>>),
}

impl<Row: 'static> Columns<Row> {
    /// A table of this kind that has no columns yet.
    pub fn new(id: &'static str, version: u32) -> Self {
        Self { schema: TableSchema { id, version, columns: Vec::new() }, fields: Vec::new() }
    }

    /// Adds a column of text.
    #[must_use]
    pub fn text(
        self,
        name: impl Into<String>,
        get: impl for<'a> Fn(&'a Row) -> &'a str + Send + Sync + 'static,
        set: impl Fn(&mut Row, &str) + Send + Sync + 'static,
    ) -> Self {
        let set = move |row: &mut Row, text: &str| {
            set(row, text);
            Ok(())
        };
        self.with(name, "1", Field::Text(Box::new(move |row| Cow::Borrowed(get(row))), Box::new(set)))
    }

    /// Adds a column of names: serde's names of the variants of `T`, an enum without fields.
    #[must_use]
    pub fn choice<T: Serialize + DeserializeOwned>(
        self,
        name: impl Into<String>,
        get: impl Fn(&Row) -> T + Send + Sync + 'static,
        set: impl Fn(&mut Row, T) + Send + Sync + 'static,
    ) -> Self {
        let set = move |row: &mut Row, text: &str| {
            let known: StrDeserializer<'_, Unknown> = text.into_deserializer();
            set(row, T::deserialize(known)?);
            Ok(())
        };
        self.with(name, "1", Field::Text(Box::new(move |row| name_of(&get(row)).into()), Box::new(set)))
    }

    /// Adds a column of integers.
    #[must_use]
    pub fn integer(
        self,
        name: impl Into<String>,
        unit: &str,
        get: impl Fn(&Row) -> i32 + Send + Sync + 'static,
        set: impl Fn(&mut Row, i32) + Send + Sync + 'static,
    ) -> Self {
        self.with(name, unit, Field::Integer(Box::new(get), Box::new(set)))
    }

    /// Adds a column of numbers that every row has.
    #[must_use]
    pub fn number(
        self,
        name: impl Into<String>,
        unit: &str,
        get: impl Fn(&Row) -> f64 + Send + Sync + 'static,
        set: impl Fn(&mut Row, f64) + Send + Sync + 'static,
    ) -> Self {
        self.with(name, unit, Field::Number(Box::new(get), Box::new(set)))
    }

    /// Adds a column of numbers that some rows may lack.
    #[must_use]
    pub fn optional(
        self,
        name: impl Into<String>,
        unit: &str,
        get: impl Fn(&Row) -> Option<f64> + Send + Sync + 'static,
        set: impl Fn(&mut Row, Option<f64>) + Send + Sync + 'static,
    ) -> Self {
        self.with(name, unit, Field::Optional(Box::new(get), Box::new(set)))
    }

    fn with(mut self, name: impl Into<String>, unit: &str, field: Field<Row>) -> Self {
        let nullable = matches!(field, Field::Optional(..));
        self.schema.columns.push(ColumnSpec::new(name, unit, field.kind(), nullable));
        self.fields.push(field);
        self
    }

    /// Id, version and columns of the table.
    pub fn schema(&self) -> &TableSchema {
        &self.schema
    }

    /// `rows` as one block of the table.
    pub fn table(&self, rows: &[Row]) -> Table {
        Table { columns: self.fields.iter().map(|field| field.column(rows)).collect() }
    }

    /// `rows` as one block of the table, as it stands in the file.
    ///
    /// # Errors
    /// See [`encode_block`].
    pub fn encode(&self, rows: &[Row]) -> Result<EncodedBlock> {
        encode_block(&self.schema, &self.table(rows))
    }
}

impl<Row: Clone + 'static> Columns<Row> {
    /// The rows of block `block`, each made from `blank` by setting every column.
    ///
    /// # Errors
    /// [`Error::Refused`] for a damaged block, or an unknown name in a column of names.
    pub fn read_block(&self, reader: &TableReader, block: usize, blank: &Row) -> Result<Vec<Row>> {
        let names: Vec<&str> = self.schema.columns.iter().map(|column| column.name.as_str()).collect();
        let table = reader.read_block(block, &names)?;
        reader.check_memory(reader.block_rows(block), size_of::<Row>())?;
        let mut rows = vec![blank.clone(); reader.block_rows(block)];
        for ((field, spec), column) in self.fields.iter().zip(&self.schema.columns).zip(&table.columns) {
            field.fill(&mut rows, column).map_err(|(row, expected)| {
                let before: usize = (0..block).map(|earlier| reader.block_rows(earlier)).sum();
                let thing = format!("column `{}`, row {}", spec.name, before + row);
                let text = format!("`{}`", column.text_at(row).unwrap_or_default());
                Error::refuse(reader.path(), thing, text, expected, "write the table again")
            })?;
        }
        Ok(rows)
    }

    /// All rows of a table whose columns are checked first.
    ///
    /// # Errors
    /// As [`Columns::read_block`]; columns that are missing.
    pub fn read(&self, reader: &TableReader, blank: &Row) -> Result<Vec<Row>> {
        reader.require(&self.schema.columns)?;
        reader.check_memory(reader.rows(), size_of::<Row>())?;
        let blocks = (0..reader.blocks()).map(|block| self.read_block(reader, block, blank));
        Ok(blocks.collect::<Result<Vec<_>>>()?.concat())
    }
}

impl<Row> fmt::Debug for Columns<Row> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Columns").field("schema", &self.schema).finish_non_exhaustive()
    }
}

impl<Row> Field<Row> {
    fn kind(&self) -> Kind {
        match self {
            Self::Text(..) => Kind::Text,
            Self::Integer(..) => Kind::I32,
            Self::Number(..) | Self::Optional(..) => Kind::F64,
        }
    }

    fn column(&self, rows: &[Row]) -> Column {
        match self {
            Self::Text(get, _) => {
                let mut labels = Labels::default();
                rows.iter().for_each(|row| labels.push(&get(row), 1));
                labels.column()
            }
            Self::Integer(get, _) => Column::i32(rows.iter().map(get).collect()),
            Self::Number(get, _) => Column::f64(rows.iter().map(get).collect()),
            Self::Optional(get, _) => {
                let values = rows.iter().map(get).map(|v| (v.unwrap_or(f64::NAN), v.is_some()));
                let (values, present) = values.unzip();
                Column::nullable_f64(values, present)
            }
        }
    }

    /// Sets this field of every row; else returns the row whose text is unknown, and what was expected there.
    fn fill(&self, rows: &mut [Row], column: &Column) -> Result<(), (usize, String)> {
        for (i, row) in rows.iter_mut().enumerate() {
            match self {
                Self::Text(_, set) => {
                    set(row, column.text_at(i).unwrap_or_default()).map_err(|unknown| (i, unknown.0))?;
                }
                Self::Integer(_, set) => set(row, column.as_i32().map_or(0, |all| all[i])),
                Self::Number(_, set) => set(row, column.value_at(i).unwrap_or(f64::NAN)),
                Self::Optional(_, set) => set(row, column.value_at(i)),
            }
        }
        Ok(())
    }
}

/// The name that serde gives to a variant without fields.
fn name_of<T: Serialize>(variant: &T) -> String {
    match serde_json::to_value(variant) {
        Ok(Value::String(name)) => name,
        other => unreachable!("a variant without fields is written as its name, not as {other:?}"),
    }
}

/// serde's names, where a text is none of them.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Unknown(String);

impl serde::de::Error for Unknown {
    fn custom<T: Display>(message: T) -> Self {
        Self(message.to_string())
    }

    fn unknown_variant(_: &str, expected: &'static [&'static str]) -> Self {
        let quoted: Vec<String> = expected.iter().map(|name| format!("`{name}`")).collect();
        Self(format!("one of {}", quoted.join(", ")))
    }
}
