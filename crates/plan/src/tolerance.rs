use std::fmt;

use ship::engine::Pose;

use crate::Stopped;
use crate::grid::wrap;

/// The distance from its node, and from a settled state there, within which a leg must end. It is the same
/// for all nodes, so legs that end within it from anywhere within it can be chained: errors do not grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Distance from the node \[m\].
    pub distance_m: f64,
    /// Difference from the level's heading \[rad\].
    pub heading_rad: f64,
    /// Difference from the mode's speed \[m/s\].
    pub surge_m_s: f64,
    /// Sway speed over the ground \[m/s\].
    pub sway_m_s: f64,
    /// Yaw rate \[rad/s\].
    pub yaw_rate_rad_s: f64,
}

/// A vessel near a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Astray {
    /// Its position relative to the node (north, east), and its heading.
    pub pose: Pose,
    /// u, v \[m/s\], r \[rad/s\].
    pub state: [f64; 3],
}

impl Astray {
    /// A vessel relative to `node`.
    pub fn of(pose: Pose, state: [f64; 3], [north, east]: [f64; 2]) -> Self {
        Self { pose: Pose { x: pose.x - north, y: pose.y - east, ..pose }, state }
    }

    /// Distance from the node \[m\].
    pub fn distance_m(&self) -> f64 {
        libm::hypot(self.pose.x, self.pose.y)
    }
}

/// Quantities that have a tolerance.
const QUANTITIES: [&str; 5] = ["position", "heading", "speed", "sway", "yaw rate"];

/// The used fractions of a tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Used {
    /// Of position, heading, speed, sway and yaw rate: 1 is the whole tolerance.
    Parts([f64; 5]),
    /// Of a vessel that does not complete its maneuver.
    Unfinished,
    /// Of a vessel that is lost.
    Lost,
}

impl Used {
    /// Nothing of it.
    pub const NONE: Self = Self::Parts([0.0; 5]);

    /// The largest fraction; infinite where there is none.
    pub fn part(&self) -> f64 {
        match self {
            Self::Parts(parts) => parts.iter().copied().fold(0.0, f64::max),
            Self::Unfinished | Self::Lost => f64::INFINITY,
        }
    }

    /// The larger fractions of two vessels, quantity by quantity.
    #[must_use]
    pub fn or_more(self, other: Self) -> Self {
        match (self, other) {
            (Self::Parts(own), Self::Parts(others)) => {
                Self::Parts(std::array::from_fn(|k| own[k].max(others[k])))
            }
            (Self::Lost, _) | (_, Self::Lost) => Self::Lost,
            _ => Self::Unfinished,
        }
    }
}

impl From<Stopped> for Used {
    fn from(stopped: Stopped) -> Self {
        match stopped {
            Stopped::Unfinished(_) => Self::Unfinished,
            Stopped::Lost(_) => Self::Lost,
        }
    }
}

/// Names every quantity that exceeds its tolerance, or the largest where none does.
impl fmt::Display for Used {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = match self {
            Self::Parts(parts) => parts,
            Self::Unfinished => return f.write_str("not done within its `duration_s` in the dictionary"),
            Self::Lost => return f.write_str("motion out of all bounds"),
        };
        let least = self.part().min(1.0);
        let is_said = |part: f64| part > 1.0 || part == least;
        let said = QUANTITIES.iter().zip(parts).filter(|(_, part)| is_said(**part));
        let said: Vec<String> = said.map(|(quantity, part)| format!("{quantity} {part:.1}")).collect();
        let whose = if said.len() > 1 { "their tolerances" } else { "its tolerance" };
        write!(f, "{} times {whose}", said.join(" and "))
    }
}

/// Fraction of the tolerance in which sampled vessels must end near their node, and from which they begin;
/// and of the offsets in heading, speed and yaw rate at the beginning.
const NEAR: f64 = 0.25;
const BEGUN: f64 = 0.5;

impl Tolerance {
    /// The stricter tolerance for the ends of sampled vessels, so that vessels that were not sampled still
    /// keep the whole one.
    #[must_use]
    pub fn ended(&self) -> Self {
        Self { distance_m: NEAR * self.distance_m, ..*self }
    }

    /// The tolerance for the beginnings of sampled vessels.
    #[must_use]
    pub fn begun(&self) -> Self {
        let Self { heading_rad, surge_m_s, yaw_rate_rad_s, .. } = *self;
        Self {
            heading_rad: BEGUN * heading_rad,
            surge_m_s: BEGUN * surge_m_s,
            yaw_rate_rad_s: BEGUN * yaw_rate_rad_s,
            ..self.ended()
        }
    }

    /// The used fractions of a vessel under way at `speed_m_s`, wherever it is.
    pub fn used_in_motion(&self, state: [f64; 3], speed_m_s: f64) -> Used {
        self.used(&Astray { pose: Pose::default(), state }, 0.0, speed_m_s)
    }

    /// The used fractions of a vessel at a node of `heading_rad` and `speed_m_s`.
    pub fn used(&self, vessel: &Astray, heading_rad: f64, speed_m_s: f64) -> Used {
        let [_, _, heading, surge, sway, yaw_rate] = self.off(vessel, heading_rad, speed_m_s).map(f64::abs);
        Used::Parts([vessel.distance_m() / self.distance_m, heading, surge, sway, yaw_rate])
    }

    /// The same with signs, and the position as north and east, for searches that compare vessels: north, east, heading, surge,
    /// sway, yaw rate.
    pub(crate) fn off(&self, vessel: &Astray, heading_rad: f64, speed_m_s: f64) -> [f64; 6] {
        let (Pose { x, y, psi }, [u, v, r]) = (vessel.pose, vessel.state);
        let [north, east] = [x, y].map(|own| own / self.distance_m);
        let heading = wrap(psi - heading_rad) / self.heading_rad;
        let surge = (u - speed_m_s) / self.surge_m_s;
        [north, east, heading, surge, v / self.sway_m_s, r / self.yaw_rate_rad_s]
    }
}
