//! Tallies of shards, merged.

use std::path::{Path, PathBuf};

use artifact::{Error, Loaded, Provenance, check_shards, read_document};

use crate::documents::TallyDocument;

/// The tally that all `shards` make together, whatever their order.
///
/// # Errors
/// Files that are not all shards of one tally.
pub fn merged(shards: &[PathBuf]) -> Result<(Provenance, TallyDocument), Error> {
    let read = |path| Ok::<_, Error>((Path::new(path), read_document::<TallyDocument>(path)?));
    let mut all: Vec<(&Path, Loaded<TallyDocument>)> = shards.iter().map(read).collect::<Result<_, _>>()?;
    check_shards(all.iter().map(|(path, loaded)| (*path, &loaded.provenance)))?;
    all.sort_by_key(|(_, loaded)| loaded.provenance.shard);
    let mut all = all.into_iter();
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
