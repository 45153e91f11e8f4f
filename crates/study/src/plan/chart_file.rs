//! Reads files of charts, and notes their digests.

use std::path::Path;

use files::{Digest, Error, Provenance};

/// Reads a chart's file, and notes its digest.
pub(super) fn bytes(path: &Path, provenance: &mut Provenance) -> Result<Vec<u8>, Error> {
    let bytes = files::read(path)?;
    note(path, Digest::of_bytes(&bytes), provenance);
    Ok(bytes)
}

/// Notes the digest of a chart's file by its name; with a number if another chart's file has the same name.
pub(super) fn note(path: &Path, digest: Digest, provenance: &mut Provenance) {
    let name = path.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
    let roles = (1..).map(|k| if k == 1 { format!("chart:{name}") } else { format!("chart:{name} ({k})") });
    for role in roles {
        let known = provenance.inputs.get(&role);
        if known.is_none_or(|known| *known == digest) {
            provenance.inputs.insert(role, digest);
            return;
        }
    }
}
