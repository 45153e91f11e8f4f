//! Clocks: the order of their times, where they begin anew, and rows that share a time.

use numerics::statistics::streamed_median;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Samples;
use crate::samples::steps;

/// What a time column counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum TimeUnit {
    /// Seconds, from any origin.
    S,
    /// Milliseconds.
    Ms,
    /// Microseconds.
    Us,
    /// Nanoseconds.
    Ns,
    /// Date and time as text, `2020-07-31T13:04:24.5+09:00`; without an offset in the time's `zone`.
    Iso8601,
}

impl TimeUnit {
    /// Seconds in one unit; none where time is text.
    pub fn seconds(self) -> Option<f64> {
        match self {
            Self::S => Some(1.0),
            Self::Ms => Some(1e-3),
            Self::Us => Some(1e-6),
            Self::Ns => Some(1e-9),
            Self::Iso8601 => None,
        }
    }

    /// Whether a text in ISO 8601 has a time of day, and not only a date.
    pub(crate) fn has_time(text: &str) -> bool {
        text.get(10..).is_some_and(|rest| rest.starts_with(['T', 't', ' ']))
    }
}

/// What to do with rows whose time is before that of an earlier row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum NonMonotonic {
    /// Refuse the file.
    #[default]
    Refuse,
    /// Put the rows in the order of time.
    Sort,
    /// Leave them out.
    Drop,
}

/// What to do with rows that have the time of the row before, such as rows at 20 Hz with whole seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Repeated {
    /// Leave them out where they are few; refuse the file where they are more than a fifth.
    #[default]
    Refuse,
    /// Leave them out: the first row of each time stays.
    Drop,
    /// Spread the rows of each time evenly until the next.
    Spread,
}

/// The rows of a file in order of time, each time once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Order {
    /// The remaining rows, in order.
    pub rows: Vec<u32>,
    /// Rows left out because an earlier row has the same time.
    pub repeated: usize,
    /// Rows that stood after a later time.
    pub backwards: usize,
}

/// Time goes backwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Backwards {
    /// The row whose time is too early.
    pub row: usize,
    /// Its time \[s\].
    pub time: f64,
    /// The latest time before it \[s\].
    pub latest: f64,
}

/// Orders rows by their `times` (\[s\]) and leaves out rows without a time (not finite). Sorting holds all times in memory.
///
/// # Errors
/// The first row that is earlier than a row before it, where `policy` refuses that.
pub fn order(times: &Samples, policy: NonMonotonic) -> Result<Order, Backwards> {
    let mut out = Order { rows: Vec::new(), repeated: 0, backwards: 0 };
    let mut latest = f64::NEG_INFINITY;
    for (row, time) in times.iter().enumerate().filter(|(_, time)| time.is_finite()) {
        if time < latest {
            if policy == NonMonotonic::Refuse {
                return Err(Backwards { row, time, latest });
            }
            out.backwards += 1;
        }
        if time > latest || policy == NonMonotonic::Sort {
            out.rows.push(row as u32);
        } else if time == latest {
            out.repeated += 1;
        }
        latest = latest.max(time);
    }
    if policy == NonMonotonic::Sort {
        let times = times.to_vec();
        let time = |row: u32| times[row as usize];
        out.rows.sort_by(|a, b| time(*a).total_cmp(&time(*b)));
        let before = out.rows.len();
        out.rows.dedup_by(|later, earlier| time(*later) == time(*earlier));
        out.repeated = before - out.rows.len();
    }
    Ok(out)
}

// Clocks that begin anew: at midnight if they have no date, after a week, when a counter overflows. And
// clocks that were set while the log ran.

/// A day \[s\].
pub(crate) const DAY: f64 = 86_400.0;

/// How much earlier than the previous row a row may be that is late across midnight \[s\].
const LATE: f64 = 3600.0;

/// Periods of counters \[s\]: days and weeks in seconds; 16, 24, 31 and 32 bits of ticks.
const PERIODS: [f64; 12] = [
    DAY,
    7.0 * DAY,
    TWO_32 * 1e-9,
    TWO_32 * 1e-6,
    TWO_32 * 1e-3,
    TWO_32,
    0.5 * TWO_32 * 1e-6,
    0.5 * TWO_32 * 1e-3,
    16_777.216,
    16.777_216,
    65_536.0,
    65.536,
];

const TWO_32: f64 = 4_294_967_296.0;

/// A period must be this many usual steps long to be distinguished from one.
const STEPS: f64 = 20.0;

/// Most usual steps between the last row before a rollover and the first after it.
const NEXT: f64 = 5.0;

/// A step that no recording has \[s\]: the clock was set there.
const YEAR: f64 = 365.0 * DAY;

/// Clocks that were set do not show times before 2001 \[s\].
const SET: f64 = 978_307_200.0;

/// Whether a clock that advanced by `step_s` \[s\], which is below 0, began anew with the next row within `near_s`.
pub fn begins_anew(step_s: f64, near_s: f64) -> bool {
    PERIODS.iter().any(|period| (0.0..=near_s).contains(&(step_s + period)))
}

/// `times` \[s\] with what a clock lost at its rollovers, and their number. Clocks `of_day` have no date.
/// Others count from any origin; their period is recognized by the size of the loss, and by a next row within
/// a few usual steps or `max_gap_s`.
pub(crate) fn unrolled(times: Samples, of_day: bool, max_gap_s: f64) -> (Samples, usize) {
    let known = || times.iter().filter(|time| time.is_finite());
    let is_late = |step: f64| of_day && step > DAY - LATE;
    if !steps(known()).any(|step| step < 0.0 || is_late(step)) {
        return (times, 0);
    }
    let usual = streamed_median(|| steps(known()).filter(|step| *step > 0.0)).unwrap_or(0.0);
    let mut clock = Unrolling {
        of_day,
        usual,
        near: max_gap_s.max(NEXT * usual),
        before: f64::NAN,
        period: if of_day { DAY } else { f64::INFINITY },
        lost: 0.0,
        count: 0,
    };
    let unrolled = times.made(times.iter().map(|time| clock.next(time)));
    if clock.count == 0 { (times, 0) } else { (unrolled, clock.count) }
}

struct Unrolling {
    of_day: bool,
    /// The median step \[s\].
    usual: f64,
    /// How far away the next row may be \[s\].
    near: f64,
    /// The latest time since the last rollover.
    before: f64,
    /// The last loss.
    period: f64,
    /// The total loss.
    lost: f64,
    count: usize,
}

impl Unrolling {
    fn next(&mut self, time: f64) -> f64 {
        let step = time - self.before;
        if step < 0.0 {
            let Some(period) = self.period(time) else { return self.lost + time };
            (self.period, self.lost, self.count) = (period, self.lost + period, self.count + 1);
        } else if self.period - step < if self.of_day { LATE } else { self.near } {
            // A late row, from before the rollover.
            return self.lost - self.period + time;
        }
        if time.is_finite() {
            self.before = time;
        }
        self.lost + time
    }

    /// The period if the clock began anew before `time`, which is earlier than the previous one.
    fn period(&self, time: f64) -> Option<f64> {
        if self.of_day {
            // A leap second at midnight is lost, too.
            let day = if self.before >= DAY { DAY + 1.0 } else { DAY };
            return (self.before - time > 0.5 * DAY).then_some(day);
        }
        let fits = |period: f64| {
            // Signed counters begin anew at minus half their period.
            let top = if time < 0.0 { 0.5 * period } else { period };
            let near = self.near.min(0.125 * period);
            self.before <= top && period >= STEPS * self.usual && period - self.before + time <= near
        };
        let periods = PERIODS.into_iter().filter(|period| fits(*period));
        periods.min_by(f64::total_cmp)
    }
}

/// `times` \[s\] without those of the rows before the clock was set, by decades, and how many these are.
pub(crate) fn set(times: Samples) -> Result<(Samples, usize), (usize, [f64; 2])> {
    let (mut before, mut jump) = (f64::NAN, None);
    for (row, time) in times.iter().enumerate().filter(|(_, time)| time.is_finite()) {
        if time - before > YEAR {
            jump = Some((row, [before, time]));
        }
        before = time;
    }
    let Some((row, [before, after])) = jump else { return Ok((times, 0)) };
    // Where time goes back again, only this row is wrong.
    if times.range(row..times.len()).any(|time| time < after - DAY) {
        return Ok((times, 0));
    }
    if before >= SET || after < SET {
        return Err((row, [before, after]));
    }
    let unset = times.range(0..row).filter(|time| time.is_finite()).count();
    let kept = times.iter().enumerate().map(|(i, time)| if i < row { f64::NAN } else { time });
    Ok((times.made(kept), unset))
}

/// Consecutive rows with one time.
struct Shared {
    time: f64,
    rows: usize,
}

/// Steps that are longer than this many usual ones are gaps.
const GAP: f64 = 1.5;

/// `times` \[s\] with the rows of each spread evenly until the next, and how many were moved. In an incomplete second, at
/// the ends of a recording and at gaps, rows keep the usual distance: at an end they follow their time, at a beginning they
/// lead up to the next one, unless all rows follow a stamp with their time (`is_stamped`).
pub(crate) fn spread(times: Samples, is_stamped: bool) -> (Samples, usize) {
    let shared = shared(&times);
    let known = times.iter().filter(|time| time.is_finite()).count();
    let steps = || shared.windows(2).map(|pair| pair[1].time - pair[0].time);
    let step = streamed_median(|| steps().filter(|step| *step > 0.0));
    let (Some(step), true) = (step, known > shared.len()) else { return (times, 0) };
    let usual = streamed_median(|| shared.iter().map(|group| group.rows as f64)).unwrap_or(1.0);
    let afters = steps().map(Some).chain([None]);
    let befores = [None].into_iter().chain(steps().map(Some));
    let gap = |other: Option<f64>| other.is_none_or(|distance| !(distance > 0.0 && distance <= GAP * step));
    let mut rows = shared.iter().zip(befores.zip(afters)).flat_map(|(group, (before, after))| {
        let count = group.rows as f64;
        let (first, between) = match after {
            after if gap(after) => {
                // Several seconds, where the times between were lost.
                let space = after.filter(|after| *after > 0.0).map_or(f64::INFINITY, |after| after / count);
                (group.time, (step / usual).min(space))
            }
            Some(after) if !is_stamped && gap(before) && count < usual => {
                (group.time + after * (1.0 - count / usual), after / usual)
            }
            after => (group.time, after.unwrap_or(step) / count),
        };
        (0..group.rows).map(move |row| first + row as f64 * between)
    });
    let spread = times.iter().map(|time| if time.is_finite() { rows.next().unwrap_or(time) } else { time });
    (times.made(spread), known - shared.len())
}

fn shared(times: &Samples) -> Vec<Shared> {
    let mut shared: Vec<Shared> = Vec::new();
    for time in times.iter().filter(|time| time.is_finite()) {
        match shared.last_mut().filter(|last| last.time == time) {
            Some(last) => last.rows += 1,
            None => shared.push(Shared { time, rows: 1 }),
        }
    }
    shared
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unrolled_all(times: &[f64], of_day: bool) -> (Vec<f64>, usize) {
        let (times, count) = unrolled(times.into(), of_day, 1.5);
        (times.to_vec(), count)
    }

    #[test]
    fn law_a_counter_of_any_width_runs_on() {
        for period in PERIODS {
            for rows in [0.1, 0.7] {
                let step = (period / 60.0).min(1.0);
                let truth: Vec<f64> =
                    (0..300).map(|k| period - rows * 100.0 * step + step * k as f64).collect();
                let signed = |time: &f64| (time + 0.5 * period).rem_euclid(period) - 0.5 * period;
                let counted: Vec<f64> = truth.iter().map(|time| time.rem_euclid(period)).collect();
                let (times, count) = unrolled_all(&counted, false);
                let gone = truth[299].div_euclid(period) - truth[0].div_euclid(period);
                assert_eq!(count as f64, gone, "{period}");
                let steps: Vec<f64> = steps(times.iter().copied()).collect();
                assert!(
                    steps.iter().all(|length| (length - step).abs() < 1e-6 * step.max(1e-3)),
                    "{period}: {steps:?}"
                );
                let (times, _) = unrolled_all(&truth.iter().map(signed).collect::<Vec<_>>(), false);
                let last = times[299] - times[0];
                assert!((last - 299.0 * step).abs() < 1e-6 * period, "{period}, signed: {last}");
            }
        }
    }

    #[test]
    fn a_day_without_a_date_passes_and_rows_that_are_late_stay_so() {
        let day = [86_398.0, 86_399.0, 0.0, 86_399.5, 1.0, f64::NAN, 2.0];
        let (times, count) = unrolled_all(&day, true);
        assert_eq!((times[2], times[3], times[6], count), (86_400.0, 86_399.5, 86_402.0, 1));
        assert_eq!(unrolled_all(&[10.0, 9.0, 11.0], true).1, 0);
        assert_eq!(unrolled_all(&[86_399.0, 86_400.0, 0.0, 1.0], true).0[2..], [86_401.0, 86_402.0]);
        // A clock that was set back, one that began anew after an hour.
        assert_eq!(unrolled_all(&[100.0, 101.0, 37.0, 38.0], false).1, 0);
        assert_eq!(unrolled_all(&[3598.0, 3599.0, 0.0, 1.0], false).1, 0);
    }

    #[test]
    fn rows_before_a_clock_is_set_are_left_out_and_other_jumps_refused() {
        let (times, unset) = set([0.0, 1.0, 1.7e9, 1.7e9 + 1.0].as_slice().into()).unwrap();
        assert!(times.first().unwrap().is_nan() && unset == 2);
        assert_eq!(set([1.0e9, 1.1e9].as_slice().into()).unwrap_err().0, 1);
        assert_eq!(set([1.0, 1.7e9, 2.0].as_slice().into()).unwrap().1, 0);
    }

    fn spread_all(times: Vec<f64>) -> (Vec<f64>, usize) {
        let (times, moved) = spread(times.into(), false);
        (times.to_vec(), moved)
    }

    #[test]
    fn law_rows_at_a_constant_rate_get_their_times_back() {
        // 4 Hz from 2.5 s on, with a gap from 6 to 9.5 s; of the first second and of that after the gap there are two rows.
        let truth: Vec<f64> = (10..24).chain(38..47).map(|row| 0.25 * f64::from(row)).collect();
        let (spread, moved) = spread_all(truth.iter().map(|time| time.floor()).collect());
        assert_eq!(spread, truth);
        assert_eq!(moved, truth.len() - 7);
    }

    #[test]
    fn rows_of_a_stamp_that_was_lost_keep_their_distance() {
        // 5 Hz; the stamp of second 3 is lost, and second 0 has but four rows.
        let stamps: Vec<f64> =
            (0..40).filter(|row| *row != 2).map(|row| [0.0, 1.0, 2.0, 2.0, 4.0][(row / 5).min(4)]).collect();
        let stamps: Vec<f64> = stamps.into_iter().take(24).collect();
        let (spread_times, _) = spread(stamps.into(), true);
        let spread_times = spread_times.to_vec();
        assert_eq!((spread_times[0], spread_times[4]), (0.0, 1.0));
        for (row, time) in spread_times[9..19].iter().enumerate() {
            assert!((time - 2.0 - 0.2 * row as f64).abs() < 1e-9, "{spread_times:?}");
        }
    }

    #[test]
    fn rows_without_a_time_and_clocks_that_are_fine_enough_stay() {
        let (spread, _) = spread_all(vec![0.0, f64::NAN, 0.0, 1.0, 1.0]);
        assert!(spread[1].is_nan() && spread[2] == 0.5 && spread[4] == 1.5, "{spread:?}");
        assert_eq!(spread_all(vec![0.0, 0.5, 1.5]), (vec![0.0, 0.5, 1.5], 0));
    }
}
