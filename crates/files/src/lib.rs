//! Tables (Parquet) and documents (JSON, TOML) that carry their schema, units and provenance.
//!
//! Every file is written as a whole or not at all; a document refuses files beside it that were not written with it. Every file has a seal that detects a single flipped byte, and has the
//! same bytes for the same contents. Every file is checked before its contents are trusted; a fault is
//! reported in one line that names the file, the thing, what was found, what was expected and the remedy.
//!
//! ```
//! use files::{Column, ColumnSpec, Kind, Provenance, Table, TableReader, TableSchema, TableWriter};
//! use files::{commit, encode_block};
//!
//! # fn main() -> files::Result<()> {
//! let folder = tempfile::tempdir().unwrap();
//! let path = folder.path().join("speeds.parquet");
//! let speed = ColumnSpec { name: "u".into(), unit: "m/s".into(), kind: Kind::F64, nullable: false };
//! let schema = TableSchema { id: "speeds", version: 1, columns: vec![speed] };
//! let provenance = Provenance { producer: "example 1.0.0".into(), ..Provenance::default() };
//!
//! let mut writer = TableWriter::create(&path, &schema, &provenance)?;
//! writer.push(encode_block(&schema, &Table { columns: vec![Column::f64(vec![0.1, 0.2])] })?)?;
//! commit(vec![writer.finish()?])?;
//!
//! let reader = TableReader::open(&path, "speeds", 1)?;
//! reader.require(&schema.columns)?;
//! let block = reader.read_block(0, &["u"])?;
//! assert_eq!(block.columns[0].as_f64(), Some(&[0.1, 0.2][..]));
//! # Ok(())
//! # }
//! ```
//!
//! The crate starts no threads, prints nothing and reads neither clock nor environment, except for the
//! available memory and disk space ([`Budget`]). [`encode_block`] and [`TableReader::read_block`] are made to
//! be called from many threads.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod access;
mod budget;
mod columns;
mod decode;
mod document;
mod document_reader;
mod encode;
mod error;
mod footer;
mod foreign;
mod gather;
mod hand_written;
mod json;
mod layout;
mod provenance;
mod rows;
mod scratch;
mod seal;
mod staged;
mod table_reader;
mod table_writer;
mod toml_place;

pub use self::budget::{Budget, PROGRAM_BYTES, Work, budget, free_bytes, mib_with_program, set_budget};
pub use access::{
    DEEPEST, DEVICES, Observed, Trace, check_within, device_in, exists, observe_names, open, place_of, read,
    refuse_device, slashed, trace, traced,
};
pub use columns::{
    Column, ColumnSpec, FloatColumn, IntegerColumn, Kind, Labels, Table, TableSchema, TextColumn,
};
pub use decode::decoding;
pub use document::{
    Document, Loaded, Units, check_members, commit, commit_with_document, json_schema, stage_document,
    stage_set_document, units,
};
pub use document_reader::{Inspected, inspect, read_document, read_json, read_part};
pub use encode::{EncodedBlock, PIECE_ROWS, encode_block};
pub use error::{Error, Result};
pub use foreign::{ForeignTable, Timed};
pub use gather::{check_given, check_settings, check_shards, gather, shards_of};
pub use hand_written::{Change, Changes, parse_toml, read_hand_written, read_to_string, read_toml};
pub use provenance::{MIXED, Provenance, STUDY_ROLES, Shard};
pub use rows::Columns;
pub use scratch::Scratch;
pub use seal::{Digest, Digesting};
pub use staged::{Staged, abandon, fault, is_unfinished, whole_folder};
pub use table_reader::TableReader;
pub use table_writer::TableWriter;
