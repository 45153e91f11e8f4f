use artifact::{Digest, Document};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `simulated.json`: seals a folder of simulated logs, and labels them as what they are.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SimulatedLogsDocument {
    /// `simulated logs`, as everything that is made of them is labelled.
    pub label: String,
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

impl Document for SimulatedLogsDocument {
    const ID: &'static str = "simulated-logs";
    const VERSION: u32 = 1;
    const UNITS: &'static [(&'static str, &'static str)] =
        &[("sample_rate_hz", "Hz"), ("samples", "1"), ("repeat", "1"), ("heading", "rad"), ("limited", "1")];
}
