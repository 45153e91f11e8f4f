use std::collections::BTreeMap;

use files::{Document, Units};
pub use logs::{
    ChannelSummary, ManeuverCount, MotionSummary, RecordingSummary, RowSummary, State, WarningKind,
    WarningSummary,
};
use logs::{Omission, Omissions};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::trajectories::DataLabel;

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
            let own = || channels().filter(|c| c.name == channel.name);
            let low = own().filter_map(|c| c.min).fold(f64::INFINITY, f64::min);
            let high = own().filter_map(|c| c.max).fold(f64::NEG_INFINITY, f64::max);
            let size = low.abs().max(high.abs());
            own().count() == self.recordings.len() && size > 0.0 && high - low < STEADY * size
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
