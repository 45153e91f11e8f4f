//! Positions that a ship cannot reach from the previous ones.

use std::f64::consts::TAU;

use crate::samples::Samples;
use crate::{Channels, Omissions, Reason, Series};

/// Distance that a position may always be off \[m\].
const SLACK_M: f64 = 10.0;

/// Radius of the earth \[m\].
const EARTH_M: f64 = 6_371_000.0;

/// Channels of a geographic position.
const GEOGRAPHIC: [&str; 2] = ["latitude_deg", "longitude_deg"];

/// Tracks that are followed in parallel.
const MOST_TRACKS: usize = 16;

/// Positions each of which a ship can reach from the previous one.
struct Track {
    time: f64,
    place: [f64; 2],
    count: u64,
    /// Whether all of them are 0 N 0 E.
    null: bool,
}

/// Consecutive positions of one track.
struct Stay {
    times: [f64; 2],
    track: usize,
    /// Whether all of them are 0 N 0 E.
    null: bool,
}

/// The positions of a recording, track by track.
struct Tracks {
    geographic: bool,
    metres: Metres,
    fastest: f64,
    tracks: Vec<Track>,
    stays: Vec<Stay>,
}

/// The distance between two positions \[m\].
type Metres = fn([f64; 2], [f64; 2]) -> f64;

/// The channels of the position, if there are any, and their distance function.
pub(super) fn pair(channels: &Channels) -> Option<([&'static str; 2], Metres)> {
    let pairs: [(_, Metres); 2] = [(GEOGRAPHIC, on_earth), (["x", "y"], on_plane)];
    pairs.into_iter().find(|(names, _)| names.iter().all(|name| channels.contains_key(*name)))
}

fn on_plane(from: [f64; 2], to: [f64; 2]) -> f64 {
    let [a, b] = [to[0] - from[0], to[1] - from[1]];
    (a * a + b * b).sqrt()
}

fn on_earth(from: [f64; 2], to: [f64; 2]) -> f64 {
    let [north, turned] = [to[0] - from[0], to[1] - from[1]];
    let east = (turned - TAU * (turned / TAU).round()) * libm::cos(0.5 * (from[0] + to[0]));
    EARTH_M * (north * north + east * east).sqrt()
}

/// Leaves out of `channels` the positions that a ship of at most `fastest` \[m/s\] cannot reach, and counts
/// them.
pub(crate) fn keep_possible(channels: &mut Channels, fastest: f64, omitted: &mut Omissions) {
    let Some((names, metres)) = pair(channels) else { return };
    let [Some(first), Some(second)] = names.map(|name| channels.get(name)) else { return };
    let mut tracks =
        Tracks { geographic: names == GEOGRAPHIC, metres, fastest, tracks: Vec::new(), stays: Vec::new() };
    for ((time, a), b) in first.t.iter().zip(first.values.iter()).zip(second.at(first.t.iter())) {
        if b.is_finite() {
            tracks.add(time, [a, b]);
        }
    }
    let wrong = tracks.wrong();
    for name in names.iter().filter(|_| !wrong.is_empty()) {
        let Some(series) = channels.get_mut(*name) else { continue };
        let (kept, counts) = without(series, &wrong);
        *series = kept;
        omitted.add(name, Reason::Motion, counts[0]);
        omitted.add(name, Reason::NullIsland, counts[1]);
    }
}

impl Tracks {
    fn add(&mut self, time: f64, place: [f64; 2]) {
        let null = self.geographic && place == [0.0; 2];
        let near = |(i, track): (usize, &Track)| {
            let off = (self.metres)(track.place, place);
            (off <= self.fastest * (time - track.time) + SLACK_M).then_some((i, off))
        };
        let near = self.tracks.iter().enumerate().filter_map(near).min_by(|a, b| a.1.total_cmp(&b.1));
        let own = match near {
            Some((i, _)) => i,
            None if self.tracks.len() < MOST_TRACKS => {
                self.tracks.push(Track { time, place, count: 0, null: true });
                self.tracks.len() - 1
            }
            // One of many that continue no track: the shortest track begins anew.
            None => (0..MOST_TRACKS).min_by_key(|i| self.tracks[*i].count).unwrap_or(0),
        };
        let track = &mut self.tracks[own];
        (track.time, track.place, track.count, track.null) =
            (time, place, track.count + 1, track.null && null);
        match self.stays.last_mut().filter(|stay| stay.track == own && stay.null == null) {
            Some(stay) => stay.times[1] = time,
            None => self.stays.push(Stay { times: [time; 2], track: own, null }),
        }
    }

    /// The stays that are not on the longest track, in order; all that are 0 N 0 E where the longest track
    /// is.
    fn wrong(self) -> Vec<Stay> {
        let longest = (0..self.tracks.len()).max_by_key(|i| (self.tracks[*i].count, std::cmp::Reverse(*i)));
        let Some(longest) = longest else { return Vec::new() };
        let null = self.tracks[longest].null;
        self.stays.into_iter().filter(|stay| stay.track != longest || null && stay.null).collect()
    }
}

/// `series` without the values in `wrong`, and how many of these are not 0 N 0 E, and how many are.
fn without(series: &Series, wrong: &[Stay]) -> (Series, [u64; 2]) {
    let (mut counts, mut next) = ([0; 2], 0);
    let values: Samples =
        series.values.made(series.t.iter().zip(series.values.iter()).map(|(time, value)| {
            while wrong.get(next).is_some_and(|stay| stay.times[1] < time) {
                next += 1;
            }
            match wrong.get(next).filter(|stay| stay.times[0] <= time) {
                Some(stay) => {
                    counts[usize::from(stay.null)] += 1;
                    f64::NAN
                }
                None => value,
            }
        }));
    (series.with(values), counts)
}
