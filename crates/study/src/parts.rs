//! Documents made in shards.

use std::path::{Path, PathBuf};

use files::{Document, Error, Loaded, Provenance, check_given, check_shards, read_part};

use crate::documents::MomentsDocument;

/// The documents of all `shards`, in the order of their numbers.
///
/// # Errors
/// Files that are not all the shards of one document.
pub(crate) fn all<D: Document>(shards: &[PathBuf]) -> Result<Vec<(&Path, Loaded<D>)>, Error> {
    let read = |path| Ok::<_, Error>((path, read_part::<D>(path)?));
    let mut all: Vec<(&Path, Loaded<D>)> =
        shards.iter().map(PathBuf::as_path).map(read).collect::<Result<_, _>>()?;
    check_shards(all.iter().map(|(path, loaded)| (*path, &loaded.provenance)))?;
    all.sort_by_key(|(_, loaded)| loaded.provenance.shard);
    Ok(all)
}

/// The moments of all `shards` together. `given`: their expected inputs.
///
/// # Errors
/// Files that are not all shards of one document; shards of other inputs.
pub fn moments(shards: &[PathBuf], mut given: Provenance) -> Result<(Provenance, MomentsDocument), Error> {
    let mut all = all::<MomentsDocument>(shards)?.into_iter();
    let Some((path, first)) = all.next() else { unreachable!("there is a shard to gather") };
    check_given(&mut given, path, &first.provenance)?;
    let Loaded { data: mut whole, mut provenance, .. } = first;
    provenance.accept_label(&given);
    all.for_each(|(_, loaded)| whole.0.maneuvers.extend(loaded.data.0.maneuvers));
    Ok((Provenance { shard: None, ..provenance }, whole))
}
