use std::f64::consts::FRAC_PI_2;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Axes of measured positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Frame {
    /// x north, y east.
    #[default]
    Ned,
    /// x east, y north.
    Enu,
}

/// How measured headings count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Heading {
    /// Clockwise from north, as a compass does (from the x axis of [`Frame::Ned`]).
    NorthClockwise,
    /// Counter-clockwise from east (from the x axis of [`Frame::Enu`]).
    EastCounterclockwise,
}

/// Axes of measured body velocities.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Body {
    /// x forward, y starboard, z down: sway to starboard and turns to starboard are positive.
    #[default]
    Frd,
    /// x forward, y port, z up: sway to port and turns to port are positive.
    Flu,
}

impl Frame {
    /// North and east of a measured x and y.
    pub fn north_east<T>(self, x: T, y: T) -> [T; 2] {
        match self {
            Self::Ned => [x, y],
            Self::Enu => [y, x],
        }
    }

    /// How headings count in these axes unless said otherwise.
    pub fn heading(self) -> Heading {
        match self {
            Self::Ned => Heading::NorthClockwise,
            Self::Enu => Heading::EastCounterclockwise,
        }
    }
}

impl Heading {
    /// The heading clockwise from north \[rad\].
    pub fn from_north(self, measured: f64) -> f64 {
        match self {
            Self::NorthClockwise => measured,
            Self::EastCounterclockwise => FRAC_PI_2 - measured,
        }
    }
}

impl Body {
    /// Sign of sway and yaw rate: what is positive to starboard.
    pub fn starboard(self) -> f64 {
        match self {
            Self::Frd => 1.0,
            Self::Flu => -1.0,
        }
    }
}
