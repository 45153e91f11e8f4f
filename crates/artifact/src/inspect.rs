//! What a file says about itself, whatever its kind.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;

use serde_json::Value;

use crate::digest::Digest;
use crate::document::Envelope;
use crate::document_reader::{check_seal, refusal};
use crate::error::{Error, Result};
use crate::footer::Footer;
use crate::identity::Header;
use crate::leftover::recover;
use crate::metadata::TableMetadata;
use crate::names::folder_of;
use crate::provenance::Provenance;
use crate::seal;
use crate::set::{check_companion, check_members};
use crate::table_reader::parse;
use crate::toml_input::text_of;

/// A file that was written as a document or table.
#[derive(Clone, Debug)]
pub struct Inspected {
    /// Kind and version, like `design/1`.
    pub schema: String,
    /// Digest of the file.
    pub digest: Digest,
    /// Whether it has a seal; one that has fits it.
    pub sealed: bool,
    /// Where its contents come from.
    pub provenance: Provenance,
    /// Digests of the files that were written together with it, by their names beside it.
    pub members: BTreeMap<String, Digest>,
}

/// Looks at the file at `path`; none where it is neither document nor table.
///
/// # Errors
/// [`Error::Io`] if it cannot be read; [`Error::Refused`] if it does not fit its seal or what was written together with it.
pub fn inspect(path: &Path) -> Result<Option<Inspected>> {
    recover(folder_of(path));
    match path.extension().and_then(|end| end.to_str()) {
        Some("json") => document(path),
        Some("parquet") => table(path).map(Some),
        _ => Ok(None),
    }
}

fn document(path: &Path) -> Result<Option<Inspected>> {
    let bytes = std::fs::read(path).map_err(|e| Error::io(path, "read", e))?;
    let text = text_of(path, bytes)?;
    let header: Header = serde_json::from_str(&text).map_err(|e| refusal(path, &text, &e))?;
    let Some(schema) = header.schema().map(str::to_owned) else { return Ok(None) };
    let digests = check_seal(path, &text, header.seal())?;
    let envelope: Envelope<Value> = serde_json::from_str(&text).map_err(|e| refusal(path, &text, &e))?;
    check_members(path, envelope.members())?;
    let loaded = envelope.loaded(digests.digest);
    let (sealed, provenance, members) = (header.seal().is_some(), loaded.provenance, loaded.members);
    Ok(Some(Inspected { schema, digest: digests.digest, sealed, provenance, members }))
}

fn table(path: &Path) -> Result<Inspected> {
    let unreadable = |e| Error::io(path, "read", e);
    let mut file = File::open(path).map_err(unreadable)?;
    let footer = Footer::read(path, &mut file)?;
    let envelope = footer.envelope(path)?;
    let header: Header = parse(path, envelope)?;
    let digits_at = header.seal().map(|seal| footer.seal_digits_at(path, seal)).transpose()?.flatten();
    let digests = seal::digests(&mut file, digits_at).map_err(unreadable)?;
    seal::check(path, header.seal(), digests)?;
    let metadata: TableMetadata = parse(path, envelope)?;
    check_companion(path, digests.digest, metadata.document.as_deref())?;
    Ok(Inspected {
        schema: header.schema().unwrap_or_default().to_owned(),
        digest: digests.digest,
        sealed: header.seal().is_some(),
        provenance: metadata.into_parts().1,
        members: BTreeMap::new(),
    })
}
