//! Working copies of a ground, whose stages write into the folder `out`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use files::Digest;
use tempfile::TempDir;

use crate::grounds::{Files, Ground, files, write};
use crate::support::listing;

/// A copy of a ground.
pub struct Place {
    pub folder: TempDir,
    pub ground: &'static Ground,
    /// The files that differ from the ground.
    touched: Vec<String>,
}

/// Name, length and time of the last change of files.
type Listing = BTreeMap<PathBuf, (u64, SystemTime)>;

impl Place {
    pub fn on(ground: &'static Ground) -> Self {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &ground.files);
        fs::create_dir(folder.path().join("out")).unwrap();
        Self { folder, ground, touched: Vec::new() }
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// The contents of a file on the ground.
    pub fn original(&self, name: &str) -> &'static [u8] {
        self.ground.files.get(name).unwrap_or_else(|| panic!("no {name}"))
    }

    /// Gives a file other contents.
    pub fn put(&mut self, name: &str, bytes: &[u8]) {
        fs::write(self.path().join(name), bytes).unwrap();
        self.touched.push(name.to_owned());
    }

    /// Updates the digests of a changed file in the documents that have them.
    pub fn vouch(&mut self, name: &str) {
        let hex = |bytes: &[u8]| Digest::of_bytes(bytes).hex();
        let before = hex(self.original(name));
        let after = hex(&fs::read(self.path().join(name)).unwrap());
        for (other, bytes) in &self.ground.files {
            if other.ends_with(".json") && other != name {
                let text = String::from_utf8_lossy(bytes);
                if text.contains(&before) {
                    let text = text.replace(&before, &after);
                    self.put(other, &unsealed(text.as_bytes()));
                }
            }
        }
    }

    /// Everything but the outputs.
    pub fn inputs(&self) -> Listing {
        let mut all = listing(self.path());
        let out = self.path().join("out");
        all.retain(|path, _| !path.starts_with(&out));
        all
    }

    /// The files in `out`.
    pub fn outputs(&self) -> Files {
        files(&self.path().join("out"))
    }

    /// Restores `out`.
    pub fn put_outputs(&self, wanted: &Files) {
        let out = self.path().join("out");
        for name in self.outputs().keys().filter(|name| !wanted.contains_key(*name)) {
            fs::remove_file(out.join(name)).unwrap();
        }
        write(&out, wanted);
    }

    /// Empties `out` and puts all files back.
    pub fn restore(&mut self) {
        let out = self.path().join("out");
        if fs::read_dir(&out).unwrap().next().is_some() {
            fs::remove_dir_all(&out).unwrap();
            fs::create_dir(&out).unwrap();
        }
        for name in std::mem::take(&mut self.touched) {
            fs::write(self.path().join(&name), self.original(&name)).unwrap();
        }
    }
}

/// Removes the seal, so that further checks run; the file keeps its length.
pub fn unsealed(bytes: &[u8]) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for seal in [&b"\"seal\":\"blake3:"[..], &b"\"seal\": \"blake3:"[..]] {
        if let Some(at) = out.windows(seal.len()).position(|window| window == seal) {
            let (start, end) = (at + seal.len() - 8, at + seal.len() + 65);
            out[start..end].fill(b' ');
            out[start..start + 4].copy_from_slice(b"null");
        }
    }
    out
}

/// Whether a file is unfinished.
pub fn is_unfinished(name: &str) -> bool {
    name.rsplit('/').next().is_some_and(|name| name.starts_with(".unfinished"))
}
