use serde::Deserialize;

use crate::{Conventions, NonMonotonic, TimeUnit};

/// How the logs of a ship were made.
#[derive(Clone, Debug)]
pub struct Setup {
    /// What messages call the file whose keys say so.
    pub written_in: &'static str,
    /// Kinds of files; a recording has one file of each.
    pub files: Vec<FileSpec>,
    /// How channels become trajectories.
    pub conventions: Conventions,
    /// Channels are not interpolated over longer gaps \[s\].
    pub max_gap_s: f64,
    /// What to do where time goes backwards.
    pub non_monotonic: NonMonotonic,
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

impl Setup {
    /// The channels as they stand in the files, group by group.
    pub(crate) fn channels(&self) -> impl Iterator<Item = &ChannelSpec> {
        self.files.iter().flat_map(|file| &file.channel)
    }
}
