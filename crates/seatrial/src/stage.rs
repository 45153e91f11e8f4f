//! A stage as a program: its command line, how it runs and how it ends.

use std::ffi::OsString;
use std::process::ExitCode;

use clap::builder::Resettable;
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Args, Command, CommandFactory, FromArgMatches, Parser, Subcommand};
use serde_json::{Value, json};

use crate::cli::Common;
use crate::failure::Failure;

/// What every help ends with.
const EXIT_CODES: &str = "Exit codes: 0 written, 1 failed, 2 wrong usage, 3 input refused, 4 no answer";

/// What a stage says when it is done.
pub struct Summary {
    /// One line for people.
    pub line: String,
    /// The same for programs.
    pub json: Value,
}

/// A command line that was parsed.
pub trait Task {
    /// The flags that all stages share.
    fn common(&self) -> &Common;

    /// Reads, calls the science, writes.
    ///
    /// # Errors
    /// Whatever leaves nothing written.
    fn run(&self) -> Result<Summary, Failure>;
}

/// A stage: its command line and what that becomes.
pub struct Stage {
    command: fn() -> Command,
    parse: fn(&ArgMatches) -> Result<Box<dyn Task>, clap::Error>,
}

impl Stage {
    /// The stage with the command line `A`.
    pub const fn of<A: Parser + Task + 'static>() -> Self {
        Self { command: A::command, parse: |matches| Ok(Box::new(A::from_arg_matches(matches)?)) }
    }

    /// Its command line.
    pub fn command(&self) -> Command {
        dressed((self.command)())
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
        match (self.parse)(matches) {
            Ok(task) => run(&*task),
            Err(error) => usage(&error),
        }
    }
}

/// A stage with flags of its own and with subcommands.
pub enum Either<A, S> {
    /// Without a subcommand.
    Alone(A),
    /// With one.
    Sub(S),
}

impl<A: Parser, S: Subcommand> Parser for Either<A, S> {}

impl<A: Parser, S: Subcommand> CommandFactory for Either<A, S> {
    fn command() -> Command {
        let alone = A::command().subcommand_negates_reqs(true);
        let [about, long] = [alone.get_about(), alone.get_long_about()]
            .map(|text| text.cloned().map_or(Resettable::Reset, Resettable::Value));
        // The subcommands' own description would replace that of the stage.
        S::augment_subcommands(alone).about(about).long_about(long)
    }

    fn command_for_update() -> Command {
        Self::command()
    }
}

impl<A: Parser, S: Subcommand> FromArgMatches for Either<A, S> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        match matches.subcommand_name() {
            Some(_) => S::from_arg_matches(matches).map(Self::Sub),
            None => A::from_arg_matches(matches).map(Self::Alone),
        }
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl<A: Task, S: Task> Task for Either<A, S> {
    fn common(&self) -> &Common {
        match self {
            Self::Alone(a) => a.common(),
            Self::Sub(s) => s.common(),
        }
    }

    fn run(&self) -> Result<Summary, Failure> {
        match self {
            Self::Alone(a) => a.run(),
            Self::Sub(s) => s.run(),
        }
    }
}

/// `command` with what all have: the flags that may stand before a subcommand, the version and the exit codes.
pub fn dressed(command: Command) -> Command {
    let common = Common::augment_args(Command::new("common"));
    let missing: Vec<Arg> = common.get_arguments().filter(|arg| arg.is_global_set()).cloned().collect();
    let known: Vec<_> = command.get_arguments().map(|arg| arg.get_id().clone()).collect();
    let missing = missing.into_iter().filter(|arg| !known.contains(arg.get_id()));
    with_exit_codes(command.args(missing).version(env!("CARGO_PKG_VERSION")).propagate_version(true))
}

fn with_exit_codes(command: Command) -> Command {
    let own = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let own = own.strip_suffix(EXIT_CODES).unwrap_or(&own).trim_end();
    let gap = if own.is_empty() { "" } else { "\n\n" };
    let help = format!("{own}{gap}{EXIT_CODES}");
    command.after_help(help).mut_subcommands(with_exit_codes)
}

/// Parses `words`, the first of which is the program; or tells what is wrong with them.
///
/// # Errors
/// How the program ends: with the help or the version that was asked for, or with a refusal.
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

/// A flag of `command` itself before a subcommand, which would not see it.
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
pub fn run(task: &dyn Task) -> ExitCode {
    let common = task.common();
    match start_threads(common.threads).and_then(|()| task.run()) {
        Ok(summary) if common.json => println!("{}", summary.json),
        Ok(summary) => println!("{}", summary.line),
        Err(failure) => return ended(&failure, common.json),
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
    ended(&failure, asked_for_json())
}

/// Of a command line that could not be parsed.
fn asked_for_json() -> bool {
    std::env::args_os().any(|argument| argument == "--json")
}

/// What stands in clap's `message` above its usage.
fn one_line(message: &str) -> String {
    let above = message.split("\n\nUsage:").next().unwrap_or_default();
    let above = above.split("\n\nFor more information").next().unwrap_or_default();
    let words: Vec<&str> = above.trim_start_matches("error: ").split_whitespace().collect();
    format!("{}; see --help", words.join(" "))
}

/// Tells a failure.
pub fn ended(failure: &Failure, json: bool) -> ExitCode {
    eprintln!("error: {failure}");
    if json {
        println!("{}", json!({"exit_code": failure.exit_code(), "error": failure.to_string()}));
    }
    ExitCode::from(failure.exit_code())
}

fn start_threads(threads: Option<u32>) -> Result<(), Failure> {
    let builder = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0) as usize);
    builder.build_global().map_err(|e| Failure::Failed(format!("threads: {e}")))
}
