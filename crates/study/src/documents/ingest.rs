use std::collections::BTreeMap;
use std::fmt;

use artifact::{Document, Units};
use logs::{ChannelQuality, Oddity, Recorded, RowCounts, Source, Warning};
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

/// How much there is of a maneuver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ManeuverCount {
    /// Its name.
    pub name: String,
    /// Number of segments.
    pub segments: u64,
    /// Their samples.
    pub samples: u64,
}

/// The files that were recorded together.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordingSummary {
    /// Its name.
    pub name: String,
    /// Its files, relative to the folder of the logs.
    pub files: Vec<String>,
    /// Numbers of the runs made of it.
    pub runs: Vec<u64>,
    /// From the moment at which all needed channels have begun to the end of the first that ends, in whole samples \[s\].
    pub duration_s: f64,
    /// Samples of its runs.
    pub samples: u64,
    /// Segments of its runs.
    pub segments: u64,
    /// Gaps that split it.
    pub splits: u64,
    /// Segments that were left out for being too short.
    pub short_segments: u64,
    /// Rows of its files.
    pub rows: RowSummary,
    /// Its channels, measured and computed, on their own clocks.
    pub channels: Vec<ChannelSummary>,
    /// Measured velocities beside the derivatives of position and heading, where there are both.
    pub motion: Vec<MotionSummary>,
    /// What is odd about its channels.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<WarningSummary>,
}

/// Something odd about a channel that does not hinder its use.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WarningSummary {
    /// What is odd.
    pub kind: WarningKind,
    /// The channel.
    pub channel: String,
    /// How often.
    pub count: u64,
    /// In words.
    pub text: String,
}

/// What is odd about a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum WarningKind {
    /// It has one value.
    Constant,
    /// It may be in another unit.
    Unit,
    /// It is logged less often than the common rate.
    Rate,
    /// It jumps.
    Jump,
}

/// Rows that were read, and left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RowSummary {
    /// All rows.
    pub read: u64,
    /// Left out: no value at all.
    pub empty: u64,
    /// Left out: cut short at the end of the file.
    pub cut: u64,
    /// Left out: no time.
    pub without_time: u64,
    /// Left out: the time of an earlier row.
    pub repeated: u64,
    /// Earlier than a row before: left out or put in order, as `non_monotonic` says.
    pub backwards: u64,
}

/// One channel of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChannelSummary {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The inverse of the median step.
    pub rate_hz: Option<f64>,
    /// Rows without a value.
    pub missing: u64,
    /// Gaps longer than `max_gap_s`.
    pub gaps: u64,
    /// Robust standard deviation of what parabolas through 11 neighbours leave.
    pub noise: Option<f64>,
    /// Smallest value.
    pub min: Option<f64>,
    /// Largest value.
    pub max: Option<f64>,
}

/// A measured velocity beside the derivative of position or heading.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionSummary {
    /// The velocity.
    pub state: State,
    /// Root mean square of measured − derivative.
    pub rms: f64,
    /// Robust standard deviation of measured − derivative: where it is far below `rms`, a few jumps of the position make up
    /// most of that.
    pub robust_std: f64,
    /// Mean of measured − derivative.
    pub bias: f64,
    /// By how much the measured velocity is late; null where there is too little motion to tell. Where a filter and no pure
    /// delay is behind it, it depends on `velocities.window_s`.
    pub lag_s: Option<f64>,
    /// Slope of the line of measured over derivative, 1 where both are in the same unit; null where they are not correlated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
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
        let told = |c: &ChannelSummary| format!("`{}` at {:.4} {}", c.name, c.max.unwrap_or(0.0), c.unit);
        self.recordings.first().map_or(Vec::new(), |r| r.channels.iter().filter(constant).map(told).collect())
    }
}

/// A velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// Surge.
    U,
    /// Sway.
    V,
    /// Yaw rate.
    R,
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

impl RecordingSummary {
    /// What became of `source`; its runs have their numbers.
    pub fn of(source: &Source, recorded: &Recorded) -> Self {
        let Recorded { runs, quality, .. } = recorded;
        let states = [State::U, State::V, State::R].into_iter().zip(quality.motion);
        let motion = |(state, found): (State, Option<logs::Consistency>)| {
            let logs::Consistency { rms, robust_std, bias, lag_s, gain } = found?;
            Some(MotionSummary { state, rms, robust_std, bias, lag_s, gain })
        };
        Self {
            name: source.name.clone(),
            files: source.files.clone(),
            runs: runs.iter().map(|run| run.run as u64).collect(),
            duration_s: quality.duration_s,
            samples: runs.iter().map(|run| run.samples() as u64).sum(),
            segments: runs.iter().map(|run| run.segments.len() as u64).sum(),
            splits: quality.splits as u64,
            short_segments: quality.short as u64,
            rows: quality.rows.into(),
            channels: quality.channels.iter().map(ChannelSummary::from).collect(),
            motion: states.filter_map(motion).collect(),
            warnings: quality.warnings.iter().map(WarningSummary::from).collect(),
        }
    }
}

impl From<&ChannelQuality> for ChannelSummary {
    fn from(channel: &ChannelQuality) -> Self {
        Self {
            name: channel.name.clone(),
            unit: channel.unit.clone(),
            rate_hz: channel.rate_hz,
            missing: channel.missing as u64,
            gaps: channel.gaps as u64,
            noise: channel.noise,
            min: channel.min,
            max: channel.max,
        }
    }
}

impl From<RowCounts> for RowSummary {
    fn from(rows: RowCounts) -> Self {
        Self {
            read: rows.read as u64,
            empty: rows.empty as u64,
            cut: rows.cut as u64,
            without_time: rows.without_time as u64,
            repeated: rows.repeated as u64,
            backwards: rows.backwards as u64,
        }
    }
}

impl From<&logs::ManeuverCount> for ManeuverCount {
    fn from(count: &logs::ManeuverCount) -> Self {
        Self { name: count.name.clone(), segments: count.segments as u64, samples: count.samples as u64 }
    }
}

impl From<&Warning> for WarningSummary {
    fn from(Warning { channel, oddity }: &Warning) -> Self {
        use WarningKind::{Constant, Jump, Rate, Unit};
        let (kind, count, text) = match oddity {
            Oddity::Constant(value) => (Constant, 1, format!("is {value} throughout")),
            Oddity::BeyondTurn(rad) => {
                (Unit, 1, format!("reaches {rad:.1} rad, more than a turn: it may be in degrees"))
            }
            Oddity::WithinTurn(deg) => (Unit, 1, format!("stays within {deg:.2} deg: it may be in radians")),
            Oddity::Slow { own_hz, common_hz } => {
                (Rate, 1, format!("is logged at {own_hz:.3} Hz and interpolated to {common_hz} Hz"))
            }
            Oddity::Jumps { count, above } => (
                Jump,
                *count as u64,
                format!("jumps by more than {:.1} deg {count} times", above.to_degrees()),
            ),
        };
        Self { kind, channel: channel.clone(), count, text: format!("`{channel}` {text}") }
    }
}

impl Document for IngestDocument {
    const ID: &'static str = "ingest";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("Hz", "sample_rate_hz rate_hz"),
        ("1", "runs samples segments splits short_segments rows missing gaps gain count"),
        ("s", "duration_s lag_s"),
        ("unit of the channel", "noise min max"),
        ("m/s; rad/s for r", "rms robust_std bias"),
    ];
}
