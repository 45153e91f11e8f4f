//! Tallies of shards, merged.

use std::path::PathBuf;

use files::{Error, Loaded, Provenance};

use crate::documents::TallyDocument;

/// The usual name of the tally.
pub const MAIN: &str = "tally.json";

/// The merged tally of all `shards`, in any order.
///
/// # Errors
/// Files that are not all shards of one tally.
pub fn merged(shards: &[PathBuf]) -> Result<(Provenance, TallyDocument), Error> {
    let mut all = crate::parts::all::<TallyDocument>(shards)?.into_iter();
    let Some((_, first)) = all.next() else { unreachable!("there is a shard to gather") };
    let Loaded { data: mut merged, provenance, .. } = first;
    for (path, loaded) in all {
        if !merged.tally.merge(loaded.data.tally) {
            let (expected, remedy) = ("those of the other shards", "write the shards again");
            return Err(crate::refuse(path, "`tally`", "other designs or estimators", expected, remedy));
        }
    }
    let TallyDocument { tally, bounds, realizations, samples, validation_samples, seed, .. } = merged;
    let samples = [samples, validation_samples];
    let provenance = Provenance { shard: None, ..provenance };
    Ok((provenance, TallyDocument::new(tally, bounds, realizations, samples, seed)))
}
