//! The names of files in a record, wherever a study and its results lie.

use std::path::{Path, PathBuf, absolute};

use files::Observed;

/// The folders of a study and of its results, by which a record names files.
#[derive(Debug)]
pub struct Folders {
    /// The hand-written files.
    pub study: PathBuf,
    /// The results.
    pub out: PathBuf,
}

/// The names of these folders in a record.
const OUT: &str = "{out}";
const STUDY: &str = "{study}";

impl Folders {
    /// How a record names `path`: relative to these folders where it is below them.
    pub(crate) fn key(&self, path: &Path) -> String {
        let whole = absolute(path).unwrap_or_else(|_| path.to_owned());
        for (name, folder) in [(OUT, &self.out), (STUDY, &self.study)] {
            for base in [absolute(folder).ok(), folder.canonicalize().ok()].into_iter().flatten() {
                if let Ok(rest) = whole.strip_prefix(base) {
                    return Path::new(name).join(rest).to_string_lossy().trim_end_matches('/').to_owned();
                }
            }
        }
        // Folders above are where they are from the study.
        let study = self.study.canonicalize().unwrap_or_default();
        match study.strip_prefix(&whole) {
            Ok(below) => STUDY.to_owned() + &"/..".repeat(below.components().count()),
            Err(_) => whole.to_string_lossy().into_owned(),
        }
    }

    /// The path that a record names `key`.
    fn path(&self, key: &str) -> PathBuf {
        let below = |(name, folder): (&str, &PathBuf)| {
            let rest = key.strip_prefix(name)?;
            Some(if rest.is_empty() { folder.clone() } else { folder.join(rest.strip_prefix('/')?) })
        };
        let folders = [(OUT, &self.out), (STUDY, &self.study)];
        folders.into_iter().find_map(below).unwrap_or_else(|| key.into())
    }

    /// How a record names an observation.
    pub(crate) fn noted(&self, what: &Observed) -> String {
        let path = self.key(what.path());
        match what {
            Observed::File(_) => path,
            Observed::Names(_, pattern) => format!("names {pattern} in {path}"),
            Observed::Place(_) => format!("place of {path}"),
        }
    }

    /// The observation that a record names `key`.
    pub(crate) fn observed(&self, key: &str) -> Observed {
        let names = key.strip_prefix("names ").and_then(|rest| rest.split_once(" in "));
        match (names, key.strip_prefix("place of ")) {
            (Some((pattern, folder)), _) => Observed::Names(self.path(folder), pattern.to_owned()),
            (_, Some(folder)) => Observed::Place(self.path(folder)),
            _ => Observed::File(self.path(key)),
        }
    }
}
