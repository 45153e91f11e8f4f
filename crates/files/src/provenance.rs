//! The origin of a file's contents.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::error::{Error, Result};
use crate::hand_written::{Changes, read_changed};
use crate::seal::Digest;

/// Roles that one file plays in a whole study: an output whose inputs refer to different files is a mixture.
pub const STUDY_ROLES: [&str; 7] =
    ["vessel", "dictionary", "campaign", "moments", "design", "validation", "estimates"];

/// The setting that labels outputs of mixed files: the roles that several files play.
pub const MIXED: &str = "mixed";

/// The setting that records replaced values of hand-written files.
const CHANGED: &str = "set";

/// The producer of a file, and its inputs. Contains no clock, host, user or thread count, so that the same
/// computation gives the same bytes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    /// Program and version, like `simulate 0.1.0`.
    pub producer: String,
    /// Digest of each input file, by its role (`vessel`, `dictionary`).
    pub inputs: BTreeMap<String, Digest>,
    /// Digests of the inputs' own inputs, by the roles of [`STUDY_ROLES`] that no input plays itself.
    pub origins: BTreeMap<String, Digest>,
    /// Settings that determine the contents (`seed`, `runs`), by name.
    pub settings: BTreeMap<String, serde_json::Value>,
    /// Which part of the whole this is, if it is a part.
    pub shard: Option<Shard>,
    /// Whether files of different studies may be used together. Not written.
    pub allow_mixed: bool,
    /// Replacements for values of its hand-written inputs. Not written; the applied ones are recorded in
    /// `settings`.
    pub changes: Changes,
    /// The file that reported each role's digest, for messages. Not written.
    pub reported_by: BTreeMap<String, PathBuf>,
    /// The input files: no output may replace them. Not written.
    pub read: BTreeSet<PathBuf>,
}

impl Provenance {
    /// Reads the hand-written file at `path` as the input `role`, with the replacements for `file`, its usual
    /// name without `.toml`.
    ///
    /// # Errors
    /// As [`crate::read_toml`] and [`Provenance::written`].
    pub fn read_toml<T: DeserializeOwned + JsonSchema>(
        &mut self,
        role: &str,
        file: &str,
        path: &Path,
    ) -> Result<T> {
        let (parsed, digest) = read_changed(path, file, &self.changes)?;
        self.written(role, path, digest)?;
        for change in self.changes.of(file) {
            let known = self.settings.entry(CHANGED.to_owned()).or_insert_with(|| json!({}));
            known[change.key()] = json!(change.value());
        }
        Ok(parsed)
    }

    /// Records the hand-written file at `path` as the input `role`.
    ///
    /// # Errors
    /// [`Error::Refused`] if another input was made of another such file.
    pub fn written(&mut self, role: &str, path: &Path, digest: Digest) -> Result<()> {
        self.note(role, path, digest)?;
        self.read.insert(path.to_owned());
        self.origins.remove(role);
        self.inputs.insert(role.to_owned(), digest);
        Ok(())
    }

    /// Records the file at `path`, which comes from `from`, as the input `role`.
    ///
    /// # Errors
    /// [`Error::Refused`] if it was made of other files than the previous inputs.
    pub fn made(&mut self, role: &str, path: &Path, digest: Digest, from: &Self) -> Result<()> {
        self.written(role, path, digest)?;
        self.accept_label(from);
        // A file of the same role among its inputs is an earlier version of it.
        let before = from.inputs.iter().chain(&from.origins).filter(|(known, _)| *known != role);
        for (known, digest) in before.filter(|(known, _)| STUDY_ROLES.contains(&known.as_str())) {
            self.note(known, path, *digest)?;
            if !self.inputs.contains_key(known) {
                self.origins.insert(known.clone(), *digest);
            }
        }
        Ok(())
    }

    /// Forgets the files of `roles`, for outputs that have others.
    pub fn forget(&mut self, roles: &[&str]) {
        self.inputs.retain(|role, _| !roles.contains(&role.as_str()));
        self.origins.retain(|role, _| !roles.contains(&role.as_str()));
    }

    /// Refuses an output at the path of one of its inputs.
    pub(crate) fn check_output(&self, path: &Path) -> Result<()> {
        let Ok(existing) = path.canonicalize() else { return Ok(()) };
        if self.read.iter().any(|input| input.canonicalize().is_ok_and(|input| input == existing)) {
            let (found, expected) = ("a file that this is made of", "another file");
            return Err(Error::refuse(path, "output", found, expected, "name another --out"));
        }
        Ok(())
    }

    /// Inherits the label of a mixture.
    pub fn accept_label(&mut self, from: &Self) {
        if let Some(roles) = from.settings.get(MIXED).and_then(|roles| roles.as_array()) {
            roles.iter().filter_map(|role| role.as_str()).for_each(|role| self.label(role));
        }
    }

    pub(crate) fn label(&mut self, role: &str) {
        let known = self.settings.entry(MIXED.to_owned()).or_insert_with(|| Vec::<String>::new().into());
        if let Some(roles) = known.as_array_mut()
            && !roles.iter().any(|known| known == role)
        {
            roles.push(role.into());
        }
    }

    /// Compares the digest that `path` reports for `role` with the known one.
    fn note(&mut self, role: &str, path: &Path, digest: Digest) -> Result<()> {
        let known = self.inputs.get(role).or_else(|| self.origins.get(role));
        if !STUDY_ROLES.contains(&role) || known.is_none_or(|known| *known == digest) {
            self.reported_by.entry(role.to_owned()).or_insert_with(|| path.to_owned());
            return Ok(());
        }
        if self.allow_mixed {
            self.label(role);
            return Ok(());
        }
        let other = self.reported_by.get(role).map_or("another input".into(), |file| file.to_string_lossy());
        let (found, expected) = (format!("another {role} than that of {other}"), "files of one study");
        let remedy = "make both again (`make` does), or add --allow=mixed";
        Err(Error::refuse(path, "provenance", found, expected, remedy))
    }
}

/// Part `index` of `count`, written `K/N` with 1 ≤ K ≤ N.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(with = "String", extend("pattern" = "^[1-9][0-9]*/[1-9][0-9]*$"))]
pub struct Shard {
    /// Number of this part, from 1.
    pub index: u32,
    /// Number of parts.
    pub count: u32,
}

impl Shard {
    /// The items, out of `items`, that belong to this part.
    ///
    /// The ranges of the parts 1 to N follow each other, cover `0..items`, and their lengths
    /// differ by at most one. A part outside `1..=count` has no items.
    pub fn range(&self, items: usize) -> Range<usize> {
        if self.index == 0 || self.index > self.count {
            return 0..0;
        }
        // At most `items`.
        let bound = |parts: u32| (items as u128 * u128::from(parts) / u128::from(self.count)) as usize;
        bound(self.index - 1)..bound(self.index)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

/// Why a text is not a [`Shard`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a shard: expected K/N with whole numbers 1 <= K <= N, like 2/4")]
pub struct NotAShard(String);

impl FromStr for Shard {
    type Err = NotAShard;

    fn from_str(text: &str) -> Result<Self, NotAShard> {
        let wrong = || NotAShard(text.to_owned());
        let (index, count) = text.split_once('/').ok_or_else(wrong)?;
        let number = |part: &str| part.parse::<u32>().ok().filter(|n| n.to_string() == part);
        let index = number(index).ok_or_else(wrong)?;
        let count = number(count).ok_or_else(wrong)?;
        if index == 0 || index > count { Err(wrong()) } else { Ok(Self { index, count }) }
    }
}

impl TryFrom<String> for Shard {
    type Error = NotAShard;

    fn try_from(text: String) -> Result<Self, NotAShard> {
        text.parse()
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}
