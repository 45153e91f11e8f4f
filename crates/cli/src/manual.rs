//! Shell completions and manual pages of a command line.

use std::io::Write;
use std::path::Path;

use clap::Command;
use clap_complete::Shell;
use clap_mangen::Man;
use files::{Staged, commit};

use crate::failure::Failure;
use crate::said::{on_stdout, printed};

/// Prints the completions of `command` for `shell`.
///
/// # Errors
/// Output that fails.
pub fn completions(shell: Option<Shell>, mut command: Command) -> Result<(), Failure> {
    let (mut script, name) = (Vec::new(), command.get_name().to_owned());
    if let Some(shell) = shell {
        clap_complete::generate(shell, &mut command, name, &mut script);
    }
    printed(std::io::stdout().write_all(&script))
}

/// Writes the manual pages of `command` and its subcommands into `folder`.
///
/// # Errors
/// Output that fails.
pub fn manual(folder: &Path, command: Command) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|e| files::Error::io(folder, "create", e))?;
    let mut command = without_help(command);
    command.build();
    let mut staged = Vec::new();
    pages(&command, folder, &mut staged)?;
    let count = staged.len();
    commit(staged)?;
    on_stdout(format_args!("{}: {count} pages", folder.display()))
}

/// `command` without the subcommands that print help, which pages are in place of.
fn without_help(command: Command) -> Command {
    command.disable_help_subcommand(true).mut_subcommands(without_help)
}

/// A page for `command` and each of its subcommands.
fn pages(command: &Command, folder: &Path, staged: &mut Vec<Staged>) -> Result<(), Failure> {
    let man = Man::new(command.clone());
    let mut page = Vec::new();
    man.render(&mut page).map_err(|e| Failure::Failed(format!("{}: {e}", man.get_filename())))?;
    staged.push(Staged::bytes(folder.join(man.get_filename()), &page)?);
    let mut others = command.get_subcommands().filter(|own| own.get_name() != "help");
    others.try_for_each(|own| pages(own, folder, staged))
}
