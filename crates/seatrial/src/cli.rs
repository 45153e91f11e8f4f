//! Flags that all stages share, and how a stage runs.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use artifact::{Provenance, Shard};
use clap::error::ErrorKind;
use clap::{Args, Parser, ValueEnum};
use serde_json::{Value, json};

use crate::failure::Failure;

/// Flags of every stage.
#[derive(Clone, Debug, Args)]
pub struct Common {
    /// Where to write: the main file, or a folder for files under their usual names
    #[arg(long, value_name = "PATH")]
    pub out: PathBuf,
    /// Threads to use (default: all cores); results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// Replaces the seed of the configuration
    #[arg(long, value_name = "SEED")]
    pub seed: Option<u64>,
    /// No progress on stderr
    #[arg(long)]
    pub quiet: bool,
    /// One JSON object on stdout instead of a summary line
    #[arg(long)]
    pub json: bool,
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
    /// Whether files are to be gathered instead of computed.
    pub fn gathers(&self) -> bool {
        !self.gather.is_empty()
    }
}

/// The value of a flag that clap requires unless files are gathered.
///
/// # Errors
/// Usage, naming the flag.
pub fn given<'a>(path: &'a Option<PathBuf>, flag: &str) -> Result<&'a Path, Failure> {
    path.as_deref()
        .ok_or_else(|| Failure::Usage(format!("--{flag}: found none, expected a path; name the file")))
}

impl Common {
    /// The main output: `--out`, or `name` in it where it is a folder. It may be none of `inputs`.
    ///
    /// # Errors
    /// Usage, naming the input that would be overwritten.
    pub fn main_output(&self, name: &str, inputs: &[&Path]) -> Result<PathBuf, Failure> {
        let folder = self.out.is_dir() || self.out.as_os_str().to_string_lossy().ends_with('/');
        let out = if folder { self.out.join(name) } else { self.out.clone() };
        let Ok(existing) = out.canonicalize() else { return Ok(out) };
        match inputs.iter().find(|input| input.canonicalize().is_ok_and(|path| path == existing)) {
            None => Ok(out),
            Some(input) => Err(Failure::Usage(format!(
                "--out: found {}, which is also an input, expected another file; name another output",
                input.display()
            ))),
        }
    }
}

/// What a choice is called on the command line and in files.
pub fn name_of(choice: impl ValueEnum) -> String {
    choice.to_possible_value().map_or(String::new(), |value| value.get_name().to_owned())
}

/// `name` beside `main`.
pub fn beside(main: &Path, name: &str) -> PathBuf {
    main.parent().unwrap_or(Path::new("")).join(name)
}

/// Provenance of what stage `stage` writes, without inputs and settings yet.
pub fn provenance(stage: &str) -> Provenance {
    Provenance { producer: format!("{stage} {}", env!("CARGO_PKG_VERSION")), ..Provenance::default() }
}

/// What a stage says when it is done.
pub struct Summary {
    /// One line for people.
    pub line: String,
    /// The same for programs.
    pub json: Value,
}

/// Runs a stage: parses its arguments, starts its threads, prints its summary or its failure.
pub fn run<A: Parser>(
    common: impl Fn(&A) -> &Common,
    stage: impl FnOnce(&A) -> Result<Summary, Failure>,
) -> ExitCode {
    run_from(std::env::args_os(), common, stage)
}

/// [`run`] of a command line of one's own; its first word is the program.
pub fn run_from<A: Parser>(
    words: impl IntoIterator<Item = OsString>,
    common: impl Fn(&A) -> &Common,
    stage: impl FnOnce(&A) -> Result<Summary, Failure>,
) -> ExitCode {
    let arguments = match A::try_parse_from(words) {
        Ok(arguments) => arguments,
        Err(error) => return usage(&error),
    };
    let (json, threads) = (common(&arguments).json, common(&arguments).threads);
    let result = start_threads(threads).and_then(|()| stage(&arguments));
    match result {
        Ok(summary) if json => println!("{}", summary.json),
        Ok(summary) => println!("{}", summary.line),
        Err(failure) => {
            tell(&failure, json);
            return ExitCode::from(failure.exit_code());
        }
    }
    ExitCode::SUCCESS
}

/// Prints the help that was asked for, or what is wrong with the command line, in one line.
fn usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        // Whoever closed the pipe has read enough.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    let failure = match error.kind() {
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            Failure::Usage("subcommand: found none, expected one; see --help".to_owned())
        }
        _ => Failure::Usage(one_line(&error.render().to_string())),
    };
    tell(&failure, std::env::args_os().any(|argument| argument == "--json"));
    ExitCode::from(failure.exit_code())
}

/// What stands in clap's `message` above its usage.
fn one_line(message: &str) -> String {
    let above = message.split("\n\nUsage:").next().unwrap_or_default();
    let above = above.split("\n\nFor more information").next().unwrap_or_default();
    let words: Vec<&str> = above.trim_start_matches("error: ").split_whitespace().collect();
    format!("{}; see --help", words.join(" "))
}

fn tell(failure: &Failure, json: bool) {
    eprintln!("error: {failure}");
    if json {
        println!("{}", json!({"exit_code": failure.exit_code(), "error": failure.to_string()}));
    }
}

fn start_threads(threads: Option<u32>) -> Result<(), Failure> {
    let builder = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0) as usize);
    builder.build_global().map_err(|e| Failure::Failed(format!("threads: {e}")))
}
