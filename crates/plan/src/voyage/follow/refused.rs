//! Positions that cannot be a ship's on a plan.

use refusal::Invalid;

use super::track::{Along, FollowLimits, MAX_GAP_S, PlannedTrack, ShipPosition, aligned, median};
use crate::voyage::passage::distance;

/// Farther than this before the departure or after the end of the plan is another day \[s\].
const ANOTHER_DAY_S: f64 = 12.0 * 3600.0;

/// What helps where positions do not, for messages.
pub(super) const SAY_WHERE: &str = "say where she is by --done STEPS --from LON,LAT,HEADING";

/// A line of the positions, for messages.
fn line(position: &ShipPosition) -> String {
    format!("line {}", position.line)
}

/// So many positions in a row are a spike, if the ship goes on from the one before; and so many spikes are too many.
const SPIKE: usize = 3;
const SPIKES: usize = 3;
/// Units that times may be in: seconds in each.
const TIMES: [(f64, &str); 4] =
    [(60.0, "minutes"), (3600.0, "hours"), (86_400.0, "days"), (1e-3, "milliseconds")];

/// Positions without spikes, and how many those are. Refuses positions of another day, jumps, times in another unit.
pub(super) fn check_positions(
    track: &PlannedTrack,
    positions: &[ShipPosition],
    limits: &FollowLimits,
) -> Result<(Vec<ShipPosition>, usize), Invalid> {
    let ([first, ..], Some(last)) = (positions, positions.last()) else {
        let remedy = "export the positions since the departure";
        return Err(Invalid::new("positions", "none", "at least one", remedy));
    };
    check_day(track, [first, last])?;
    let (kept, spikes) = without_spikes(positions, limits)?;
    check_pace(track, &kept, limits)?;
    Ok((kept, spikes))
}

fn without_spikes(
    positions: &[ShipPosition],
    limits: &FollowLimits,
) -> Result<(Vec<ShipPosition>, usize), Invalid> {
    let goes = |from: &ShipPosition, to: usize| {
        positions.get(to).is_some_and(|to| check_jump(&[*from, *to], limits).is_ok())
    };
    let (mut kept, mut spikes, mut k) = (vec![positions[0]], 0, 1);
    while let Some(position) = positions.get(k) {
        let last = kept[kept.len() - 1];
        let back = (k..=k + SPIKE).find(|to| goes(&last, *to));
        if back.is_none() && k == 1 && goes(position, 2) && goes(position, 3) {
            (kept, spikes) = (vec![*position], 1);
        } else if let Some(back) = back.filter(|back| spikes + back - k <= SPIKES.max(positions.len() / 100))
        {
            (spikes, k) = (spikes + back - k, back);
            kept.push(positions[k]);
        } else {
            check_jump(&[last, *position], limits)?;
        }
        k += 1;
    }
    Ok((kept, spikes))
}

/// Refuses a ship that is too fast over a longer way, or always far too slow: times are in another unit.
fn check_pace(track: &PlannedTrack, positions: &[ShipPosition], limit: &FollowLimits) -> Result<(), Invalid> {
    let (mut from, mut speeds) = (&positions[0], Vec::new());
    for position in positions {
        let way_m = distance(position.place, from.place);
        if way_m >= 10.0 * limit.uncertain_m {
            speeds.push(way_m / (position.at_s - from.at_s));
            from = position;
        }
    }
    let speed_m_s = median(speeds.iter().copied());
    let ratio = speed_m_s / track.usual_m_s();
    let unit = TIMES.into_iter().find(|(factor, _)| libm::log(ratio / factor).abs() < 0.7);
    let is_slow = speeds.len() > 1 && unit.is_some() && ratio < 0.01;
    if speeds.is_empty() || speed_m_s <= limit.fastest_m_s && !is_slow {
        return Ok(());
    }
    let unit = unit.map_or(String::new(), |(_, unit)| format!(", as of {unit} in place of seconds"));
    let speed = format!("a ship at {speed_m_s:.3} m/s{unit}");
    let expected = format!("about {:.1} m/s, as planned", track.usual_m_s());
    Err(Invalid::new("`time`", speed, expected, "write times in seconds, or as dates with a time"))
}

fn check_day(track: &PlannedTrack, [first, last]: [&ShipPosition; 2]) -> Result<(), Invalid> {
    let hours = |s: f64| format!("{:.1} h", s / 3600.0);
    let another = |at: &ShipPosition, times: String| {
        let expected = "positions within 12 h of the plan";
        let remedy = "give the log of the trial's day, or correct `departure` and plan again";
        Err(Invalid::new(format!("{}, `time`", line(at)), times, expected, remedy))
    };
    if last.at_s < -ANOTHER_DAY_S {
        return another(last, format!("{} before the departure of the plan", hours(-last.at_s)));
    }
    let after_s = first.at_s - track.ends_s();
    if after_s > ANOTHER_DAY_S {
        return another(first, format!("{} after the end of the plan", hours(after_s)));
    }
    Ok(())
}

fn check_jump(pair: &[ShipPosition], limits: &FollowLimits) -> Result<(), Invalid> {
    let (way_m, elapsed_s) = (distance(pair[0].place, pair[1].place), pair[1].at_s - pair[0].at_s);
    let most_m = limits.fastest_m_s * elapsed_s + 2.0 * limits.uncertain_m;
    if way_m <= most_m {
        return Ok(());
    }
    let jump = format!("a jump of {way_m:.0} m in {elapsed_s:.1} s");
    let expected = format!("at most {most_m:.0} m, at {:.1} m/s", limits.fastest_m_s);
    let remedy = "leave out positions that are wrong, or of another ship";
    Err(Invalid::new(line(&pair[1]), jump, expected, remedy))
}

/// Refuses positions that are displaced by more than a step may be off.
pub(super) fn check_shift(track: &PlannedTrack, shift: &Shift) -> Result<(), Invalid> {
    let within_m = track.steps.iter().map(|step| step.within_m).fold(f64::INFINITY, f64::min);
    if shift.metres() <= within_m {
        return Ok(());
    }
    let expected = format!("positions in WGS84, of the middle of the ship, within {within_m:.0} m");
    let remedy = format!("convert their datum, correct the antenna's place, or {SAY_WHERE}");
    Err(Invalid::new("positions", shift.words(), expected, remedy))
}

/// Refuses positions of another plan, gaps in maneuvers, and a ship that left the end of the plan.
pub(super) fn check_alignment(along: &Along) -> Result<(), Invalid> {
    let (nearest_m, within_m) = (along.nearest_m(), along.least_within_m());
    if nearest_m > within_m {
        let none = format!("none nearer to the plan's track than {nearest_m:.0} m");
        let expected = format!("positions along it, within {within_m:.0} m");
        let remedy = format!("name the plan that is sailed, or {SAY_WHERE}");
        return Err(Invalid::new("positions", none, expected, remedy));
    }
    check_beginning(along)?;
    check_gaps(along)?;
    check_end(along)
}

/// Refuses positions that begin after a maneuver.
fn check_beginning(along: &Along) -> Result<(), Invalid> {
    let first = &along.track.points[along.at[0]];
    let before = &along.track.points[..along.at[0]];
    let maneuver = before.iter().rfind(|point| point.informative);
    let Some(point) = maneuver.filter(|_| first.at_s > MAX_GAP_S) else { return Ok(()) };
    let name = &along.track.steps[point.step].name;
    let start = format!("a beginning at step {}, after `{name}` in step {}", first.step + 1, point.step + 1);
    let expected = "positions since the departure of the plan";
    Err(Invalid::new(line(&along.positions[0]), start, expected, "give the whole log"))
}

fn check_gaps(along: &Along) -> Result<(), Invalid> {
    for (pair, at) in along.positions.windows(2).zip(along.at.windows(2)) {
        let gap_s = pair[1].at_s - pair[0].at_s;
        let maneuver = along.track.points[at[0]..=at[1]].iter().find(|point| point.informative);
        if let Some(point) = maneuver.filter(|_| gap_s > MAX_GAP_S) {
            let name = &along.track.steps[point.step].name;
            let (line_before, step) = (pair[0].line, point.step + 1);
            let gap = format!("{gap_s:.0} s since line {line_before}, in `{name}` of step {step}");
            let expected = format!("at most {MAX_GAP_S} s in a maneuver");
            let remedy = format!("give a log without the gap, or {SAY_WHERE}");
            return Err(Invalid::new(line(&pair[1]), gap, expected, remedy));
        }
    }
    Ok(())
}

fn check_end(along: &Along) -> Result<(), Invalid> {
    let Some(reached) = along.reached_end() else { return Ok(()) };
    let ship = &along.ship;
    let end = &along.track.points[along.track.points.len() - 1];
    let (away_m, within_m) = (end.away_m(ship.place), along.track.steps[end.step].within_m);
    // With maneuvers left, she goes on from wherever she is.
    if away_m <= within_m || !along.are_maneuvers_covered() {
        return Ok(());
    }
    let after_s = ship.at_s - along.positions[reached].at_s;
    let place = format!("{away_m:.0} m from the end of the plan, {after_s:.0} s after the ship was there");
    let expected = format!("positions up to the end, within {within_m:.0} m");
    Err(Invalid::new(line(ship), place, expected, "the plan is done: cut the log where it ends"))
}

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
                let across = || all.iter().filter(|off| off.2 == moves).map(|off| by.across_m(off).abs());
                if across().count() < FEW { 0.0 } else { median(across()) }
            };
            // A ship that stays may turn an antenna that is not in her middle.
            if matches!(by, Self::Ship(aside) if aside != 0.0) { of(true) } else { of(true).max(of(false)) }
        };
        let before = offs(track, &few);
        if before.iter().filter(|off| off.2).count() < FEW {
            return None;
        }
        let before_m = away_m(&before, Self::Ship(0.0));
        if before_m < 0.5 * LEAST_M {
            return None;
        }
        let mut moved = [0.0; 2];
        for widened in WIDENED {
            let mut wide = track.clone();
            wide.steps.iter_mut().for_each(|step| step.within_m *= widened);
            let Some(step) = displacement(&offs(&wide, &Self::Earth(moved).without(&few))) else { break };
            moved = [0, 1].map(|c| moved[c] + step[c]);
        }
        let after_m = away_m(&offs(track, &Self::Earth(moved).without(&few)), Self::Ship(0.0));
        let moving = before.iter().filter(|off| off.2);
        let aside = Self::Ship(median(moving.map(|moving| Self::Ship(0.0).across_m(moving))));
        let (displacement, after_m) = match away_m(&before, aside) {
            aside_m if aside_m < after_m && aside.metres() >= LEAST_M => (aside, aside_m),
            _ => (Self::Earth(moved), after_m),
        };
        let explains = after_m <= (EXPLAINED * before_m).max(0.5 * LEAST_M);
        (displacement.metres() >= LEAST_M && explains).then_some(displacement)
    }

    /// How far a position is to starboard of its course without the displacement \[m\].
    fn across_m(&self, (off, side, _): &Off) -> f64 {
        let across = |metres: &[f64; 2]| metres[0] * side[0] + metres[1] * side[1];
        let displaced = match self {
            Self::Earth(metres) => across(metres),
            Self::Ship(metres) => *metres,
        };
        across(off) - displaced
    }

    fn metres(&self) -> f64 {
        match self {
            Self::Earth([east, north]) => libm::hypot(*east, *north),
            Self::Ship(aside) => aside.abs(),
        }
    }

    /// Positions without it.
    pub(super) fn without(&self, positions: &[ShipPosition]) -> Vec<ShipPosition> {
        let Self::Earth(by) = self else { return positions.to_vec() };
        let moved = |at: &ShipPosition| ShipPosition { place: [0, 1].map(|c| at.place[c] - by[c]), ..*at };
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
