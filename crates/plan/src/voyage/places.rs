//! Places on the chart as poses of the lattice.

use crate::lattice::Pose;
use refusal::Invalid;

use super::prepared::Prepared;
use super::task::{Goal, Place};

impl Prepared {
    /// The node and heading level nearest to a place, in its speed mode (by default the slowest).
    pub(super) fn pose(&self, key: &str, place: &Place) -> Result<Pose, Invalid> {
        let [east, north] = self.chart.plane().to_plane(place.longitude_deg, place.latitude_deg);
        let node = |at: f64, origin: f64| ((at - origin) / self.grid.cell_m).round();
        let (i, j) = (node(east, self.grid.origin_m[0]), node(north, self.grid.origin_m[1]));
        let inside = |n: f64, count: usize| n >= 0.0 && n < count as f64;
        if !inside(i, self.grid.nx) || !inside(j, self.grid.ny) || !place.heading_deg.is_finite() {
            let found = format!(
                "longitude {}, latitude {}, heading {}",
                place.longitude_deg, place.latitude_deg, place.heading_deg
            );
            let expected = "a place inside `area` and a compass heading";
            return Err(refuse(key, &found, expected, "move it, or widen `area`"));
        }
        let grid_rad = place.heading_deg.to_radians() + self.chart.plane().north_rad([east, north]);
        let level = self.grid.nearest_level(grid_rad);
        Ok(Pose { i: i as usize, j: j as usize, layer: self.grid.layer(level, self.mode(key, place)?) })
    }

    fn mode(&self, key: &str, place: &Place) -> Result<usize, Invalid> {
        let Some(name) = &place.mode else { return Ok(0) };
        let names = || self.grid.modes.iter().map(|m| m.name.as_str()).collect::<Vec<_>>().join(", ");
        self.grid.modes.iter().position(|m| m.name == *name).ok_or_else(|| {
            refuse(&format!("{key}.mode"), &format!("`{name}`"), &names(), "name one of these")
        })
    }

    /// Where the trial may end.
    pub(super) fn goal(&self, goal: &Goal, start: Pose) -> Result<crate::lattice::Goal, Invalid> {
        match goal {
            Goal::Any {} => Ok(crate::lattice::Goal::Any),
            Goal::Home {} => Ok(crate::lattice::Goal::Poses(vec![start])),
            Goal::Places { places } if places.is_empty() => {
                Err(refuse("goal.places", "none", "at least one place", "add one, or take kind = \"any\""))
            }
            Goal::Places { places } => {
                let poses = places.iter().map(|place| self.pose("goal.places", place));
                Ok(crate::lattice::Goal::Poses(poses.collect::<Result<_, _>>()?))
            }
        }
    }

    /// The true heading of a pose on the plane, from 0 to 360 \[deg\].
    pub fn true_deg(&self, pose: ship::engine::Pose) -> f64 {
        compass_deg(pose.psi - self.chart.plane().north_rad([pose.y, pose.x]))
    }

    /// A pose in words: its position in degrees, and its true heading.
    pub(super) fn words(&self, pose: Pose) -> String {
        let (level, _) = self.grid.level_and_mode(pose.layer);
        let at = self.grid.pose(pose.i, pose.j, level);
        let (longitude, latitude) = self.chart.plane().to_geographic([at.y, at.x]);
        let part = |degrees: f64, side: char| format!("{:.4} {side}", degrees.abs());
        let north = part(latitude, if latitude < 0.0 { 'S' } else { 'N' });
        let east = part(longitude, if longitude < 0.0 { 'W' } else { 'E' });
        format!("{north} {east} heading {:.0}°", self.true_deg(at).round() % 360.0)
    }
}

fn refuse(key: &str, found: &str, expected: &str, remedy: &str) -> Invalid {
    Invalid::new(format!("`{key}`"), found, expected, remedy)
}

/// A heading in degrees from 0 to 360.
pub fn compass_deg(heading_rad: f64) -> f64 {
    heading_rad.to_degrees().rem_euclid(360.0)
}
