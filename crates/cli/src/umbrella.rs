//! `seatrial`: every stage as a subcommand, with completions and manual pages.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::manual::{completions, manual};
use crate::verify::Verify;
use clap::{Arg, Command, CommandFactory, FromArgMatches, value_parser};
use clap_complete::Shell;

use crate::cli::set_budget;
use crate::commands::STAGES;
use crate::failure::Failure;
use crate::stage::Stage;
use crate::stage::{dressed, ended, matches};
use crate::{new, run, ships};

/// The program `seatrial`.
pub fn main() -> ExitCode {
    let mut command = command();
    let matches = match matches(&mut command, std::env::args_os()) {
        Ok(matches) => matches,
        Err(code) => return code,
    };
    let done = match matches.subcommand() {
        Some(("completions", own)) => completions(own.get_one("shell").copied(), command),
        Some(("verify", own)) => {
            Verify::from_arg_matches(own).map_err(|e| Failure::Usage(e.to_string())).and_then(|verify| {
                set_budget(own.get_one("memory_mib").copied());
                verify.run()
            })
        }
        Some(("manual", own)) => {
            manual(own.get_one("folder").map_or(Path::new("."), PathBuf::as_path), command)
        }
        Some((name, own)) => {
            let stage = subcommands().find(|stage| stage.command().get_name() == name);
            return stage.map_or(ExitCode::FAILURE, |stage| stage.run(own));
        }
        None => Ok(()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => ended(&failure, false),
    }
}

/// What begins a study, and what runs all of it.
const OWN: [Stage; 4] = [
    Stage::of::<new::Arguments>(),
    Stage::of::<ships::Guess>(),
    Stage::of::<ships::Scale>(),
    Stage::of::<run::Arguments>(),
];

/// The program's own subcommands that write files, and the stages.
fn subcommands() -> impl Iterator<Item = &'static Stage> {
    OWN.iter().chain(STAGES)
}

/// Its command line.
pub fn command() -> Command {
    let shell = Arg::new("shell").required(true).value_parser(value_parser!(Shell)).help("The shell");
    let completions = Command::new("completions")
        .about("Prints what a shell completes this program's command lines with")
        .arg(shell)
        .after_help("Example:\n  completions bash > ~/.local/share/bash-completion/completions/seatrial");
    let folder = Arg::new("folder").required(true).value_name("FOLDER").value_parser(value_parser!(PathBuf));
    let manual = Command::new("manual")
        .about("Writes the manual pages of this program and its subcommands")
        .arg(folder.help("Where to write them; made if there is none"))
        .after_help("Example:\n  manual ~/.local/share/man/man1/");
    let all = Command::new("seatrial")
        .about("Plans the shortest sea trial that identifies a ship's manoeuvring model")
        .after_help(
            "Example:\n  simulate dictionary --vessel pipelines/smoke/vessel.toml \
            --dictionary pipelines/smoke/dictionary.toml --out dictionary.parquet",
        )
        .subcommand_required(true)
        .arg_required_else_help(true)
        .subcommands(subcommands().map(Stage::command))
        .subcommands([Verify::command(), completions, manual]);
    named(dressed(all))
}

/// `command` with examples that begin with `seatrial`.
fn named(command: Command) -> Command {
    let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let lines = help.lines().map(|line| match line.strip_prefix("  ") {
        Some(example) => format!("  seatrial {example}"),
        None => line.to_owned(),
    });
    let help = lines.collect::<Vec<_>>().join("\n");
    command.after_help(help).mut_subcommands(named)
}
