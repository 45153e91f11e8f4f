//! Tables (Parquet) and documents (JSON, TOML) that carry their schema, units and provenance.
//!
//! Every file is written as a whole or not at all; a document refuses files beside it that were not written with it. Every file has a seal that detects a single flipped byte, and has the
//! same bytes for the same contents. Every file is checked before its contents are trusted; a fault is
//! reported in one line that names the file, the thing, what was found, what was expected and the remedy.
//!
//! ```
//! use crate::{Column, ColumnSpec, Kind, Provenance, Table, TableReader, TableSchema, TableWriter};
//! use crate::{commit, encode_block};
//!
//! # fn main() -> crate::Result<()> {
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

mod agreement;
mod arrow_schema;
mod budget;
mod changes;
mod chunk;
mod columns;
mod commit;
mod complaint;
mod decode;
mod digest;
mod document;
mod document_reader;
mod encode;
mod error;
mod finite;
mod flat;
mod footer;
mod foreign;
mod gather;
mod identity;
mod inspect;
mod layout;
mod meaning;
mod metadata;
mod names;
mod ordinary;
mod page_bytes;
mod pretty;
mod provenance;
mod rows;
mod schema;
mod scratch;
mod seal;
mod set;
mod shard;
mod source;
mod staged;
mod table_reader;
mod table_writer;
mod thrift;
mod toml_input;
mod toml_place;
mod trace;
mod unfinished;
mod weight;

pub use self::budget::{Budget, PROGRAM_BYTES, Work, budget, free_bytes, mib_with_program, set_budget};
pub use self::commit::{commit, commit_with_document};
pub use changes::{Change, Changes};
pub use columns::{Column, FloatColumn, IntegerColumn, Labels, Table, TextColumn};
pub use decode::decoding;
pub use digest::{Digest, Digesting};
pub use document::{Document, Loaded, Units, json_schema, stage_document, stage_set_document, units};
pub use document_reader::{read_document, read_json, read_part};
pub use encode::{EncodedBlock, encode_block};
pub use error::{Error, Result};
pub use foreign::ForeignTable;
pub use gather::{check_given, check_settings, check_shards, gather, shards_of};
pub use inspect::{Inspected, inspect};
pub use meaning::Timed;
pub use ordinary::{exists, open, read};
pub use provenance::{MIXED, Provenance, STUDY_ROLES};
pub use rows::Columns;
pub use schema::{ColumnSpec, Kind, TableSchema};
pub use scratch::Scratch;
pub use set::check_members;
pub use shard::Shard;
pub use staged::{Staged, fault, whole_folder};
pub use table_reader::TableReader;
pub use table_writer::{PIECE_ROWS, TableWriter};
pub use toml_input::{parse_toml, read_hand_written, read_to_string, read_toml};
pub use trace::{DEEPEST, Observed, Trace, check_within, observe_names, place_of, trace, traced};
pub use unfinished::{abandon, is_unfinished};
