//! Tables and documents, written, read, damaged and refused.

mod atomic;
mod damage;
mod document;
mod sample;
mod shards;
mod table;
mod toml;
