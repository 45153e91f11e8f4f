//! `ingest.toml`.

use logs::{Body, Frame, Heading, Law, Method, NonMonotonic, TimeUnit};
use serde::Deserialize;

/// `ingest.toml` as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IngestFile {
    /// Name of the design that the runs belong to.
    #[serde(default = "measured")]
    pub design: String,
    /// The common rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Channels are not interpolated over longer gaps: the recording is split there \[s\].
    pub max_gap_s: f64,
    /// Every channel is averaged over this long before it is resampled \[s\].
    pub average_s: Option<f64>,
    /// What to do where time goes backwards.
    #[serde(default)]
    pub non_monotonic: NonMonotonic,
    /// Axes of `x` and `y`.
    #[serde(default)]
    pub frame: Frame,
    /// How `psi` counts, if not as in `frame`.
    pub heading: Option<Heading>,
    /// Axes of `y_u`, `y_v`, `y_r`.
    #[serde(default)]
    pub body: Body,
    /// The antenna, or whatever positions and velocities were measured at, from the reference point: forward, to starboard
    /// \[m\].
    #[serde(default)]
    pub antenna_m: [f64; 2],
    /// What the trajectories' positions and velocities are those of, in words.
    pub reference_point: Option<String>,
    /// How velocities are made from positions.
    #[serde(default)]
    pub velocities: VelocitySpec,
    /// Files, one group per kind of file.
    pub file: Vec<FileSpec>,
    /// Computed channels.
    #[serde(default)]
    pub derived: Vec<DerivedSpec>,
    /// Thrusters, whose forces make up `tau1`, `tau2`, `tau3`.
    #[serde(default)]
    pub thruster: Vec<ThrusterSpec>,
    /// The maneuver of all recordings.
    pub maneuver: Option<String>,
    /// Template that finds `{kind}` in a file's name, or in its path where the template has a `/`.
    pub maneuver_from_file: Option<String>,
    /// Sub-experiments are windows of this length \[s\] …
    pub window_s: Option<f64>,
    /// … named by kind and class of mean speed, with these bounds \[m/s\].
    #[serde(default)]
    pub speed_classes_m_s: Vec<f64>,
    /// Names of the speed classes, one more than bounds.
    pub speed_class_names: Option<Vec<String>>,
    /// Sub-experiments by time.
    #[serde(default)]
    pub segment: Vec<SegmentSpec>,
    /// Shorter sub-experiments are left out \[s\].
    pub min_s: Option<f64>,
    /// Whether every sub-experiment becomes a run of its own.
    #[serde(default)]
    pub each_segment_is_a_run: bool,
}

fn measured() -> String {
    "measured".to_owned()
}

/// How velocities are made from positions.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VelocitySpec {
    /// Explicit Euler differences, or slopes of local parabolas.
    #[serde(default)]
    pub method: Method,
    /// Length of the parabolas \[s\]; also of those that measured velocities are compared with.
    #[serde(default = "one_second")]
    pub window_s: f64,
}

fn one_second() -> f64 {
    1.0
}

impl Default for VelocitySpec {
    fn default() -> Self {
        Self { method: Method::default(), window_s: one_second() }
    }
}

/// Files of one kind.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileSpec {
    /// Patterns with `*`, relative to the folder of the logs.
    pub pattern: Vec<String>,
    /// Template that finds `{run}` in a file's name (in its path where it has a `/`): files of several groups with the
    /// same `{run}` are one recording. Without it each file is a recording, named as the file.
    pub run_from_file: Option<String>,
    /// Separator of CSV files.
    #[serde(default = "comma")]
    pub separator: char,
    /// Column with labels of sub-experiments.
    pub label_column: Option<String>,
    /// The clock.
    pub time: TimeSpec,
    /// The channels.
    #[serde(default)]
    pub channel: Vec<ChannelSpec>,
}

fn comma() -> char {
    ','
}

/// The clock of a kind of files.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeSpec {
    /// Its column.
    pub column: String,
    /// What it counts.
    pub unit: TimeUnit,
    /// Added to the clock \[s\].
    #[serde(default)]
    pub offset_s: f64,
}

/// A channel: `sign` · `scale` · (the column, converted) + `offset`, `delay_s` earlier.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelSpec {
    /// The column it is in.
    pub column: String,
    /// Its name: `y_u`, `y_v`, `y_r`, `x`, `y`, `psi`, `latitude_deg`, `longitude_deg`, or one of the vessel's, or any other.
    pub channel: String,
    /// Unit in the file.
    pub unit: String,
    /// 1 or -1.
    #[serde(default = "one")]
    pub sign: f64,
    /// A further factor.
    #[serde(default = "one")]
    pub scale: f64,
    /// Added last, in SI units and radians.
    #[serde(default)]
    pub offset: f64,
    /// The sensor's delay \[s\]: what stands at time t happened at t − delay.
    #[serde(default)]
    pub delay_s: f64,
    /// Its own longest gap \[s\].
    pub max_gap_s: Option<f64>,
    /// Whether it may be absent at some samples; for channels that the vessel does not need.
    #[serde(default)]
    pub optional: bool,
}

fn one() -> f64 {
    1.0
}

/// A channel computed from others.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DerivedSpec {
    /// Its name.
    pub channel: String,
    /// A product, such as `negative(n)` or `-1 wind^2 cos(gamma)`.
    pub formula: String,
    /// Its unit.
    pub unit: String,
}

/// A thruster. Axes: x forward, y starboard, z down.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum ThrusterSpec {
    /// Turns about the vertical.
    Azimuth {
        /// Channel of its speed.
        speed: String,
        /// Channel of its angle: where it pushes, from forward to starboard.
        angle: String,
        /// Force per speed squared, or per speed \[N\].
        coefficient: f64,
        /// Force from speed.
        #[serde(default)]
        law: Law,
        /// Forward and to starboard of the reference point \[m\].
        position_m: [f64; 2],
    },
    /// Pushes to starboard for positive speed.
    Tunnel {
        /// Channel of its speed.
        speed: String,
        /// Force per speed squared, or per speed \[N\].
        coefficient: f64,
        /// Force from speed.
        #[serde(default)]
        law: Law,
        /// Forward and to starboard of the reference point \[m\].
        position_m: [f64; 2],
    },
}

/// A sub-experiment by time.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SegmentSpec {
    /// Name of the recording.
    pub run: String,
    /// Where it begins, from the recording's first row \[s\].
    pub from_s: f64,
    /// Where it ends \[s\].
    pub to_s: f64,
    /// Its maneuver.
    pub maneuver: String,
}
