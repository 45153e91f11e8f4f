//! Files that were written together: a document vouches for the others by their digests.

use std::collections::BTreeMap;
use std::path::Path;

use crate::digest::Digest;
use crate::error::{Error, Result};
use crate::identity::Header;
use crate::names::folder_of;
use crate::staged::Staged;

/// Digests of `files` by their names beside `document`.
pub(crate) fn members(document: &Path, files: &[Staged]) -> Result<BTreeMap<String, Digest>> {
    let folder = folder_of(document);
    let member = |file: &Staged| {
        let name = file.path().strip_prefix(folder).unwrap_or(file.path());
        let digest = Digest::of_file(file.temporary())?;
        Ok((name.to_string_lossy().into_owned(), digest))
    };
    files.iter().map(member).collect()
}

/// Refuses a document beside which stand other files than those written with it. One that is not there is no mixture.
/// `known` are the digests of files that need not be read for that.
///
/// # Errors
/// Names the first that is another.
pub fn check_members(
    document: &Path,
    members: &BTreeMap<String, Digest>,
    known: impl Fn(&Path) -> Option<Digest>,
) -> Result<()> {
    for (name, digest) in members {
        let member = folder_of(document).join(name);
        let found = || known(&member).map_or_else(|| Digest::of_file(&member), Ok);
        if member.is_file() && found().is_ok_and(|found| found != *digest) {
            return Err(mixed(&member, document));
        }
    }
    Ok(())
}

/// Refuses the table at `path`, whose digest is `digest`, if the document that names itself its companion was written with
/// another one.
pub(crate) fn check_companion(path: &Path, digest: Digest, companion: Option<&str>) -> Result<()> {
    let Some(document) = companion.map(|name| folder_of(path).join(name)) else { return Ok(()) };
    let Ok(text) = std::fs::read_to_string(&document) else { return Ok(()) };
    let header: Option<Header> = serde_json::from_str(&text).ok();
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    match header.and_then(|header| header.member(&name)) {
        Some(expected) if expected != digest => Err(mixed(path, &document)),
        _ => Ok(()),
    }
}

fn mixed(file: &Path, document: &Path) -> Error {
    let found = format!("another file than the one written with {}", document.display());
    let remedy = "run the stage that writes both again, or keep them in folders of their own";
    Error::refuse(file, "digest", found, "the files of one run of a stage", remedy)
}
