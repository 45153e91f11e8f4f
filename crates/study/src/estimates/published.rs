//! Publishing a table of estimates with its document and the files beside it.

use std::path::Path;

use files::{Error, Provenance, Staged, commit, stage_set_document};

use crate::documents::EstimateDocument;

/// Publishes `table`, the files `beside` it that there are, and the `document` that vouches for all of them. A shard is
/// published alone.
///
/// # Errors
/// Output that fails; what `data` refuses.
pub fn publish(
    table: Staged,
    beside: [Option<Staged>; 2],
    document: &Path,
    provenance: &Provenance,
    data: impl FnOnce() -> Result<EstimateDocument, Error>,
) -> Result<(), Error> {
    if provenance.shard.is_some() {
        return commit(vec![table]);
    }
    let mut staged = vec![table];
    staged.extend(beside.into_iter().flatten());
    staged.push(stage_set_document(document, provenance, &data()?, &staged)?);
    commit(staged)
}
