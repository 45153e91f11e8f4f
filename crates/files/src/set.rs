//! Files that were written together: a document vouches for the others by their digests.

use std::collections::BTreeMap;
use std::path::Path;

use refusal::foreign;

use crate::digest::Digest;
use crate::error::{Error, Result};
use crate::identity::Header;
use crate::leftover::read_written;
use crate::names::{folder_of, is_inside};
use crate::staged::Staged;

/// Digests of `files` by their names beside `document`.
pub(crate) fn members(document: &Path, files: &[Staged]) -> Result<BTreeMap<String, Digest>> {
    let folder = folder_of(document);
    let member = |file: &Staged| {
        let name = file.path().strip_prefix(folder).unwrap_or(file.path());
        Ok((name.to_string_lossy().into_owned(), file.digest()?))
    };
    files.iter().map(member).collect()
}

/// Refuses a document if the files beside it are not those written with it. A missing file is accepted.
/// `known` are digests of files that need not be read again.
///
/// # Errors
/// Names the first differing file, or one in another folder.
pub fn check_members(
    document: &Path,
    members: &BTreeMap<String, Digest>,
    known: impl Fn(&Path) -> Option<Digest>,
) -> Result<()> {
    for (name, digest) in members {
        if !is_inside(Path::new(name)) {
            let (found, expected) = (format!("`{}`", foreign(name)), "files beside the document");
            let remedy = "write the document again: it names files of other folders";
            return Err(Error::refuse(document, "members", found, expected, remedy));
        }
        let member = folder_of(document).join(name);
        if known(&member).or_else(|| Digest::of_written(&member).ok()).is_some_and(|found| found != *digest) {
            return Err(mixed(&member, document));
        }
    }
    Ok(())
}

/// Refuses the table at `path`, whose digest is `digest`, if the document of this name beside it was written
/// with another one.
pub(crate) fn check_companion(path: &Path, digest: Digest, companion: Option<&str>) -> Result<()> {
    let inside = companion.filter(|name| is_inside(Path::new(name)));
    let Some(document) = inside.map(|name| folder_of(path).join(name)) else { return Ok(()) };
    let Ok(bytes) = read_written(&document) else { return Ok(()) };
    let header: Option<Header> = serde_json::from_slice(&bytes).ok();
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
