//! Publishing a table of estimates with its document and the files beside it.

use std::path::Path;

use files::{Error, Provenance, Staged, commit, is_member_of, stage_set_document};

use crate::documents::EstimateDocument;

/// Publishes `table`, the files `beside` it that there are, and the `document` that vouches for all of them. Those of an
/// earlier estimate that there are not now are removed. A shard is published alone.
///
/// # Errors
/// Output that fails; what `data` refuses.
pub fn publish(
    table: Staged,
    beside: [(&Path, Option<Staged>); 2],
    document: &Path,
    provenance: &Provenance,
    data: impl FnOnce() -> Result<EstimateDocument, Error>,
) -> Result<(), Error> {
    if provenance.shard.is_some() {
        return commit(vec![table]);
    }
    let mut earlier = Vec::new();
    let mut staged = vec![table];
    for (path, now) in beside {
        if now.is_none() && is_member_of::<EstimateDocument>(document, path) {
            earlier.push(path);
        }
        staged.extend(now);
    }
    staged.push(stage_set_document(document, provenance, &data()?, &staged)?);
    commit(staged)?;
    for path in earlier {
        // What an earlier estimate wrote does not belong to this one.
        let _ = std::fs::remove_file(path);
    }
    Ok(())
}
