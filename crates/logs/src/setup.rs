use serde::Deserialize;

use crate::{Conventions, Method, NonMonotonic, TimeUnit};

/// How the logs of a ship were made, and at which rate they become trajectories.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Kinds of files; a recording has one file of each.
    pub groups: Vec<Group>,
    /// In which axes and about which point the channels were measured, and what is computed from them.
    pub conventions: Conventions,
    /// How velocities that are not measured are made from positions.
    pub method: Method,
    /// The common rate \[Hz\].
    pub rate_hz: f64,
    /// Every channel is averaged over this long before it is resampled \[s\].
    pub average_s: Option<f64>,
    /// Channels are not interpolated over longer gaps \[s\].
    pub max_gap_s: f64,
    /// What to do where time goes backwards.
    pub non_monotonic: NonMonotonic,
}

/// Files of one kind.
#[derive(Clone, Debug)]
pub struct Group {
    /// The clock.
    pub time: TimeSpec,
    /// The channels.
    pub channels: Vec<ChannelSpec>,
    /// Column with labels of sub-experiments.
    pub label_column: Option<String>,
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
        self.groups.iter().flat_map(|group| &group.channels)
    }
}
