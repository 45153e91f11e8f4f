//! The passage and the track of a plan as layers for maps.

use serde_json::{Value, json};
use study::documents::{Passage, PassageLeg};
use study::plan::{Feature, Geometry, Plane, Route};

use super::package::{Column, Shape, StyledLayer};

/// The contents of the layers.
pub(super) struct Layers<'a> {
    pub plane: &'a Plane,
    /// The route along the passage.
    pub route: &'a Route,
    pub passage: &'a Passage,
    /// A line per step.
    pub tracks: Vec<Feature>,
    /// Prefix of names: empty for a safe plan.
    pub label: &'a str,
}

impl Layers<'_> {
    /// From the lowest on a map to the highest.
    pub(super) fn all(self) -> Vec<StyledLayer> {
        vec![
            StyledLayer {
                name: "corridors",
                title: self.titled("corridors"),
                shape: Shape::Polygon,
                columns: &LEG,
                features: self.corridors(),
                style: include_str!("styles/corridors.qml"),
            },
            StyledLayer {
                name: "legs",
                title: self.titled("legs"),
                shape: Shape::Line,
                columns: &LEG,
                features: self.legs(),
                style: include_str!("styles/legs.qml"),
            },
            StyledLayer {
                name: "waypoints",
                title: self.titled("waypoints"),
                shape: Shape::Point,
                columns: &WAYPOINT,
                features: self.waypoints(),
                style: include_str!("styles/waypoints.qml"),
            },
            StyledLayer {
                name: "track",
                title: self.titled("planned track"),
                shape: Shape::Line,
                columns: &TRACK,
                style: include_str!("styles/track.qml"),
                features: self.tracks,
            },
        ]
    }

    fn titled(&self, title: &str) -> String {
        format!("{}{title}", self.label)
    }

    fn waypoints(&self) -> Vec<Feature> {
        let waypoints = self.route.waypoints.iter().map(|own| {
            let properties = json!({
                "number": own.id,
                "name": own.name,
                "eta": own.time_s,
                "after_departure_s": own.time_s,
                "speed_m_s": own.speed_m_s,
                "turn_radius_m": own.turn_radius_m,
                "purpose": own.note,
            });
            Feature::new(Geometry::Point([own.lon_deg, own.lat_deg]), properties)
        });
        waypoints.collect()
    }

    fn legs(&self) -> Vec<Feature> {
        let ends = self.route.waypoints.windows(2);
        let legs = ends.zip(self.passage.legs.iter().enumerate()).map(|(ends, (index, leg))| {
            let line = ends.iter().map(|own| [own.lon_deg, own.lat_deg]).collect();
            Feature::new(Geometry::Line(line), self.leg(index, leg))
        });
        legs.collect()
    }

    fn corridors(&self) -> Vec<Feature> {
        let rings = self.passage.corridors(self.plane);
        let legs = rings.into_iter().zip(self.passage.legs.iter().enumerate());
        let feature = |(ring, (index, leg)): (Option<[[f64; 2]; 4]>, (usize, &PassageLeg))| {
            let [a, b, c, d] = ring?.map(|corner| <[f64; 2]>::from(self.plane.to_geographic(corner)));
            // Counterclockwise, as the format requires.
            Some(Feature::new(Geometry::Polygon(vec![d, c, b, a, d]), self.leg(index, leg)))
        };
        legs.filter_map(feature).collect()
    }

    /// The properties of a leg.
    fn leg(&self, index: usize, leg: &PassageLeg) -> Value {
        let nearest = leg.nearest.as_ref();
        json!({
            "number": index + 1,
            "name": format!("{}{}", self.label, leg.what),
            "informative": leg.informative,
            "course_deg": leg.course_deg,
            "distance_m": leg.distance_m,
            "speed_m_s": leg.speed_m_s,
            "xtd_port_m": leg.xtd_port_m,
            "xtd_starboard_m": leg.xtd_starboard_m,
            "least_depth_m": leg.least_depth_m,
            "under_keel_m": leg.under_keel_m,
            "nearest_danger": nearest.map(|danger| &danger.what),
            "nearest_danger_m": nearest.map(|danger| danger.distance_m),
            "nearest_danger_deg": nearest.map(|danger| danger.bearing_deg),
        })
    }
}

const WAYPOINT: [(&str, Column); 7] = [
    ("number", Column::Integer),
    ("name", Column::Text),
    ("eta", Column::Time),
    ("after_departure_s", Column::Real),
    ("speed_m_s", Column::Real),
    ("turn_radius_m", Column::Real),
    ("purpose", Column::Text),
];

const LEG: [(&str, Column); 13] = [
    ("number", Column::Integer),
    ("name", Column::Text),
    ("informative", Column::Boolean),
    ("course_deg", Column::Real),
    ("distance_m", Column::Real),
    ("speed_m_s", Column::Real),
    ("xtd_port_m", Column::Real),
    ("xtd_starboard_m", Column::Real),
    ("least_depth_m", Column::Real),
    ("under_keel_m", Column::Real),
    ("nearest_danger", Column::Text),
    ("nearest_danger_m", Column::Real),
    ("nearest_danger_deg", Column::Real),
];

const TRACK: [(&str, Column); 8] = [
    ("step", Column::Integer),
    ("name", Column::Text),
    ("informative", Column::Boolean),
    ("start_s", Column::Real),
    ("duration_s", Column::Real),
    ("heading_deg", Column::Real),
    ("speed_m_s", Column::Real),
    ("safe", Column::Boolean),
];
