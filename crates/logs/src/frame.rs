use std::f64::consts::FRAC_PI_2;

use serde::Deserialize;

/// Axes of measured positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Frame {
    /// x north, y east.
    #[default]
    Ned,
    /// x east, y north.
    Enu,
}

/// How measured headings count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Heading {
    /// Clockwise from north, as a compass does (from the x axis of [`Frame::Ned`]).
    NorthClockwise,
    /// Counter-clockwise from east (from the x axis of [`Frame::Enu`]).
    EastCounterclockwise,
}

/// Axes of measured body velocities.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_from_north_east_to_east_north_and_back_is_the_identity() {
        for k in 0..20 {
            let (x, y, psi) = (f64::from(k) - 7.0, 0.3 * f64::from(k * k), 0.4 * f64::from(k) - 3.0);
            let [east, north] = Frame::Enu.north_east(x, y);
            assert_eq!(Frame::Enu.north_east(east, north), [x, y]);
            let there = Heading::EastCounterclockwise.from_north(psi);
            approx::assert_abs_diff_eq!(
                Heading::EastCounterclockwise.from_north(there),
                psi,
                epsilon = 1e-14
            );
        }
        assert_eq!(Body::Flu.starboard() * Body::Flu.starboard(), 1.0);
    }

    #[test]
    fn heading_east_and_sailing_ahead_goes_east_in_both() {
        let enu = Heading::EastCounterclockwise.from_north(0.0);
        approx::assert_abs_diff_eq!(enu, FRAC_PI_2);
        assert_eq!(Frame::Enu.north_east(1.0, 0.0), [0.0, 1.0]);
    }
}
