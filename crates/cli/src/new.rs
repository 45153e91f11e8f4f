//! `new`: the hand-written files of a study.

use std::path::PathBuf;

use artifact::{Staged, commit};
use clap::Parser;
use pipeline::starting::{PRESETS, Preset, measured, schemas, simulated};
use serde_json::json;

use crate::cli::{Common, in_folder};
use crate::failure::Failure;
use crate::stage::{Summary, Task};

/// Writes the commented files of a new study: of a ship that is known, or of your logs
#[derive(Parser)]
#[command(name = "new", after_help = help())]
pub struct Arguments {
    /// Folder of the study; made here
    #[arg(value_name = "FOLDER")]
    out: PathBuf,
    /// The ship to begin with: its model, and what it may be asked for
    #[arg(long, value_name = "PRESET")]
    vessel: String,
    /// Folder of logs in CSV: what is in them is guessed, and what was guessed is marked
    #[arg(long, value_name = "FOLDER")]
    logs: Option<PathBuf>,
}

/// The presets and an example.
fn help() -> String {
    let presets = PRESETS.iter().map(|own| format!("{}: {}\n", own.name, own.about));
    format!("Presets:\n{}\nExample:\n  new my-study --vessel model-ship", presets.collect::<String>())
}

impl Task for Arguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let out = &common.out;
        let preset = Preset::named(&self.vessel).map_err(|e| Failure::Usage(format!("--vessel: {e}")))?;
        if out.symlink_metadata().is_ok() {
            let found = "it there already";
            return Err(Failure::refuse(
                out,
                "folder",
                found,
                "a new folder",
                "name another, or run this one",
            ));
        }
        let (files, said) = match &self.logs {
            None => (simulated(preset), String::new()),
            Some(logs) => {
                let (files, looked) = measured(preset, logs)?;
                let (guessed, missing) = (looked.guessed(), looked.missing().len());
                (
                    files,
                    format!(
                        "; {} logs, {guessed} lines guessed, {missing} channels missing",
                        looked.files.len()
                    ),
                )
            }
        };
        let schemas = schemas();
        in_folder(out, || {
            in_folder(&out.join("schemas"), || {
                let all = files.iter().chain(&schemas);
                let staged = all.map(|(name, text)| Staged::bytes(out.join(name), text.as_bytes()));
                Ok(commit(staged.collect::<Result<_, _>>()?)?)
            })
        })?;
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        let line = format!("{}{said}; next: seatrial run {}", names.join(", "), out.display());
        Ok(Summary::of(out, line, json!({"files": names})))
    }
}
