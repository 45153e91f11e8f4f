use serde::Deserialize;

use crate::{
    Body, ChannelError, Conventions, Formula, Frame, Heading, Law, Lever, Method, NonMonotonic, Thruster,
    TimeUnit,
};

/// How the logs of a ship were made, and at which rate they become trajectories.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Kinds of files; a recording has one file of each.
    pub groups: Vec<Group>,
    /// Computed channels; each may use those before it.
    pub derived: Vec<DerivedSpec>,
    /// Thrusters, whose forces make up `tau1`, `tau2`, `tau3`.
    pub thrusters: Vec<ThrusterSpec>,
    /// Axes of `x` and `y`.
    pub frame: Frame,
    /// How `psi` counts.
    pub heading: Heading,
    /// Axes of `y_u`, `y_v`, `y_r`.
    pub body: Body,
    /// From the reference point to the antenna.
    pub lever: Lever,
    /// How velocities are made from positions.
    pub velocities: VelocitySpec,
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

impl DerivedSpec {
    pub(crate) fn parse(&self) -> Result<Formula, ChannelError> {
        Formula::parse(&self.formula).map_err(|malformed| ChannelError::Formula {
            channel: self.channel.clone(),
            formula: self.formula.clone(),
            malformed,
        })
    }
}

/// How velocities are made from positions.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VelocitySpec {
    /// Explicit Euler differences, or slopes of local parabolas.
    pub method: Method,
    /// Length of the parabolas \[s\]; also of those that measured velocities are compared with.
    pub window_s: f64,
}

impl Default for VelocitySpec {
    fn default() -> Self {
        Self { method: Method::default(), window_s: 1.0 }
    }
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

impl ThrusterSpec {
    /// The thruster, the channel of its speed, and for an azimuth thruster that of its angle.
    pub(crate) fn parts(&self) -> (Thruster, String, Option<String>) {
        match self.clone() {
            Self::Azimuth { speed, angle, coefficient, law, position_m } => {
                (Thruster { law, coefficient, position_m }, speed, Some(angle))
            }
            Self::Tunnel { speed, coefficient, law, position_m } => {
                (Thruster { law, coefficient, position_m }, speed, None)
            }
        }
    }
}

impl Setup {
    /// In which axes the channels were measured, and what is computed from them.
    ///
    /// # Errors
    /// A formula that cannot be read.
    pub(crate) fn conventions(&self) -> Result<Conventions, ChannelError> {
        let derived = |d: &DerivedSpec| Ok((d.channel.clone(), d.parse()?));
        Ok(Conventions {
            frame: self.frame,
            heading: self.heading,
            body: self.body,
            lever: self.lever,
            window_s: self.velocities.window_s,
            derived: self.derived.iter().map(derived).collect::<Result<_, _>>()?,
            thrusters: self.thrusters.iter().map(ThrusterSpec::parts).collect(),
        })
    }

    /// The channels as they stand in the files, group by group.
    pub(crate) fn channels(&self) -> impl Iterator<Item = &ChannelSpec> {
        self.groups.iter().flat_map(|group| &group.channels)
    }
}
