//! Simulated logs, sealed and labelled by `simulated.json` next to them.

use std::path::Path;

use files::{Digest, Error, Provenance, exists, read_document};
use logs::Source;

use crate::documents::{SIMULATED_FILE, SimulatedLogsDocument};
use crate::trajectories::DataLabel;

/// The label of the logs in `folder` if they are simulated: then each of `sources` must be unchanged, and its digest
/// is noted.
///
/// # Errors
/// A log that was changed, or that the document does not list.
pub fn simulated_label(
    folder: &Path,
    sources: &[Source],
    provenance: &mut Provenance,
) -> Result<Option<DataLabel>, Error> {
    let path = folder.join(SIMULATED_FILE);
    if !exists(&path) {
        return Ok(None);
    }
    let loaded = read_document::<SimulatedLogsDocument>(&path)?;
    for file in sources.iter().flat_map(|source| source.files.iter().flatten()) {
        let log = folder.join(file);
        let listed = loaded.data.recordings.iter().find(|recording| recording.file == *file);
        let expected = match listed {
            Some(recording) if recording.digest == Digest::of_file(&log)? => continue,
            Some(_) => "the log as it was simulated",
            None => "one of the logs that were simulated together",
        };
        let found = if listed.is_some() { "another digest" } else { "a log that is not listed" };
        let remedy = "simulate the logs again into an empty folder, or keep other logs elsewhere";
        let expected = format!("{expected}, as {} says", path.display());
        return Err(crate::refuse(&log, "simulated log", found, &expected, remedy));
    }
    provenance.made("simulated", &path, loaded.digest, &loaded.provenance)?;
    Ok(Some(loaded.data.label))
}
