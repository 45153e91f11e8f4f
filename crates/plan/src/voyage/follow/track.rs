//! Planned tracks and positions, as they are compared.

use super::super::legs::{Primitive, VoyageLeg};
use super::super::task::Task;
use crate::grid::wrap;

/// Most points of a track, and most positions, that are compared.
const MOST: f64 = 3000.0;
/// Standard deviations by which a position may be off.
const SIGMAS: f64 = 5.0;
/// Least standard deviation of logged positions \[m\]: a ship's autopilot may have better ones than her log.
const POSITION_M: f64 = 3.0;

/// Slower points stay where they are \[m/s\].
const SLOWEST_M_S: f64 = 0.1;

/// Part of a maneuver's way that a ship may be off its track.
const SPREAD: f64 = 0.25;

/// A sample of a planned track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackPoint {
    /// When the ship is there, after the departure \[s\].
    pub at_s: f64,
    /// East and north of the plane's origin \[m\].
    pub place: [f64; 2],
    /// True heading \[deg\].
    pub heading_deg: f64,
    /// Speed \[m/s\].
    pub speed_m_s: f64,
    /// Its step.
    pub step: usize,
    /// Whether it is of an informative maneuver.
    pub informative: bool,
}

/// A step of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedStep {
    /// Its action.
    pub name: String,
    /// How far from the track the ship may come along it \[m\].
    pub within_m: f64,
}

/// A planned track.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedTrack {
    /// Its samples in order, at least one.
    pub points: Vec<TrackPoint>,
    /// The steps that they are of.
    pub steps: Vec<PlannedStep>,
}

/// A position of the ship.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShipPosition {
    /// The line that it stands on.
    pub line: usize,
    /// When she was there, after the departure \[s\].
    pub at_s: f64,
    /// East and north of the plane's origin \[m\].
    pub place: [f64; 2],
    /// True heading, if known \[deg\].
    pub heading_deg: Option<f64>,
    /// Speed over the ground, if known \[m/s\].
    pub speed_m_s: Option<f64>,
}

impl TrackPoint {
    /// Distance of a place from it \[m\].
    pub fn away_m(&self, [east, north]: [f64; 2]) -> f64 {
        libm::hypot(east - self.place[0], north - self.place[1])
    }
}

impl PlannedTrack {
    /// The track of `points`, with a step for each of the plan's `legs`. One counts as done within the tolerance at nodes and
    /// what positions may be off; a maneuver within the spread of those who rehearsed it, too, but no farther than a part of
    /// its way: beyond, another maneuver would pass.
    pub fn new(points: Vec<TrackPoint>, legs: &[VoyageLeg], primitives: &[Primitive], task: &Task) -> Self {
        let least_m = task.approach.tolerance.distance_m + uncertain_m(task.sensors.position_m);
        let step = |(index, leg): (usize, &VoyageLeg)| {
            let own = primitives.iter().filter(|primitive| leg.informative && primitive.maneuver == leg.name);
            let spread_m = own.map(|own| own.spread_m).fold(0.0, f64::max);
            let pairs = points.windows(2).filter(|pair| pair[0].step == index && pair[0].informative);
            let way_m: f64 = pairs.map(|pair| pair[0].away_m(pair[1].place)).sum();
            PlannedStep { name: leg.name.clone(), within_m: least_m + spread_m.min(SPREAD * way_m) }
        };
        let steps = legs.iter().enumerate().map(step).collect();
        Self { points, steps }
    }

    /// The same, with every step done within `within_m`, if that is stated.
    #[must_use]
    pub fn within(mut self, within_m: Option<f64>) -> Self {
        let Some(within_m) = within_m else { return self };
        self.steps.iter_mut().for_each(|step| step.within_m = within_m);
        self
    }

    /// The direction of its motion over the ground at a point, east and north; `None` where it stays.
    pub(super) fn course(&self, k: usize) -> Option<[f64; 2]> {
        let [a, b] = [k.saturating_sub(1), (k + 1).min(self.points.len() - 1)].map(|k| &self.points[k]);
        let way_m = a.away_m(b.place);
        let is_moving = way_m > SLOWEST_M_S * (b.at_s - a.at_s);
        is_moving.then(|| [0, 1].map(|c| (b.place[c] - a.place[c]) / way_m))
    }

    /// The usual speed where it moves \[m/s\].
    pub(super) fn usual_m_s(&self) -> f64 {
        let speeds = self.points.iter().map(|point| point.speed_m_s);
        median(speeds.filter(|speed| *speed > SLOWEST_M_S)).max(SLOWEST_M_S)
    }

    /// When it ends, after the departure \[s\].
    pub fn ends_s(&self) -> f64 {
        self.points.last().map_or(0.0, |last| last.at_s)
    }

    /// The track with no more points than can be compared: the first of every step, and the last of all, stay.
    pub(super) fn thinned(&self) -> Self {
        let apart_s = self.ends_s() / MOST;
        let last = self.points.len() - 1;
        let mut points: Vec<TrackPoint> = Vec::new();
        for (k, point) in self.points.iter().enumerate() {
            let is_new = |before: &TrackPoint| {
                point.step != before.step
                    || point.informative != before.informative
                    || point.at_s >= before.at_s + apart_s
            };
            if k == last || points.last().is_none_or(is_new) {
                points.push(*point);
            }
        }
        Self { points, steps: self.steps.clone() }
    }
}

/// No more positions than can be compared: the last, and both ends of gaps longer than `max_gap_s`, stay.
pub(super) fn thinned_positions(all: &[ShipPosition], max_gap_s: f64) -> Vec<ShipPosition> {
    let span_s = all[all.len() - 1].at_s - all[0].at_s;
    let mut kept: Vec<ShipPosition> = Vec::new();
    for (k, own) in all.iter().enumerate() {
        let is_late = kept.last().is_none_or(|last| own.at_s >= last.at_s + span_s / MOST);
        let gap = |a: usize, b: usize| all.get(b).is_none_or(|later| later.at_s - all[a].at_s > max_gap_s);
        if is_late || gap(k, k + 1) || k > 0 && gap(k - 1, k) {
            kept.push(*own);
        }
    }
    kept
}

/// How far positions may be off \[m\], where sensors state a standard deviation of `position_m`, or 0.
pub(super) fn uncertain_m(position_m: f64) -> f64 {
    SIGMAS * position_m.max(POSITION_M)
}

/// Difference of two headings, from 0 to 180 \[deg\].
pub(super) fn turned_deg(a: f64, b: f64) -> f64 {
    wrap((a - b).to_radians()).abs().to_degrees()
}

/// The median; 0 of none.
pub(super) fn median(values: impl Iterator<Item = f64>) -> f64 {
    numerics::statistics::median(values.collect()).unwrap_or(0.0)
}
