//! Logs as a ship's instruments would have written them, for studies whose real logs cannot be had.

use std::path::Path;

use artifact::{Provenance, Staged, commit, stage_document};
use logs::chain::{Entry, FORCES, Logbook, LogbookError, force_factors};
use study::documents::SimulatedLogsDocument;
use study::logs_file::LogsFile;
use vessel::{Generator, Source, Vessel};

use crate::cli::{beside, in_folder};
use crate::failure::Failure;

/// The hand-written files, for messages.
pub struct Files<'a> {
    /// `vessel.toml`.
    pub vessel: &'a Path,
    /// `dictionary.toml`.
    pub dictionary: &'a Path,
    /// `logs.toml`.
    pub logs: &'a Path,
}

/// Simulates the logs that `config` asks for.
///
/// # Errors
/// What [`LogsFile::check`] refuses, a vessel without true parameters or without the forces of azimuth thrusters for
/// inputs; see [`Logbook`].
pub fn simulate(
    files: &Files,
    vessel: &Vessel,
    generator: &Generator,
    config: &LogsFile,
    seed: u64,
) -> Result<Vec<Entry>, Failure> {
    let names: Vec<&str> = generator.maneuvers().iter().map(|m| m.name.as_str()).collect();
    config.check(&names, vessel.sample_rate_hz).map_err(|e| Failure::invalid(files.logs, &e))?;
    let parameters = vessel.parameters(Source::Value).map_err(|e| Failure::invalid(files.vessel, &e))?;
    let entries = || {
        let chain = config.chain(vessel, &parameters, force_factors(vessel)?);
        Logbook::new(chain, generator, config.schedule(), seed)?.entries()
    };
    entries().map_err(|error| failure(files, error))
}

fn failure(files: &Files, error: LogbookError) -> Failure {
    match error {
        LogbookError::Inputs(found) => {
            let expected = "tau1 [N], tau2 [N], tau3 [N m], the forces of azimuth thrusters";
            let found = found.join(", ");
            Failure::refuse(files.vessel, "[[input]]", &found, expected, "simulate another vessel")
        }
        LogbookError::Name(name) => {
            let expected = "letters, digits, - and . alone, for the name of a log";
            let thing = format!("maneuver `{name}`");
            Failure::refuse(files.dictionary, &thing, "another character", expected, "rename it")
        }
        LogbookError::Maneuver(invalid) => Failure::invalid(files.dictionary, &invalid),
        LogbookError::Diverged { maneuver, repeat, at } => Failure::invalid(
            files.vessel,
            &at.invalid(format!("model in log {repeat} of maneuver `{maneuver}`")),
        ),
        LogbookError::Unreachable { maneuver, sample, what } => {
            let (force, unit) = FORCES[what.force.min(2)];
            let found = format!(
                "thrusters that make {force} = {:.4} {unit} where maneuver `{maneuver}` needs {:.4} at sample {sample}",
                what.made, what.wanted
            );
            let expected = "thrusters that can make surge, sway and yaw together";
            let remedy = "add a thruster elsewhere, or couple the inputs with `follows`";
            Failure::refuse(files.logs, "[[thruster]]", &found, expected, remedy)
        }
    }
}

/// Writes the logs and, beside them, `out`: all or nothing.
///
/// # Errors
/// Output that fails.
pub fn publish(
    out: &Path,
    entries: &[Entry],
    document: &SimulatedLogsDocument,
    provenance: &Provenance,
) -> Result<(), Failure> {
    in_folder(out.parent().unwrap_or(Path::new("")), || {
        let mut files = Vec::with_capacity(entries.len() + 1);
        for (entry, recording) in entries.iter().zip(&document.recordings) {
            files.push(Staged::bytes(beside(out, &recording.file), entry.text.as_bytes())?);
        }
        files.push(stage_document(out, provenance, document)?);
        Ok(commit(files)?)
    })
}
