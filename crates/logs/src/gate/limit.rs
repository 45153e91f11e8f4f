use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::{self, Display};

use crate::{ChannelSpec, Unit};

/// The allowed range of the numbers in a column, in its own unit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Limit {
    /// Least and greatest number.
    pub(crate) numbers: [f64; 2],
    /// Where it comes from.
    pub(crate) of: LimitOf,
}

/// Where a limit comes from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum LimitOf {
    /// `valid` in the configuration.
    Configuration,
    /// The input's `range` in the vessel file of this name, extended by half of its width on either side.
    Vessel(String),
    /// What is possible for a channel of this kind.
    Kind(&'static str),
}

impl Display for LimitOf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Configuration => write!(f, "`valid` of the channel"),
            Self::Vessel(file) => write!(f, "the input's `range` in {file}, extended by half of its width"),
            Self::Kind(kind) => write!(f, "what is possible for {kind}"),
        }
    }
}

/// No quantity of a ship is larger in SI units.
const LARGEST: f64 = 1e12;

/// No direction of a ship turns faster, even of a small boat \[rad/s\].
const FASTEST_TURN: f64 = PI;

/// No shaft of a ship turns faster \[1/s\].
const FASTEST_SHAFT: f64 = 10_000.0 / 60.0;

/// No wind blows faster \[m/s\].
const FASTEST_WIND: f64 = 150.0;

impl Limit {
    /// The limit for the column of `spec`, in `unit`. `range` is that of the vessel's input, in SI units,
    /// with its file's name; `fastest` is the ship's greatest speed \[m/s\].
    pub(crate) fn new(
        spec: &ChannelSpec,
        unit: &Unit,
        range: Option<([f64; 2], &str)>,
        fastest: f64,
    ) -> Self {
        if let Some(numbers) = spec.valid {
            return Self { numbers, of: LimitOf::Configuration };
        }
        let (values, of) = match range {
            Some(([low, high], file)) => {
                let more = 0.5 * (high - low);
                ([low - more, high + more], LimitOf::Vessel(file.to_owned()))
            }
            None => {
                let (greatest, kind) = of_kind(&spec.channel, unit, fastest);
                ([-greatest, greatest], LimitOf::Kind(kind))
            }
        };
        let factor = spec.sign * spec.scale * unit.factor;
        let [a, b] = values.map(|value| (value - spec.offset) / factor);
        Self { numbers: [a.min(b), a.max(b)], of }
    }

    /// A turn in the unit of the column of `spec`, if that is an angle that may continue beyond one.
    pub(super) fn turn(&self, spec: &ChannelSpec, unit: &Unit) -> Option<f64> {
        let goes_round =
            unit.si == "rad" && !["latitude_deg", "longitude_deg"].contains(&spec.channel.as_str());
        let turn = TAU / (spec.scale * unit.factor).abs();
        (goes_round && self.of != LimitOf::Configuration).then_some(turn)
    }
}

/// The greatest modulus of a channel by its name and unit, in SI units, and the kind of channel.
fn of_kind(channel: &str, unit: &Unit, fastest: f64) -> (f64, &'static str) {
    // Allows for rounding in another unit.
    let just = 1.0 + 1e-6;
    match (channel, unit.si) {
        ("latitude_deg", _) => (just * FRAC_PI_2, "latitudes"),
        ("longitude_deg", _) => (just * TAU, "longitudes"),
        ("y_u" | "y_v" | "v_x" | "v_y", _) => (just * fastest, "a ship's speed, `max_speed_m_s`"),
        ("y_r", _) => (FASTEST_TURN, "yaw rates"),
        (name, "rad") if ["delta", "rudder"].iter().any(|own| name.starts_with(own)) => {
            (just * FRAC_PI_2, "rudder angles")
        }
        (_, "m/s") => (FASTEST_WIND, "speeds of wind and water"),
        (_, "1/s") if unit.name != "Hz" => (just * FASTEST_SHAFT, "shafts"),
        _ => (LARGEST, "anything on a ship"),
    }
}
