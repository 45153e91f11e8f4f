//! Legs of a passage under construction, and the lines between their waypoints.

use std::ops::Range;

use crate::BASIC_MOVES;

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
