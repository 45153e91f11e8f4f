//! Flags that all stages share.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use files::{Change, Changes, Provenance, Shard};

use crate::failure::Failure;

pub use files::{budget, set_budget};
pub use study::beside;
use study::check_kind;

/// Flags of every stage.
#[derive(Clone, Debug, Args)]
pub struct Common {
    /// Where to write: the main file, or a folder for files under their usual names
    #[arg(long, value_name = "PATH")]
    pub out: PathBuf,
    /// Threads to use (default: all cores); results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// Replaces the seed of the configuration
    #[arg(long, global = true, value_name = "SEED")]
    pub seed: Option<u64>,
    /// Uses files of different studies together; what is made of them is labelled as mixed
    #[arg(long, global = true)]
    pub allow_mixed: bool,
    /// Replaces a value of a hand-written file before it is checked, as in campaign.realizations=100: the file's usual name
    /// without .toml, the key, the value as in TOML or a plain word; an item of a list by its name or its place from 0.
    /// May stand more than once
    #[arg(long, global = true, value_name = "FILE.KEY=VALUE")]
    pub set: Vec<Change>,
    /// No progress on stderr
    #[arg(long, global = true)]
    pub quiet: bool,
    /// One JSON object on stdout instead of a summary line
    #[arg(long, global = true)]
    pub json: bool,
    /// Memory that the work may use (default: what the machine has); what would need more is refused
    #[arg(long, global = true, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..))]
    pub memory_mib: Option<u64>,
}

/// Flags of stages whose work can be split over machines.
#[derive(Clone, Debug, Args)]
pub struct Sharding {
    /// Do only part K of N of the work; gather the parts with --gather
    #[arg(long, value_name = "K/N", conflicts_with = "gather")]
    pub shard: Option<Shard>,
    /// Put the files of all shards together instead of computing
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub gather: Vec<PathBuf>,
}

impl Sharding {
    /// Whether shards are gathered instead of computed.
    pub fn gathers(&self) -> bool {
        !self.gather.is_empty()
    }
}

/// The value of a flag that clap requires unless files are gathered.
///
/// # Errors
/// A usage error that names the flag.
pub fn given<'a>(path: &'a Option<PathBuf>, flag: &str) -> Result<&'a Path, Failure> {
    path.as_deref()
        .ok_or_else(|| Failure::Usage(format!("--{flag}: found none, expected a path; name the file")))
}

impl Common {
    /// Changes to values of the hand-written files. A key that is given twice was refused before the stage began.
    pub fn changes(&self) -> Changes {
        Changes::new(self.set.clone()).unwrap_or_default()
    }

    /// Provenance of the files of stage `stage`, still without inputs and settings.
    pub fn provenance(&self, stage: &str) -> Provenance {
        Provenance {
            producer: format!("{stage} {}", env!("CARGO_PKG_VERSION")),
            allow_mixed: self.allow_mixed,
            changes: self.changes(),
            ..Provenance::default()
        }
    }

    /// The main output: `--out`, or `name` in it if it is a folder. It must not be one of `inputs`, and its folder
    /// must exist, so that a missing folder is reported before the work.
    ///
    /// # Errors
    /// A usage error: an input that would be overwritten, the name of another kind of file; no such folder.
    pub fn main_output<I: AsRef<Path>>(
        &self,
        name: &str,
        inputs: impl IntoIterator<Item = I>,
    ) -> Result<PathBuf, Failure> {
        let out = self.output_in_any_folder(name, inputs)?;
        let folder = if folder_of(&out).as_os_str().is_empty() { Path::new(".") } else { folder_of(&out) };
        match std::fs::metadata(folder) {
            Ok(found) if found.is_dir() => Ok(out),
            Ok(_) => Err(files::Error::io(out, "create", ErrorKind::NotADirectory.into()).into()),
            Err(error) => Err(files::Error::io(out, "create", error).into()),
        }
    }

    /// [`Common::main_output`] for stages that create the folder.
    ///
    /// # Errors
    /// A usage error: an input that would be overwritten, the name of another kind of file.
    pub fn output_in_any_folder<I: AsRef<Path>>(
        &self,
        name: &str,
        inputs: impl IntoIterator<Item = I>,
    ) -> Result<PathBuf, Failure> {
        let folder = self.out.is_dir() || self.out.as_os_str().to_string_lossy().ends_with('/');
        let out = if folder { self.out.join(name) } else { self.out.clone() };
        let existing = out.canonicalize().ok();
        let same = |input: &I| existing.is_some() && input.as_ref().canonicalize().ok() == existing;
        match inputs.into_iter().find(same) {
            None => check_kind(&out, name).map(|()| out).map_err(|e| Failure::Usage(e.to_string())),
            Some(input) => Err(Failure::Usage(format!(
                "--out: found {}, which is also an input, expected another file; name another output",
                input.as_ref().display()
            ))),
        }
    }
}

/// The path of `name` in the set with the main file `out`, usually called `usual`. It must not be one of `inputs`: a
/// model that is made from another would overwrite it.
///
/// # Errors
/// A usage error that names the input that would be overwritten.
pub fn member<I: AsRef<Path>>(
    out: &Path,
    usual: &str,
    name: &str,
    inputs: impl IntoIterator<Item = I>,
) -> Result<PathBuf, Failure> {
    let member = beside(out, usual, name);
    let Ok(existing) = member.canonicalize() else { return Ok(member) };
    let same = |input: &I| input.as_ref().canonicalize().is_ok_and(|path| path == existing);
    match inputs.into_iter().find(same) {
        None => Ok(member),
        Some(input) => Err(Failure::Usage(format!(
            "--out: found that {name} beside it would replace {}, which is also an input, expected another place; name another \
             output",
            input.as_ref().display()
        ))),
    }
}

/// The name of a choice on the command line and in files.
pub fn name_of(choice: impl ValueEnum) -> String {
    choice.to_possible_value().map_or(String::new(), |value| value.get_name().to_owned())
}

/// The folder of `main`.
pub fn folder_of(main: &Path) -> &Path {
    main.parent().unwrap_or(Path::new(""))
}

/// Calls `write` with an existing `folder`: created if missing, and removed again if nothing was written.
///
/// # Errors
/// A folder that cannot be created; those of `write`.
pub fn in_folder<T>(folder: &Path, write: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    if folder.as_os_str().is_empty() || folder.is_dir() {
        return write();
    }
    files::check_within(folder)?;
    std::fs::create_dir(folder).map_err(|e| files::Error::io(folder, "create", e))?;
    write().inspect_err(|_| {
        // Removes only an empty folder; the failure itself is reported.
        let _ = std::fs::remove_dir(folder);
    })
}

/// Refuses a folder that contains anything but files of these `names`, since its contents are used as a whole. Names
/// that begin with a dot are ignored.
///
/// # Errors
/// A folder that contains other files, or a file in its place.
pub fn only_folder_of(folder: &Path, names: &[String]) -> Result<(), Failure> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(files::Error::io(folder, "list", error).into()),
    };
    let found = entries.filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()));
    let mut others: Vec<String> =
        found.filter(|name| !name.starts_with('.') && !names.contains(name)).collect();
    others.sort();
    match others.first() {
        None => Ok(()),
        Some(other) => {
            let expected = format!("none but {}", names.join(", "));
            Err(Failure::refuse(
                folder,
                "folder",
                &format!("`{other}` in it"),
                &expected,
                "name another folder with --out",
            ))
        }
    }
}

/// The largest number that a flag takes.
const LARGEST: f64 = 1e12;

/// Refuses a number that is not positive, or unreasonably large.
///
/// # Errors
/// A usage error that names the flag.
pub fn check_positive(flag: &str, value: Option<f64>) -> Result<(), Failure> {
    let refuse = |value: f64, expected: &str| {
        Err(Failure::Usage(format!("{flag}: found {value:?}, expected {expected}; correct it")))
    };
    match value {
        Some(value) if !(value.is_finite() && value > 0.0) => refuse(value, "a number above 0"),
        Some(value) if !(1e-15..=LARGEST).contains(&value) => {
            refuse(value, &format!("a number from 1e-15 to {LARGEST:e}"))
        }
        _ => Ok(()),
    }
}

/// Refuses the first of `flags` that is given where there is `found`.
///
/// # Errors
/// A usage error that names the flag.
pub fn none_given<'a>(
    flags: impl IntoIterator<Item = (&'a str, bool)>,
    found: &str,
    expected: &str,
) -> Result<(), Failure> {
    match flags.into_iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((flag, _)) => {
            Err(Failure::Usage(format!("{flag}: found {found}, expected {expected}; leave it out")))
        }
    }
}

/// `value`, which must not be below `least`.
///
/// # Errors
/// A usage error that names the flag.
pub fn not_below(flag: &str, value: f64, least: f64) -> Result<f64, Failure> {
    if value.is_finite() && value >= least && value <= LARGEST {
        return Ok(value);
    }
    let most = if value > LARGEST { format!(" to {LARGEST:e}") } else { " on".to_owned() };
    Err(Failure::Usage(format!("{flag}: found {value:?}, expected a number from {least}{most}; correct it")))
}

/// Seconds in samples.
///
/// # Errors
/// A usage error: less than a sample.
pub fn samples(flag: &str, seconds: f64, rate_hz: f64) -> Result<usize, Failure> {
    let samples = (seconds * rate_hz).round();
    if (1.0..1e9).contains(&samples) {
        return Ok(samples as usize);
    }
    let expected = format!("at least a sample, {} s", 1.0 / rate_hz);
    Err(Failure::Usage(format!("{flag}: found {seconds}, expected {expected}; correct it")))
}
