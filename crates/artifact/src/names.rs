//! Names and folders of files.

use std::path::{Component, Path};

/// The prefix of unfinished files.
pub(crate) const UNFINISHED: &str = ".unfinished-";

/// Whether `path` is that of an unfinished file.
pub fn is_unfinished(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(UNFINISHED))
}

/// Names of the unfinished files in `folder`.
pub(crate) fn unfinished_in(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    names.filter(|name| name.starts_with(UNFINISHED)).collect()
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
