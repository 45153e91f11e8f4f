//! A small table and a small document for the tests.
#![allow(dead_code)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use files::{
    Column, ColumnSpec, Digest, Document, EncodedBlock, Kind, Provenance, Result, Shard, Staged, Table,
    TableSchema, TableWriter, Units, commit, encode_block,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;
use tempfile::TempDir;

/// Rows per block of [`block`].
pub const ROWS: usize = 50;

pub fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

pub fn spec(name: &str, unit: &str, kind: Kind, nullable: bool) -> ColumnSpec {
    ColumnSpec { name: name.to_owned(), unit: unit.to_owned(), kind, nullable }
}

pub fn schema() -> TableSchema {
    let columns = vec![
        spec("maneuver", "1", Kind::Text, false),
        spec("run", "1", Kind::I32, false),
        spec("u", "m/s", Kind::F64, false),
        spec("tau1", "N", Kind::F64, true),
    ];
    TableSchema { id: "trajectories", version: 2, columns }
}

/// Block `i`: run `i`, two maneuvers, the last row without input.
pub fn block(i: usize) -> Table {
    let speed = |row: usize| ((i * ROWS + row) as f64 * 0.1).sin();
    let labels = vec!["zig-zag, 10 °".to_owned(), "spiral".to_owned()];
    let columns = vec![
        Column::text(labels, (0..ROWS).map(|row| u32::from(row >= ROWS / 2)).collect()),
        Column::i32(vec![i as i32; ROWS]),
        Column::f64((0..ROWS).map(speed).collect()),
        Column::nullable_f64(
            (0..ROWS).map(|row| row as f64).collect(),
            (0..ROWS).map(|row| row + 1 < ROWS).collect(),
        ),
    ];
    Table { columns }
}

pub fn provenance() -> Provenance {
    Provenance {
        producer: "simulate 0.1.0".to_owned(),
        inputs: BTreeMap::from([("vessel".to_owned(), Digest::of_bytes(b"vessel"))]),
        settings: BTreeMap::from([
            ("seed".to_owned(), json!(1)),
            ("note".to_owned(), json!("\"seal\":\"blake3:00")),
        ]),
        shard: None,
        ..Provenance::default()
    }
}

pub fn shard(index: u32, count: u32) -> Provenance {
    Provenance { shard: Some(Shard { index, count }), ..provenance() }
}

pub fn encode(blocks: impl IntoIterator<Item = usize>) -> Vec<EncodedBlock> {
    blocks.into_iter().map(|i| encode_block(&schema(), &block(i)).unwrap()).collect()
}

pub fn stage(path: &Path, provenance: &Provenance, blocks: Vec<EncodedBlock>) -> Result<Staged> {
    let mut writer = TableWriter::create(path, &schema(), provenance)?;
    for block in blocks {
        writer.push(block)?;
    }
    writer.finish()
}

/// Writes the sample blocks `blocks` to `name` in `folder`.
pub fn write(
    folder: &TempDir,
    name: &str,
    provenance: &Provenance,
    blocks: std::ops::Range<usize>,
) -> PathBuf {
    let path = folder.path().join(name);
    commit(vec![stage(&path, provenance, encode(blocks)).unwrap()]).unwrap();
    path
}

/// The single line of a refusal, which must be one.
pub fn refusal<T>(result: Result<T>) -> String {
    match result {
        Err(error @ files::Error::Refused { .. }) => {
            let line = error.to_string();
            assert!(!line.contains('\n'), "{line}");
            line
        }
        Err(other) => panic!("not a refusal: {other}"),
        Ok(_) => panic!("not refused"),
    }
}

/// What lies in `folder`.
pub fn names(folder: &TempDir) -> Vec<String> {
    let entries = std::fs::read_dir(folder.path()).unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Design {
    pub shares: BTreeMap<String, f64>,
    pub gap: f64,
    pub rows: Vec<[f64; 2]>,
    pub starts: Option<u32>,
}

impl Document for Design {
    const ID: &'static str = "design";
    const VERSION: u32 = 2;
    const UNITS: Units = &[("1", "shares gap"), ("m", "rows")];
}

pub fn design() -> Design {
    let shares = BTreeMap::from([("spiral".to_owned(), 0.1 + 0.2), ("zig-zag".to_owned(), 1e-300)]);
    Design { shares, gap: -0.0, rows: vec![[1.0, 2.0 / 3.0], [f64::MAX, 5e-324]], starts: None }
}
