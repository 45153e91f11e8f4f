//! Names and folders of files.

use std::path::{Component, Path, PathBuf};

/// The prefix of unfinished files.
pub(crate) const UNFINISHED: &str = ".unfinished-";
/// Their suffix. Between the two stand [`RANDOM`] random characters: files of a user have no such names by chance.
pub(crate) const OWN: &str = ".seatrial";
const RANDOM: usize = 6;
/// Marks before the random characters: of the list of a set's renames, of a replaced file.
pub(crate) const SET: &str = "set-";
pub(crate) const OLD: &str = "old-";

/// Whether `path` looks like that of an unfinished file.
pub fn is_unfinished(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(UNFINISHED))
}

/// Whether `name` is one that this program gives: only such files are renamed or removed.
pub(crate) fn is_own(name: &str) -> bool {
    let inner = name.strip_prefix(UNFINISHED).and_then(|rest| rest.strip_suffix(OWN));
    let random =
        |inner: &str| inner.len() == RANDOM && inner.bytes().all(|byte| byte.is_ascii_alphanumeric());
    inner.is_some_and(|inner| {
        [SET, OLD].iter().find_map(|mark| inner.strip_prefix(mark)).map_or_else(|| random(inner), random)
    })
}

/// The name with `mark` that belongs to the unfinished file `temporary`.
pub(crate) fn marked(temporary: &Path, mark: &str) -> PathBuf {
    let name = temporary.file_name().unwrap_or_default().to_string_lossy();
    temporary.with_file_name(name.replacen(UNFINISHED, &format!("{UNFINISHED}{mark}"), 1))
}

/// Names of the unfinished files in `folder` that this program gave.
pub(crate) fn unfinished_in(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    names.filter(|name| is_own(name)).collect()
}

/// The folder of `file`.
pub(crate) fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Whether a relative path stays below its start.
pub(crate) fn is_inside(path: &Path) -> bool {
    path.components().all(|part| matches!(part, Component::Normal(_)))
}
