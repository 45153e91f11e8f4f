//! Flags that all stages share.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use estimation::Estimator;
use estimation::runs::{AdditionalUnknowns, Intercepts, UnknownCurrent};
use files::{Change, Changes, PROGRAM_BYTES, Provenance, Shard};
use plan::lattice::{Options, Progress};
use plan::voyage::Watch;
use serde_json::{Value, json};
use study::check_kind;

use crate::failure::{Failure, on_stderr};

pub use files::{budget, set_budget};
pub use study::beside;

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
    /// Accepts what is refused otherwise; the outputs say so
    #[arg(long, global = true, value_name = "LIST", value_delimiter = ',', value_parser = allowance(&[Allowed::Mixed]))]
    pub allow: Vec<Allowed>,
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

refusal::choices! {
    /// What else is refused.
    pub enum Allowed {
        /// Files of different studies together.
        Mixed = "mixed",
        /// Recordings that ingest.json calls doubtful.
        Doubtful = "doubtful",
        /// Inputs and motions that the logs of a model from logs do not cover.
        BeyondRange = "beyond-range",
        /// Maneuvers that miss what they are called: a heading, a speed, a turn beyond `tolerance`.
        Unreached = "unreached",
        /// A plan whose check runs aground or breaks the margin.
        Unsafe = "unsafe",
    }
}

/// The parser of those that a stage can let pass.
pub fn allowance(all: &'static [Allowed]) -> impl TypedValueParser<Value = Allowed> {
    choice(all, Allowed::name, Allowed::description)
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
            allow_mixed: self.allow.contains(&Allowed::Mixed),
            changes: self.changes(),
            ..Provenance::default()
        }
    }

    /// The main output: `--out`, or `name` in it if it is a folder. It must not be one of `inputs`, and its folder
    /// must exist, so that a missing folder is reported before the work.
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
    pub fn output_in_any_folder<I: AsRef<Path>>(
        &self,
        name: &str,
        inputs: impl IntoIterator<Item = I>,
    ) -> Result<PathBuf, Failure> {
        let folder =
            self.out.is_dir() || self.out.as_os_str().to_string_lossy().ends_with(std::path::is_separator);
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

/// The folder of `main`.
pub fn folder_of(main: &Path) -> &Path {
    main.parent().unwrap_or(Path::new(""))
}

/// Calls `write` with an existing `folder`: created if missing, and removed again if nothing was written.
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
pub fn only_folder_of(folder: &Path, names: &[String]) -> Result<(), Failure> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(files::Error::io(folder, "list", error).into()),
    };
    let there = entries.filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()));
    let mut others: Vec<String> =
        there.filter(|name| !name.starts_with('.') && !names.contains(name)).collect();
    others.sort();
    match others.first() {
        None => Ok(()),
        Some(other) => {
            let (other, expected) = (format!("`{other}` in it"), format!("none but {}", names.join(", ")));
            Err(Failure::refuse(folder, "folder", &other, &expected, "name another folder with --out"))
        }
    }
}

/// The largest number that a flag takes.
const LARGEST: f64 = 1e12;

/// Refuses a number that is not positive, or unreasonably large.
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
pub fn not_below(flag: &str, value: f64, least: f64) -> Result<f64, Failure> {
    if value.is_finite() && value >= least && value <= LARGEST {
        return Ok(value);
    }
    let most = if value > LARGEST { format!(" to {LARGEST:e}") } else { " on".to_owned() };
    Err(Failure::Usage(format!("{flag}: found {value:?}, expected a number from {least}{most}; correct it")))
}

/// Seconds in samples.
pub fn samples(flag: &str, seconds: f64, rate_hz: f64) -> Result<usize, Failure> {
    let samples = (seconds * rate_hz).round();
    if (1.0..1e9).contains(&samples) {
        return Ok(samples as usize);
    }
    let expected = format!("at least a sample, {} s", 1.0 / rate_hz);
    Err(Failure::Usage(format!("{flag}: found {seconds}, expected {expected}; correct it")))
}

/// Parses one of `all` by its name; `help` is its line in `--help`.
pub fn choice<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
    help: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let values = all.iter().map(|one| PossibleValue::new(name(*one)).help(help(*one)));
    PossibleValuesParser::new(values.collect::<Vec<_>>()).try_map(move |given| {
        let known = all.iter().copied().find(|one| name(*one) == given);
        known.ok_or_else(|| format!("unknown value {given}"))
    })
}

/// Share of the time for a search, so that the rest is left to check its plan.
const SEARCHED: f64 = 0.7;
/// The same if there is nothing to check.
const FOUND: f64 = 0.95;

/// The flags.
#[derive(Args)]
pub struct LimitFlags {
    /// Stop after this time, all phases counted, with a plan that is found in a moment and its gap, if there is one
    #[arg(long, value_name = "SECONDS")]
    time_limit_s: Option<f64>,
}

impl LimitFlags {
    /// The limits of the flags, starting now.
    pub fn limits(&self, common: &Common) -> Result<Limits, Failure> {
        let time = match self.time_limit_s {
            Some(s) if !(s.is_finite() && s > 0.0 && s < 1e9) => {
                let message = format!("--time-limit-s: found {s}, expected seconds above 0; correct it");
                return Err(Failure::Usage(message));
            }
            time => time.map(Duration::from_secs_f64),
        };
        Ok(Limits { memory_bytes: memory_bytes(common), started: Instant::now(), time, quiet: common.quiet })
    }
}

/// Memory of chart, lattice, search and check, without the program: by default no more than a fixed limit even if
/// more is available, since a search uses all that it may have, and a plan should not depend on the machine.
fn memory_bytes(common: &Common) -> u64 {
    let usual = common.memory_mib.map_or(Options::default().memory_bytes as f64, |_| f64::INFINITY);
    (budget().bytes().min(usual) as u64).saturating_sub(PROGRAM_BYTES)
}

/// Limits of a search.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Memory it may take \[bytes\].
    pub memory_bytes: u64,
    /// The start of all phases, for their common time limit.
    pub started: Instant,
    /// Time it may take.
    pub time: Option<Duration>,
    /// Whether to report no progress.
    pub quiet: bool,
}

impl Limits {
    /// As options of the search.
    pub fn options(&self) -> Options {
        Options { memory_bytes: self.memory_bytes, ..Options::default() }
    }

    /// Whether there is time left.
    pub fn keep_going(&self) -> bool {
        self.time.is_none_or(|time| self.started.elapsed() < time)
    }

    /// Limits of a search that leaves time to check what it finds.
    pub fn before_check(&self) -> Self {
        Self { time: self.time.map(|time| time.mul_f64(SEARCHED)), ..*self }
    }

    /// Limits of a search that leaves time to free its memory and to write its result.
    pub fn before_writing(&self) -> Self {
        Self { time: self.time.map(|time| time.mul_f64(FOUND)), ..*self }
    }

    /// A watch that stops the search when its time is over, and reports progress every few seconds.
    pub fn watch(&self) -> Watch {
        let limits = *self;
        let mut reported = Instant::now();
        Box::new(move |progress: Progress| {
            if !limits.quiet && reported.elapsed() > Duration::from_secs(2) {
                reported = Instant::now();
                let bound = progress.lower_bound.primary;
                let seconds = limits.started.elapsed().as_secs_f64();
                on_stderr(format_args!("plan: {seconds:.0} s, at least {bound}"));
            }
            limits.keep_going()
        })
    }
}

/// The flags.
#[derive(Args, Clone, Copy, Debug)]
pub struct AdditionalFlags {
    /// Forces that stay, as unknowns of `output-error` and `prediction-error`
    #[arg(long, value_parser = choice(&Intercepts::ALL, Intercepts::name, Intercepts::description), default_value_t = Intercepts::Each)]
    intercepts: Intercepts,
    /// A current of every run, as two more unknowns of `output-error`
    #[arg(long, value_name = "AXES", value_parser = choice(&UnknownCurrent::ALL, UnknownCurrent::name, UnknownCurrent::description), default_value_t = UnknownCurrent::None)]
    unknown_current: UnknownCurrent,
}

impl AdditionalFlags {
    /// The unknowns of the flags.
    pub fn unknown(self) -> AdditionalUnknowns {
        AdditionalUnknowns { intercepts: self.intercepts, current: self.unknown_current }
    }

    /// Refuses flags that none of the `estimators` uses.
    pub fn check(self, estimators: &[Estimator]) -> Result<(), Failure> {
        let simulated = estimators.contains(&Estimator::OutputError);
        let searched = estimators.iter().any(|estimator| estimator.searches());
        let asked = estimators.iter().map(|e| e.name()).collect::<Vec<_>>().join(", ");
        if self.unknown_current != UnknownCurrent::None && !simulated {
            return Err(Failure::Usage(format!(
                "--unknown-current {} is for `output-error`: found {asked}; add it to --estimator or leave the flag out",
                self.unknown_current
            )));
        }
        if self.intercepts != Intercepts::Each && !searched {
            return Err(Failure::Usage(format!(
                "--intercepts {} is for `output-error` and `prediction-error`: found {asked}; --mean-removal is for the others",
                self.intercepts
            )));
        }
        Ok(())
    }

    /// Notes values that are not the default.
    pub fn note(self, settings: &mut BTreeMap<String, Value>) {
        let (usual, AdditionalUnknowns { intercepts, current }) =
            (AdditionalUnknowns::default(), self.unknown());
        if intercepts != usual.intercepts {
            settings.insert("intercepts".into(), json!(intercepts));
        }
        if current != usual.current {
            settings.insert("unknown_current".into(), json!(current));
        }
    }
}
