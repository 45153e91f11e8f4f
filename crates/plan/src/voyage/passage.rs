//! The passage of a plan, as on a bridge.

use std::f64::consts::TAU;
use std::ops::Range;

use chart::Plane;
use chart::route::Timestamp;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::BASIC_MOVES;

/// The voyage as a bridge plans it: courses from waypoint to waypoint. Straight moves on one course are one leg; a turn under
/// way is a waypoint where its two courses cross.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Passage {
    /// When the trial begins, in UTC; absent where `plan.toml` does not say.
    pub departure: Option<String>,
    /// The tide that the plan counts with; absent without a table.
    pub tide: Option<Tide>,
    /// Departures for which the same plan holds; absent where nothing says when it may be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub departures: Option<Departures>,
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
    /// that are kept come, at least 10 m and what positions and the hull are uncertain by, and no farther than the water is clear,
    /// unless the nominal track comes there.
    pub xtd_port_m: f64,
    /// The same to starboard \[m\].
    pub xtd_starboard_m: f64,
    /// Least charted depth between its cross-track distances, at the chart's datum; absent where none is charted \[m\].
    pub least_depth_m: Option<f64>,
    /// How much deeper she is at the speed of this leg; absent without `hull.block_coefficient` \[m\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub squat_m: Option<f64>,
    /// What remains under the keel at the tide's least level; absent without `hull.draught_m`, too \[m\].
    pub under_keel_m: Option<f64>,
    /// The danger nearest to the nominal track of the reference point.
    pub nearest: Option<NearestDanger>,
    /// Charted things near the nominal track that a bridge knows of: whom to call, what lies on the ground, where others meet.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub passes: Vec<String>,
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

/// A row of a tide table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TideRow {
    /// Seconds since 1970, UTC.
    pub at_s: f64,
    /// Height of the water over the chart's datum \[m\].
    pub level_m: f64,
    /// North and east components of the stream \[m/s\].
    pub stream_m_s: [f64; 2],
}

/// What the tide is at worst from the departure until the trial has to be over.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tide {
    /// When the trial has to be over, after its departure \[s\].
    pub slot_s: f64,
    /// Least height of the water over the chart's datum \[m\]: charted depths count with it.
    pub level_m: f64,
    /// Middle of the stream, north and east \[m/s\]: it joins the known current.
    pub stream_m_s: [f64; 2],
    /// Farthest that the stream is from its middle \[m/s\]: it joins the unknown current.
    pub spread_m_s: f64,
}

/// Departures for which a plan holds, the planned one among them: the tide is no worse than what it counts with, and the slowest vessel
/// of the check is back in the slot. All in UTC.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Departures {
    /// The earliest.
    pub earliest: String,
    /// What closes it before.
    pub before: String,
    /// The latest.
    pub latest: String,
    /// What closes it after.
    pub after: String,
    /// The one with most water under the keel, the earliest of equals; absent without a tide.
    pub best: Option<String>,
}

/// When trials may be: a table of tides and a slot.
#[derive(Clone, Debug, Default)]
pub struct Times {
    /// The tide, in ascending order; empty if it is not known.
    pub table: Vec<TideRow>,
    /// The key and the time that the slot begins with, and ends with \[s since 1970, UTC\].
    pub bounds: [Option<(&'static str, f64)>; 2],
}

/// Steps between departures that are tried, and how far from the planned one \[s\].
const TRIED_S: f64 = 60.0;
const FARTHEST_S: f64 = 2.0 * 86_400.0;

impl Departures {
    /// Around `departure_s`, for a trial that lasts so long and counts with `tide`; `None` where nothing limits it.
    pub fn around(times: &Times, tide: Option<&Tide>, departure_s: f64, lasts_s: f64) -> Option<Self> {
        if times.table.is_empty() && times.bounds.iter().all(Option::is_none) {
            return None;
        }
        let closed = |at_s: f64| times.closed(tide, at_s, lasts_s);
        let last = |way: f64| {
            let mut steps = (1..).map(|k| departure_s + way * TRIED_S * f64::from(k));
            let why = steps.find_map(|at_s| match closed(at_s) {
                None if (at_s - departure_s).abs() > FARTHEST_S => {
                    Some((at_s, "nothing within two days".to_owned()))
                }
                why => Some((at_s, why?)),
            });
            let (at_s, why) = why.unwrap_or((departure_s, String::new()));
            (at_s - way * TRIED_S, why)
        };
        let ((earliest_s, before), (latest_s, after)) = (last(-1.0), last(1.0));
        let level_m = |at_s: f64| {
            Tide::worst(&times.table, at_s, lasts_s).map_or(f64::NEG_INFINITY, |tide| tide.level_m)
        };
        let steps = (0..).map(|k| earliest_s + TRIED_S * f64::from(k)).take_while(|at_s| *at_s <= latest_s);
        let best = steps.map(|at_s| (at_s, level_m(at_s))).reduce(|a, b| if b.1 > a.1 { b } else { a });
        let (earliest, latest) = (utc(earliest_s), utc(latest_s));
        let best = best.filter(|_| tide.is_some()).map(|(at_s, _)| utc(at_s));
        Some(Self { earliest, before, latest, after, best })
    }
}

impl Times {
    /// Why a trial that lasts so long cannot begin at a time by what the plan counts with; `None` if it can.
    fn closed(&self, tide: Option<&Tide>, at_s: f64, lasts_s: f64) -> Option<String> {
        match self.bounds {
            [Some((key, begins_s)), _] if at_s < begins_s => return Some(format!("`{key}`")),
            [_, Some((key, ends_s))] if at_s + lasts_s > ends_s => return Some(format!("`{key}`")),
            _ => {}
        }
        let tide = tide?;
        let Some(all) = within(&self.table, at_s, lasts_s) else {
            return Some("the table of tides ends".to_owned());
        };
        all.iter().find_map(|row| {
            let [north, east] = [0, 1].map(|k: usize| row.stream_m_s[k] - tide.stream_m_s[k]);
            if row.level_m < tide.level_m - 1e-9 {
                return Some(format!("level {:.2} m at {}", row.level_m, utc(row.at_s)));
            }
            let speed = libm::hypot(row.stream_m_s[0], row.stream_m_s[1]);
            let is_other = libm::hypot(north, east) > tide.spread_m_s + 1e-9;
            is_other.then(|| format!("stream {speed:.2} m/s at {}", utc(row.at_s)))
        })
    }
}

/// A time in seconds since 1970 as a time of day in UTC, to the second.
pub fn utc(at_s: f64) -> String {
    Timestamp::from_second(at_s.round() as i64).map_or_else(|_| format!("{at_s} s"), |at| at.to_string())
}

/// The rows of a table at both ends of a trial and within it; `None` where it does not cover that.
fn within(table: &[TideRow], departure_s: f64, lasts_s: f64) -> Option<Vec<TideRow>> {
    let ends = [departure_s, departure_s + lasts_s];
    let inner = table.iter().filter(|row| ends[0] < row.at_s && row.at_s < ends[1]).copied();
    Some([at(table, ends[0])?, at(table, ends[1])?].into_iter().chain(inner).collect())
}

/// North and east of a current of `speed_m_s` towards a compass direction \[m/s\].
pub fn current_m_s(speed_m_s: f64, towards_deg: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(towards_deg.to_radians());
    [speed_m_s * cos, speed_m_s * sin]
}

impl Tide {
    /// The worst case of a table of ascending times, interpolated linearly, over `slot_s` from `departure_s`.
    /// `None` where the table does not cover it.
    pub fn worst(table: &[TideRow], departure_s: f64, slot_s: f64) -> Option<Self> {
        let all = within(table, departure_s, slot_s)?;
        let level_m = all.iter().map(|row| row.level_m).fold(f64::INFINITY, f64::min);
        let stream_m_s = [0, 1].map(|c: usize| {
            let of = all.iter().map(|row| row.stream_m_s[c]);
            0.5 * (of.clone().fold(f64::INFINITY, f64::min) + of.fold(f64::NEG_INFINITY, f64::max))
        });
        let off =
            |row: &TideRow| libm::hypot(row.stream_m_s[0] - stream_m_s[0], row.stream_m_s[1] - stream_m_s[1]);
        Some(Self { slot_s, level_m, stream_m_s, spread_m_s: all.iter().map(off).fold(0.0, f64::max) })
    }
}

/// The table interpolated at a time within it.
fn at(table: &[TideRow], at_s: f64) -> Option<TideRow> {
    let later = table.iter().position(|row| row.at_s >= at_s)?;
    let after = table[later];
    if after.at_s == at_s {
        return Some(after);
    }
    let before = table[later.checked_sub(1)?];
    let part = (at_s - before.at_s) / (after.at_s - before.at_s);
    let between = |a: f64, b: f64| a + part * (b - a);
    Some(TideRow {
        at_s,
        level_m: between(before.level_m, after.level_m),
        stream_m_s: [0, 1].map(|c: usize| between(before.stream_m_s[c], after.stream_m_s[c])),
    })
}

// Sunrise and sunset, by the low-precision formulas of the Astronomical Almanac: to 0.01° from 1950 to 2050.

/// Elevation of the sun's centre when its upper edge rises or sets in usual refraction \[deg\].
const HORIZON_DEG: f64 = -0.833;
/// 2000-01-01 12:00 \[s since 1970, UTC\].
const J2000_S: f64 = 946_728_000.0;
const DAY_S: f64 = 86_400.0;
/// Steps towards noon, sunrise and sunset: each leaves about a hundredth of the error.
const STEPS: u32 = 6;

/// The daylight of the day whose noon is nearest to a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Daylight {
    /// From sunrise to sunset \[s since 1970, UTC\].
    Between([f64; 2]),
    /// All day.
    Always,
    /// Never on this day.
    Never,
}

impl Daylight {
    /// At a longitude and latitude \[deg\], on the day of `at_s` \[s since 1970, UTC\].
    pub fn of([lon_deg, lat_deg]: [f64; 2], at_s: f64) -> Self {
        let lon = lon_deg.to_radians();
        let when = |target: &dyn Fn(f64) -> f64, from_s: f64| {
            (0..STEPS).fold(from_s, |at_s, _| {
                let ahead = libm::remainder(hour_angle(lon, at_s) - target(at_s), TAU);
                at_s - ahead / TAU * DAY_S
            })
        };
        let noon_s = when(&|_| 0.0, at_s);
        let cosine = |at_s: f64| {
            let (declination, lat) = (sun(at_s)[0], lat_deg.to_radians());
            let up = libm::sin(HORIZON_DEG.to_radians()) - libm::sin(lat) * libm::sin(declination);
            up / (libm::cos(lat) * libm::cos(declination))
        };
        match cosine(noon_s) {
            high if high >= 1.0 => Self::Never,
            low if low <= -1.0 => Self::Always,
            _ => {
                let half = |at_s: f64| libm::acos(cosine(at_s).clamp(-1.0, 1.0));
                Self::Between([when(&|at_s| -half(at_s), noon_s), when(&half, noon_s)])
            }
        }
    }
}

/// The hour angle of the sun west of the meridian of `lon` \[rad\].
fn hour_angle(lon: f64, at_s: f64) -> f64 {
    let days = (at_s - J2000_S) / DAY_S;
    let greenwich_deg = 280.460_618_37 + 360.985_647_366_29 * days;
    libm::remainder(greenwich_deg.to_radians() + lon - sun(at_s)[1], TAU)
}

/// Declination and right ascension of the sun \[rad\].
fn sun(at_s: f64) -> [f64; 2] {
    let days = (at_s - J2000_S) / DAY_S;
    let anomaly = (357.528 + 0.985_600_3 * days).to_radians();
    let centre_deg = 1.915 * libm::sin(anomaly) + 0.020 * libm::sin(2.0 * anomaly);
    let longitude = (280.460 + 0.985_647_4 * days + centre_deg).to_radians();
    let obliquity = (23.439 - 4e-7 * days).to_radians();
    let (sin, cos) = libm::sincos(longitude);
    [libm::asin(libm::sin(obliquity) * sin), libm::atan2(libm::cos(obliquity) * sin, cos)]
}

/// Courses that differ by less are one \[rad\].
const ONE_COURSE_RAD: f64 = 1e-6;

/// A leg of the passage under construction; positions are north and east \[m\].
pub struct Draft {
    /// The move, or the maneuver.
    pub what: String,
    /// Whether it is an informative maneuver.
    pub informative: bool,
    /// Whether it may be extended.
    pub straight: bool,
    /// Steps of the plan on this leg, some of them in part, and those at its waypoint.
    pub steps: Range<usize>,
    /// The place where it begins.
    pub from: [f64; 2],
    /// The place where it ends.
    pub to: [f64; 2],
    /// Radius of the turn at its end, if it turns under way \[m\].
    pub turn_radius_m: Option<f64>,
    /// Samples of the nominal track.
    pub samples: Range<usize>,
    /// What is done at its end.
    pub then: Vec<String>,
    /// The sample at which the ship leaves its end.
    pub leaves: usize,
}

/// The line between the waypoints of a leg, north and east \[m\].
pub struct Line {
    from: [f64; 2],
    /// Sine and cosine of its course.
    turned: (f64, f64),
    /// Its length \[m\].
    pub length_m: f64,
}

/// The move that goes straight ahead.
pub const STRAIGHT: &str = BASIC_MOVES[0];

/// Appends `next` to the legs in `all`, or extends the last leg by it if both go straight on one course.
pub fn append_leg(all: &mut Vec<Draft>, next: Draft) {
    let Some(last) = all.last_mut() else { return all.push(next) };
    let turned = libm::remainder(next.course() - last.course(), std::f64::consts::TAU).abs();
    let on = last.straight && next.straight && last.turn_radius_m.is_none() && last.then.is_empty();
    if !on || turned > ONE_COURSE_RAD {
        return all.push(next);
    }
    last.to = next.to;
    last.steps.end = next.steps.end;
    (last.samples.end, last.leaves) = (next.samples.end, next.leaves);
    last.turn_radius_m = next.turn_radius_m;
}

impl Draft {
    fn course(&self) -> f64 {
        libm::atan2(self.to[1] - self.from[1], self.to[0] - self.from[0])
    }

    /// The line between its waypoints.
    pub fn line(&self) -> Line {
        Line::between(self.from, self.to)
    }
}

impl Line {
    /// The line between two places.
    pub fn between(from: [f64; 2], to: [f64; 2]) -> Self {
        let course = libm::atan2(to[1] - from[1], to[0] - from[0]);
        Self { from, turned: libm::sincos(course), length_m: distance(from, to) }
    }

    /// North and east of the place with these coordinates along the line and to starboard of it.
    pub fn place(&self, [along, across]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.turned;
        [self.from[0] + along * cos - across * sin, self.from[1] + along * sin + across * cos]
    }

    /// The coordinates along the line and to starboard of it.
    pub fn along(&self, [north, east]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.turned;
        let [north, east] = [north - self.from[0], east - self.from[1]];
        [north * cos + east * sin, east * cos - north * sin]
    }

    /// Distance from the line between the waypoints \[m\].
    pub fn away(&self, place: [f64; 2]) -> f64 {
        let [along, across] = self.along(place);
        let beyond = along - along.clamp(0.0, self.length_m);
        libm::hypot(beyond, across)
    }
}

/// The distance of two places \[m\].
pub(super) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}
