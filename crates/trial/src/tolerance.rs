use std::fmt;

use engine::Pose;

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

/// The used fraction of a tolerance, and of which quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Used {
    /// 1 is the whole tolerance.
    pub part: f64,
    /// The quantity, in words; why there is none where all of it is used.
    pub of: &'static str,
}

impl Used {
    /// Of a vessel that is lost.
    pub const LOST: Self = Self { part: f64::INFINITY, of: "motion out of all bounds" };
    /// Of a vessel that does not complete its maneuver.
    pub const UNFINISHED: Self =
        Self { part: f64::INFINITY, of: "not done within its `duration_s` in the dictionary" };
}

impl From<Stopped> for Used {
    fn from(stopped: Stopped) -> Self {
        match stopped {
            Stopped::Unfinished(_) => Self::UNFINISHED,
            Stopped::Lost(_) => Self::LOST,
        }
    }
}

impl fmt::Display for Used {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.part.is_infinite() {
            return f.write_str(self.of);
        }
        write!(f, "{} {:.1} times its tolerance", self.of, self.part)
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

    /// The largest used fraction of a vessel under way at `speed_m_s`, wherever it is.
    pub fn used_in_motion(&self, [u, v, r]: [f64; 3], speed_m_s: f64) -> Used {
        most([
            ("speed", (u - speed_m_s).abs() / self.surge_m_s),
            ("sway", v.abs() / self.sway_m_s),
            ("yaw rate", r.abs() / self.yaw_rate_rad_s),
        ])
    }

    /// The largest used fraction of a vessel at a node of `heading_rad` and `speed_m_s`.
    pub fn used(&self, vessel: &Astray, heading_rad: f64, speed_m_s: f64) -> Used {
        let there = most([
            ("position", vessel.distance_m() / self.distance_m),
            ("heading", wrap(vessel.pose.psi - heading_rad).abs() / self.heading_rad),
        ]);
        let moving = self.used_in_motion(vessel.state, speed_m_s);
        if moving.part.total_cmp(&there.part).is_ge() { moving } else { there }
    }
}

/// The largest of some parts, the last of equals.
fn most<const N: usize>(parts: [(&'static str, f64); N]) -> Used {
    let most = parts.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
    most.map_or(Used::LOST, |(of, part)| Used { part, of })
}
