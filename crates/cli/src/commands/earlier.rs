//! Files that stages only sometimes write next to their main file.

use std::path::Path;

use artifact::{Document, read_document};

/// Whether `member` was written with the existing `document`, and so does not belong to a new one.
pub fn is_of<D: Document>(document: &Path, member: &Path) -> bool {
    let Some(name) = member.file_name().and_then(|name| name.to_str()) else { return false };
    read_document::<D>(document).is_ok_and(|old| old.members.contains_key(name))
}
