//! What positions of a ship may be.

use super::super::task::Task;
use super::track::{PlannedTrack, uncertain_m};

/// How much faster than planned a ship may be.
const FASTER: f64 = 1.5;

/// Limits of positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowLimits {
    /// The longest time between two positions within a maneuver \[s\].
    pub max_gap_s: f64,
    /// What the ship does not exceed over the ground \[m/s\].
    pub fastest_m_s: f64,
    /// How far positions may be off \[m\].
    pub uncertain_m: f64,
}

impl FollowLimits {
    /// The limits of a ship on the plan of `task` with its `track`.
    pub fn of(task: &Task, track: &PlannedTrack, max_gap_s: f64) -> Self {
        let planned = track.points.iter().map(|point| point.speed_m_s);
        let modes = task.modes.iter().map(|mode| mode.speed_m_s);
        let [north, east] = task.known_current_m_s;
        let current_m_s = libm::hypot(north, east) + task.safety.unknown_current_m_s;
        Self {
            max_gap_s,
            fastest_m_s: FASTER * planned.chain(modes).fold(0.0, f64::max) + current_m_s,
            uncertain_m: uncertain_m(task.sensors.position_m),
        }
    }
}
