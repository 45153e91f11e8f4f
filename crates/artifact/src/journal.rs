//! The list of renames that make a set: once it stands in the folder, the set will be complete, whoever completes it.

use std::fs;
use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::names::{UNFINISHED, folder_of};

/// What follows [`UNFINISHED`] in the name of a journal.
const MARK: &str = "set-";

/// Renames within a folder: paths relative to it.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Journal(Vec<[PathBuf; 2]>);

/// Whether `name` is that of a journal.
pub(crate) fn is_one(name: &str) -> bool {
    name.strip_prefix(UNFINISHED).is_some_and(|rest| rest.starts_with(MARK))
}

impl Journal {
    /// Those of `renames`, each within a folder, that stay below `folder`; in their order.
    pub fn of<'a>(renames: impl Iterator<Item = [&'a Path; 2]>, folder: &Path) -> Self {
        let below = |[from, to]: [&Path; 2]| {
            let to = to.strip_prefix(folder).unwrap_or(to);
            inside(to).then(|| Some([to.with_file_name(from.file_name()?), to.to_owned()]))?
        };
        Self(renames.filter_map(below).collect())
    }

    /// The journal of the set whose main file is `main`.
    pub fn path(main: &Path) -> PathBuf {
        let name = main.file_name().unwrap_or_default().to_string_lossy();
        folder_of(main).join(format!("{UNFINISHED}{MARK}{name}"))
    }

    /// As it stands in its file.
    pub fn text(&self) -> Vec<u8> {
        serde_json::to_vec(self).unwrap_or_default()
    }

    /// What stands in a file; none of what could not have been written here.
    pub fn read(path: &Path) -> Option<Self> {
        let journal: Self = serde_json::from_slice(&fs::read(path).ok()?).ok()?;
        let unfinished = |path: &PathBuf| {
            path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(UNFINISHED))
        };
        let ours = |[from, to]: &[PathBuf; 2]| {
            (unfinished(from) || unfinished(to)) && inside(from) && inside(to) && from.parent() == to.parent()
        };
        journal.0.iter().all(ours).then_some(journal)
    }

    /// Renames whatever has not been renamed yet.
    pub fn rename_all(&self, folder: &Path) {
        for [from, to] in &self.0 {
            let _ = fs::rename(folder.join(from), folder.join(to));
        }
    }
}

/// Whether a relative path stays below where it starts.
fn inside(path: &Path) -> bool {
    path.components().all(|part| matches!(part, Component::Normal(_)))
}
