//! A ship along a track: where she came along it, and how far off.

use super::super::drafts::distance;
use super::alignment::aligned;
use super::track::{PlannedTrack, ShipPosition, TrackPoint};

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
        for (k, own) in at.iter().zip(positions) {
            away_m[*k] = away_m[*k].min(track.points[*k].away_m(own.place));
        }
        for (ends, places) in at.windows(2).zip(positions.windows(2)) {
            let [from_s, to_s] = [0, 1].map(|end: usize| track.points[ends[end]].at_s);
            for (away, point) in away_m.iter_mut().zip(&track.points).take(ends[1]).skip(ends[0] + 1) {
                let part = (point.at_s - from_s) / (to_s - from_s);
                let place = [0, 1]
                    .map(|c: usize| places[0].place[c] + part * (places[1].place[c] - places[0].place[c]));
                *away = point.away_m(place);
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
            |step: usize| self.track.points.iter().any(|own| own.step == step && own.informative);
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
        let away_m = |ship_position: &ShipPosition| {
            let points = self.track.points.iter();
            points.map(|point| point.away_m(ship_position.place)).fold(f64::INFINITY, f64::min)
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
        there.position(|(own, at)| *at >= first && end.away_m(own.place) <= within_m)
    }

    /// How much later than planned she was at a position \[s\].
    pub(super) fn delay_s(&self, position: usize) -> f64 {
        self.positions[position].at_s - self.track.points[self.at[position]].at_s
    }

    /// Course and speed over the ground at the last position \[deg, m/s\]: since she was so far away that it gives a course.
    pub(super) fn course(&self) -> Option<[f64; 2]> {
        let ship = &self.ship;
        let from =
            self.positions.iter().rfind(|position| distance(ship.place, position.place) >= COURSE_M)?;
        let [east, north] = [0, 1].map(|c: usize| ship.place[c] - from.place[c]);
        let speed_m_s = distance(ship.place, from.place) / (ship.at_s - from.at_s);
        Some([libm::atan2(east, north).to_degrees().rem_euclid(360.0), speed_m_s])
    }
}
