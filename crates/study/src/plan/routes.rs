//! The plan in other formats: tracks, and routes for bridges and ground stations.

use chart::route::{Feature, Geometry, Route, Track, Waypoint, geojson, gpx, qgroundcontrol, rtz};
use chart::{Invalid, Plane};
use plan::{Sailed, Sample, Side};
use serde_json::json;

use crate::documents::{Passage, PlanDocument, Voyage, VoyageLeg};

/// A file's name and content.
pub type NamedFile = (&'static str, Vec<u8>);

/// A plan's track on the globe.
pub struct Routes<'a> {
    /// Name of the trial.
    pub name: &'a str,
    /// The plane of its coordinates.
    pub plane: &'a Plane,
    /// The plan.
    pub document: &'a PlanDocument,
    /// Its part at sea.
    pub voyage: &'a Voyage,
    /// The simulated track.
    pub sailed: &'a Sailed,
    /// Time from sample to sample \[s\].
    pub sample_s: f64,
}

impl Routes<'_> {
    /// Names and contents of the files for bridges and maps; `rtz_name` is that of `route.rtz`, without
    /// its ending.
    ///
    /// # Errors
    /// A route that the format does not support, with the name of its file.
    pub fn files(&self, rtz_name: &str) -> Result<Vec<NamedFile>, (&'static str, Invalid)> {
        let route = self.route();
        // ECDIS expect the route to be called as its file.
        let filed = Route { name: self.labelled(rtz_name), ..route.clone() };
        let files = [
            ("track.geojson", geojson(&self.features())),
            ("route.rtz", rtz(&filed)),
            ("route.gpx", gpx(&route, &[self.track()])),
            ("route.plan", qgroundcontrol(&route)),
        ];
        let named = |(name, text): (&'static str, Result<String, Invalid>)| match text {
            Ok(text) => Ok((name, text.into_bytes())),
            Err(invalid) => Err((name, invalid)),
        };
        files.into_iter().map(named).collect()
    }

    /// The route along the passage.
    pub fn route(&self) -> Route {
        let departure = self.voyage.passage.departure.as_deref().and_then(|at| at.parse().ok());
        let mut route = Route { name: self.labelled(self.name), departure, waypoints: self.waypoints() };
        route.fit_radii();
        route
    }

    /// The prefix of names in an unsafe plan; empty for a safe one.
    pub fn label(&self) -> &'static str {
        if self.voyage.check.safe { "" } else { "unsafe plan: " }
    }

    /// A name, with the prefix if the plan fails its check.
    fn labelled(&self, name: &str) -> String {
        if self.voyage.check.safe { name.to_owned() } else { format!("{name} (unsafe)") }
    }

    /// The action of a leg, in words, with the prefix in an unsafe plan.
    fn what(&self, leg: &VoyageLeg) -> String {
        let label = self.label();
        match leg.side {
            Some(Side::Mirrored) => format!("{label}{} (mirrored)", leg.name),
            _ => format!("{label}{}", leg.name),
        }
    }

    fn place(&self, sample: &Sample) -> [f64; 2] {
        self.position([sample.pose.y, sample.pose.x])
    }

    fn position(&self, place: [f64; 2]) -> [f64; 2] {
        let (longitude, latitude) = self.plane.to_geographic(place);
        [longitude, latitude]
    }

    /// The end of the track.
    fn end(&self) -> [f64; 2] {
        self.sailed.ends.last().map_or([0.0; 2], |(pose, _)| self.position([pose.y, pose.x]))
    }

    /// The waypoints of the passage.
    fn waypoints(&self) -> Vec<Waypoint> {
        let Passage { longitude_deg, latitude_deg, before, leave_s, legs, .. } = &self.voyage.passage;
        let label = self.label();
        let first = Waypoint {
            name: "start".to_owned(),
            lon_deg: *longitude_deg,
            lat_deg: *latitude_deg,
            time_s: Some(0.0),
            leave_s: Some(*leave_s).filter(|leave| *leave > 0.0),
            note: noted(label, before),
            ..Waypoint::default()
        };
        let later = legs.iter().enumerate().map(|(index, leg)| Waypoint {
            id: index as u32 + 1,
            name: (index + 1).to_string(),
            lon_deg: leg.longitude_deg,
            lat_deg: leg.latitude_deg,
            turn_radius_m: leg.turn_radius_m,
            // A leg without duration has no speed.
            speed_m_s: Some(leg.speed_m_s).filter(|speed| *speed > 0.0),
            xtd_m: Some([leg.xtd_port_m, leg.xtd_starboard_m]),
            time_s: Some(leg.end_s),
            leave_s: Some(leg.leave_s).filter(|leave| *leave > leg.end_s),
            note: noted(label, std::iter::once(&leg.what).chain(&leg.then)),
        });
        let mut waypoints: Vec<Waypoint> = std::iter::once(first).chain(later).collect();
        if waypoints.len() == 1 {
            // A trial that stays at its node still needs a leg: to its farthest position.
            let from = [waypoints[0].lon_deg, waypoints[0].lat_deg];
            let away = |place: &[f64; 2]| self.plane.distance_m(from, *place);
            let places = self.sailed.samples.iter().map(|s| self.place(s));
            let farthest = places.max_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(from);
            let [lon_deg, lat_deg] = farthest;
            waypoints.push(Waypoint { id: 1, name: "1".to_owned(), lon_deg, lat_deg, ..Waypoint::default() });
        }
        waypoints
    }

    fn track(&self) -> Track {
        let points = self.sailed.samples.iter().map(|s| self.place(s)).chain([self.end()]);
        let clock_s = [0.0, self.sample_s];
        Track { name: self.labelled("planned track"), points: points.collect(), clock_s }
    }

    /// The track of step `k`, up to the start of the next one.
    fn line(&self, k: usize) -> Vec<[f64; 2]> {
        let samples = &self.sailed.samples;
        let own = samples.iter().skip_while(|s| s.leg != k).take_while(|s| s.leg == k);
        let mut line: Vec<[f64; 2]> = own.map(|s| self.place(s)).collect();
        line.push(samples.iter().find(|s| s.leg == k + 1).map_or(self.end(), |s| self.place(s)));
        line
    }

    /// A line per step that moves the ship, then start and goal.
    pub fn features(&self) -> Vec<Feature> {
        let mut features = Vec::new();
        let samples = &self.sailed.samples;
        for (k, (step, leg)) in self.document.steps.iter().zip(&self.voyage.legs).enumerate() {
            let line = self.line(k);
            if line.len() < 2 {
                continue;
            }
            let properties = json!({
                "step": k + 1,
                "name": self.what(leg),
                "action": step.action,
                "variant": step.variant,
                "informative": leg.informative,
                "side": leg.side,
                "start_s": leg.start_s,
                "duration_s": leg.duration_s,
                "heading_deg": leg.heading_deg,
                "speed_m_s": leg.speed_m_s,
                "safe": self.voyage.check.safe,
            });
            features.push(Feature::new(Geometry::Line(line), properties));
        }
        let check = &self.voyage.check;
        let point = |name: &str, place: [f64; 2]| {
            let properties = json!({ "name": name, "safe": check.safe, "faults": check.faults });
            Feature::new(Geometry::Point(place), properties)
        };
        if let Some(first) = samples.first() {
            features.push(point("start", self.place(first)));
            features.push(point("goal", self.end()));
        }
        features
    }
}

/// The actions, in words, with the prefix in an unsafe plan.
fn noted<'a>(label: &str, what: impl IntoIterator<Item = &'a String>) -> String {
    let what: Vec<String> = what.into_iter().map(|what| format!("{label}{what}")).collect();
    what.join(", ")
}
