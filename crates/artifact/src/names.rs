//! What files are called and where they stand.

use std::path::Path;

/// How the names of files begin that no stage has finished.
pub(crate) const UNFINISHED: &str = ".unfinished-";

/// The folder that `file` stands in.
pub(crate) fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}
