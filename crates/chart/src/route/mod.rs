//! Routes and tracks as files: RTZ 1.0 (IEC 61174), GPX 1.1, QGroundControl's plans and GeoJSON (RFC 7946). Pure
//! functions from values to text.

mod formats;

use jiff::SignedDuration;
use refusal::check_numbers;

use crate::Invalid;
use crate::plane::distance_m;

pub use formats::{Feature, Geometry, geojson, gpx, qgroundcontrol, rtz};
pub use jiff::Timestamp;

/// A nautical mile \[m\].
const NAUTICAL_MILE_M: f64 = 1852.0;
/// A knot \[m/s\].
pub const KNOT_M_S: f64 = NAUTICAL_MILE_M / 3600.0;

/// Of WGS84's ellipsoid.
const ECCENTRICITY: f64 = 0.081_819_190_842_621_49;

/// Largest radius as a share of the shortest adjacent leg when radii are lowered: below the half that RTZ
/// requires, so that readers with another formula for a leg's length agree.
const FITTING: f64 = 0.49;

/// A point where the route turns.
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
    /// How far to port and to starboard of the leg that ends here the ship may come \[m\]; not written for the first waypoint.
    pub xtd_m: Option<[f64; 2]>,
    /// Time here, after the departure \[s\].
    pub time_s: Option<f64>,
    /// Time when the ship goes on, where she stays, after the departure \[s\].
    pub leave_s: Option<f64>,
    /// The activity on the leg that ends here; may be empty.
    pub note: String,
}

/// A route.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Route {
    /// Name; ECDIS expect the file to have the same name.
    pub name: String,
    /// The departure. Without it no times are written: no format has relative times.
    pub departure: Option<Timestamp>,
    /// Waypoints in the order of sailing; at least two.
    pub waypoints: Vec<Waypoint>,
}

/// A track: the ship's path, densely sampled.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    /// Name.
    pub name: String,
    /// Points in order: longitude and latitude, WGS84 \[deg\].
    pub points: Vec<[f64; 2]>,
    /// Time at the first point, after the departure, and the time from point to point \[s\].
    pub clock_s: [f64; 2],
}

impl Route {
    /// Length of the geodesic from waypoint `index` to the next \[m\]; `None` for the last.
    pub fn leg_m(&self, index: usize) -> Option<f64> {
        let (a, b) = (self.waypoints.get(index)?, self.waypoints.get(index + 1)?);
        Some(distance_m((a.lon_deg, a.lat_deg), (b.lon_deg, b.lat_deg)))
    }

    /// Course along the loxodrome from waypoint `index` to the next, true \[deg\]; `None` for the last.
    pub fn course_deg(&self, index: usize) -> Option<f64> {
        let (a, b) = (self.waypoints.get(index)?, self.waypoints.get(index + 1)?);
        Some(course_deg([a.lon_deg, a.lat_deg], [b.lon_deg, b.lat_deg]))
    }

    /// The time at waypoint `index`, if departure and time are known; to whole seconds.
    pub(crate) fn instant(&self, index: usize) -> Option<String> {
        let after_s = self.waypoints.get(index)?.time_s?;
        instant(self.departure?, after_s.round())
    }

    /// The time when the ship goes on from waypoint `index`, if she stays there and the departure is known.
    pub(crate) fn leave(&self, index: usize) -> Option<String> {
        instant(self.departure?, self.waypoints.get(index)?.leave_s?.round())
    }

    /// Lowers turn radii to 0.49 of the shortest adjacent leg.
    pub fn fit_radii(&mut self) {
        let limits: Vec<f64> = (0..self.waypoints.len()).map(|i| FITTING * self.shortest_leg_m(i)).collect();
        for (waypoint, limit) in self.waypoints.iter_mut().zip(limits) {
            waypoint.turn_radius_m = waypoint.turn_radius_m.map(|radius| radius.min(limit));
        }
    }

    /// Whether the waypoint is neither the first nor the last.
    pub(crate) fn is_inner(&self, index: usize) -> bool {
        index > 0 && index + 1 < self.waypoints.len()
    }

    fn shortest_leg_m(&self, index: usize) -> f64 {
        let legs = [index.checked_sub(1), Some(index)].into_iter().flatten();
        legs.filter_map(|i| self.leg_m(i)).fold(f64::INFINITY, f64::min)
    }

    /// Requirements that all formats share.
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        text("route name", &self.name)?;
        if self.waypoints.len() < 2 {
            let count = format!("{} waypoints", self.waypoints.len());
            return Err(Invalid::new("route", count, "at least two", "add a start and an end"));
        }
        let mut ids: Vec<u32> = self.waypoints.iter().map(|w| w.id).collect();
        ids.sort_unstable();
        if let Some(twice) = ids.windows(2).find(|w| w[0] == w[1]) {
            let repeated = format!("id {} twice", twice[0]);
            return Err(Invalid::new("route", repeated, "every id once", "number the waypoints"));
        }
        self.check_times()?;
        self.waypoints.iter().enumerate().try_for_each(|(index, w)| self.check_waypoint(index, w))
    }

    /// Refuses times that go backwards.
    fn check_times(&self) -> Result<(), Invalid> {
        let timed: Vec<(u32, f64)> = self.waypoints.iter().filter_map(|w| Some((w.id, w.time_s?))).collect();
        let Some(pair) = timed.windows(2).find(|w| w[1].1 < w[0].1) else { return Ok(()) };
        let [(before, early), (id, late)] = [pair[0], pair[1]];
        Err(Invalid::new(
            format!("waypoint {id}, time"),
            format!("{late} s"),
            format!("{early} s or more, the time of waypoint {before} before it"),
            "put the waypoints in the order of sailing",
        ))
    }

    fn check_waypoint(&self, index: usize, waypoint: &Waypoint) -> Result<(), Invalid> {
        let thing = format!("waypoint {}", waypoint.id);
        text(&format!("{thing}, name"), &waypoint.name)?;
        text(&format!("{thing}, note"), &waypoint.note)?;
        place(&thing, [waypoint.lon_deg, waypoint.lat_deg])?;
        let [port, starboard] = [0, 1].map(|side| waypoint.xtd_m.map(|xtd| xtd[side]));
        let numbers = [
            ("speed", waypoint.speed_m_s),
            ("turn radius", waypoint.turn_radius_m),
            ("time", waypoint.time_s),
            ("port XTD", port),
            ("starboard XTD", starboard),
        ];
        let numbers =
            numbers.into_iter().filter_map(|(name, value)| Some((format!("{thing}, {name}"), value?)));
        check_numbers(numbers, "a finite number of 0 or more", |value| value >= 0.0)?;
        let Some(radius) = waypoint.turn_radius_m else { return Ok(()) };
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
    /// The time at point `index`, after the departure \[s\].
    pub(crate) fn time_s(&self, index: usize) -> f64 {
        self.clock_s[0] + index as f64 * self.clock_s[1]
    }

    pub(crate) fn check(&self) -> Result<(), Invalid> {
        text("track name", &self.name)?;
        let point = |(i, p): (usize, &[f64; 2])| place(&format!("track `{}`, point {i}", self.name), *p);
        self.points.iter().enumerate().try_for_each(point)
    }
}

/// `after_s` after `departure`, as ISO 8601 in UTC.
fn instant(departure: Timestamp, after_s: f64) -> Option<String> {
    let later = departure.checked_add(SignedDuration::try_from_secs_f64(after_s).ok()?).ok()?;
    Some(later.to_string())
}

/// Course along the loxodrome, true \[deg\].
fn course_deg(from: [f64; 2], to: [f64; 2]) -> f64 {
    // Isometric latitude on the ellipsoid: a loxodrome is straight over it.
    let isometric = |lat_deg: f64| {
        let sin = libm::sin(lat_deg.to_radians());
        libm::atanh(sin) - ECCENTRICITY * libm::atanh(ECCENTRICITY * sin)
    };
    let east = (to[0] - from[0] + 540.0).rem_euclid(360.0) - 180.0;
    let north = isometric(to[1]) - isometric(from[1]);
    // Along a parallel both isometric latitudes are equal.
    libm::atan2(east.to_radians(), north).to_degrees().rem_euclid(360.0)
}

/// Longitude within ±180 (180 itself is written −180), latitude within ±90.
fn place(thing: &str, [lon, lat]: [f64; 2]) -> Result<(), Invalid> {
    if lon.abs() <= 180.0 && lat.abs() <= 90.0 {
        return Ok(());
    }
    let position = format!("longitude {lon}, latitude {lat}");
    Err(Invalid::new(thing, position, "degrees within ±180 and ±90", "correct it"))
}

/// At least `least` positions, to 10⁻⁹ degrees (0.1 mm); `thing` names them in refusals.
fn rounded(places: &[[f64; 2]], least: usize, thing: &str) -> Result<Vec<[f64; 2]>, Invalid> {
    places.iter().try_for_each(|p| place(thing, *p))?;
    if places.len() < least {
        let (count, expected) = (format!("{} points", places.len()), format!("at least {least}"));
        return Err(Invalid::new(thing, count, expected, "add points"));
    }
    Ok(places.iter().map(|p| p.map(|v| (v * 1e9).round() / 1e9)).collect())
}

/// Requires names of one line of text: XML cannot hold control characters.
fn text(thing: &str, text: &str) -> Result<(), Invalid> {
    let bad = |c: char| c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}');
    match text.chars().find(|c| bad(*c)) {
        None => Ok(()),
        Some(c) => {
            let character = format!("character {:?}", u32::from(c));
            Err(Invalid::new(thing, character, "one line of text", "remove the character"))
        }
    }
}
