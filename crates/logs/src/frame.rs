//! Axes, velocities from positions, the antenna, and units that a log may use.

use std::f64::consts::{FRAC_PI_2, TAU};

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

/// How velocities are made from positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Explicit Euler differences at the common rate, as in the paper: [`euler`].
    Euler,
    /// Slopes of local parabolas on the channels' own clocks: [`crate::local_quadratic`].
    #[default]
    Smoother,
}

/// Surge and sway \[m/s\] from the rates of north and east \[m/s\] and the heading \[rad\]: R(ψ)ᵀ ṗ.
pub fn body_velocity([north, east]: [f64; 2], psi: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(psi);
    [north * cos + east * sin, east * cos - north * sin]
}

/// u(k), v(k) = R(ψ(k))ᵀ (p(k+1) − p(k))/dt and r(k) = (ψ(k+1) − ψ(k))/dt of M samples of x, y \[m\] and unwrapped ψ
/// \[rad\], `dt` seconds apart: M velocities, the last NaN, as is what touches a missing sample.
pub fn euler(poses: impl Iterator<Item = [f64; 3]>, dt: f64) -> impl Iterator<Item = [f64; 3]> {
    let mut poses = poses.peekable();
    std::iter::from_fn(move || {
        let pose = poses.next()?;
        let next = poses.peek().copied().unwrap_or([f64::NAN; 3]);
        let [north, east, r] = [0, 1, 2].map(|i| (next[i] - pose[i]) / dt);
        let [u, v] = body_velocity([north, east], pose[2]);
        Some([u, v, r])
    })
}

/// The antenna's position relative to the reference point, in body axes (x forward, y starboard) \[m\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lever(pub [f64; 2]);

impl Lever {
    /// Whether the antenna is at the reference point.
    pub fn is_zero(self) -> bool {
        self.0 == [0.0; 2]
    }

    /// North and east of the reference point \[m\] from those of the antenna and the heading \[rad\]:
    /// p_ref = p_antenna − R(ψ) l.
    pub fn position(self, [north, east]: [f64; 2], psi: f64) -> [f64; 2] {
        let [x, y] = self.0;
        let (sin, cos) = libm::sincos(psi);
        [north - (x * cos - y * sin), east - (x * sin + y * cos)]
    }

    /// Surge and sway of the reference point \[m/s\] from those of the antenna and the yaw rate \[rad/s\]:
    /// the antenna moves with u − r l_y and v + r l_x.
    pub fn velocity(self, [u, v]: [f64; 2], r: f64) -> [f64; 2] {
        let [x, y] = self.0;
        [u + r * y, v - r * x]
    }
}

/// A unit that a log may use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// As written.
    pub name: &'static str,
    /// The unit that it is converted to: SI, radians, revolutions per second.
    pub si: &'static str,
    /// Its size in that unit.
    pub factor: f64,
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

const fn of(name: &'static str, si: &'static str, factor: f64) -> Unit {
    Unit { name, si, factor }
}

/// All known units. Case matters: `kn` is a knot, `kN` a kilonewton.
pub const UNITS: &[Unit] = &[
    of("1", "1", 1.0),
    of("%", "1", 0.01),
    of("s", "s", 1.0),
    of("ms", "s", 1e-3),
    of("min", "s", 60.0),
    of("m", "m", 1.0),
    of("mm", "m", 1e-3),
    of("cm", "m", 1e-2),
    of("km", "m", 1e3),
    of("ft", "m", 0.3048),
    of("nmi", "m", 1852.0),
    of("m/s", "m/s", 1.0),
    of("mm/s", "m/s", 1e-3),
    of("cm/s", "m/s", 1e-2),
    of("km/h", "m/s", 1.0 / 3.6),
    of("knot", "m/s", 1852.0 / 3600.0),
    of("kn", "m/s", 1852.0 / 3600.0),
    of("kt", "m/s", 1852.0 / 3600.0),
    of("ft/s", "m/s", 0.3048),
    of("m/s^2", "m/s^2", 1.0),
    of("rad", "rad", 1.0),
    of("deg", "rad", DEGREE),
    of("rad/s", "rad/s", 1.0),
    of("deg/s", "rad/s", DEGREE),
    of("deg/min", "rad/s", DEGREE / 60.0),
    of("1/s", "1/s", 1.0),
    of("rps", "1/s", 1.0),
    of("Hz", "1/s", 1.0),
    of("rpm", "1/s", 1.0 / 60.0),
    of("1/min", "1/s", 1.0 / 60.0),
    of("N", "N", 1.0),
    of("kN", "N", 1e3),
    of("MN", "N", 1e6),
    of("N m", "N m", 1.0),
    of("Nm", "N m", 1.0),
    of("kN m", "N m", 1e3),
    of("kNm", "N m", 1e3),
    of("MN m", "N m", 1e6),
    of("W", "W", 1.0),
    of("kW", "W", 1e3),
    of("V", "V", 1.0),
    of("mV", "V", 1e-3),
    of("A", "A", 1.0),
    of("Pa", "Pa", 1.0),
    of("hPa", "Pa", 1e2),
    of("kPa", "Pa", 1e3),
];

/// The unit called `name`.
pub fn unit(name: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|unit| unit.name == name)
}

/// [`factor`], and from turning in radians to revolutions of a shaft, or back.
pub fn shaft_factor(from: &str, to: &str) -> Option<f64> {
    let of = |from: &Unit, to: &Unit| match (from.si, to.si) {
        ("rad/s", "1/s") => Some(from.factor / to.factor / TAU),
        ("1/s", "rad/s") => Some(from.factor / to.factor * TAU),
        _ => None,
    };
    factor(from, to).or_else(|| of(unit(from)?, unit(to)?))
}

/// The factor from `from` to `to`; `None` if they measure different things. Units that are not in the table
/// match only themselves.
pub fn factor(from: &str, to: &str) -> Option<f64> {
    if from == to {
        return Some(1.0);
    }
    let (from, to) = (unit(from)?, unit(to)?);
    (from.si == to.si).then(|| if to.factor == 1.0 { from.factor } else { from.factor / to.factor })
}
