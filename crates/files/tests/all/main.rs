//! Tables and documents, written, read, damaged and refused.

mod atomic;
mod damage;
mod digest;
mod document;
mod faults;
mod foreign;
mod rows;
mod sample;
mod sets;
mod shard;
mod shards;
mod table;
mod toml;
