use super::time::Instant;
use crate::Invalid;
use crate::plane::distance_m;

/// A nautical mile \[m\].
pub(crate) const NAUTICAL_MILE_M: f64 = 1852.0;

/// Largest radius as a share of the shortest adjacent leg when radii are lowered: below the half that RTZ
/// asks, so that readers with another formula for a leg's length agree.
const FITTING: f64 = 0.49;

/// A point that the route turns at.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Waypoint {
    /// Identity, unique within the route.
    pub id: u32,
    /// Name; may be empty.
    pub name: String,
    /// Longitude, WGS84 \[deg\].
    pub lon_deg: f64,
    /// Latitude, WGS84 \[deg\].
    pub lat_deg: f64,
    /// Radius of the turn here \[m\]; not written for the first and the last waypoint.
    pub turn_radius_m: Option<f64>,
    /// Speed on the leg that ends here \[m/s\]; not written for the first waypoint.
    pub speed_m_s: Option<f64>,
    /// Half width of the corridor of the leg that ends here, to port and starboard \[m\]; not written for
    /// the first waypoint.
    pub corridor_m: Option<f64>,
    /// Time of arrival since the departure \[s\].
    pub t_s: Option<f64>,
    /// What is done on the leg that ends here; may be empty.
    pub note: String,
}

/// A route.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Route {
    /// Name; ECDIS expect the file to be called like it.
    pub name: String,
    /// Waypoints in the order of sailing; at least two.
    pub waypoints: Vec<Waypoint>,
    /// Departure as `YYYY-MM-DDThh:mm:ssZ`. Without it there are no times, as no format tells times from
    /// the departure.
    pub departure_utc: Option<String>,
}

/// A track: where the ship goes, densely.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    /// Name.
    pub name: String,
    /// Points in order.
    pub points: Vec<TrackPoint>,
}

/// A point of a track.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrackPoint {
    /// Longitude, WGS84 \[deg\].
    pub lon_deg: f64,
    /// Latitude, WGS84 \[deg\].
    pub lat_deg: f64,
    /// Time since the departure \[s\].
    pub t_s: Option<f64>,
}

impl Route {
    /// Length of the geodesic from waypoint `index` to the next \[m\]; `None` for the last.
    pub fn leg_m(&self, index: usize) -> Option<f64> {
        let (a, b) = (self.waypoints.get(index)?, self.waypoints.get(index + 1)?);
        Some(distance_m((a.lon_deg, a.lat_deg), (b.lon_deg, b.lat_deg)))
    }

    /// Lowers every turn radius to 0.49 of the shortest adjacent leg and returns how many were lowered.
    pub fn fit_radii(&mut self) -> usize {
        let limits: Vec<f64> = (0..self.waypoints.len()).map(|i| FITTING * self.shortest_leg_m(i)).collect();
        let mut lowered = 0;
        for (waypoint, limit) in self.waypoints.iter_mut().zip(limits) {
            if let Some(radius) = waypoint.turn_radius_m.as_mut().filter(|r| **r > limit) {
                *radius = limit;
                lowered += 1;
            }
        }
        lowered
    }

    /// Whether the waypoint is neither the first nor the last.
    pub(crate) fn is_inner(&self, index: usize) -> bool {
        index > 0 && index + 1 < self.waypoints.len()
    }

    fn shortest_leg_m(&self, index: usize) -> f64 {
        let legs = [index.checked_sub(1), Some(index)].into_iter().flatten();
        legs.filter_map(|i| self.leg_m(i)).fold(f64::INFINITY, f64::min)
    }

    /// The departure, where there is one.
    pub(crate) fn departure(&self) -> Result<Option<Instant>, Invalid> {
        self.departure_utc.as_deref().map(Instant::parse).transpose()
    }

    /// What all formats ask of a route.
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        text("route name", &self.name)?;
        if self.waypoints.len() < 2 {
            let found = format!("{} waypoints", self.waypoints.len());
            return Err(Invalid::new("route", found, "at least two", "add a start and an end"));
        }
        let mut ids: Vec<u32> = self.waypoints.iter().map(|w| w.id).collect();
        ids.sort_unstable();
        if let Some(twice) = ids.windows(2).find(|w| w[0] == w[1]) {
            let found = format!("id {} twice", twice[0]);
            return Err(Invalid::new("route", found, "every id once", "number the waypoints"));
        }
        let mut before = f64::NEG_INFINITY;
        for (index, waypoint) in self.waypoints.iter().enumerate() {
            self.check_waypoint(index, waypoint)?;
            let t = waypoint.t_s.unwrap_or(before);
            if t < before {
                let thing = format!("waypoint {}, time", waypoint.id);
                return Err(Invalid::new(
                    thing,
                    format!("{t} s"),
                    format!("{before} s or later"),
                    "correct it",
                ));
            }
            before = t;
        }
        Ok(())
    }

    fn check_waypoint(&self, index: usize, waypoint: &Waypoint) -> Result<(), Invalid> {
        let thing = format!("waypoint {}", waypoint.id);
        text(&format!("{thing}, name"), &waypoint.name)?;
        text(&format!("{thing}, note"), &waypoint.note)?;
        place(&thing, waypoint.lon_deg, waypoint.lat_deg, waypoint.t_s)?;
        for (name, value) in [("speed", waypoint.speed_m_s), ("corridor", waypoint.corridor_m)] {
            positive(&format!("{thing}, {name}"), value)?;
        }
        let Some(radius) = waypoint.turn_radius_m else { return Ok(()) };
        positive(&format!("{thing}, turn radius"), waypoint.turn_radius_m)?;
        let half = self.shortest_leg_m(index) / 2.0;
        if !self.is_inner(index) || radius < half {
            return Ok(());
        }
        Err(Invalid::new(
            format!("{thing}, turn radius"),
            format!("{radius} m"),
            format!("below {half:.1} m, half the shortest adjacent leg"),
            "lower it (`fit_radii`) or move the waypoint",
        ))
    }
}

impl Track {
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        text("track name", &self.name)?;
        let point = |(i, p): (usize, &TrackPoint)| {
            place(&format!("track `{}`, point {i}", self.name), p.lon_deg, p.lat_deg, p.t_s)
        };
        self.points.iter().enumerate().try_for_each(point)
    }
}

/// Longitude within ±180 (180 itself is written −180), latitude within ±90, a time of 0 or more.
pub(crate) fn place(thing: &str, lon: f64, lat: f64, t_s: Option<f64>) -> Result<(), Invalid> {
    let time = t_s.is_none_or(|t| (0.0..1e10).contains(&t));
    if lon.abs() <= 180.0 && lat.abs() <= 90.0 && time {
        return Ok(());
    }
    let found = format!("longitude {lon}, latitude {lat}, time {t_s:?}");
    Err(Invalid::new(thing, found, "degrees within ±180 and ±90, seconds since the departure", "correct it"))
}

fn positive(thing: &str, value: Option<f64>) -> Result<(), Invalid> {
    match value {
        Some(v) if !(v.is_finite() && v >= 0.0) => {
            Err(Invalid::new(thing, v.to_string(), "a finite number of 0 or more", "correct it"))
        }
        _ => Ok(()),
    }
}

/// Names must be one line of text: XML cannot hold control characters.
pub(crate) fn text(thing: &str, text: &str) -> Result<(), Invalid> {
    let bad = |c: char| c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}');
    match text.chars().find(|c| bad(*c)) {
        None => Ok(()),
        Some(c) => {
            let found = format!("character {:?}", u32::from(c));
            Err(Invalid::new(thing, found, "one line of text", "remove the character"))
        }
    }
}
