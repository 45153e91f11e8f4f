//! Files as from other programs, other versions and damage.

use std::fs::{self, File};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use files::{
    Column, ColumnSpec, Digest, Kind, Provenance, Table, TableReader, TableSchema, TableWriter, commit,
    encode_block,
};
use parquet::basic::{Repetition, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use serde_json::{Value, json};

/// A whole table.
pub struct Whole {
    pub schema: TableSchema,
    pub blocks: Vec<Table>,
    pub provenance: Provenance,
}

/// Reads a whole table of kind `id`, version 1.
pub fn read(path: &Path, id: &'static str) -> Whole {
    let reader = TableReader::open(path, id, 1).unwrap();
    let columns = reader.columns().to_vec();
    let names: Vec<&str> = columns.iter().map(|c| c.name.as_str()).collect();
    let blocks = (0..reader.blocks()).map(|i| reader.read_block(i, &names).unwrap()).collect();
    let provenance = reader.provenance().clone();
    Whole { schema: TableSchema { id, version: 1, columns }, blocks, provenance }
}

impl Whole {
    /// Writes the table, sealed.
    pub fn write(&self, path: &Path) {
        let mut writer = TableWriter::create(path, &self.schema, &self.provenance).unwrap();
        for block in &self.blocks {
            writer.push(encode_block(&self.schema, block).unwrap()).unwrap();
        }
        commit(vec![writer.finish().unwrap()]).unwrap();
    }

    /// The specification of a column.
    pub fn column(&mut self, name: &str) -> &mut ColumnSpec {
        self.schema.columns.iter_mut().find(|c| c.name == name).unwrap()
    }

    /// The same table without the named columns.
    pub fn without(mut self, names: &[&str]) -> Self {
        let kept: Vec<bool> = self.schema.columns.iter().map(|c| !names.contains(&c.name.as_str())).collect();
        let mut keep = kept.iter();
        self.schema.columns.retain(|_| *keep.next().unwrap());
        for block in &mut self.blocks {
            let mut keep = kept.iter();
            block.columns.retain(|_| *keep.next().unwrap());
        }
        self
    }

    /// The same table in blocks of `rows` rows.
    pub fn in_blocks_of(mut self, rows: usize) -> Self {
        let parts = |block: &Table| {
            let length = block.columns.first().map_or(0, Column::len);
            let starts = (0..length).step_by(rows);
            let part = |start: usize| {
                let range = start..length.min(start + rows);
                Table { columns: block.columns.iter().map(|column| slice(column, range.clone())).collect() }
            };
            starts.map(part).collect::<Vec<_>>()
        };
        self.blocks = self.blocks.iter().flat_map(parts).collect();
        self
    }

    /// Writes the table unsealed with the parquet crate alone, value `row` of column `name` replaced by `value`.
    pub fn write_foreign(&self, path: &Path, name: &str, row: usize, value: f64) {
        let entry = |c: &ColumnSpec| json!({"name": c.name, "unit": c.unit, "kind": c.kind});
        let columns: Vec<Value> = self.schema.columns.iter().map(entry).collect();
        let envelope = json!({
            "schema": format!("{}/{}", self.schema.id, self.schema.version), "producer": "another program",
            "seal": null, "inputs": {}, "settings": {}, "columns": columns, "shard": self.provenance.shard,
        });
        let keys = vec![KeyValue::new("seatrial".to_owned(), envelope.to_string())];
        let properties = WriterProperties::builder().set_key_value_metadata(Some(keys)).build();
        let fields = self.schema.columns.iter().map(|c| Arc::new(parquet_type(c))).collect();
        let root = Type::group_type_builder("schema").with_fields(fields).build().unwrap();
        let file = File::create(path).unwrap();
        let mut writer = SerializedFileWriter::new(file, Arc::new(root), Arc::new(properties)).unwrap();
        for block in &self.blocks {
            let mut group = writer.next_row_group().unwrap();
            for (spec, column) in self.schema.columns.iter().zip(&block.columns) {
                let replaced = (spec.name == name).then_some((row, value));
                let mut out = group.next_column().unwrap().unwrap();
                write_column(out.untyped(), spec, column, replaced);
                out.close().unwrap();
            }
            group.close().unwrap();
        }
        writer.close().unwrap();
    }
}

fn slice(column: &Column, rows: Range<usize>) -> Column {
    match column {
        Column::F64(_) => {
            let present = rows.clone().map(|row| !column.is_null(row)).collect();
            Column::nullable_f64(column.as_f64().unwrap()[rows].to_vec(), present)
        }
        Column::I32(_) => Column::i32(column.as_i32().unwrap()[rows].to_vec()),
        Column::Text(_) => {
            let (labels, codes) = column.text_codes().unwrap();
            Column::text(labels.to_vec(), codes[rows].to_vec())
        }
    }
}

fn parquet_type(column: &ColumnSpec) -> Type {
    let physical = match column.kind {
        Kind::F64 => Physical::DOUBLE,
        Kind::I32 => Physical::INT32,
        Kind::Text => Physical::BYTE_ARRAY,
    };
    let repetition = if column.nullable { Repetition::OPTIONAL } else { Repetition::REQUIRED };
    Type::primitive_type_builder(&column.name, physical).with_repetition(repetition).build().unwrap()
}

fn write_column(out: &mut ColumnWriter, spec: &ColumnSpec, column: &Column, replaced: Option<(usize, f64)>) {
    match out {
        ColumnWriter::DoubleColumnWriter(out) => {
            let mut values = column.as_f64().unwrap().to_vec();
            if let Some((row, value)) = replaced {
                values[row] = value;
            }
            let levels: Vec<i16> = (0..values.len()).map(|r| i16::from(!column.is_null(r))).collect();
            let present = values.iter().zip(&levels).filter(|(_, level)| **level == 1);
            let present: Vec<f64> = present.map(|(value, _)| *value).collect();
            out.write_batch(&present, spec.nullable.then_some(levels.as_slice()), None).unwrap();
        }
        ColumnWriter::Int32ColumnWriter(out) => {
            out.write_batch(column.as_i32().unwrap(), None, None).unwrap();
        }
        ColumnWriter::ByteArrayColumnWriter(out) => {
            let text = |row| ByteArray::from(column.text_at(row).unwrap());
            let texts: Vec<ByteArray> = (0..column.len()).map(text).collect();
            out.write_batch(&texts, None, None).unwrap();
        }
        _ => panic!("column `{}` is of a type that no table has", spec.name),
    }
}

/// Replaces `from` by `to`, equally long, in the bytes of a sealed file, and seals it again.
pub fn patch(path: &Path, from: &str, to: &str) {
    assert_eq!(from.len(), to.len());
    let mut bytes = fs::read(path).unwrap();
    let at = find(&bytes, from);
    bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
    let digits = find(&bytes, "blake3:") + "blake3:".len();
    bytes[digits..digits + 64].fill(b'0');
    let seal = Digest::of_bytes(&bytes).hex();
    bytes[digits..digits + 64].copy_from_slice(seal.as_bytes());
    fs::write(path, bytes).unwrap();
}

/// Replaces `from` by `to` in the text of a document, and takes its seal away.
pub fn unsealed(path: &Path, from: &str, to: &str) {
    let text = fs::read_to_string(path).unwrap();
    let at = text.find("\"seal\": ").unwrap() + "\"seal\": ".len();
    let text = text[..at].to_owned() + "null" + &text[at + text[at..].find(',').unwrap()..];
    assert!(text.contains(from), "no `{from}` in the file");
    fs::write(path, text.replacen(from, to, 1)).unwrap();
}

fn find(bytes: &[u8], text: &str) -> usize {
    let found = bytes.windows(text.len()).position(|window| window == text.as_bytes());
    found.unwrap_or_else(|| panic!("no `{text}` in the file"))
}
