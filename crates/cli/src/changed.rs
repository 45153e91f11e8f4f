//! Checks that the files that `--set` changes are named on the command line.

use std::path::Path;

use clap::{Arg, ArgMatches, Command};
use files::{Change, Changes};
use refusal::Invalid;

use crate::failure::Failure;

/// The hand-written files that a folder given as `--study` may contain.
const IN_STUDIES: [&str; 4] = ["vessel", "dictionary", "campaign", "reference"];

/// Those that the stages of a whole study read together; each stage is told those of its own.
const IN_RUNS: [&str; 7] = ["vessel", "dictionary", "campaign", "reference", "plan", "ingest", "logs"];

/// Refuses `changes` of a file that `matches` of `command` do not name, and a key that is given twice: a change
/// without effect would go unnoticed.
///
/// # Errors
/// A usage error that suggests the nearest file.
pub fn check_changes(command: &Command, matches: &ArgMatches, changes: &[Change]) -> Result<(), Failure> {
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
    let own = names.filter_map(|name| name.strip_suffix(".toml")).map(str::to_owned);
    if json { Vec::new() } else { own.collect() }
}
