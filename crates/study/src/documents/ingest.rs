//! Measured and simulated logs: `ingest.json` and `simulated.json`.

use std::collections::BTreeMap;

use files::{Digest, Document, Units};
use logs::chain::{Entry, Hits};
use logs::{Omission, Omissions};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::Vessel;

use crate::tables::trajectories::DataLabel;
use crate::written::logs_file::LogsFile;

pub use logs::{
    ChannelSummary, ManeuverCount, MotionSummary, RecordingSummary, RowSummary, State, WarningKind,
    WarningSummary,
};

/// `ingest.json`: what log files became, and how good their data are.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IngestDocument {
    /// Name of the vessel that the channels were chosen for, if one was named.
    pub vessel: Option<String>,
    /// Name of the design that the runs belong to.
    pub design: String,
    /// What the logs are where they are not those of a real ship.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data: Option<DataLabel>,
    /// What positions and velocities are those of.
    pub reference_point: Option<String>,
    /// The common rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Number of runs.
    pub runs: u64,
    /// Samples of all runs.
    pub samples: u64,
    /// The maneuvers, in the order of appearance.
    pub maneuvers: Vec<ManeuverCount>,
    /// One entry per recording, in the order of names.
    pub recordings: Vec<RecordingSummary>,
}

/// A channel whose range over all recordings is below this share of its size never varies.
const STEADY: f64 = 1e-3;

impl IngestDocument {
    /// By number of a run, the name of the recording that it was cut from.
    pub fn recordings_by_run(&self) -> BTreeMap<i32, String> {
        let named = |r: &RecordingSummary| {
            let name = r.name.clone();
            r.runs.iter().map(move |run| (*run as i32, name.clone())).collect::<Vec<_>>()
        };
        self.recordings.iter().flat_map(named).collect()
    }

    /// The omitted values of all recordings.
    pub fn omitted(&self) -> Omissions {
        let mut omitted = Omissions::default();
        for Omission { channel, reason, count } in self.recordings.iter().flat_map(|r| &r.omitted) {
            omitted.add(channel, *reason, *count);
        }
        omitted
    }

    /// `n` at 10.23 1/s, for every channel that is constant and not 0 over all recordings.
    pub fn constant_channels(&self) -> Vec<String> {
        let channels = || self.recordings.iter().flat_map(|r| &r.channels);
        let constant = |channel: &&ChannelSummary| {
            let recorded = || channels().filter(|c| c.name == channel.name);
            let low = recorded().filter_map(|c| c.min).fold(f64::INFINITY, f64::min);
            let high = recorded().filter_map(|c| c.max).fold(f64::NEG_INFINITY, f64::max);
            let size = low.abs().max(high.abs());
            recorded().count() == self.recordings.len() && size > 0.0 && high - low < STEADY * size
        };
        let named = |c: &ChannelSummary| format!("`{}` at {:.4} {}", c.name, c.max.unwrap_or(0.0), c.unit);
        self.recordings
            .first()
            .map_or(Vec::new(), |r| r.channels.iter().filter(constant).map(named).collect())
    }
}

impl Document for IngestDocument {
    const ID: &'static str = "ingest";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("Hz", "sample_rate_hz rate_hz"),
        ("1", "runs samples segments splits short_segments rows missing gaps gain count"),
        ("s", "duration_s left_out_s lag_s"),
        ("unit of the channel", "noise min max"),
        ("m/s; rad/s for r", "rms robust_std bias"),
    ];
}

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
