//! `seatrial verify`: checks that the files in a folder are complete and belong together, and shows their
//! dependencies.

use std::path::PathBuf;

use crate::pipeline::{Folders, Record};
use clap::Parser;
use study::folder::Folder;

use crate::failure::{Failure, on_stdout};

/// Checks that files are whole and belong together, and prints what was made of what
#[derive(Parser)]
#[command(
    name = "verify",
    after_help = "A file that is not in the folder is shown by its role alone; name the hand-written ones with --study.\n\n\
    Example:\n  verify out/paper --study pipelines/paper"
)]
pub struct Verify {
    /// Folders that the stages wrote into, with those below them
    #[arg(required = true, value_name = "FOLDER")]
    folders: Vec<PathBuf>,
    /// Folder of the hand-written files, where the folders are of one study
    #[arg(long, value_name = "FOLDER")]
    study: Option<PathBuf>,
}

impl Verify {
    /// Prints the graph and the errors.
    ///
    /// # Errors
    /// A folder that cannot be listed or has nothing to verify; files that are damaged or do not belong together.
    pub fn run(&self) -> Result<(), Failure> {
        for root in &self.folders {
            let mut folder = Folder::read(root, self.study.as_deref())?;
            if let Some(study) = &self.study {
                let folders = Folders { study: study.clone(), out: root.clone() };
                folder.faults.extend(Record::read(root, String::new(), None).faults(&folders));
            }
            folder.lines(root).into_iter().try_for_each(on_stdout)?;
            folder.faults.iter().try_for_each(|fault| on_stdout(format_args!("fault: {fault}")))?;
            let (files, faults) = (folder.count(), folder.faults.len());
            if faults > 0 {
                let (found, expected) =
                    (format!("{faults} faults in {files} files"), "whole files of one study");
                return Err(Failure::refuse(
                    root,
                    "files",
                    &found,
                    expected,
                    "make again what is named above",
                ));
            }
            on_stdout(format_args!("{}: {files} files, whole and of one study", root.display()))?;
        }
        Ok(())
    }
}
