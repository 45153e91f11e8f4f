//! What columns are, by how they move together: names are not read.
//!
//! The increments of an angle are integrals of its rate, those of positions integrals of speeds along the angle. What steers
//! and drives predicts the motion in recordings that it was not fitted to.

mod actuators;
mod clocks;
mod contradiction;
mod motion;
mod table;

pub use actuators::ActuatorChoice;
pub use clocks::{ClockChoice, clocks};
pub use contradiction::{Agreement, SampledRecording, judged};
pub use motion::{Ground, Hypothesis, RateChoice, Speeds};
pub use table::{LoggedTable, RECORDINGS, ROWS};

use actuators::{Of, Response};
use motion::{Fits, Motions, TURN};

/// What is sure: this little is not explained; the score; that of rivals, times and plus; time \[s\], rows.
const UNEXPLAINED: f64 = 0.1;
const SCORE: f64 = 0.2;
const RIVAL: (f64, f64) = (2.5, 0.03);
const LENGTH_S: f64 = 30.0;
const ENOUGH: usize = 200;

/// A column that was found to be a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundChannel {
    /// The channel.
    pub channel: &'static str,
    /// The column.
    pub column: usize,
    /// Its unit.
    pub unit: &'static str,
    /// 1 or −1.
    pub sign: f64,
    /// Whether nothing else comes near.
    pub is_sure: bool,
    /// The smaller the better.
    pub score: f64,
    /// Columns that come near, with their scores.
    pub rivals: Vec<(usize, f64)>,
}

/// What was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundMotion {
    /// Channels of the motion.
    pub channels: Vec<FoundChannel>,
    /// Whether angles count counter-clockwise from east.
    pub is_east: bool,
    /// What may steer, the best first.
    pub steering: Vec<ActuatorChoice>,
    /// What may drive, the best first.
    pub drive: Vec<ActuatorChoice>,
    /// Columns that may be actuators.
    pub candidates: Vec<usize>,
    /// The score of the best hypothesis; infinite if there is none.
    pub score: f64,
    /// Whether there is motion enough to tell, and it fits.
    pub is_known: bool,
}

/// What the columns of `table` are, by the clock that explains most among `clocks`, the first of those that explain alike; `free` are the columns
/// that are looked at.
pub fn motion_with_clock(
    table: &LoggedTable,
    clocks: &[ClockChoice],
    free: &[usize],
    fits: Fits,
) -> Option<(ClockChoice, FoundMotion)> {
    let mut best: Option<(ClockChoice, FoundMotion)> = None;
    for clock in clocks {
        // No other can be better by enough.
        if best.as_ref().is_some_and(|(_, known)| clock.is_counter || known.score < RIVAL.1) {
            continue;
        }
        let size = clock.unit.seconds().unwrap_or(1.0);
        let time: Vec<f64> = table.columns[clock.column].iter().map(|count| size * count).collect();
        let is_copy = |at: &usize| *at == clock.column || is_copy(table, *at, clock.column);
        let free: Vec<usize> = free.iter().copied().filter(|at| !is_copy(at)).collect();
        let moved = motion_of(table, &time, &free, fits);
        let is_better = |known: &FoundMotion| moved.score < SCORE && moved.score + RIVAL.1 < known.score;
        if best.as_ref().is_none_or(|(_, known)| is_better(known)) {
            best = Some((*clock, moved));
        }
    }
    best
}

/// What the columns of `table` are, where `time` \[s\] is known for every row; `fits` says whether a column may be in a unit.
/// `free` columns are those that are not the clock.
pub fn motion_of(table: &LoggedTable, time: &[f64], free: &[usize], fits: Fits) -> FoundMotion {
    let free: Vec<usize> = free.iter().copied().filter(|at| table.moves(*at)).collect();
    let all = Motions::new(table, time, &free, fits).hypotheses();
    let Some(best) = all.first() else {
        return FoundMotion { candidates: free, score: f64::INFINITY, ..FoundMotion::default() };
    };
    let length = table.recordings.iter().map(|rows| time[rows.end - 1] - time[rows.start]).sum::<f64>();
    let is_known = length >= LENGTH_S
        && table.rows() >= ENOUGH
        && best.turn >= TURN
        && best.unexplained < UNEXPLAINED
        && best.score < SCORE
        && (best.rate.is_some() || best.ground != Ground::Metres);
    // Without sway an angle that fits may be the course.
    let is_course = matches!(best.speeds.0, Speeds::Ship(_, _, None));
    let mut channels: Vec<FoundChannel> = Vec::new();
    for (channel, column, unit, sign) in channels_of(best) {
        let mut rivals: Vec<(usize, f64)> = Vec::new();
        let other = |other: &Hypothesis| {
            let entry = channels_of(other).into_iter().find(|(name, ..)| same(name, channel))?;
            (entry.1 != column || entry.2 != unit).then_some((entry.1, other.score))
        };
        for (at, score) in all.iter().filter_map(other) {
            if rivals.iter().all(|(known, _)| *known != at) {
                rivals.push((at, score));
            }
        }
        let limit = (RIVAL.0 * best.score).max(best.score + RIVAL.1);
        rivals.retain(|(at, score)| *score <= limit && !is_copy(table, *at, column));
        let is_angle = ["psi", "y_u"].contains(&channel);
        let is_sure = is_known && rivals.is_empty() && !(is_course && is_angle);
        channels.push(FoundChannel { channel, column, unit, sign, is_sure, score: best.score, rivals });
    }
    let mut moved = FoundMotion {
        channels,
        is_east: best.ground == Ground::East,
        score: best.score,
        is_known,
        ..FoundMotion::default()
    };
    actuated(&mut moved, table, time, &free, best);
    moved
}

/// Whether two columns have the same numbers, but for their unit.
fn is_copy(table: &LoggedTable, a: usize, b: usize) -> bool {
    a != b && 1.0 - table::correlation(&table.columns[a], &table.columns[b]).abs() < 1e-10
}

/// Whether two channels have the same information.
fn same(a: &str, b: &str) -> bool {
    const SAME: [[&str; 2]; 2] = [["x", "latitude_deg"], ["y", "longitude_deg"]];
    a == b || SAME.iter().any(|pair| pair.contains(&a) && pair.contains(&b))
}

/// Channel, column, unit and sign of all columns of a hypothesis.
fn channels_of(known: &Hypothesis) -> Vec<(&'static str, usize, &'static str, f64)> {
    let Hypothesis { angle, rate, speeds, position: [along, across], ground, is_astern, .. } = known;
    let ahead = if *is_astern { -1.0 } else { 1.0 };
    // What counts counter-clockwise from north is turned over.
    let over = if *ground == Ground::Compass { along.1 * across.1 } else { 1.0 };
    let mut all = vec![("psi", angle.0, angle.1, over)];
    all.extend(rate.map(|rate| ("y_r", rate.column, rate.unit, over * rate.sign)));
    match speeds.0 {
        Speeds::Ship(signs, surge, sway) => {
            all.push(("y_u", surge, speeds.1, ahead * signs[0]));
            all.extend(sway.map(|sway| ("y_v", sway, speeds.1, ahead * over * signs[1])));
        }
        Speeds::Earth([x, y]) => all.extend([("v_x", x, speeds.1, 1.0), ("v_y", y, speeds.1, across.1)]),
    }
    all.extend(match ground {
        Ground::Metres => [("x", along.0, "m", ahead * along.1), ("y", across.0, "m", ahead * across.1)],
        Ground::Compass => [("latitude_deg", along.0, "deg", 1.0), ("longitude_deg", across.0, "deg", 1.0)],
        Ground::East => [("latitude_deg", across.0, "deg", 1.0), ("longitude_deg", along.0, "deg", 1.0)],
    });
    all
}

fn actuated(moved: &mut FoundMotion, table: &LoggedTable, time: &[f64], free: &[usize], best: &Hypothesis) {
    let of = |channel: &str| moved.channels.iter().find(|entry| entry.channel == channel);
    let values = |entry: &FoundChannel| -> Vec<f64> {
        let size = entry.sign * crate::unit(entry.unit).map_or(1.0, |unit| unit.factor);
        table.columns[entry.column].iter().map(|value| size * value).collect()
    };
    let rate = of("y_r").map(values).or_else(|| Some(slope(table, time, &values(of("psi")?))));
    let surge = of("y_u").map(values).or_else(|| match best.speeds.0 {
        Speeds::Earth([x, y]) => {
            Some(table.columns[x].iter().zip(&table.columns[y]).map(|(x, y)| libm::hypot(*x, *y)).collect())
        }
        Speeds::Ship(..) => None,
    });
    let (Some(rate), Some(surge)) = (rate, surge) else { return };
    let response = Response { table, time, surge: &surge, rate: &rate };
    let used: Vec<usize> = moved.channels.iter().map(|entry| entry.column).collect();
    let candidates = response.candidates(free, &used);
    let (steering, drive) = (response.ranked(&candidates, Of::Rate), response.ranked(&candidates, Of::Surge));
    (moved.steering, moved.drive, moved.candidates) = (steering, drive, candidates);
}

/// Slopes over a few rows.
fn slope(table: &LoggedTable, time: &[f64], values: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; values.len()];
    for rows in &table.recordings {
        for row in rows.clone() {
            let (from, to) = (row.saturating_sub(2).max(rows.start), (row + 2).min(rows.end - 1));
            let step = values[to] - values[from];
            out[row] = step / (time[to] - time[from]);
        }
    }
    out
}
