//! Logs that contradict themselves or the plan: the place or the motion at their end is then in doubt.

use refusal::Invalid;

use super::refused::SAY_WHERE;
use super::track::{Along, FollowLimits, ShipPosition, median, turned_deg};
use crate::voyage::passage::distance;

/// Parts of the way take so long \[s\], and are so long \[m\].
const PART_S: [f64; 2] = [10.0, 120.0];
const PART_M: f64 = 30.0;
/// A ship that goes ahead heads along her course \[deg\].
const AHEAD_DEG: f64 = 20.0;
/// Least chord of a straight part, of its length.
const STRAIGHT: f64 = 0.95;
/// Fewer straight parts say nothing of a column.
const FEW: usize = 5;
/// Ratios of a logged speed to that of positions that currents and logs may cause.
const RATIOS: [f64; 2] = [0.6, 1.6];
/// Units that a speed may be in, by what it is then multiplied with.
const SPEEDS: [(f64, &str); 4] =
    [(1.944, "knots"), (3.6, "km/h"), (2.237, "miles per hour"), (0.514, "m/s where knots were expected")];
/// A heading that is off by more is no true heading \[deg\]; on courses that hardly vary, a current may cause more.
const TURNED_DEG: f64 = 5.0;
const TURNED_IN_CURRENT_DEG: f64 = 30.0;
/// Part of motions that have to differ, to tell a heading's error from a current.
const VARIED: f64 = 0.15;
/// A ship's heading changes by no more from one position to the next \[deg\], within \[s\].
const SWING_DEG: f64 = 60.0;
const NEXT_S: f64 = 5.0;
/// Positions stand still if they stay where they may be off, and their halves within a part of it, where more of a way is expected.
const STILL: f64 = 0.5;
const MISSED: f64 = 2.0;
/// Receivers report such speeds of a ship at rest \[m/s\].
const AT_REST_M_S: f64 = 0.3;
/// Part of the way in which a ship of the plan stops that is too short for her.
const ABRUPT: f64 = 0.5;

/// A straight part of the way: its first position, one between and its last; and its velocity to north and east \[m/s\].
type StraightPart = ([usize; 3], [f64; 2]);

/// Refuses columns that contradict the positions, and positions that stand still; says what else is odd.
pub(super) fn check(along: &Along, limits: &FollowLimits) -> Result<Option<String>, Invalid> {
    let parts = parts(along);
    let odd = check_speed(along, &parts)?;
    check_swing(along.positions)?;
    check_heading(along, &parts)?;
    check_still(along, limits)?;
    Ok(odd)
}

fn parts(along: &Along) -> Vec<StraightPart> {
    let (all, apart_s) = (along.positions, (PART_M / along.track.usual_m_s()).clamp(PART_S[0], PART_S[1]));
    let mut picked = vec![0];
    for (row, position) in all.iter().enumerate() {
        if position.at_s >= all[picked[picked.len() - 1]].at_s + apart_s {
            picked.push(row);
        }
    }
    let part = |rows: &[usize]| {
        let [a, b, c] = [0, 1, 2].map(|k: usize| &all[rows[k]]);
        let way_m = distance(a.place, b.place) + distance(b.place, c.place);
        let chord_m = distance(a.place, c.place);
        let velocity = [1, 0].map(|k: usize| (c.place[k] - a.place[k]) / (c.at_s - a.at_s));
        let part = ([rows[0], rows[1], rows[2]], velocity);
        (chord_m >= STRAIGHT * way_m && chord_m >= PART_M).then_some(part)
    };
    picked.windows(3).filter_map(part).collect()
}

fn check_speed(along: &Along, parts: &[StraightPart]) -> Result<Option<String>, Invalid> {
    let ratio = |(rows, velocity): &StraightPart| {
        let logged = rows.iter().map(|row| along.positions[*row].speed_m_s).sum::<Option<f64>>()?;
        Some(logged / 3.0 / libm::hypot(velocity[0], velocity[1]))
    };
    let ratios: Vec<f64> = parts.iter().filter_map(ratio).collect();
    let (count, ratio) = (ratios.len(), median(ratios.into_iter()));
    if count < FEW || (RATIOS[0]..=RATIOS[1]).contains(&ratio) {
        return Ok(None);
    }
    let mut logged = along.positions.iter().filter_map(|position| position.speed_m_s);
    if let Some(first) = logged.next().filter(|first| logged.all(|speed| speed == *first)) {
        let words = format!("the logged speed is {first:.1} m/s throughout, and not that of the positions");
        return Ok(Some(words));
    }
    let unit = SPEEDS.into_iter().find(|(factor, _)| (ratio / factor - 1.0).abs() < 0.08);
    let unit = unit.map_or(String::new(), |(_, unit)| format!(", as in {unit}"));
    let speeds = format!("{ratio:.2} times the speed of the positions on {count} straight parts{unit}");
    let remedy = "convert the speed, or give the positions as CSV without it";
    Err(Invalid::new("speed", speeds, "that over the ground, in m/s, or in knots in sentences", remedy))
}

/// Refuses headings that jump, as courses over ground do where a ship hardly moves.
fn check_swing(all: &[ShipPosition]) -> Result<(), Invalid> {
    let swings = |pair: &&[ShipPosition]| {
        let headings = pair[1].heading_deg.zip(pair[0].heading_deg);
        headings.is_some_and(|(to, from)| turned_deg(to, from) > SWING_DEG)
            && pair[1].at_s - pair[0].at_s <= NEXT_S
    };
    let mut jumps = all.windows(2).filter(swings);
    let Some(pair) = jumps.next().filter(|_| jumps.count() >= FEW) else { return Ok(()) };
    let jumps = format!("jumps from one position to the next, the first by more than {SWING_DEG} deg");
    let expected = "a heading: a course over ground is none, and jumps where she hardly moves";
    Err(refused_heading(&format!("line {}, heading", pair[1].line), jumps, expected))
}

fn refused_heading(thing: &str, headings: String, expected: &str) -> Invalid {
    let remedy = "log the true heading in degrees, or give the positions as CSV without heading";
    Invalid::new(thing, headings, expected, remedy)
}

/// Refuses headings that are off the courses over ground: least squares of velocities = turn · headings + a current.
fn check_heading(along: &Along, parts: &[StraightPart]) -> Result<(), Invalid> {
    let pair = |(rows, velocity): &StraightPart| {
        let [a, b, c] = rows.map(|row| &along.track.points[along.at[row]]);
        let heading = along.positions[rows[1]].heading_deg?.to_radians();
        // Where the plan goes astern or aside, the heading is no course.
        let course = libm::atan2(c.place[0] - a.place[0], c.place[1] - a.place[1]).to_degrees();
        let is_ahead = [a, b, c].iter().all(|position| turned_deg(course, position.heading_deg) < AHEAD_DEG);
        let ahead = [libm::cos(heading), libm::sin(heading)].map(|part| b.speed_m_s * part);
        is_ahead.then(|| [velocity[0], velocity[1], ahead[0], ahead[1]])
    };
    let pairs: Vec<[f64; 4]> = parts.iter().filter_map(pair).collect();
    let (count, none) = (pairs.len() as f64, sums(&pairs, [0.0; 4]));
    let mean = [0, 1, 2, 3].map(|c: usize| pairs.iter().map(|pair| pair[c]).sum::<f64>() / count);
    let centered = sums(&pairs, mean);
    let is_varied = centered[0] > VARIED * none[0];
    if pairs.len() < FEW {
        return Ok(());
    }
    if is_varied && centered[1] * none[0] < 0.1 * centered[0] * none[1] {
        let stuck = "headings that hardly change while courses do, as of radians, or of a sensor that hangs";
        return Err(refused_heading("heading", stuck.to_owned(), "true headings in degrees"));
    }
    let [velocities, headings, ahead, aside] = if is_varied { centered } else { none };
    let product = libm::hypot(ahead, aside);
    let misses = velocities - product * product / headings;
    let error_deg = ((misses * headings / (2.0 * count)).max(0.0).sqrt() / product).to_degrees();
    let turned_deg = libm::atan2(aside, ahead).to_degrees();
    let most_deg = if is_varied { TURNED_DEG + 3.0 * error_deg } else { TURNED_IN_CURRENT_DEG };
    if turned_deg.abs() <= most_deg {
        return Ok(());
    }
    let side = if turned_deg > 0.0 { "left" } else { "right" };
    let by = format!("headings {:.0} deg {side} of the courses over ground on all of them", turned_deg.abs());
    Err(refused_heading("heading", by, "true headings: magnetic ones lack the variation"))
}

/// Sums of squares of velocities and of headings, both about means, and of their products, along and across.
fn sums(pairs: &[[f64; 4]], about: [f64; 4]) -> [f64; 4] {
    let product = |pair: &[f64; 4]| {
        let [vn, ve, hn, he] = [0, 1, 2, 3].map(|c: usize| pair[c] - about[c]);
        [vn * vn + ve * ve, hn * hn + he * he, vn * hn + ve * he, ve * hn - vn * he]
    };
    pairs.iter().map(product).fold([0.0; 4], |sum, next| [0, 1, 2, 3].map(|c: usize| sum[c] + next[c]))
}

/// Refuses positions that stand still at the end while the ship moves, by her speed or by how abruptly they stopped.
fn check_still(along: &Along, limits: &FollowLimits) -> Result<(), Invalid> {
    let all = along.positions;
    let last = all[all.len() - 1];
    let mean = |of: &[ShipPosition]| {
        [0, 1].map(|c: usize| of.iter().map(|position| position.place[c]).sum::<f64>() / of.len() as f64)
    };
    let recent = all.iter().rev().take_while(|position| last.at_s - position.at_s <= PART_S[0]).count();
    let center = mean(&all[all.len() - recent..]);
    let leaves = all.iter().rposition(|position| distance(position.place, center) > limits.uncertain_m);
    let from = leaves.map_or(0, |k| k + 1);
    let (before, after) = all[from..].split_at((all.len() - from) / 2);
    if before.is_empty() || distance(mean(after), mean(before)) > STILL * limits.uncertain_m {
        return Ok(());
    }
    let (lasts_s, missed_m) = (last.at_s - all[from].at_s, MISSED * limits.uncertain_m);
    let logged: Vec<f64> = all[from..].iter().filter_map(|position| position.speed_m_s).collect();
    let speed_m_s = median(logged.iter().copied());
    let points = &along.track.points;
    let planned_m = |from_s: f64, until_s: f64| {
        let pairs = points.windows(2).filter(|pair| pair[0].at_s >= from_s && pair[1].at_s <= until_s);
        pairs.map(|pair| pair[0].away_m(pair[1].place)).sum::<f64>()
    };
    let at_s = points[along.at[from]].at_s;
    let end = &points[along.last()];
    // A plan that turns on a small circle here moves as far, and stays near.
    let near = points.iter().filter(|point| (point.at_s - end.at_s).abs() <= lasts_s);
    let is_circle = near.map(|point| point.away_m(end.place)).fold(0.0, f64::max) <= 2.0 * limits.uncertain_m
        && planned_m(end.at_s - lasts_s, end.at_s) > missed_m;
    let moves = speed_m_s > AT_REST_M_S && speed_m_s * lasts_s > missed_m && !is_circle;
    let why = match logged.is_empty() {
        false if moves => format!("her speed is {speed_m_s:.1} m/s"),
        true if planned_m(at_s, at_s + lasts_s) > missed_m && stops_abruptly(along, from) => {
            "a ship of this plan does not stop so abruptly".to_owned()
        }
        _ => return Ok(()),
    };
    let stay = format!("no motion since line {}, {lasts_s:.0} s before the end, while {why}", all[from].line);
    let remedy = format!("give a log that ends where she is, or {SAY_WHERE}");
    Err(Invalid::new(format!("line {}", last.line), stay, "positions that follow her", remedy))
}

/// Whether positions that stand still from one on stopped within less than the plan's ship needs, or are one and the same.
fn stops_abruptly(along: &Along, from: usize) -> bool {
    let (all, points) = (along.positions, &along.track.points);
    let earlier = all[..from].partition_point(|position| position.at_s < all[from].at_s - 20.0);
    let [start, before] = [from, earlier].map(|k| &all[k]);
    let speed_m_s = distance(before.place, start.place) / (start.at_s - before.at_s);
    if from == 0 || speed_m_s < 0.5 * points[along.at[from]].speed_m_s {
        return false;
    }
    let ends = points.windows(11).map(|window| (window[0], window[10]));
    let slows = ends.map(|(a, b)| (a.speed_m_s - b.speed_m_s) / (b.at_s - a.at_s));
    let stops_m = speed_m_s * speed_m_s / (2.0 * slows.fold(0.0, f64::max));
    let last = &all[all.len() - 1];
    let is_same = all.iter().rev().take_while(|position| position.place == last.place).count() >= FEW;
    is_same || ABRUPT * stops_m > distance(last.place, start.place)
}
