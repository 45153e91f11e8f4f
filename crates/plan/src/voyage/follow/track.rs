//! Planned tracks and positions, as they are compared.

use std::collections::VecDeque;

use super::super::legs::{Primitive, VoyageLeg};
use super::super::task::Task;
use crate::leg::wrap;
use crate::voyage::passage::distance;

/// Most points of a track, and most positions, that are compared.
const MOST: f64 = 3000.0;
/// Standard deviations by which a position may be off.
const SIGMAS: f64 = 5.0;
/// Least standard deviation of logged positions \[m\]: a ship's autopilot may have better ones than her log.
const POSITION_M: f64 = 3.0;

/// The longest time between two positions within a maneuver \[s\].
pub(super) const MAX_GAP_S: f64 = 30.0;

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
            let uses = primitives.iter().filter(|used| leg.informative && used.maneuver == leg.name);
            let spread_m = uses.map(|primitive| primitive.spread_m).fold(0.0, f64::max);
            let pairs = points.windows(2).filter(|pair| pair[0].step == index && pair[0].informative);
            let way_m: f64 = pairs.map(|pair| pair[0].away_m(pair[1].place)).sum();
            PlannedStep { name: leg.name.clone(), within_m: least_m + spread_m.min(SPREAD * way_m) }
        };
        let steps = legs.iter().enumerate().map(step).collect();
        Self { points, steps }
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

/// No more positions than can be compared: the last, and both ends of gaps longer than [`MAX_GAP_S`], stay.
pub(super) fn thinned_positions(all: &[ShipPosition]) -> Vec<ShipPosition> {
    let span_s = all[all.len() - 1].at_s - all[0].at_s;
    let mut kept: Vec<ShipPosition> = Vec::new();
    for (k, position) in all.iter().enumerate() {
        let is_late = kept.last().is_none_or(|last| position.at_s >= last.at_s + span_s / MOST);
        let gap = |a: usize, b: usize| all.get(b).is_none_or(|later| later.at_s - all[a].at_s > MAX_GAP_S);
        if is_late || gap(k, k + 1) || k > 0 && gap(k - 1, k) {
            kept.push(*position);
        }
    }
    kept
}

/// How far positions may be off \[m\], where sensors state a standard deviation of `position_m`, or 0.
fn uncertain_m(position_m: f64) -> f64 {
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

/// The last seconds of a plan, in which she comes to rest, are not told apart by positions: so many at most, and within this
/// part of the least distance.
const LAST_S: f64 = 30.0;
const LAST: f64 = 0.5;
/// Least way over the ground that gives a course \[m\].
const COURSE_M: f64 = 20.0;

/// Positions that are aligned with a track.
pub(super) struct Along<'a> {
    pub(super) track: &'a PlannedTrack,
    pub(super) positions: &'a [ShipPosition],
    /// Where she is now: the last of them, or a later one, after she left the end of the track.
    pub(super) ship: ShipPosition,
    /// The point that each position belongs to.
    pub(super) at: Vec<usize>,
    /// Distance of the ship from each point when she was there, between positions on a straight line \[m\]; infinite where
    /// she was not.
    away_m: Vec<f64>,
}

impl<'a> Along<'a> {
    fn new(track: &'a PlannedTrack, positions: &'a [ShipPosition], at: Vec<usize>) -> Self {
        let mut away_m = vec![f64::INFINITY; track.points.len()];
        for (k, position) in at.iter().zip(positions) {
            away_m[*k] = away_m[*k].min(track.points[*k].away_m(position.place));
        }
        for (ends, places) in at.windows(2).zip(positions.windows(2)) {
            let [from_s, to_s] = [0, 1].map(|end: usize| track.points[ends[end]].at_s);
            for (away, point) in away_m.iter_mut().zip(&track.points).take(ends[1]).skip(ends[0] + 1) {
                let part = (point.at_s - from_s) / (to_s - from_s);
                let [a, b] = [places[0].place, places[1].place];
                *away = point.away_m([0, 1].map(|c: usize| a[c] + part * (b[c] - a[c])));
            }
        }
        let ship = positions[positions.len() - 1];
        Self { track, positions, ship, at, away_m }
    }

    /// `positions` aligned with the track; up to where she was last nearest to its end, if she came there and left it.
    pub(super) fn of(track: &'a PlannedTrack, positions: &'a [ShipPosition]) -> Self {
        let end = &track.points[track.points.len() - 1];
        let away_m = |index: &usize| end.away_m(positions[*index].place);
        let within_m = track.steps[end.step].within_m;
        let is_away = |index: &usize| away_m(index) > within_m;
        let near = (0..positions.len()).rev().skip_while(is_away).take_while(|index| !is_away(index));
        let nearest = near.min_by(|a, b| away_m(a).total_cmp(&away_m(b)));
        let has_left = is_away(&(positions.len() - 1));
        let until = nearest.filter(|_| has_left).map_or(0, |index| index + 1);
        if (1..positions.len()).contains(&until) {
            let before = &positions[..until];
            let along = Self::new(track, before, aligned(track, before));
            if along.reached_end().is_some() {
                return Self { ship: positions[positions.len() - 1], ..along };
            }
        }
        Self::new(track, positions, aligned(track, positions))
    }

    /// The point that the last position belongs to.
    pub(super) fn last(&self) -> usize {
        self.at.last().copied().unwrap_or(0)
    }

    /// Distances from the points of a step up to where she is \[m\].
    fn of_step(&self, step: usize) -> impl Iterator<Item = f64> {
        let all = self.track.points.iter().zip(&self.away_m).take(self.last() + 1);
        all.filter(move |(point, _)| point.step == step).map(|(_, away)| *away)
    }

    /// Whether the ship came along all of a step within its distance.
    pub(super) fn is_covered(&self, step: usize) -> bool {
        self.of_step(step).all(|away| away <= self.track.steps[step].within_m)
    }

    /// Whether that holds for all steps with maneuvers.
    pub(super) fn are_maneuvers_covered(&self) -> bool {
        let of_maneuver =
            |step: usize| self.track.points.iter().any(|point| point.step == step && point.informative);
        (0..self.track.steps.len()).filter(|step| of_maneuver(*step)).all(|step| self.is_covered(step))
    }

    /// The greatest distance of the ship from a step, where she was at it \[m\].
    pub(super) fn deviation_m(&self, step: usize) -> Option<f64> {
        self.of_step(step).filter(|away| away.is_finite()).reduce(f64::max)
    }

    /// The least distance within which a step counts as done \[m\].
    pub(super) fn least_within_m(&self) -> f64 {
        self.track.steps.iter().map(|step| step.within_m).fold(f64::INFINITY, f64::min)
    }

    /// The least distance of any position from any point \[m\].
    pub(super) fn nearest_m(&self) -> f64 {
        let aligned_m = self.away_m.iter().copied().fold(f64::INFINITY, f64::min);
        if aligned_m <= self.least_within_m() {
            return aligned_m;
        }
        let away_m = |position: &ShipPosition| {
            let points = self.track.points.iter();
            points.map(|point| point.away_m(position.place)).fold(f64::INFINITY, f64::min)
        };
        self.positions.iter().map(away_m).fold(aligned_m, f64::min)
    }

    /// The first position at the end of the track, if she came there: its index.
    pub(super) fn reached_end(&self) -> Option<usize> {
        let end = &self.track.points[self.track.points.len() - 1];
        let within_m = self.track.steps[end.step].within_m;
        let is_last = |point: &&TrackPoint| {
            point.at_s >= end.at_s - LAST_S
                && !point.informative
                && end.away_m(point.place) <= LAST * self.least_within_m()
        };
        let first = self.track.points.len() - self.track.points.iter().rev().take_while(is_last).count();
        let mut there = self.positions.iter().zip(&self.at);
        there.position(|(position, at)| *at >= first && end.away_m(position.place) <= within_m)
    }

    /// How much later than planned she was at a position \[s\].
    pub(super) fn delay_s(&self, position: usize) -> f64 {
        self.positions[position].at_s - self.track.points[self.at[position]].at_s
    }

    /// Course and speed over the ground at the last position \[deg, m/s\]: since she was so far away that it gives a course.
    pub(super) fn course(&self) -> Option<[f64; 2]> {
        let ship = &self.ship;
        let from = self.positions.iter().rfind(|from| distance(ship.place, from.place) >= COURSE_M)?;
        let [east, north] = [0, 1].map(|c: usize| ship.place[c] - from.place[c]);
        let speed_m_s = distance(ship.place, from.place) / (ship.at_s - from.at_s);
        Some([libm::atan2(east, north).to_degrees().rem_euclid(360.0), speed_m_s])
    }
}

/// Cost of a second by which the ship is later than before, or earlier, in seconds of being off the track.
const WAITS: f64 = 0.1;
const SKIPS: f64 = 0.25;
/// Difference of headings that counts as much as the distance within which a step is done \[deg\].
const HEADING_DEG: f64 = 45.0;
/// A position counts for no longer than this \[s\].
const LONGEST_S: f64 = 10.0;

/// The index of the point of `track` that each of `positions` belongs to; it never decreases.
///
/// The alignment costs least, in seconds: positions cost the time since the one before, times how far they are off, squared;
/// 1 at the distance within which a step is done, and beyond. A change of the delay by a second costs a part of a second, so
/// that the ship keeps the plan's pace where positions say nothing else. Dynamic programming over all pairs, in a time that
/// grows as positions × points.
pub fn aligned(track: &PlannedTrack, positions: &[ShipPosition]) -> Vec<usize> {
    let count = track.points.len();
    let mut before: Vec<f64> = track.points.iter().map(|point| SKIPS * point.at_s).collect();
    let mut came_from: Vec<u16> = Vec::with_capacity(count * positions.len());
    let mut last_s = None;
    for position in positions {
        let elapsed_s = last_s.map_or(1.0, |last_s| position.at_s - last_s);
        match last_s {
            Some(_) => advance(track, &mut before, elapsed_s, &mut came_from),
            None => came_from.resize(count, 0),
        }
        for (k, cost) in before.iter_mut().enumerate() {
            *cost += elapsed_s.min(LONGEST_S) * off(track, k, position);
        }
        last_s = Some(position.at_s);
    }
    traced(&before, &came_from)
}

/// How far a position is off a point, squared; at most 1.
fn off(track: &PlannedTrack, k: usize, position: &ShipPosition) -> f64 {
    let point = &track.points[k];
    let away = point.away_m(position.place) / track.steps[point.step].within_m;
    let turned = position.heading_deg.map_or(0.0, |deg| turned_deg(deg, point.heading_deg) / HEADING_DEG);
    (away * away + turned * turned).min(1.0)
}

/// The least costs `elapsed_s` later, before the position then is counted, and by how many points each advances.
fn advance(track: &PlannedTrack, costs: &mut [f64], elapsed_s: f64, came_from: &mut Vec<u16>) {
    let at_s = |k: usize| track.points[k].at_s;
    let before = costs.to_vec();
    // The best point from which the ship skips some time, and those from which she keeps pace or waits, the best first.
    let (mut skipped, mut next) = (None::<usize>, 0);
    let mut waited: VecDeque<usize> = VecDeque::new();
    let skipping = |k: usize| before[k] - SKIPS * at_s(k);
    let waiting = |k: usize| before[k] + WAITS * at_s(k);
    for (k, cost) in costs.iter_mut().enumerate() {
        while next < k && at_s(next) < at_s(k) - elapsed_s {
            skipped = Some(skipped.filter(|skipped| skipping(*skipped) <= skipping(next)).unwrap_or(next));
            next += 1;
        }
        while waited.back().is_some_and(|back| waiting(*back) >= waiting(k)) {
            waited.pop_back();
        }
        waited.push_back(k);
        while waited.front().is_some_and(|front| *front < next) {
            waited.pop_front();
        }
        let waits = waited.front().map(|front| (waiting(*front) + WAITS * (elapsed_s - at_s(k)), *front));
        let skips = skipped.map(|skipped| (skipping(skipped) + SKIPS * (at_s(k) - elapsed_s), skipped));
        let best = waits.into_iter().chain(skips).min_by(|a, b| a.0.total_cmp(&b.0));
        let (least, from) = best.unwrap_or((f64::INFINITY, k));
        *cost = least;
        came_from.push((k - from) as u16);
    }
}

/// The points of the cheapest alignment, by the costs of its end and by how many points each advanced.
fn traced(costs: &[f64], came_from: &[u16]) -> Vec<usize> {
    let count = costs.len();
    let mut k = (0..count).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).unwrap_or(0);
    let mut steps = Vec::new();
    for row in came_from.chunks_exact(count).rev() {
        steps.push(k);
        k -= usize::from(row[k]);
    }
    steps.reverse();
    steps
}

/// How much faster than planned a ship may be.
const FASTER: f64 = 1.5;

/// Limits of positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowLimits {
    /// What the ship does not exceed over the ground \[m/s\].
    pub fastest_m_s: f64,
    /// How far positions may be off \[m\].
    pub uncertain_m: f64,
}

impl FollowLimits {
    /// The limits of a ship on the plan of `task` with its `track`.
    pub fn of(task: &Task, track: &PlannedTrack) -> Self {
        let planned = track.points.iter().map(|point| point.speed_m_s);
        let modes = task.modes.iter().map(|mode| mode.speed_m_s);
        let [north, east] = task.known_current_m_s;
        let current_m_s = libm::hypot(north, east) + task.safety.unknown_current_m_s;
        Self {
            fastest_m_s: FASTER * planned.chain(modes).fold(0.0, f64::max) + current_m_s,
            uncertain_m: uncertain_m(task.sensors.position_m),
        }
    }
}
