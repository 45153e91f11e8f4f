//! The plan as files for others: GeoJSON track, RTZ and GPX route.

use chart::route::{Feature, Geometry, Route, Track, Waypoint, geojson, gpx, rtz};
use chart::{Invalid, Plane};
use serde_json::{Value, json};
use trial::{Sailed, Sample, Side};

use crate::documents::{PlanDocument, Voyage, VoyageLeg};

/// A plan's track on the globe.
pub struct Routes<'a> {
    /// The plane that it was sailed on.
    pub plane: &'a Plane,
    /// The plan.
    pub document: &'a PlanDocument,
    /// Its part at sea.
    pub voyage: &'a Voyage,
    /// What was sailed.
    pub sailed: &'a Sailed,
}

impl Routes<'_> {
    /// Names and contents of `track.geojson`, `route.rtz` and `route.gpx`.
    ///
    /// # Errors
    /// A route that the format cannot hold, with the name of its file.
    pub fn files(&self) -> Result<Vec<(&'static str, String)>, (&'static str, Invalid)> {
        let mut route = Route { name: self.labelled("route"), waypoints: self.waypoints() };
        route.fit_radii();
        let files = [
            ("track.geojson", geojson(&self.features())),
            ("route.rtz", rtz(&route)),
            ("route.gpx", gpx(&route, &[self.track()])),
        ];
        let named = |(name, text): (&'static str, Result<String, Invalid>)| match text {
            Ok(text) => Ok((name, text)),
            Err(invalid) => Err((name, invalid)),
        };
        files.into_iter().map(named).collect()
    }

    /// A name, of which a plan that fails its check says so.
    fn labelled(&self, name: &str) -> String {
        if self.voyage.check.safe { name.to_owned() } else { format!("{name} (unsafe)") }
    }

    /// What is done on a leg, in words; of an unsafe plan each says so.
    fn what(&self, leg: &VoyageLeg) -> String {
        let label = if self.voyage.check.safe { "" } else { "unsafe plan: " };
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

    /// Where the track ends.
    fn end(&self) -> [f64; 2] {
        self.sailed.ends.last().map_or([0.0; 2], |(pose, _)| self.position([pose.y, pose.x]))
    }

    /// The nodes that the plan passes, each where the course or what is done may change.
    fn waypoints(&self) -> Vec<Waypoint> {
        let mut waypoints: Vec<Waypoint> = Vec::new();
        let legs = &self.voyage.legs;
        let after =
            |k: usize| legs.get(k + 1).map_or(self.end(), |leg| [leg.longitude_deg, leg.latitude_deg]);
        if let Some(first) = legs.first() {
            waypoints.push(Waypoint {
                name: "start".to_owned(),
                lon_deg: first.longitude_deg,
                lat_deg: first.latitude_deg,
                ..Waypoint::default()
            });
        }
        for (k, leg) in legs.iter().enumerate() {
            let [lon_deg, lat_deg] = after(k);
            let from = waypoints.last().map_or([0.0; 2], |w| [w.lon_deg, w.lat_deg]);
            let way = geodesic(self.plane, from, [lon_deg, lat_deg]);
            if way < 1.0 {
                // Turns on the spot and maneuvers that end where they began are told at the waypoint itself.
                if let Some(last) = waypoints.last_mut() {
                    let so_far =
                        if last.note.is_empty() { String::new() } else { format!("{}, ", last.note) };
                    last.note = so_far + &self.what(leg);
                }
                continue;
            }
            let id = waypoints.len() as u32;
            waypoints.push(Waypoint {
                id,
                name: format!("{id}"),
                lon_deg,
                lat_deg,
                turn_radius_m: Some(way / 4.0),
                // A leg that is over as soon as it begins has no speed.
                speed_m_s: (leg.duration_s > 0.0).then(|| (way / leg.duration_s).max(0.01)),
                note: self.what(leg),
            });
        }
        if waypoints.len() == 1 {
            // A trial that stays at its node still needs a leg: to where it strays farthest.
            let from = [waypoints[0].lon_deg, waypoints[0].lat_deg];
            let away = |place: &[f64; 2]| geodesic(self.plane, from, *place);
            let places = self.sailed.samples.iter().map(|s| self.place(s));
            let farthest = places.max_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(from);
            let [lon_deg, lat_deg] = farthest;
            waypoints.push(Waypoint { id: 1, name: "1".to_owned(), lon_deg, lat_deg, ..Waypoint::default() });
        }
        waypoints
    }

    fn track(&self) -> Track {
        let points = self.sailed.samples.iter().map(|s| self.place(s)).chain([self.end()]);
        Track { name: self.labelled("planned track"), points: points.collect() }
    }

    fn features(&self) -> Vec<Feature> {
        let mut features = Vec::new();
        let samples = &self.sailed.samples;
        for (k, (step, leg)) in self.document.steps.iter().zip(&self.voyage.legs).enumerate() {
            let own = samples.iter().skip_while(|s| s.leg != k).take_while(|s| s.leg == k);
            let mut line: Vec<[f64; 2]> = own.map(|s| self.place(s)).collect();
            line.push(samples.iter().find(|s| s.leg == k + 1).map_or(self.end(), |s| self.place(s)));
            if line.len() < 2 {
                continue;
            }
            features.push(Feature {
                geometry: Geometry::Line(line),
                properties: object(json!({
                    "step": k + 1,
                    "action": step.action,
                    "variant": step.variant,
                    "informative": leg.informative,
                    "side": leg.side,
                    "start_s": leg.start_s,
                    "duration_s": leg.duration_s,
                    "heading_deg": leg.heading_deg,
                    "speed_m_s": leg.speed_m_s,
                    "safe": self.voyage.check.safe,
                })),
            });
        }
        let check = &self.voyage.check;
        let point = |name: &str, place: [f64; 2]| Feature {
            geometry: Geometry::Point(place),
            properties: object(json!({ "name": name, "safe": check.safe, "faults": check.faults })),
        };
        if let Some(first) = samples.first() {
            features.push(point("start", self.place(first)));
            features.push(point("goal", self.end()));
        }
        features
    }
}

fn geodesic(plane: &Plane, a: [f64; 2], b: [f64; 2]) -> f64 {
    let (a, b) = (plane.to_plane(a[0], a[1]), plane.to_plane(b[0], b[1]));
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

fn object(value: Value) -> serde_json::Map<String, Value> {
    match value {
        Value::Object(object) => object,
        _ => serde_json::Map::new(),
    }
}
