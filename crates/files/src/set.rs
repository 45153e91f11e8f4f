//! Files that were written together: a document vouches for the others by their digests.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use refusal::foreign;

use crate::digest::Digest;
use crate::error::{Error, Result};
use crate::identity::Header;
use crate::names::{folder_of, is_inside};
use crate::ordinary::{bytes_of, open_unobserved, read};
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

/// The files that the existing `document` vouches for and that are not among the new `files`.
pub(crate) fn earlier(document: &Path, files: &[Staged]) -> Vec<PathBuf> {
    let is_document = document.extension().is_some_and(|end| end == "json");
    let header = || {
        let file = open_unobserved(document).ok().filter(|_| is_document)?;
        serde_json::from_slice::<Header>(&bytes_of(document, file).ok()?).ok()
    };
    let is_new = |name: &Path| files.iter().any(|new| new.path().file_name() == name.file_name());
    let gone = |(name, digest): (String, Digest)| {
        let name = Some(Path::new(&name)).filter(|name| is_inside(name) && !is_new(name))?;
        let file = folder_of(document).join(name);
        Digest::of_own(&file).is_ok_and(|found| found == digest).then_some(file)
    };
    header().map(Header::members).into_iter().flatten().filter_map(gone).collect()
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
        if known(&member).or_else(|| Digest::of_file(&member).ok()).is_some_and(|found| found != *digest) {
            return Err(mixed(&member, document));
        }
    }
    Ok(())
}

/// Refuses the table at `path`, whose digest is `digest`, if the document of this name beside it was not written
/// with it.
pub(crate) fn check_companion(path: &Path, digest: Digest, companion: Option<&str>) -> Result<()> {
    let inside = companion.filter(|name| is_inside(Path::new(name)));
    let Some(document) = inside.map(|name| folder_of(path).join(name)) else { return Ok(()) };
    let Ok(bytes) = read(&document) else { return Ok(()) };
    let Ok(header) = serde_json::from_slice::<Header>(&bytes) else { return Ok(()) };
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    if header.members().get(&*name) == Some(&digest) { Ok(()) } else { Err(mixed(path, &document)) }
}

fn mixed(file: &Path, document: &Path) -> Error {
    let found = format!("another file than the one written with {}", document.display());
    let remedy = "run the stage that writes both again, or keep them in folders of their own";
    Error::refuse(file, "digest", found, "the files of one run of a stage", remedy)
}
