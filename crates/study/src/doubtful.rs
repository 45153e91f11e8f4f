//! Recordings of logs that are inconsistent, or of which much was left out: they are not used for estimates by
//! default.

use std::collections::BTreeMap;
use std::path::Path;

use files::{Error, Provenance};
use serde_json::json;

use crate::documents::RecordingSummary;

/// Name of the setting with them.
const DOUBTFUL: &str = "doubtful";

/// The numbers of their runs, by the recordings' names. They are in the settings of trajectories and of the results
/// from these.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Doubtful(BTreeMap<String, Vec<i32>>);

impl Doubtful {
    /// The doubtful ones of `recordings`.
    pub fn among(recordings: &[RecordingSummary]) -> Self {
        let doubtful = recordings.iter().filter(|recording| !recording.doubtful.is_empty());
        let runs = |recording: &RecordingSummary| recording.runs.iter().map(|run| *run as i32).collect();
        Self(doubtful.map(|recording| (recording.name.clone(), runs(recording))).collect())
    }

    /// The doubtful recordings in `provenance`.
    pub fn of(provenance: &Provenance) -> Self {
        let noted = provenance.settings.get(DOUBTFUL).cloned();
        Self(noted.and_then(|noted| serde_json::from_value(noted).ok()).unwrap_or_default())
    }

    /// Notes them, if there are any, in `provenance`.
    pub fn note(&self, provenance: &mut Provenance) {
        if !self.0.is_empty() {
            provenance.settings.insert(DOUBTFUL.to_owned(), json!(self.0));
        }
    }

    /// Their names.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// Refuses an estimate from runs of `file`, if one of these is `used`.
    ///
    /// # Errors
    /// Names the recording.
    pub fn check(&self, file: &Path, used: impl Fn(i32) -> bool) -> Result<(), Error> {
        let found: Vec<&str> = self
            .0
            .iter()
            .filter(|(_, runs)| runs.iter().any(|run| used(*run)))
            .map(|(name, _)| name.as_str())
            .collect();
        let Some(first) = found.first() else { return Ok(()) };
        let more = if found.len() > 1 { format!(", as in {} more", found.len() - 1) } else { String::new() };
        Err(Error::refuse(
            file,
            format!("recording `{first}`"),
            format!(
                "much that was left out, or a motion that contradicts itself{more}: see `doubtful` in ingest.json"
            ),
            "logs that agree with themselves",
            "correct the logs or ingest.toml, leave the recording out, or add --allow-doubtful",
        ))
    }
}
