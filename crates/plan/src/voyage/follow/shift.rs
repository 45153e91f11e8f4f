//! Positions that are all displaced alike: by another datum, or an antenna whose place is not known.

use super::alignment::aligned;
use super::track::{PlannedTrack, ShipPosition, median};

/// Smaller displacements are those of a ship that is steered \[m\].
const LEAST_M: f64 = 8.0;
/// Distances by which the search widens those of steps: displaced positions are far from all points.
const WIDENED: [f64; 3] = [16.0, 4.0, 1.0];
/// As many positions suffice.
const MOST: usize = 500;
/// Fewer positions under way, or at rest, say nothing.
const FEW: usize = 20;
/// A displacement explains positions if they are so much nearer without it.
const EXPLAINED: f64 = 0.4;
/// Part of all directions that courses have to cover for a displacement along them.
const COVERED: f64 = 0.05;

/// A displacement of all positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shift {
    /// East and north \[m\].
    Earth([f64; 2]),
    /// To starboard of the ship \[m\].
    Ship(f64),
}

/// A position against the plan: how far it is off its point, the unit vector to starboard of the course there, and whether there is
/// one: where the plan stays, both axes count.
type Off = ([f64; 2], [f64; 2], bool);

impl Shift {
    /// What displaces all `positions` from the track, if something does.
    pub(super) fn of(track: &PlannedTrack, positions: &[ShipPosition]) -> Option<Self> {
        let few: Vec<ShipPosition> =
            positions.iter().step_by(positions.len().div_ceil(MOST)).copied().collect();
        let away_m = |all: &[Off], by: Self| {
            let of = |moves: bool| {
                let own = || all.iter().filter(|own| own.2 == moves).map(|own| by.across_m(own).abs());
                if own().count() < FEW { 0.0 } else { median(own()) }
            };
            // A ship that stays may turn an antenna that is not in her middle.
            if matches!(by, Self::Ship(aside) if aside != 0.0) { of(true) } else { of(true).max(of(false)) }
        };
        let own = offs(track, &few);
        if own.iter().filter(|own| own.2).count() < FEW {
            return None;
        }
        let before_m = away_m(&own, Self::Ship(0.0));
        if before_m < 0.5 * LEAST_M {
            return None;
        }
        let mut moved = [0.0; 2];
        for widened in WIDENED {
            let mut wide = track.clone();
            wide.steps.iter_mut().for_each(|step| step.within_m *= widened);
            let Some(found) = displacement(&offs(&wide, &Self::Earth(moved).without(&few))) else { break };
            moved = [0, 1].map(|c| moved[c] + found[c]);
        }
        let after_m = away_m(&offs(track, &Self::Earth(moved).without(&few)), Self::Ship(0.0));
        let moving = own.iter().filter(|own| own.2);
        let aside = Self::Ship(median(moving.map(|moving| Self::Ship(0.0).across_m(moving))));
        let (found, after_m) = match away_m(&own, aside) {
            aside_m if aside_m < after_m && aside.metres() >= LEAST_M => (aside, aside_m),
            _ => (Self::Earth(moved), after_m),
        };
        (found.metres() >= LEAST_M && after_m <= (EXPLAINED * before_m).max(0.5 * LEAST_M)).then_some(found)
    }

    /// How far a position is to starboard of its course without the displacement \[m\].
    fn across_m(&self, (off, side, _): &Off) -> f64 {
        let across = |own: &[f64; 2]| own[0] * side[0] + own[1] * side[1];
        let displaced = match self {
            Self::Earth(own) => across(own),
            Self::Ship(own) => *own,
        };
        across(off) - displaced
    }

    pub(super) fn metres(&self) -> f64 {
        match self {
            Self::Earth([east, north]) => libm::hypot(*east, *north),
            Self::Ship(aside) => aside.abs(),
        }
    }

    /// Positions without it.
    pub(super) fn without(&self, positions: &[ShipPosition]) -> Vec<ShipPosition> {
        let Self::Earth(by) = self else { return positions.to_vec() };
        let moved = |own: &ShipPosition| ShipPosition { place: [0, 1].map(|c| own.place[c] - by[c]), ..*own };
        positions.iter().map(moved).collect()
    }

    pub(super) fn words(&self) -> String {
        match self {
            Self::Earth([east, north]) => {
                let towards = libm::atan2(*east, *north).to_degrees().round().rem_euclid(360.0) as u32;
                format!("all positions are displaced by {:.0} m towards {towards:03} deg", self.metres())
            }
            Self::Ship(aside) => {
                let side = if *aside > 0.0 { "starboard" } else { "port" };
                format!("all positions are {:.0} m to {side} of the track", aside.abs())
            }
        }
    }
}

/// Positions against the points that they belong to.
fn offs(track: &PlannedTrack, positions: &[ShipPosition]) -> Vec<Off> {
    let off = |(position, k): (&ShipPosition, usize)| {
        let off = [0, 1].map(|c| position.place[c] - track.points[k].place[c]);
        match track.course(k) {
            Some([east, north]) => vec![(off, [north, -east], true)],
            None => vec![(off, [1.0, 0.0], false), (off, [0.0, 1.0], false)],
        }
    };
    positions.iter().zip(aligned(track, positions)).flat_map(off).collect()
}

/// The displacement that leaves the least across the courses, by least squares.
fn displacement(all: &[Off]) -> Option<[f64; 2]> {
    let [mut ee, mut en, mut nn, mut e, mut n] = [0.0; 5];
    for (off, [east, north], _) in all {
        let across = off[0] * east + off[1] * north;
        (ee, en, nn) = (ee + east * east, en + east * north, nn + north * north);
        (e, n) = (e + east * across, n + north * across);
    }
    let (trace, determinant) = (ee + nn, ee * nn - en * en);
    (determinant > COVERED * trace * trace / 4.0)
        .then(|| [(nn * e - en * n) / determinant, (ee * n - en * e) / determinant])
}
