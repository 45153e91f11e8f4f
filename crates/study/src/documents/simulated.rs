use files::{Digest, Document, Units};
use logs::chain::{Entry, Hits};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::Vessel;

use crate::logs_file::LogsFile;
use crate::trajectories::DataLabel;

/// Name of the document that seals simulated logs, in the same folder.
pub const SIMULATED_FILE: &str = "simulated.json";

/// `simulated.json`: seals a folder of simulated logs, and labels them as what they are.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SimulatedLogsDocument {
    /// As everything that is made of them is labelled.
    pub label: DataLabel,
    /// Name of the vessel.
    pub vessel: String,
    /// Rows per second.
    pub sample_rate_hz: f64,
    /// Samples per sub-experiment that velocities from differences have; two rows more are logged.
    pub samples: u64,
    /// One per file.
    pub recordings: Vec<SimulatedRecording>,
    /// Limits that were hit, in words.
    pub statements: Vec<String>,
}

/// One simulated log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SimulatedRecording {
    /// Its file, beside this document.
    pub file: String,
    /// BLAKE3 of the file.
    pub digest: Digest,
    /// Its maneuver.
    pub maneuver: String,
    /// Its number among the maneuver's, from 1.
    pub repeat: u64,
    /// Whether it is run to the other side.
    pub mirrored: bool,
    /// The day.
    pub day: String,
    /// Heading at the start of the log.
    pub heading: f64,
    /// Share of the samples at which each thruster could not follow its command.
    pub limited: Vec<f64>,
}

impl SimulatedLogsDocument {
    /// The document of the logs of `vessel` by `config`.
    pub fn of(vessel: &Vessel, config: &LogsFile, entries: &[Entry]) -> Self {
        Self {
            label: DataLabel::SimulatedLogs,
            vessel: vessel.name.clone(),
            sample_rate_hz: vessel.sample_rate_hz,
            samples: u64::from(config.samples),
            recordings: entries.iter().map(SimulatedRecording::from).collect(),
            statements: (0..config.thruster.len()).flat_map(|i| statements(i, entries)).collect(),
        }
    }
}

impl From<&Entry> for SimulatedRecording {
    fn from(entry: &Entry) -> Self {
        Self {
            file: format!("{}_{:02}.csv", entry.maneuver, entry.repeat),
            digest: Digest::of_bytes(entry.text.as_bytes()),
            maneuver: entry.maneuver.clone(),
            repeat: u64::from(entry.repeat),
            mirrored: entry.mirrored,
            day: entry.day.clone(),
            heading: entry.heading,
            limited: entry.limited.clone(),
        }
    }
}

/// The number of hits of one limit.
type Count = fn(&Hits) -> usize;

/// The limits that thruster `i` reached.
fn statements(i: usize, entries: &[Entry]) -> Vec<String> {
    let limits: [(&str, Count); 3] = [
        ("highest speed", |hits| hits.speed),
        ("fastest change of speed", |hits| hits.speed_rate),
        ("fastest turn", |hits| hits.angle_rate),
    ];
    let statement = |(limit, count): (&str, Count)| {
        let each = || entries.iter().map(|entry| count(&entry.hits[i])).filter(|count| *count > 0);
        let (samples, logs) = (each().sum::<usize>(), each().count());
        let text =
            || format!("thruster {} was held at its {limit} at {samples} samples of {logs} logs", i + 1);
        (logs > 0).then(text)
    };
    limits.into_iter().filter_map(statement).collect()
}

impl Document for SimulatedLogsDocument {
    const ID: &'static str = "simulated-logs";
    const VERSION: u32 = 1;
    const UNITS: Units = &[("Hz", "sample_rate_hz"), ("1", "samples repeat limited"), ("rad", "heading")];
}
