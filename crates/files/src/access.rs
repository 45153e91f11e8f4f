//! Opens files for reading: ordinary files only. A pipe, a device or a folder is refused without waiting.
//!
//! What a stage opens, looks for and writes is traced, so that nothing that is read is missed, whatever its files name. A file that
//! is not there and the names in a folder are observations like a file's bytes: a stage whose observations are as before gives the
//! same outputs.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, FileType, OpenOptions};
use std::io::{self, BufReader, ErrorKind, Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bytes::Bytes;
use parquet::errors::Result as ParquetResult;
use parquet::file::reader::{ChunkReader, Length};

use crate::budget::{Work, budget};
use crate::error::{Error, Result};
use crate::seal::Digest;

/// Opens the ordinary file at `path` for reading.
///
/// # Errors
/// [`Error::Refused`] for a folder, pipe, socket or device; [`Error::Io`] if the file cannot be opened.
pub fn open(path: impl AsRef<Path>) -> Result<File> {
    let path = path.as_ref();
    observed(path, open_unobserved(path))
}

/// As [`open`], without a trace of it: for what this process writes.
pub(crate) fn open_unobserved(path: &Path) -> Result<File> {
    let unreadable = |e| Error::io(path, "read", e);
    // Opening a device may have effects, and a socket cannot be opened.
    refuse_special(path, path.metadata().map_err(unreadable)?.file_type())?;
    let file = without_waiting().open(path).map_err(unreadable)?;
    // Another file may have taken the name since.
    refuse_special(path, file.metadata().map_err(unreadable)?.file_type())?;
    Ok(file)
}

/// `path` as it is named in files, which may be read on another system: with `/` between its parts.
pub fn slashed(path: &Path) -> String {
    path.to_string_lossy().replace(std::path::MAIN_SEPARATOR, "/")
}

/// Whether there is something at `path` to [`open`], or to refuse.
pub fn exists(path: impl AsRef<Path>) -> bool {
    !matches!(open(path), Err(Error::Io { source, .. }) if source.kind() == ErrorKind::NotFound)
}

impl Digest {
    /// The digest of the file at `path`, read in one streaming pass.
    ///
    /// # Errors
    /// See [`open`]; [`Error::Io`] if the file cannot be read.
    pub fn of_file(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Self::of_reader(open(path)?).map_err(|e| Error::io(path, "read", e))
    }

    /// As [`Digest::of_file`], without a trace of it: for what this process writes.
    pub(crate) fn of_own(path: &Path) -> Result<Self> {
        Self::of_reader(open_unobserved(path)?).map_err(|e| Error::io(path, "read", e))
    }
}

/// The bytes of the ordinary file at `path`.
///
/// # Errors
/// As [`open`]; [`Error::Refused`] if they do not fit in memory.
pub fn read(path: impl AsRef<Path>) -> Result<Vec<u8>> {
    let path = path.as_ref();
    bytes_of(path, open(path)?)
}

/// The contents of `file`, which was opened at `path`.
pub(crate) fn bytes_of(path: &Path, mut file: File) -> Result<Vec<u8>> {
    let unreadable = |e| Error::io(path, "read", e);
    let length = file.metadata().map_err(unreadable)?.len();
    let amount = format!("{length} bytes");
    let work = Work { file: path, thing: "file", found: &amount, remedy: REMEDY };
    budget().memory(work, length as f64)?;
    let mut bytes = Vec::new();
    let reserved = bytes.try_reserve_exact(usize::try_from(length).unwrap_or(usize::MAX));
    reserved.map_err(|_| unreadable(ErrorKind::OutOfMemory.into()))?;
    file.read_to_end(&mut bytes).map_err(unreadable)?;
    Ok(bytes)
}

/// The remedy for a file that is too large.
pub(crate) const REMEDY: &str = "name a smaller file, or raise --memory-mib";

/// Options that never wait: opening a pipe without a writer would block.
fn without_waiting() -> OpenOptions {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        use std::os::unix::fs::OpenOptionsExt;
        options.custom_flags((OFlags::NONBLOCK | OFlags::NOCTTY).bits() as i32);
    }
    options
}

fn refuse_special(path: &Path, kind: FileType) -> Result<()> {
    if kind.is_file() {
        return Ok(());
    }
    let remedy = "name a file: what comes from elsewhere has to be written into one first";
    Err(Error::refuse(path, "file", name_of(kind), "an ordinary file", remedy))
}

#[cfg(unix)]
fn name_of(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match kind {
        _ if kind.is_dir() => "a folder",
        _ if kind.is_fifo() => "a pipe",
        _ if kind.is_socket() => "a socket",
        _ => "a device",
    }
}

#[cfg(not(unix))]
fn name_of(kind: FileType) -> &'static str {
    if kind.is_dir() { "a folder" } else { "a device" }
}

/// An open file without a shared position: the file that was checked is the file that is read, even if
/// another has taken its name since.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    file: Arc<File>,
    length: u64,
}

impl Source {
    /// Takes over an open file.
    pub fn new(file: File) -> io::Result<Self> {
        let length = file.metadata()?.len();
        Ok(Self { file: Arc::new(file), length })
    }

    /// A reader from the position `at` on.
    pub fn from(&self, at: u64) -> ReaderAt {
        ReaderAt { file: Arc::clone(&self.file), at }
    }
}

impl Length for Source {
    fn len(&self) -> u64 {
        self.length
    }
}

impl ChunkReader for Source {
    type T = BufReader<ReaderAt>;

    fn get_read(&self, start: u64) -> ParquetResult<Self::T> {
        Ok(BufReader::new(self.from(start)))
    }

    fn get_bytes(&self, start: u64, length: usize) -> ParquetResult<Bytes> {
        // No more memory than the file has bytes, regardless of the announced length.
        if length as u64 > self.length.saturating_sub(start) {
            return Err(io::Error::from(io::ErrorKind::UnexpectedEof).into());
        }
        let mut bytes = vec![0; length];
        self.from(start).read_exact(&mut bytes)?;
        Ok(bytes.into())
    }
}

/// Reads a file from a position on.
pub(crate) struct ReaderAt {
    file: Arc<File>,
    at: u64,
}

impl Read for ReaderAt {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = read_at(&self.file, buffer, self.at)?;
        self.at = self.at.saturating_add(read as u64);
        Ok(read)
    }
}

#[cfg(unix)]
fn read_at(file: &File, buffer: &mut [u8], at: u64) -> io::Result<usize> {
    std::os::unix::fs::FileExt::read_at(file, buffer, at)
}

#[cfg(windows)]
fn read_at(file: &File, buffer: &mut [u8], at: u64) -> io::Result<usize> {
    std::os::windows::fs::FileExt::seek_read(file, buffer, at)
}

/// The observations of the stage that runs, if it is traced.
static TRACE: Mutex<Option<Trace>> = Mutex::new(None);

/// Maximum depth of folders that are searched below one.
pub const DEEPEST: usize = 8;

/// The beginning of a pattern of names in a folder and in all below it.
const BELOW: &str = "**/";

/// What a stage may observe.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Observed {
    /// The bytes of the file at a path.
    File(PathBuf),
    /// The names that fit a pattern in a folder. `*` is any text, `#` a digit; letter case does not count. After `**/` those of folders
    /// below count too, without links and names with a dot in front.
    Names(PathBuf, String),
    /// The path of a folder without links.
    Place(PathBuf),
}

impl Observed {
    /// Its digest now; `None` where there is no ordinary file or no folder. A place below `base` is the same wherever that is.
    pub fn digest(&self, base: &Path) -> Option<Digest> {
        match self {
            Self::File(path) => Digest::of_file(path).ok(),
            Self::Names(folder, pattern) => {
                let below = pattern.strip_prefix(BELOW).map(|pattern| (pattern, DEEPEST));
                let (pattern, depth) = below.unwrap_or((pattern, 1));
                let mut names = BTreeSet::new();
                names_in(folder, "", pattern, depth, &mut names).ok()?;
                Some(Digest::of_bytes(Vec::from_iter(names).join("\n").as_bytes()))
            }
            Self::Place(folder) => {
                let (place, base) = (folder.canonicalize().ok()?, base.canonicalize().ok()?);
                let below = place.strip_prefix(base).unwrap_or(&place);
                Some(Digest::of_bytes(slashed(below).as_bytes()))
            }
        }
    }

    /// The path that it is about.
    pub fn path(&self) -> &Path {
        let (Self::File(path) | Self::Names(path, _) | Self::Place(path)) = self;
        path
    }
}

/// The observations of a stage.
#[derive(Debug, Default)]
pub struct Trace {
    /// What was observed first of each, as [`Observed::digest`].
    pub inputs: BTreeMap<Observed, Option<Digest>>,
    /// The files that were written.
    pub outputs: BTreeSet<PathBuf>,
    /// The folder of places that count relative to it, and the one outside which nothing is written, without links.
    folders: [PathBuf; 2],
}

/// Traces what is read from now on, with places relative to `base`, and refuses to write outside the existing folder `within`.
///
/// # Errors
/// [`Error::Io`] if there is no such folder.
pub fn trace(base: &Path, within: &Path) -> Result<()> {
    let within = within.canonicalize().map_err(|e| Error::io(within, "find", e))?;
    *current() = Some(Trace { folders: [base.to_owned(), within], ..Trace::default() });
    Ok(())
}

/// Ends tracing, and returns what was observed.
pub fn traced() -> Trace {
    current().take().unwrap_or_default()
}

/// Observes the names in `folder` that fit `pattern`, which the caller is about to look for.
pub fn observe_names(folder: &Path, pattern: &str) {
    let folder = if folder == Path::new("") { Path::new(".") } else { folder };
    observe(Observed::Names(folder.to_owned(), pattern.to_owned()));
}

/// The path of `folder` without links.
///
/// # Errors
/// No such folder.
pub fn place_of(folder: &Path) -> io::Result<PathBuf> {
    observe(Observed::Place(folder.to_owned()));
    folder.canonicalize()
}

/// Names that no file has on Windows, with any ending.
pub const DEVICES: &str = "aux con nul prn com1 com2 com3 com4 com5 com6 com7 com8 com9 lpt1 lpt2 lpt3 lpt4 lpt5 lpt6 lpt7 lpt8 lpt9";

/// The part of `path` that names a device on Windows, if one does.
pub fn device_in(path: &Path) -> Option<String> {
    let parts = path.iter().map(|part| part.to_string_lossy().into_owned());
    let is_device = |part: &String| {
        let plain = part.split('.').next().unwrap_or_default().trim_end();
        DEVICES.split(' ').any(|device| device.eq_ignore_ascii_case(plain))
    };
    parts.into_iter().find(is_device)
}

/// Refuses to write at `path` if that is outside the folder of the outputs, links resolved.
///
/// # Errors
/// [`Error::Refused`] for another place.
pub fn check_within(path: &Path) -> Result<()> {
    let Some(within) = current().as_ref().map(|trace| trace.folders[1].clone()) else { return Ok(()) };
    // What is not there yet is created below what is.
    let whole = std::path::absolute(path).map_err(|e| Error::io(path, "create", e))?;
    let place = whole.ancestors().find_map(|above| above.canonicalize().ok()).unwrap_or_default();
    if place.starts_with(&within) {
        return Ok(());
    }
    let (found, expected) =
        (format!("a place in {}", place.display()), format!("one below {}", within.display()));
    let remedy = "remove the link, or name another folder";
    Err(Error::refuse(path, "output", found, expected, remedy))
}

/// Refuses to write at a path that is a device of Windows there.
///
/// # Errors
/// [`Error::Refused`] for such a path.
pub fn refuse_device(path: &Path) -> Result<()> {
    let Some(device) = device_in(path).filter(|_| cfg!(windows)) else { return Ok(()) };
    let named = format!("`{device}`, which is a device on Windows");
    Err(Error::refuse(path, "output", named, "the name of a file", "name it otherwise"))
}

/// Notes that the stage has written `path`.
pub(crate) fn wrote(path: &Path) {
    if let Some(trace) = current().as_mut() {
        trace.outputs.insert(path.to_owned());
    }
}

/// Observes `opened`, which is to be what [`crate::open`] gave for `path`.
fn observed(path: &Path, opened: Result<File>) -> Result<File> {
    let what = Observed::File(path.to_owned());
    if is_known(&what) {
        return opened;
    }
    // Reading at a place moves the position of the file on some systems: who opens it begins at its start.
    let mut digest = None;
    let rewound = opened.and_then(|mut file| {
        digest = Digest::of_reader(&file).ok();
        file.rewind().map(|()| file).map_err(|e| Error::io(path, "read", e))
    });
    note(what, digest);
    rewound
}

fn observe(what: Observed) {
    let Some(base) = current().as_ref().map(|trace| trace.folders[0].clone()) else { return };
    if !is_known(&what) {
        let digest = what.digest(&base);
        note(what, digest);
    }
}

/// Whether `what` is not to be observed: nothing is traced, or it is known.
fn is_known(what: &Observed) -> bool {
    current().as_ref().is_none_or(|trace| trace.inputs.contains_key(what))
}

fn note(what: Observed, digest: Option<Digest>) {
    if let Some(trace) = current().as_mut() {
        trace.inputs.entry(what).or_insert(digest);
    }
}

fn current() -> MutexGuard<'static, Option<Trace>> {
    TRACE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Puts the names that fit `pattern` into `names`, with `before` in front, and those of folders below if `depth` is more than one.
fn names_in(
    folder: &Path,
    before: &str,
    pattern: &str,
    depth: usize,
    names: &mut BTreeSet<String>,
) -> io::Result<()> {
    for entry in std::fs::read_dir(folder)?.flatten() {
        let (name, kind) = (entry.file_name().to_string_lossy().into_owned(), entry.file_type()?);
        if fits(pattern.as_bytes(), name.as_bytes()) {
            let end = if entry.path().is_dir() { "/" } else { "" };
            names.insert(format!("{before}{name}{end}"));
        }
        if depth > 1 && kind.is_dir() && !name.starts_with('.') {
            // A folder that cannot be read has no names.
            let _ = names_in(&entry.path(), &format!("{before}{name}/"), pattern, depth - 1, names);
        }
    }
    Ok(())
}

/// Whether `name` fits `pattern`. Of several stars only the last one is tried again: no pattern takes long.
fn fits(pattern: &[u8], name: &[u8]) -> bool {
    let is_one =
        |sign: u8, byte: u8| sign.eq_ignore_ascii_case(&byte) || sign == b'#' && byte.is_ascii_digit();
    let (mut next, mut at, mut star) = (0, 0, None);
    while at < name.len() {
        match pattern.get(next) {
            Some(b'*') => {
                star = Some((next, at));
                next += 1;
            }
            Some(&one) if is_one(one, name[at]) => (next, at) = (next + 1, at + 1),
            _ => {
                let Some((before, from)) = star else { return false };
                star = Some((before, from + 1));
                (next, at) = (before + 1, from + 1);
            }
        }
    }
    pattern[next..].iter().all(|rest| *rest == b'*')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_fit_patterns_with_stars_and_digits_in_any_letter_case() {
        for (pattern, name) in
            [("*", ""), ("*.###", "ZZ5BAY01.002"), ("catalog.031", "CATALOG.031"), ("a*b*", "axbxb")]
        {
            assert!(fits(pattern.as_bytes(), name.as_bytes()), "{pattern} {name}");
        }
        for (pattern, name) in [("", "a"), ("*.###", "ZZ5BAY01.00x"), ("*.###", "a.0001"), ("a*b", "axbx")] {
            assert!(!fits(pattern.as_bytes(), name.as_bytes()), "{pattern} {name}");
        }
        let (pattern, name) = ("*a".repeat(100) + "b", "a".repeat(10_000));
        assert!(!fits(pattern.as_bytes(), name.as_bytes()));
    }
}
