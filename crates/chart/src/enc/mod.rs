//! Electronic navigational charts: a cell of IHO S-57 (edition 3.1) and its updates, from bytes to features.
//!
//! A cell is a file of ISO 8211 records (`US4MD81M.000`). Its vector records are nodes and edges, its feature
//! records are objects of a class (`DEPARE`, `WRECKS`) that point to them. Updates (`.001`, `.002`, …)
//! insert, delete and modify records, in order. Only cells of the ENC product are read: binary, chain-node
//! topology, WGS84, metres.
//!
//! Longitude comes before latitude, in degrees of WGS84; depths are positive down \[m\], below the sounding datum.
//!
//! ```no_run
//! let [base, first] = [Vec::new(), Vec::new()];
//! let mut cell = crate::enc::Cell::read(&base)?;
//! cell.update(&first)?;
//! let wrecks = cell.features()?.into_iter().filter(|f| f.class == crate::enc::class("WRECKS").unwrap_or(0));
//! # Ok::<(), crate::enc::Invalid>(())
//! ```

pub mod attribute;
mod catalogue;
mod cell;
mod cursor;
mod dataset;
mod datum;
mod exchange;
mod feature;
mod iso8211;
mod layout;
mod record;
mod rings;
mod topology;
mod update;

pub use catalogue::{class, class_name};
pub use cell::{Cell, identify};
pub use dataset::{Identity, Purpose};
pub use datum::{Datums, vertical_datum};
pub use exchange::{Listed, crc, listed};
pub use feature::{Feature, Geometry, Polygon};
pub use refusal::Invalid;
