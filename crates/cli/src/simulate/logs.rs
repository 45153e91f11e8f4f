//! Logs as a ship's instruments would write them, for studies without access to the real logs.

use std::path::Path;

use files::{Provenance, Staged, Work, commit, stage_set_document};
use logs::chain::{Entry, Fault, Logbook, NoLogs, force_factors};
use maneuver::Generator;
use ship::model::{Source, Vessel};
use study::documents::SimulatedLogsDocument;
use study::logs_file::LogsFile;

use crate::cli::{budget, folder_of, in_folder};
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

/// Simulates the logs of `config`.
///
/// # Errors
/// Those of [`LogsFile::check`], a vessel without true parameters or without the forces of azimuth thrusters as
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
    check_room(files.logs, config, &names, vessel.sample_rate_hz)?;
    let parameters = vessel.parameters(Source::Value).map_err(|e| Failure::invalid(files.vessel, &e))?;
    let entries = || {
        let chain = config.chain(vessel, &parameters, force_factors(vessel)?);
        Logbook::new(chain, generator, config.schedule(), seed)?.entries()
    };
    entries().map_err(|NoLogs { fault, what }| {
        let file = match fault {
            Fault::Vessel => files.vessel,
            Fault::Maneuvers => files.dictionary,
            Fault::Thrusters => files.logs,
        };
        Failure::invalid(file, &what)
    })
}

/// Refuses logs that do not fit into memory, where all are held until they are written.
fn check_room(file: &Path, config: &LogsFile, maneuvers: &[&str], rate_hz: f64) -> Result<(), Failure> {
    /// Characters of a cell with its separator.
    const CELL: f64 = 14.0;
    let rows = config.rows(maneuvers, rate_hz);
    let cells = rows * (4 + 2 * config.thruster.len()) as f64;
    let (found, remedy) = (format!("logs of {rows} rows"), "take fewer `repeats` or `samples`");
    Ok(budget().memory(Work { file, thing: "`repeats`", found: &found, remedy }, CELL * cells)?)
}

/// Writes the logs and `out` next to them: all or nothing.
///
/// # Errors
/// Output that fails.
pub fn publish(
    out: &Path,
    entries: &[Entry],
    document: &SimulatedLogsDocument,
    provenance: &Provenance,
) -> Result<(), Failure> {
    in_folder(folder_of(out), || {
        let mut files = Vec::with_capacity(entries.len() + 1);
        for (entry, recording) in entries.iter().zip(&document.recordings) {
            files.push(Staged::bytes(folder_of(out).join(&recording.file), entry.text.as_bytes())?);
        }
        files.push(stage_set_document(out, provenance, document, &files)?);
        Ok(commit(files)?)
    })
}
