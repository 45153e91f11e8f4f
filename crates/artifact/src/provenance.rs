//! Where a file's contents come from.

use std::collections::BTreeMap;

use crate::digest::Digest;
use crate::shard::Shard;

/// What produced a file, from what. Holds no clock, host, user, path or thread count, so that the
/// same computation gives the same bytes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    /// Program and version, like `simulate 0.1.0`.
    pub producer: String,
    /// Digest of each input file, by its role (`vessel`, `dictionary`).
    pub inputs: BTreeMap<String, Digest>,
    /// Settings that determine the contents (`seed`, `runs`), by name.
    pub settings: BTreeMap<String, serde_json::Value>,
    /// Which part of the whole this is, if it is a part.
    pub shard: Option<Shard>,
}
