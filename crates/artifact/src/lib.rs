//! Tables (Parquet) and documents (JSON, TOML) that carry their schema, units and provenance.
//!
//! Every file written here is written whole or not at all, holds a seal that shows a single
//! flipped byte, and has the same bytes for the same contents. Every file read here is checked
//! before its contents are trusted; what is wrong is told in one line that names the file, the
//! thing, what was found, what was expected and the remedy.
//!
//! The crate starts no threads, prints nothing and reads neither clock nor environment.
//! [`encode_block`] and [`TableReader::read_block`] are made to be called from many threads.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod agreement;
mod columns;
mod decode;
mod digest;
mod document;
mod document_reader;
mod encode;
mod error;
mod finite;
mod footer;
mod gather;
mod identity;
mod layout;
mod metadata;
mod nearest;
mod pretty;
mod provenance;
mod schema;
mod seal;
mod shard;
mod source;
mod staged;
mod table_reader;
mod table_writer;
mod toml_input;

pub use columns::{Column, FloatColumn, IntegerColumn, TextColumn};
pub use digest::Digest;
pub use document::{Document, Loaded, json_schema, stage_document};
pub use document_reader::read_document;
pub use encode::{EncodedBlock, encode_block};
pub use error::{Error, Refusal, Result};
pub use gather::gather;
pub use provenance::Provenance;
pub use schema::{ColumnSpec, Kind, Table, TableSchema};
pub use shard::Shard;
pub use staged::{Staged, commit};
pub use table_reader::TableReader;
pub use table_writer::TableWriter;
pub use toml_input::{parse_toml, read_toml};
