//! The locations of the files of cells: in one folder, in subfolders, or in an exchange set (`ENC_ROOT`,
//! `CATALOG.031`).

use std::fs::{self, DirEntry};
use std::path::{Path, PathBuf};

use files::{DEEPEST, Digest, Error, Provenance, observe_names, place_of};

/// Names of the folder of an exchange set, and of its catalogue.
const ENC_ROOT: &str = "ENC_ROOT";
const CATALOGUE: &str = "CATALOG.031";
/// Maximum number of parent folders of a cell to search for an exchange set: agency, cell, edition, update, and some
/// to spare.
const HIGHEST: usize = 7;
/// Maximum number of entries to search.
const MOST_ENTRIES: usize = 200_000;

/// A file whose suffix is a number of three digits: a cell (000) or an update.
#[derive(Clone, Debug)]
pub(super) struct CellFile {
    pub path: PathBuf,
    /// Names of folders below the root, and its own, in upper case.
    pub place: Vec<String>,
    /// Whether it is a link or not a regular file, which is not read.
    pub special: bool,
    /// Its length \[bytes\].
    pub length: u64,
}

/// The files of cells below a folder.
#[derive(Debug)]
pub(super) struct ExchangeSet {
    /// The canonical path, without links.
    pub root: PathBuf,
    /// In the order of their paths.
    pub files: Vec<CellFile>,
    pub catalogue: Option<PathBuf>,
    /// Folders that were not searched: links, too deep, or not readable.
    pub closed: usize,
    entries: usize,
}

impl CellFile {
    /// A file below `root`, or next to it.
    pub(super) fn at(path: &Path, root: &Path) -> Self {
        let whole = path.parent().and_then(|parent| here(parent).canonicalize().ok());
        let below = whole.as_deref().and_then(|folder| folder.strip_prefix(root).ok());
        let folders = below.into_iter().flat_map(Path::components);
        let folders = folders.map(|folder| folder.as_os_str().to_string_lossy().to_ascii_uppercase());
        let place = folders.chain([capitals(path)]).collect();
        Self { path: path.to_path_buf(), place, special: false, length: 0 }
    }

    /// Its name in upper case.
    pub(super) fn name(&self) -> &str {
        self.place.last().map_or("", String::as_str)
    }

    /// The common part of the names of one cell's files.
    pub(super) fn stem(&self) -> &str {
        self.name().rsplit_once('.').map_or("", |(stem, _)| stem)
    }

    pub(super) fn is_base(&self) -> bool {
        self.name().ends_with(".000")
    }
}

/// The name of a file in upper case, for ASCII letters only.
pub(super) fn capitals(path: &Path) -> String {
    path.file_name().map_or(String::new(), |name| name.to_string_lossy().to_ascii_uppercase())
}

/// Whether a file is a catalogue, by its name.
pub(super) fn is_catalogue(path: &Path) -> bool {
    capitals(path) == CATALOGUE
}

/// The file that `path` names, in any letter case.
pub(super) fn existing(path: PathBuf) -> PathBuf {
    if path.symlink_metadata().is_ok() {
        return path;
    }
    let Some(folder) = path.parent() else { return path };
    observe_names(folder, &path.file_name().unwrap_or_default().to_string_lossy());
    let entries = fs::read_dir(here(folder)).into_iter().flatten().take(MOST_ENTRIES).flatten();
    let mut same = entries.map(|e| e.file_name()).filter(|name| capitals(Path::new(name)) == capitals(&path));
    match (same.next(), same.next()) {
        (Some(name), None) => folder.join(name),
        _ => path,
    }
}

fn here(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

impl ExchangeSet {
    /// All files below a folder.
    pub(super) fn below(folder: &Path) -> Result<Self, Error> {
        let fails = |e| Error::io(folder, "read", e);
        let root = place_of(here(folder)).map_err(fails)?;
        let catalogue = catalogue_in(&root);
        let mut set = Self { root: root.clone(), files: Vec::new(), catalogue, closed: 0, entries: 0 };
        let entries = fs::read_dir(&root).map_err(fails)?;
        set.take(entries.flatten(), &mut Vec::new())?;
        observe_names(&root, "**/*.###");
        set.files.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(set)
    }

    fn take(
        &mut self,
        entries: impl Iterator<Item = DirEntry>,
        place: &mut Vec<String>,
    ) -> Result<(), Error> {
        for entry in entries {
            self.entries += 1;
            if self.entries > MOST_ENTRIES {
                let given = format!("more than {MOST_ENTRIES} files and folders below it");
                let expected = "the folder of a cell, or of an exchange set";
                let remedy = "move the cell and its updates into a folder of their own";
                return Err(Error::refuse(&self.root, "folder", given, expected, remedy));
            }
            let path = entry.path();
            let Ok(kind) = entry.file_type() else { continue };
            place.push(capitals(&path));
            if is_numbered(&place[place.len() - 1]) && !kind.is_dir() && !is_catalogue(&path) {
                let length = entry.metadata().map_or(0, |about| about.len());
                self.files.push(CellFile { path, place: place.clone(), special: !kind.is_file(), length });
            } else if kind.is_dir() && !place[place.len() - 1].starts_with('.') {
                self.enter(&path, place)?;
            } else if kind.is_symlink() && path.is_dir() {
                self.closed += 1;
            }
            place.pop();
        }
        Ok(())
    }

    fn enter(&mut self, folder: &Path, place: &mut Vec<String>) -> Result<(), Error> {
        match fs::read_dir(folder) {
            Ok(entries) if place.len() < DEEPEST => self.take(entries.flatten(), place),
            _ => {
                self.closed += 1;
                Ok(())
            }
        }
    }

    /// The root of a cell's folder: its exchange set, the cell's own folder with those of its editions and updates,
    /// or itself.
    pub(super) fn root_of(cell: &Path) -> Result<PathBuf, Error> {
        let named = here(cell.parent().unwrap_or(Path::new("")));
        let folder = place_of(named).map_err(|e| Error::io(named, "read", e))?;
        let is_root = |ancestor: &&Path| capitals(ancestor) == ENC_ROOT || catalogue_in(ancestor).is_some();
        if let Some(root) = folder.ancestors().take(HIGHEST).find(is_root) {
            return Ok(root.to_path_buf());
        }
        // Folders of updates and editions are in one named as the cell.
        let numbered = folder.ancestors().take_while(|a| is_number(&capitals(a))).take(2).count();
        let above = folder.ancestors().nth(numbered).filter(|ancestor| is_stem(&capitals(ancestor), cell));
        let highest = folder.ancestors().nth(numbered.saturating_sub(1));
        Ok(above.or(highest).unwrap_or(&folder).to_path_buf())
    }

    /// Files of a cell, by their stem in upper case.
    pub(super) fn of(&self, stem: &str) -> impl Iterator<Item = &CellFile> {
        self.files.iter().filter(move |file| file.stem() == stem)
    }
}

/// Whether a name has a number of three digits for a suffix.
fn is_numbered(name: &str) -> bool {
    let digits = name.rsplit_once('.').map_or("", |(_, suffix)| suffix);
    digits.len() == 3 && is_number(digits)
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

fn is_stem(name: &str, cell: &Path) -> bool {
    capitals(cell).strip_suffix(".000") == Some(name)
}

fn catalogue_in(folder: &Path) -> Option<PathBuf> {
    observe_names(folder, CATALOGUE);
    let usual = folder.join(CATALOGUE);
    if usual.is_file() {
        return Some(usual);
    }
    let entries = fs::read_dir(folder).ok()?.take(MOST_ENTRIES).flatten();
    entries.map(|path| path.path()).find(|path| is_catalogue(path) && path.is_file())
}

/// Reads a chart's file, and notes its digest.
pub(super) fn bytes(path: &Path, provenance: &mut Provenance) -> Result<Vec<u8>, Error> {
    let bytes = files::read(path)?;
    note(path, Digest::of_bytes(&bytes), provenance);
    Ok(bytes)
}

/// Notes the digest of a chart's file by its name; with a number if another chart's file has the same name.
pub(super) fn note(path: &Path, digest: Digest, provenance: &mut Provenance) {
    let name = path.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
    let roles = (1..).map(|k| if k == 1 { format!("chart:{name}") } else { format!("chart:{name} ({k})") });
    for role in roles {
        let known = provenance.inputs.get(&role);
        if known.is_none_or(|known| *known == digest) {
            provenance.inputs.insert(role, digest);
            return;
        }
    }
}
