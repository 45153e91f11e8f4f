//! Positions aligned with a track in the order of time.

use std::collections::VecDeque;

use super::track::{PlannedTrack, ShipPosition, turned_deg};

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
    let turned =
        position.heading_deg.map_or(0.0, |heading| turned_deg(heading, point.heading_deg) / HEADING_DEG);
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
    let mut found = Vec::new();
    for row in came_from.chunks_exact(count).rev() {
        found.push(k);
        k -= usize::from(row[k]);
    }
    found.reverse();
    found
}
