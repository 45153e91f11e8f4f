//! What a table's file says of its columns: their layout in Parquet, the envelope, and the schema for readers of Arrow.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::errors::ParquetError;
use parquet::schema::types::{SchemaDescPtr, SchemaDescriptor, Type};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::columns::{ColumnSpec, Kind, TableSchema};
use crate::error::{Error, Result};
use crate::provenance::{Provenance, Shard};
use crate::seal::{self, Digest, schema_id};

/// The Parquet side of `columns`; messages name the table `file`.
pub(crate) fn descriptor(file: &Path, columns: &[ColumnSpec]) -> Result<SchemaDescPtr> {
    check_columns(file, columns)?;
    let broken = |e: ParquetError| write_error(file, e);
    let fields = columns.iter().map(|c| parquet_type(c).map(Arc::new));
    let fields = fields.collect::<Result<_, _>>().map_err(broken)?;
    let root = Type::group_type_builder("schema").with_fields(fields).build().map_err(broken)?;
    Ok(Arc::new(SchemaDescriptor::new(Arc::new(root))))
}

/// The error of an attempt to write `file`.
pub(crate) fn write_error(file: &Path, error: ParquetError) -> Error {
    Error::io(file, "write", inner_io(error).unwrap_or_else(std::io::Error::other))
}

/// The operating system's error inside an error of the parquet crate, or else that error.
pub(crate) fn inner_io(
    error: ParquetError,
) -> Result<std::io::Error, Box<dyn std::error::Error + Send + Sync>> {
    match error {
        ParquetError::External(inner) => inner.downcast::<std::io::Error>().map(|io| *io),
        other => Err(other.into()),
    }
}

/// An error of the parquet crate.
pub(crate) fn general(what: impl Into<String>) -> ParquetError {
    ParquetError::General(what.into())
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

fn parquet_type(column: &ColumnSpec) -> Result<Type, ParquetError> {
    let repetition = if column.nullable { Repetition::OPTIONAL } else { Repetition::REQUIRED };
    let logical = (column.kind == Kind::Text).then_some(LogicalType::String);
    Type::primitive_type_builder(&column.name, physical(column.kind))
        .with_repetition(repetition)
        .with_logical_type(logical)
        .build()
}

/// The key in the footer of a table's envelope, a JSON text.
pub(crate) const KEY: &str = "seatrial";

/// Schema, provenance, seal and units of a table.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TableMetadata {
    schema: String,
    producer: String,
    #[serde(deserialize_with = "seal::required")]
    seal: Option<Digest>,
    /// Its inputs.
    pub inputs: BTreeMap<String, Digest>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    origins: BTreeMap<String, Digest>,
    pub(crate) settings: BTreeMap<String, Value>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    shard: Option<Shard>,
    /// The document beside the table that vouches for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub document: Option<String>,
    /// Columns in file order.
    pub columns: Vec<ColumnEntry>,
}

/// A column; the Parquet schema states whether it may contain nulls.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ColumnEntry {
    pub name: String,
    pub unit: String,
    pub kind: Kind,
}

impl TableMetadata {
    /// The envelope of a table yet to be sealed.
    pub fn new(schema: &TableSchema, provenance: &Provenance) -> Self {
        let Provenance { producer, inputs, origins, settings, shard, .. } = provenance.clone();
        let entry = |column: &ColumnSpec| {
            let ColumnSpec { name, unit, kind, .. } = column.clone();
            ColumnEntry { name, unit, kind }
        };
        Self {
            schema: schema_id(schema.id, schema.version),
            producer,
            seal: Some(Digest::ZERO),
            inputs,
            origins,
            settings,
            shard,
            document: None,
            columns: schema.columns.iter().map(entry).collect(),
        }
    }

    /// The columns, and the origin of the table.
    pub fn into_parts(self) -> (Vec<ColumnEntry>, Provenance) {
        let Self { producer, inputs, origins, settings, shard, columns, .. } = self;
        (columns, Provenance { producer, inputs, origins, settings, shard, ..Provenance::default() })
    }
}

// Parquet has no place for a column's own notes, such as its unit. Readers of Arrow (pyarrow, polars, DuckDB) take them from the
// key [`ARROW_KEY`] of the footer: a schema message of Arrow's IPC format, which is a FlatBuffer, in base 64.

/// The key in the footer.
pub(crate) const ARROW_KEY: &str = "ARROW:schema";

/// The key of a unit in a column's metadata.
const UNIT: &str = "unit";

/// Version 5 of Arrow's metadata, as a FlatBuffer numbers it.
const METADATA_V5: u32 = 4;
/// A message whose header is a schema.
const SCHEMA: u32 = 1;
/// Numbers of types.
const INT: u32 = 2;
const FLOATING_POINT: u32 = 3;
const UTF8: u32 = 5;
/// 64-bit precision.
const DOUBLE: u32 = 2;
/// What precedes the length of a message.
const CONTINUATION: [u8; 4] = [0xff; 4];

/// The value of [`ARROW_KEY`] for a table of `columns`.
pub(crate) fn arrow_schema(columns: &[ColumnSpec]) -> String {
    let flat = schema_message(columns);
    let mut bytes = CONTINUATION.to_vec();
    bytes.extend((flat.len() as u32).to_le_bytes());
    bytes.extend(flat);
    base64(&bytes)
}

/// The message: its length is a multiple of 8 bytes.
fn schema_message(columns: &[ColumnSpec]) -> Vec<u8> {
    let mut flat = Flat::new();
    // Version, kind of header, header
    let [.., header] = flat.table([Some(METADATA_V5), Some(SCHEMA), Some(0)]);
    flat.point(header);
    // Byte order (little, the default), fields
    let [_, fields] = flat.table([None, Some(0)]);
    flat.point(fields);
    for (column, place) in columns.iter().zip(flat.vector(columns.len())) {
        flat.point(place);
        field_message(&mut flat, column);
    }
    flat.finish()
}

fn field_message(flat: &mut Flat, column: &ColumnSpec) {
    let kind = match column.kind {
        Kind::F64 => FLOATING_POINT,
        Kind::I32 => INT,
        Kind::Text => UTF8,
    };
    // Name, whether nullable, kind of type, type, dictionary, children, metadata
    let nullable = u32::from(column.nullable);
    let [name, _, _, of_kind, _, children, metadata] =
        flat.table([Some(0), Some(nullable), Some(kind), Some(0), None, Some(0), Some(0)]);
    flat.point(name);
    flat.text(&column.name);
    flat.point(of_kind);
    match column.kind {
        Kind::F64 => _ = flat.table([Some(DOUBLE)]),
        // Bits, whether signed
        Kind::I32 => _ = flat.table([Some(32), Some(1)]),
        Kind::Text => _ = flat.table([]),
    }
    flat.point(children);
    flat.vector(0);
    flat.point(metadata);
    for entry in flat.vector(1) {
        flat.point(entry);
        let [key, value] = flat.table([Some(0), Some(0)]);
        flat.point(key);
        flat.text(UNIT);
        flat.point(value);
        flat.text(&column.unit);
    }
}

/// `bytes` in base 64, with padding.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |i: usize| u32::from(three.get(i).copied().unwrap_or_default());
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            let known = digit <= three.len();
            let place = (bits >> (18 - 6 * digit) & 63) as usize;
            text.push(if known { char::from(DIGITS[place]) } else { '=' });
        }
    }
    text
}

/// Bytes of a word.
const WORD: usize = 4;

/// A FlatBuffer being written from front to back: tables, vectors and texts, each behind the place that points to it. A place is a
/// word with the distance to what it points to. Every slot of a table takes a word, too: a smaller number is its first bytes. The list
/// of a table's slots follows the table. The length is always a multiple of a word.
struct Flat(Vec<u8>);

impl Flat {
    /// A buffer whose root, written next, is a table.
    pub fn new() -> Self {
        let mut flat = Self(vec![0; WORD]);
        flat.point(0);
        flat
    }

    /// Lets the word at `place` point to what is written next.
    pub fn point(&mut self, place: usize) {
        let distance = (self.0.len() - place) as u32;
        self.0[place..place + WORD].copy_from_slice(&distance.to_le_bytes());
    }

    /// A table with these numbers in its slots, `None` where a slot is absent. Returns the place of each slot.
    pub fn table<const N: usize>(&mut self, slots: [Option<u32>; N]) -> [usize; N] {
        let start = self.0.len();
        let mut places = [start; N];
        self.push(0);
        for (place, slot) in places.iter_mut().zip(slots) {
            *place = if slot.is_some() { self.0.len() } else { start };
            slot.into_iter().for_each(|number| self.push(number));
        }
        // The list follows, so its distance is negative.
        let (length, behind) = (self.0.len() - start, start as i32 - self.0.len() as i32);
        self.0[start..start + WORD].copy_from_slice(&behind.to_le_bytes());
        let offsets = places.iter().map(|place| place - start);
        for number in [WORD + 2 * N, length].into_iter().chain(offsets) {
            self.0.extend((number as u16).to_le_bytes());
        }
        self.fill(WORD);
        places
    }

    /// A vector of so many places, which are returned.
    pub fn vector(&mut self, count: usize) -> Vec<usize> {
        self.push(count as u32);
        let places = (0..count).map(|_| {
            self.push(0);
            self.0.len() - WORD
        });
        places.collect()
    }

    /// A text, with a zero behind it.
    pub fn text(&mut self, text: &str) {
        self.push(text.len() as u32);
        self.0.extend(text.bytes().chain([0]));
        self.fill(WORD);
    }

    /// The buffer, filled to a multiple of 8 bytes.
    pub fn finish(mut self) -> Vec<u8> {
        self.fill(2 * WORD);
        self.0
    }

    fn push(&mut self, word: u32) {
        self.0.extend(word.to_le_bytes());
    }

    fn fill(&mut self, multiple: usize) {
        self.0.resize(self.0.len().next_multiple_of(multiple), 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOLDEN: &str = "\
        /////7gBAAAEAAAA8P///wQAAAABAAAAEAAAAAoAEAAEAAgADAAAAPj///8MAAAACAAIAAAABAADAAAADAAAAIQAAAAAAQAA5P//\
        /ywAAAABAAAAAwAAACgAAAA0AAAANAAAABIAHAAEAAgADAAQAAAAFAAYAAAAAQAAAHUAAAD4////AgAAAAYACAAEAAAAAAAAAAEA\
        AAAEAAAA9P///xAAAAAYAAAACAAMAAQACAAEAAAAdW5pdAAAAAADAAAAbS9zAOT///8sAAAAAAAAAAIAAAAoAAAAOAAAADgAAAAS\
        ABwABAAIAAwAEAAAABQAGAAAAAMAAABydW4A9P///yAAAAABAAAACAAMAAQACAAAAAAAAQAAAAQAAAD0////EAAAABgAAAAIAAwA\
        BAAIAAQAAAB1bml0AAAAAAEAAAAxAAAA5P///ywAAAAAAAAABQAAACwAAAAwAAAAMAAAABIAHAAEAAgADAAQAAAAFAAYAAAABgAA\
        AGRlc2lnbgAA/P///wQABAAAAAAAAQAAAAQAAAD0////EAAAABgAAAAIAAwABAAIAAQAAAB1bml0AAAAAAEAAAAxAAAAAAAAAA==";

    #[test]
    fn oracle_base64_has_the_digits_of_rfc_4648() {
        let vectors = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (bytes, expected) in vectors {
            assert_eq!(base64(bytes.as_bytes()), expected);
        }
    }

    /// pyarrow 25 and polars 1 read this text: `u: double, unit m/s`, `run: int32 not null, unit 1`, `design: string not
    /// null, unit 1`; `scripts/python-check.sh` has them read tables.
    #[test]
    fn golden_the_schema_of_three_columns() {
        let columns = [
            ColumnSpec::new("u", "m/s", Kind::F64, true),
            ColumnSpec::new("run", "1", Kind::I32, false),
            ColumnSpec::new("design", "1", Kind::Text, false),
        ];
        assert_eq!(arrow_schema(&columns), GOLDEN);
    }

    #[test]
    fn law_messages_fill_whole_words_of_eight_bytes() {
        for length in 1..20 {
            let columns = [ColumnSpec::new("x".repeat(length), "m", Kind::F64, false)];
            assert_eq!(schema_message(&columns).len() % 8, 0, "{length}");
        }
    }
}
