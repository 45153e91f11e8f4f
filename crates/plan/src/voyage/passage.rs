//! The passage of a plan, as on a bridge.

use chart::Plane;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::tide::Tide;

/// The voyage as a bridge plans it: courses from waypoint to waypoint. Straight moves on one course are one leg; a turn under
/// way is a waypoint where its two courses cross.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Passage {
    /// When the trial begins, in UTC; absent where `plan.toml` does not say.
    pub departure: Option<String>,
    /// The tide that the plan counts with; absent without a table.
    pub tide: Option<Tide>,
    /// Longitude of the first waypoint.
    pub longitude_deg: f64,
    /// Latitude of the first waypoint.
    pub latitude_deg: f64,
    /// What is done at the first waypoint before going on.
    pub before: Vec<String>,
    /// When she goes on from there, after the departure \[s\].
    pub leave_s: f64,
    /// In the order of sailing.
    pub legs: Vec<PassageLeg>,
}

/// Land, a shoal or another thing to keep clear of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NearestDanger {
    /// What it is and its name, as the chart has them.
    pub what: String,
    /// How far it is, with the doubt about its place taken off \[m\].
    pub distance_m: f64,
    /// Its true bearing from the ship, where she comes nearest to it.
    pub bearing_deg: f64,
}

/// A leg of the passage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PassageLeg {
    /// What is done on it.
    pub what: String,
    /// Whether an informative maneuver is run on it.
    pub informative: bool,
    /// Longitude of the waypoint where it ends.
    pub longitude_deg: f64,
    /// Latitude of that waypoint.
    pub latitude_deg: f64,
    /// Course along the loxodrome, true.
    pub course_deg: f64,
    /// Distance between the waypoints \[m\].
    pub distance_m: f64,
    /// Mean speed over ground along the simulated track \[m/s\].
    pub speed_m_s: f64,
    /// When the ship is at its waypoint, after the departure \[s\].
    pub end_s: f64,
    /// When she goes on from there, after what is done there \[s\].
    pub leave_s: f64,
    /// Radius of the ship's turn onto the next leg \[m\]; absent where it does not turn under way.
    pub turn_radius_m: Option<f64>,
    /// Cross-track distance to port of the line between the waypoints \[m\]: as far as the nominal track and those of the check
    /// that are kept come, at least what positions and the hull are uncertain by, and no farther than the water is clear,
    /// unless the nominal track comes there.
    pub xtd_port_m: f64,
    /// The same to starboard \[m\].
    pub xtd_starboard_m: f64,
    /// Least charted depth along the nominal track, at the chart's datum; absent where none is charted \[m\].
    pub least_depth_m: Option<f64>,
    /// The same at the tide's least level, under the keel; absent without `hull.draught_m`, too \[m\].
    pub under_keel_m: Option<f64>,
    /// The danger nearest to the nominal track of the reference point.
    pub nearest: Option<NearestDanger>,
    /// What is done at its waypoint before going on, such as a turn on the spot.
    pub then: Vec<String>,
}

impl Passage {
    /// The corners of every leg's corridor on `plane`, with its cross-track distances as widths; to port of
    /// its start first, clockwise. `None` for a leg without a length.
    pub fn corridors(&self, plane: &Plane) -> Vec<Option<[[f64; 2]; 4]>> {
        let mut from = plane.to_plane(self.longitude_deg, self.latitude_deg);
        let corridor = |leg: &PassageLeg| {
            let to = plane.to_plane(leg.longitude_deg, leg.latitude_deg);
            let start = std::mem::replace(&mut from, to);
            let along = [to[0] - start[0], to[1] - start[1]];
            let length = libm::hypot(along[0], along[1]);
            let starboard = [along[1] / length, -along[0] / length];
            let offset = |at: [f64; 2], by: f64| [0, 1].map(|k| at[k] + by * starboard[k]);
            let (port, right) = (-leg.xtd_port_m, leg.xtd_starboard_m);
            (length > 0.0)
                .then(|| [offset(start, port), offset(to, port), offset(to, right), offset(start, right)])
        };
        self.legs.iter().map(corridor).collect()
    }
}
