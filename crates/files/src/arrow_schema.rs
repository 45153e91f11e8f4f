//! The Arrow schema of a table: what readers of Arrow know about its columns beyond Parquet's types, that is their units.
//!
//! Parquet has no place for a column's own notes. Readers of Arrow (pyarrow, polars, DuckDB) take them from the key
//! [`KEY`] of the footer: a schema message of Arrow's IPC format, which is a FlatBuffer, in base 64.

use crate::flat::Flat;
use crate::schema::{ColumnSpec, Kind};

/// The key in the footer.
pub(crate) const KEY: &str = "ARROW:schema";

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

/// The value of [`KEY`] for a table of `columns`.
pub(crate) fn text(columns: &[ColumnSpec]) -> String {
    let flat = message(columns);
    let mut bytes = CONTINUATION.to_vec();
    bytes.extend((flat.len() as u32).to_le_bytes());
    bytes.extend(flat);
    base64(&bytes)
}

/// The message: its length is a multiple of 8 bytes.
fn message(columns: &[ColumnSpec]) -> Vec<u8> {
    let mut flat = Flat::new();
    // Version, kind of header, header
    let [.., header] = flat.table([Some(METADATA_V5), Some(SCHEMA), Some(0)]);
    flat.point(header);
    // Byte order (little, the default), fields
    let [_, fields] = flat.table([None, Some(0)]);
    flat.point(fields);
    for (column, place) in columns.iter().zip(flat.vector(columns.len())) {
        flat.point(place);
        field(&mut flat, column);
    }
    flat.finish()
}

fn field(flat: &mut Flat, column: &ColumnSpec) {
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
        assert_eq!(text(&columns), GOLDEN);
    }

    #[test]
    fn law_messages_fill_whole_words_of_eight_bytes() {
        for length in 1..20 {
            let columns = [ColumnSpec::new("x".repeat(length), "m", Kind::F64, false)];
            assert_eq!(message(&columns).len() % 8, 0, "{length}");
        }
    }
}
