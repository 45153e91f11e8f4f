//! The list of renames that make a set: once it is in the folder, the set will be completed, by this process
//! or another.
//!
//! Every writer in a folder obeys its journals, so their power is limited: a journal has a seal, it names
//! plain files beside itself, or in a real folder there, and a file is renamed only if it is the one that the
//! journal was written for. That includes its number in the file system, which who packs a folder for somebody
//! else cannot know.

use std::fs::{self, File, Metadata};
use std::io::Seek;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::digest::Digest;
use crate::error::Result;
use crate::names::{SET, UNFINISHED, is_inside, is_own, unfinished_in};
use crate::ordinary::{bytes_of, open_itself};
use crate::seal;

const SCHEMA: &str = "set/2";
/// Larger files are not journals.
const MOST_BYTES: u64 = 1 << 24;

/// Renames within a folder.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Journal {
    schema: String,
    seal: Digest,
    renames: Vec<Rename>,
}

/// A rename: both paths are relative to the journal's folder.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Rename {
    from: String,
    to: String,
    /// Of the file to be renamed.
    digest: Digest,
    /// The number of this file in its file system; 0 where there are none.
    number: u64,
}

/// A file name's meaning under a journal.
pub(crate) enum Meaning {
    /// This file, which will get the name.
    File(File),
    /// Nothing: the name will be freed.
    Nothing,
}

/// Whether `name` looks like that of a journal.
pub(crate) fn is_one(name: &str) -> bool {
    name.strip_prefix(UNFINISHED).is_some_and(|rest| rest.starts_with(SET))
}

#[cfg(unix)]
fn number(metadata: &Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::ino(metadata)
}

#[cfg(not(unix))]
fn number(_: &Metadata) -> u64 {
    0
}

impl Journal {
    /// The renames that stay below `folder`, each within a folder and with the digest of its file; in order.
    pub fn of<'a>(renames: impl Iterator<Item = ([&'a Path; 2], Digest)>, folder: &Path) -> Self {
        let below = |([from, to], digest): ([&Path; 2], Digest)| {
            let number = number(&from.symlink_metadata().ok()?);
            let to = to.strip_prefix(folder).unwrap_or(to);
            let from = to.with_file_name(from.file_name()?).to_str()?.to_owned();
            let rename = Rename { from, to: to.to_str()?.to_owned(), digest, number };
            rename.is_ours().then_some(rename)
        };
        Self { schema: SCHEMA.to_owned(), seal: Digest::ZERO, renames: renames.filter_map(below).collect() }
    }

    /// The text of the file at `path`.
    pub fn text(&self, path: &Path) -> Result<Vec<u8>> {
        seal::sealed(path, serde_json::to_string_pretty(self).unwrap_or_default())
    }

    /// Reads a journal; `None` if it was not written by this program.
    pub fn read(path: &Path) -> Option<Self> {
        let file = open_itself(path).ok()?;
        if file.metadata().ok()?.len() > MOST_BYTES {
            return None;
        }
        let text = String::from_utf8(bytes_of(path, file).ok()?).ok()?;
        let journal: Self = serde_json::from_str(&text).ok()?;
        seal::check_text(path, &text, Some(journal.seal)).ok()?;
        (journal.schema == SCHEMA && journal.renames.iter().all(Rename::is_ours)).then_some(journal)
    }

    /// The valid journals in `folder`, by name.
    pub fn all(folder: &Path) -> Vec<(String, Self)> {
        let names = unfinished_in(folder).into_iter().filter(|name| is_one(name));
        names.filter_map(|name| Self::read(&folder.join(&name)).map(|journal| (name, journal))).collect()
    }

    /// Performs the renames that are pending and whose files are unchanged.
    pub fn rename_all(&self, folder: &Path) {
        for rename in &self.renames {
            if rename.pending(folder).is_some() {
                let _ = fs::rename(folder.join(&rename.from), folder.join(&rename.to));
            }
        }
    }

    /// The meaning of `name` in `folder` after all renames; `None` if they do not affect it.
    pub fn meaning(&self, folder: &Path, name: &str) -> Option<Meaning> {
        let given = self.renames.iter().filter(|rename| rename.to == name);
        let given = given.filter_map(|rename| rename.pending(folder)).map(Meaning::File).next();
        let taken = || self.renames.iter().filter(|rename| rename.from == name);
        given.or_else(|| taken().find_map(|rename| rename.pending(folder)).map(|_| Meaning::Nothing))
    }
}

impl Rename {
    /// Whether it has the form that this program writes.
    fn is_ours(&self) -> bool {
        let (from, to) = (Path::new(&self.from), Path::new(&self.to));
        let plain = |path: &Path| (1..=2).contains(&path.components().count()) && is_inside(path);
        let own = |path: &Path| path.file_name().and_then(|name| name.to_str()).is_some_and(is_own);
        let unfinished = own(from) || own(to);
        unfinished && plain(from) && plain(to) && from.parent() == to.parent()
    }

    /// The file to be renamed, if it is still there unchanged, in a folder that is not a link.
    fn pending(&self, folder: &Path) -> Option<File> {
        let from = Path::new(&self.from);
        let within = from.parent().filter(|within| *within != Path::new(""));
        if within
            .is_some_and(|within| !folder.join(within).symlink_metadata().is_ok_and(|found| found.is_dir()))
        {
            return None;
        }
        let mut file = open_itself(&folder.join(from)).ok()?;
        if number(&file.metadata().ok()?) != self.number {
            return None;
        }
        let digest = Digest::of_reader(&mut file).ok()?;
        file.rewind().ok()?;
        (digest == self.digest).then_some(file)
    }
}
