//! A stage as a program: its command line, how it runs and how it ends.

use std::ffi::OsString;
use std::fmt::Display;
use std::path::Path;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Args, Command, CommandFactory, FromArgMatches, Parser};
use files::fault::{Fault, inject};
use files::{Change, Changes};
use refusal::{Invalid, with_remedy};
use serde_json::{Value, json};

use crate::cli::{Common, set_budget};
use crate::failure::{Failure, on_stderr, on_stdout, printed};

/// The end of every help.
const EXIT_CODES: &str = "Also --threads, --seed, --allow, --set, --quiet, --json, --memory-mib, as every stage: see --help\n\
     Exit codes: 0 written, 1 failed, 2 wrong usage, 3 input refused, 4 no answer, 128 + N ended by signal N";

/// The result of a stage.
pub struct Summary {
    /// One line for people.
    pub line: String,
    /// The same for programs.
    pub json: Value,
}

impl Summary {
    /// The summary of the output `out`: `said` for people, the entries of `details` for programs.
    pub fn of(out: &Path, said: impl Display, details: Value) -> Self {
        let mut json = json!({"out": out.to_string_lossy()});
        if let (Value::Object(all), Value::Object(more)) = (&mut json, details) {
            all.extend(more);
        }
        Self { line: format!("{}: {said}", out.display()), json }
    }

    /// The same with a remark for people.
    pub(crate) fn also(mut self, remark: Option<String>) -> Self {
        self.line.extend(remark.map(|remark| format!("; {remark}")));
        self
    }
}

/// The flags of a stage, parsed.
pub trait Task {
    /// Reads, calls the other crates, writes.
    fn run(&self, common: &Common) -> Result<Summary, Failure>;
}

/// A stage: its command line and task, or its subcommands.
pub struct Stage {
    command: fn() -> Command,
    parse: fn(&ArgMatches) -> Result<Box<dyn Task>, clap::Error>,
    below: &'static [Stage],
}

impl Stage {
    /// The stage with the flags of `A` and those that all stages share.
    pub const fn of<A: Parser + Task + 'static>() -> Self {
        Self {
            command: || with_missing(A::command(), common_flags()),
            parse: |matches| Ok(Box::new(A::from_arg_matches(matches)?)),
            below: &[],
        }
    }

    /// A group of the stages `below`, with the help of `A`.
    pub const fn group<A: CommandFactory>(below: &'static [Self]) -> Self {
        let command = || A::command().subcommand_required(true).arg_required_else_help(true);
        Self { command, parse: |_| Err(clap::Error::new(ErrorKind::MissingSubcommand)), below }
    }

    /// The stage with `below` as its subcommands.
    pub const fn with(self, below: &'static [Self]) -> Self {
        Self { below, ..self }
    }

    /// Its command line.
    pub fn command(&self) -> Command {
        dressed(self.bare())
    }

    /// Its command line and subcommands, without the additions of [`dressed`].
    fn bare(&self) -> Command {
        let command = (self.command)().subcommands(self.below.iter().map(Self::bare));
        let alone = !command.is_subcommand_required_set();
        command.subcommand_negates_reqs(alone && !self.below.is_empty())
    }

    /// The program of this stage alone.
    pub fn main(&self) -> ExitCode {
        match matches(&mut self.command(), std::env::args_os()) {
            Ok(matches) => self.run(&matches),
            Err(code) => code,
        }
    }

    /// Runs what was parsed with [`Stage::command`].
    pub fn run(&self, matches: &ArgMatches) -> ExitCode {
        match self.task(matches) {
            Ok((task, common)) => run(&*task, &common),
            Err(failure) => ended(&failure, asked_for_json()),
        }
    }

    /// The task that `matches` of [`Stage::command`] ask for.
    pub fn task(&self, matches: &ArgMatches) -> Result<(Box<dyn Task>, Common), Failure> {
        if let Some((stage, below)) = self.chosen(matches) {
            return stage.task(below);
        }
        let parsed = (self.parse)(matches).and_then(|task| Ok((task, Common::from_arg_matches(matches)?)));
        let (task, common) = parsed.map_err(|error| misused(&error))?;
        check_changes(&(self.command)(), matches, &common.set)?;
        Ok((task, common))
    }

    /// Whether the command line of `matches` names the file of `change`.
    pub fn takes(&self, matches: &ArgMatches, change: &Change) -> bool {
        match self.chosen(matches) {
            Some((stage, below)) => stage.takes(below, change),
            None => check_changes(&(self.command)(), matches, std::slice::from_ref(change)).is_ok(),
        }
    }

    /// The stage below this one that `matches` name, and its part of them.
    fn chosen<'a>(&self, matches: &'a ArgMatches) -> Option<(&'static Self, &'a ArgMatches)> {
        let (name, below) = matches.subcommand()?;
        Some((self.below.iter().find(|stage| stage.bare().get_name() == name)?, below))
    }
}

/// The flags that all stages share, listed after a command's own, those that may precede it by the long help alone.
fn common_flags() -> Vec<Arg> {
    let all = Common::augment_args(Command::new("common"));
    let shown = |arg: &Arg| arg.clone().display_order(None).hide_short_help(arg.is_global_set());
    all.get_arguments().map(shown).collect()
}

/// `command` with those of `flags` that it does not have yet.
fn with_missing(command: Command, flags: Vec<Arg>) -> Command {
    let known: Vec<_> = command.get_arguments().map(|arg| arg.get_id().clone()).collect();
    command.args(flags.into_iter().filter(|arg| !known.contains(arg.get_id())))
}

/// `command` with the common parts: the flags that may precede a subcommand, the version and the exit codes.
pub fn dressed(command: Command) -> Command {
    let command = with_missing(command, common_flags().into_iter().filter(Arg::is_global_set).collect());
    with_exit_codes(command.version(env!("CARGO_PKG_VERSION")).propagate_version(true))
}

fn with_exit_codes(command: Command) -> Command {
    let examples = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let examples = examples.strip_suffix(EXIT_CODES).unwrap_or(&examples).trim_end();
    let gap = if examples.is_empty() { "" } else { "\n\n" };
    let help = format!("{examples}{gap}{EXIT_CODES}");
    // A negative number is a value that the flag's own bounds refuse, no unknown flag.
    let command = command.mut_args(|arg| match arg.get_action().takes_values() {
        true => arg.allow_negative_numbers(true),
        false => arg,
    });
    command.after_help(help).mut_subcommands(with_exit_codes)
}

/// Parses `words`, the first of which is the program, or reports what is wrong with them.
pub fn matches(
    command: &mut Command,
    words: impl IntoIterator<Item = OsString>,
) -> Result<ArgMatches, ExitCode> {
    let matches = command.try_get_matches_from_mut(words).map_err(|error| usage(&error))?;
    match misplaced(command, &matches) {
        None => Ok(matches),
        Some(failure) => Err(ended(&failure, asked_for_json())),
    }
}

/// Refuses a flag of `command` itself before a subcommand, which would ignore it.
fn misplaced(command: &Command, matches: &ArgMatches) -> Option<Failure> {
    let (name, below) = matches.subcommand()?;
    let given = |arg: &&Arg| matches.value_source(arg.get_id().as_str()) == Some(ValueSource::CommandLine);
    let flag = command.get_arguments().filter(|arg| !arg.is_global_set()).find(given);
    match flag.and_then(Arg::get_long) {
        Some(flag) => Some(Failure::Usage(format!(
            "--{flag}: found it before `{name}`, expected it after; write {} {name} --{flag}",
            command.get_name()
        ))),
        None => misplaced(command.find_subcommand(name)?, below),
    }
}

/// Starts the threads, runs `task`, prints its summary or its failure.
pub fn run(task: &dyn Task, common: &Common) -> ExitCode {
    inject_fault();
    tell_panics_of_our_own();
    listen();
    set_budget(common.memory_mib);
    let done =
        check_processor(common).and_then(|()| start_threads(common.threads)).and_then(|()| task.run(common));
    let print = |summary: Summary| match common.json {
        true => on_stdout(summary.json),
        false => on_stdout(summary.line),
    };
    match done.and_then(print) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => ended(&failure, common.json),
    }
}

/// Says that a processor has no instructions for the loops over lanes; refuses it where they were compiled for no other.
fn check_processor(common: &Common) -> Result<(), Failure> {
    let Some(missing) = numerics::missing_instructions() else { return Ok(()) };
    if cfg!(debug_assertions) {
        let expected = "them, as x86-64 processors have them since 2013; build it with --release";
        return Err(Failure::Failed(format!("processor: found no {missing}, expected {expected}")));
    }
    if !common.quiet {
        on_stderr(format!(
            "this processor lacks {missing}: the results are the same, and take several times as long"
        ));
    }
    Ok(())
}

/// Prints the requested help, or what is wrong with the command line, in one line.
fn usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        return match printed(error.print()) {
            Ok(()) => ExitCode::SUCCESS,
            Err(failure) => ended(&failure, false),
        };
    }
    ended(&misused(error), asked_for_json())
}

/// What is wrong with the command line, in one line.
pub fn misused(error: &clap::Error) -> Failure {
    match error.kind() {
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            Failure::Usage("subcommand: found none, expected one; see --help".to_owned())
        }
        _ => {
            let line = one_line(&error.render().to_string());
            let kinds = [ContextKind::InvalidArg, ContextKind::InvalidValue, ContextKind::InvalidSubcommand];
            let [flag, value, command] = kinds.map(|kind| match error.get(kind) {
                Some(ContextValue::String(named)) => named.as_str(),
                _ => "",
            });
            let flag = flag.split(' ').next().unwrap_or_default();
            let named = [flag, value, command, &format!("{flag} {value}")];
            Failure::Usage(match named.into_iter().find_map(refusal::gone) {
                Some(remedy) => {
                    let above = line.split(" tip: ").next().unwrap_or_default();
                    format!("{}; {remedy}", above.trim_end_matches("; see --help"))
                }
                None => line,
            })
        }
    }
}

/// Whether a command line that could not be parsed has `--json`.
fn asked_for_json() -> bool {
    std::env::args_os().any(|argument| argument == "--json")
}

/// The part of clap's `message` above its usage.
fn one_line(message: &str) -> String {
    let above = message.split("\n\nUsage:").next().unwrap_or_default();
    let above = above.split("\n\nFor more information").next().unwrap_or_default();
    // What stands behind `--` is no value of a flag, and refused in turn.
    let above = above.split("\n\n  tip: to pass ").next().unwrap_or_default();
    let words: Vec<&str> = above.trim_start_matches("error: ").split_whitespace().collect();
    let text = words.join(" ").replace("invalid digit found in string", "expected a whole number from 0 on");
    format!("{text}; see --help")
}

/// Maximum number of characters of a message.
const LONGEST: usize = 490;

/// Reports a failure.
pub fn ended(failure: &Failure, json: bool) -> ExitCode {
    let message = with_remedy(&failure.to_string(), LONGEST);
    on_stderr(format_args!("error: {message}"));
    if json {
        let _ = on_stdout(json!({"exit_code": failure.exit_code(), "error": message}));
    }
    ExitCode::from(failure.exit_code())
}

/// Silences panics of decoders on damaged files, which the refusal reports; their own message would be a second one.
fn tell_panics_of_our_own() {
    let default_hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !files::decoding() {
            default_hook(panic);
        }
    }));
}

fn start_threads(threads: Option<u32>) -> Result<(), Failure> {
    let builder = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0) as usize);
    builder.build_global().map_err(|e| Failure::Failed(format!("threads: {e}")))
}

/// Injects faults into writing for tests: `SEATRIAL_FAULT=kill:3` ends the process at the third place. Release builds
/// ignore it.
fn inject_fault() {
    let wanted = std::env::var("SEATRIAL_FAULT").unwrap_or_default();
    let parsed = wanted.split_once(':').and_then(|(kind, count)| Some((kind, count.parse().ok()?)));
    if let (Some((kind, count)), true) = (parsed, cfg!(debug_assertions)) {
        inject(if kind == "kill" { Fault::Kill } else { Fault::Error }, count);
    }
}

/// Installs the handler, so that signals first remove unfinished files.
#[cfg(unix)]
fn listen() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    // Without a handler the signal ends the process as usual; the next start removes the files that it leaves.
    let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGHUP]) else { return };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            end_by(signal);
        }
    });
}

#[cfg(not(unix))]
fn listen() {
    // As after SIGINT elsewhere
    let _ = ctrlc::set_handler(|| end_by(2));
}

/// Removes unfinished files, and ends the process as after `signal`.
fn end_by(signal: i32) -> ! {
    files::abandon();
    crate::compiler::abandon();
    on_stderr("error: interrupted");
    std::process::exit(128 + signal);
}

/// The hand-written files that a folder given as `--study` may contain.
const IN_STUDIES: [&str; 4] = ["vessel", "dictionary", "campaign", "reference"];

/// Those that the stages of a whole study read together; each stage is told those of its own.
const IN_RUNS: [&str; 8] =
    ["study", "vessel", "dictionary", "campaign", "reference", "plan", "ingest", "logs"];

/// Refuses `changes` of a file that `matches` of `command` do not name, and a key that is given twice: a change
/// without effect would go unnoticed.
fn check_changes(command: &Command, matches: &ArgMatches, changes: &[Change]) -> Result<(), Failure> {
    let usage = |invalid: Invalid| Err(Failure::Usage(format!("--set: {invalid}")));
    let files: Vec<String> = command.get_arguments().flat_map(|arg| named(arg, matches)).collect();
    let known = || files.iter().map(String::as_str);
    match changes.iter().find(|change| !files.iter().any(|file| file == change.file())) {
        Some(change) if files.is_empty() => {
            let (expected, remedy) =
                ("no change, for no TOML file is named here", "remove it, or name the file");
            usage(Invalid::new("file", format!("`{}`", change.file()), expected, remedy))
        }
        Some(change) => usage(Invalid::unknown("file", change.file(), known())),
        None => Changes::new(changes.to_vec()).map_or_else(usage, |_| Ok(())),
    }
}

/// Usual names, without `.toml`, of the hand-written files that `arg` was given.
fn named(arg: &Arg, matches: &ArgMatches) -> Vec<String> {
    let given = matches.try_get_raw(arg.get_id().as_str()).ok().flatten().and_then(|mut given| given.next());
    let Some(given) = given else { return Vec::new() };
    if arg.get_id() == "study" {
        return IN_STUDIES.map(str::to_owned).to_vec();
    }
    if arg.get_id() == "whole_study" {
        return IN_RUNS.map(str::to_owned).to_vec();
    }
    let json = Path::new(given).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    let names = arg.get_value_names().unwrap_or_default().iter().flat_map(|name| name.split('|'));
    let files = names.filter_map(|name| name.strip_suffix(".toml")).map(str::to_owned);
    if json { Vec::new() } else { files.collect() }
}
