use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::nmea::Accepted;
use crate::{Body, Conventions, NonMonotonic, Repeated, TimeUnit};

/// How the logs of a ship were made.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The file that holds these settings, as messages name it.
    pub written_in: &'static str,
    /// Kinds of files; a recording has files of each.
    pub files: Vec<FileSpec>,
    /// How channels become trajectories.
    pub conventions: Conventions,
    /// Channels are not interpolated over longer gaps \[s\].
    pub max_gap_s: f64,
    /// What to do where time goes backwards.
    pub non_monotonic: NonMonotonic,
    /// The speed that the ship does not exceed \[m/s\].
    pub max_speed_m_s: f64,
}

/// Files of one kind.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileSpec {
    /// Patterns with `*`, relative to the folder of the logs.
    pub pattern: Vec<String>,
    /// Template that finds `{run}` in a file's name (in its path where it has a `/`): files with the same `{run}` are one
    /// recording. Those of one group are its parts, in the order of their numbers or of their times. Without it each file is a recording, named as the
    /// file.
    pub run_from_file: Option<String>,
    /// Whether recordings may lack files of this kind: their channels are then absent, and a warning says so. For channels
    /// that the vessel does not need.
    #[serde(default)]
    pub optional: bool,
    /// What the files are, if not as their names end: `.parquet`, `.mcap`, `.bag`, `.db3`, `.ulg`, `.nmea`, all
    /// others CSV; all but Parquet and `.db3` may be `.gz` too.
    pub format: Option<Format>,
    /// Topic of a bag.
    pub topic: Option<String>,
    /// Who publishes the topic, where several do: the number of its channel, or a value of its metadata, such as a callerid;
    /// in a ULog the number of the instance.
    pub publisher: Option<String>,
    /// Share of sentences whose checksum may be wrong: they are left out and counted.
    #[serde(default = "hundredth")]
    #[schemars(range(min = 0.0, max = 1.0), extend("x-expected" = "a share from 0 to 1"))]
    pub max_wrong_checksums: f64,
    /// Whether sentences need a checksum; also optional where `max_wrong_checksums` is 1.
    #[serde(default)]
    pub checksums: Checksums,
    /// Talkers of sentences, such as `["HE", "GP"]`: where several send a channel, the first counts, and the next ones where
    /// it is silent for longer than the channel's `max_gap_s`. Without it several talkers are refused.
    #[serde(default)]
    pub prefer: Vec<String>,
    /// Sentences whose values count: fixes of GGA by number, modes of GNS, RMC, GLL, VTG and THS by letter. Without it all count
    /// but fixes 0, 6, 7, 8 and modes E, M, S, N, V.
    #[serde(default)]
    pub quality: Accepted,
    /// Separator of CSV files; a blank stands for any number of them.
    #[serde(default = "comma")]
    pub separator: char,
    /// What stands before the decimals in CSV files: `.` or `,`.
    #[serde(default = "point")]
    pub decimal: char,
    /// Lines of CSV files that come before the header, or before the rows where there is none.
    #[serde(default)]
    pub skip_lines: usize,
    /// Whether CSV files have a header; without one columns are called `1`, `2` and so on.
    #[serde(default = "yes")]
    pub header: bool,
    /// Number of columns of CSV files without a header.
    #[schemars(range(min = 1, max = 100000))]
    pub columns: Option<usize>,
    /// Column with labels of sub-experiments.
    pub label_column: Option<String>,
    /// The clock.
    pub time: TimeSpec,
    /// The channels.
    #[serde(default)]
    pub channel: Vec<ChannelSpec>,
    /// Attitudes as quaternions.
    #[serde(default)]
    pub quaternion: Vec<QuaternionSpec>,
}

fn comma() -> char {
    ','
}

fn point() -> char {
    '.'
}

fn yes() -> bool {
    true
}

/// How a log is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// Text with a row per line.
    Csv,
    /// Apache Parquet.
    Parquet,
    /// NMEA 0183, a sentence per line.
    Nmea,
    /// MCAP, of ROS 2 or with messages in JSON.
    Mcap,
    /// A bag of ROS 1.
    Bag,
    /// A bag of ROS 2 in SQLite.
    Db3,
    /// A ULog of PX4.
    Ulg,
}

impl Format {
    /// By the extension of a file, or of a pattern, in any case; CSV where it is none of those that others have.
    pub fn of(name: &str) -> Self {
        let name = name.strip_suffix(".gz").unwrap_or(name);
        // What a recorder that did not end leaves.
        let name = name.strip_suffix(".active").unwrap_or(name).trim_end_matches('*');
        let end = name.rsplit_once('.').map(|(_, end)| end.to_ascii_lowercase());
        match end.as_deref() {
            Some("parquet" | "parq" | "pq") => Self::Parquet,
            Some("nmea") => Self::Nmea,
            Some("mcap") => Self::Mcap,
            Some("bag") => Self::Bag,
            Some("db3") => Self::Db3,
            Some("ulg" | "ulog") => Self::Ulg,
            _ => Self::Csv,
        }
    }

    /// Whether it has topics, each with messages.
    pub fn is_bag(self) -> bool {
        matches!(self, Self::Mcap | Self::Bag | Self::Db3 | Self::Ulg)
    }
}

/// Whether sentences need a checksum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Checksums {
    /// Sentences without one are left out.
    #[default]
    Required,
    /// Sentences without one are read.
    Optional,
}

/// The clock of a kind of files.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeSpec {
    /// Its column. Of sentences: the kind that tells the time of those after it (`RMC`, `ZDA`, `GGA`, `GNS`, `GLL`), or
    /// `prefix` for what stands before each. Of bags: `log_time`, `publish_time` (MCAP alone), or a field; without a unit
    /// one that has `sec` and `nanosec`, such as `header.stamp`. Of a ULog: `timestamp`, in `us`.
    pub column: String,
    /// What it counts.
    pub unit: Option<TimeUnit>,
    /// How it is written where it is text, in the manner of strptime: `%Y/%m/%d %H:%M:%S%.f`, with `%:z` for an offset;
    /// in place of a unit.
    pub format: Option<String>,
    /// Where clocks showed the time where it is text without an offset: `Europe/Helsinki`, `+03:00`; UTC if it is not said.
    pub zone: Option<String>,
    /// Column with nanoseconds that are added to whole seconds.
    pub nanoseconds: Option<String>,
    /// What to do with rows that have the time of the row before.
    #[serde(default)]
    pub repeated: Repeated,
    /// Added to the clock \[s\].
    #[serde(default)]
    #[schemars(range(min = -1e12, max = 1e12))]
    pub offset_s: f64,
}

/// A channel: `sign` · `scale` · (the column, converted) + `offset`, `delay_s` earlier.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
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
    #[schemars(range(min = -1e15, max = 1e15))]
    pub scale: f64,
    /// Added last, in SI units and radians.
    #[serde(default)]
    #[schemars(range(min = -1e15, max = 1e15))]
    pub offset: f64,
    /// The sensor's delay \[s\]: what stands at time t happened at t − delay.
    #[serde(default)]
    #[schemars(range(min = -1e9, max = 1e9))]
    pub delay_s: f64,
    /// Its own longest gap \[s\].
    #[schemars(range(min = 1e-9, max = 1e9))]
    pub max_gap_s: Option<f64>,
    /// Numbers that stand for no value, as they stand in the column: `[-9999, 65535]`. Without it, numbers such as these that
    /// stand apart from their neighbours are left out; with it, even `[]`, only those in it are.
    pub missing: Option<Vec<f64>>,
    /// Least and greatest value, as numbers stand in the column; what is beyond is left out. Without it what is possible for a
    /// channel of its kind: the `range` of the vessel's input, or what [your own logs](own-logs.md#values-that-are-none) says.
    pub valid: Option<[f64; 2]>,
    /// Share of its values that may be left out as missing, out of range or not possible.
    #[serde(default = "fifth")]
    #[schemars(range(min = 0.0, max = 1.0), extend("x-expected" = "a share from 0 to 1"))]
    pub max_omitted: f64,
    /// Whether it may be absent at some samples; for channels that the vessel does not need.
    #[serde(default)]
    pub optional: bool,
}

/// An attitude as a quaternion w + x i + y j + z k, which turns body axes into those of the earth. Either from forward,
/// starboard, down to north, east, down, or from forward, port, up to east, north, up. It becomes channels for heading, roll
/// and pitch.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct QuaternionSpec {
    /// Column of its real part.
    pub w: String,
    /// Column of its part along the forward axis.
    pub x: String,
    /// Column of its part along the second axis.
    pub y: String,
    /// Column of its part along the vertical axis.
    pub z: String,
    /// Channel for the heading.
    #[serde(default = "psi")]
    pub heading: String,
    /// Channel for the roll, starboard side down.
    pub roll: Option<String>,
    /// Channel for the pitch, bow up.
    pub pitch: Option<String>,
    /// How far its length may be off 1.
    #[serde(default = "hundredth")]
    #[schemars(range(min = 1e-12, max = 1e3))]
    pub tolerance: f64,
    /// The sensor's delay \[s\].
    #[serde(default)]
    #[schemars(range(min = -1e9, max = 1e9))]
    pub delay_s: f64,
    /// Its own longest gap \[s\].
    #[schemars(range(min = 1e-9, max = 1e9))]
    pub max_gap_s: Option<f64>,
}

fn one() -> f64 {
    1.0
}

fn fifth() -> f64 {
    0.2
}

fn psi() -> String {
    "psi".to_owned()
}

fn hundredth() -> f64 {
    0.01
}

impl TimeSpec {
    /// Whether its decimals may be a whole number of nano- or microseconds.
    pub(crate) fn has_fractions(&self) -> bool {
        self.is_text() || self.unit == Some(TimeUnit::S) && self.nanoseconds.is_none()
    }

    /// Whether it is text.
    pub fn is_text(&self) -> bool {
        self.format.is_some() || self.unit == Some(TimeUnit::Iso8601)
    }
}

impl QuaternionSpec {
    /// Its columns, in order.
    pub(crate) fn columns(&self) -> [&String; 4] {
        [&self.w, &self.x, &self.y, &self.z]
    }

    /// The channels that are made of it, heading first.
    fn channels(&self, body: Body) -> impl Iterator<Item = ChannelSpec> {
        let angle = |channel: &String, sign, optional| ChannelSpec {
            column: format!("{}`, `{}`, `{}`, `{}", self.w, self.x, self.y, self.z),
            channel: channel.clone(),
            unit: "rad".to_owned(),
            sign,
            scale: 1.0,
            offset: 0.0,
            delay_s: self.delay_s,
            max_gap_s: self.max_gap_s,
            missing: Some(Vec::new()),
            valid: None,
            max_omitted: fifth(),
            optional,
        };
        // A rotation about the axis to port puts the bow down.
        let pitch = self.pitch.iter().map(move |pitch| angle(pitch, body.starboard(), true));
        let roll = self.roll.iter().map(move |roll| angle(roll, 1.0, true));
        [angle(&self.heading, 1.0, false)].into_iter().chain(roll).chain(pitch)
    }
}

impl FileSpec {
    /// How the file called `name` is written.
    pub fn format_of(&self, name: &str) -> Format {
        self.format.unwrap_or_else(|| Format::of(name))
    }

    /// Appends the channels that quaternions become, angles in radians.
    pub(crate) fn with_angles(mut self, body: Body) -> Self {
        let angles: Vec<ChannelSpec> = self.quaternion.iter().flat_map(|q| q.channels(body)).collect();
        self.channel.extend(angles);
        self
    }

    /// The channels that have a column of their own, where those of quaternions have been appended.
    pub(crate) fn plain(&self) -> &[ChannelSpec] {
        let angles = |q: &QuaternionSpec| 1 + usize::from(q.roll.is_some()) + usize::from(q.pitch.is_some());
        &self.channel[..self.channel.len() - self.quaternion.iter().map(angles).sum::<usize>()]
    }
}

impl Setup {
    /// The channels as they stand in the files, group by group.
    pub(crate) fn channels(&self) -> impl Iterator<Item = &ChannelSpec> {
        self.files.iter().flat_map(|file| &file.channel)
    }
}
