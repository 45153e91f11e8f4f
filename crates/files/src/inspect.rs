//! A file's description of itself, for any kind.

use std::collections::BTreeMap;
use std::path::Path;

use serde::de::IgnoredAny;

use crate::digest::Digest;
use crate::document::Envelope;
use crate::document_reader::{opened, refusal};
use crate::error::Result;
use crate::provenance::Provenance;
use crate::seal;
use crate::table_reader::Whole;

/// A file that was written as a document or table.
#[derive(Clone, Debug)]
pub struct Inspected {
    /// Kind and version, like `design/1`.
    pub schema: String,
    /// Digest of the file.
    pub digest: Digest,
    /// Whether it has a seal, which then matches.
    pub sealed: bool,
    /// The origin of its contents.
    pub provenance: Provenance,
    /// Digests of the files that were written together with it, by their names beside it.
    pub members: BTreeMap<String, Digest>,
}

/// Inspects the file at `path`; `None` if it is neither document nor table. [`crate::check_members`] checks
/// the files that were written with a document.
///
/// # Errors
/// [`Error::Io`] if it cannot be read; [`Error::Refused`] if it does not match its seal, or a table its
/// document.
pub fn inspect(path: &Path) -> Result<Option<Inspected>> {
    match path.extension().and_then(|end| end.to_str()) {
        Some("json") => document(path),
        Some("parquet") => table(path).map(Some),
        _ => Ok(None),
    }
}

fn document(path: &Path) -> Result<Option<Inspected>> {
    let (text, header) = opened(path)?;
    let Some(schema) = header.schema().map(str::to_owned) else { return Ok(None) };
    let digests = seal::check_text(path, &text, header.seal())?;
    let envelope: Envelope<IgnoredAny> = serde_json::from_str(&text).map_err(|e| refusal(path, &text, &e))?;
    let loaded = envelope.loaded(digests.digest);
    let (sealed, provenance, members) = (header.seal().is_some(), loaded.provenance, loaded.members);
    Ok(Some(Inspected { schema, digest: loaded.digest, sealed, provenance, members }))
}

fn table(path: &Path) -> Result<Inspected> {
    let Whole { header, envelope, digest, .. } = Whole::open(path, None)?;
    Ok(Inspected {
        schema: header.schema().unwrap_or_default().to_owned(),
        digest,
        sealed: header.seal().is_some(),
        provenance: envelope.into_parts().1,
        members: BTreeMap::new(),
    })
}
