//! Clocks that begin anew: at midnight if they have no date, after a week, when a counter overflows. And
//! clocks that were set while the log ran.

use numerics::statistics::streamed_median as median_again;

use crate::Samples;
use crate::samples::steps;

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

/// Whether a clock that advanced by `step_s` \[s\], which is below 0, began anew with the next row within
/// `near_s`.
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
    let usual = median_again(|| steps(known()).filter(|step| *step > 0.0)).unwrap_or(0.0);
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
///
/// # Errors
/// A jump of more than a year that is not of this kind: the row after it, the previous time and its own.
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
                let (found, count) = unrolled_all(&counted, false);
                let gone = truth[299].div_euclid(period) - truth[0].div_euclid(period);
                assert_eq!(count as f64, gone, "{period}");
                let steps: Vec<f64> = steps(found.iter().copied()).collect();
                assert!(
                    steps.iter().all(|own| (own - step).abs() < 1e-6 * step.max(1e-3)),
                    "{period}: {steps:?}"
                );
                let (found, _) = unrolled_all(&truth.iter().map(signed).collect::<Vec<_>>(), false);
                let last = found[299] - found[0];
                assert!((last - 299.0 * step).abs() < 1e-6 * period, "{period}, signed: {last}");
            }
        }
    }

    #[test]
    fn a_day_without_a_date_passes_and_rows_that_are_late_stay_so() {
        let day = [86_398.0, 86_399.0, 0.0, 86_399.5, 1.0, f64::NAN, 2.0];
        let (found, count) = unrolled_all(&day, true);
        assert_eq!((found[2], found[3], found[6], count), (86_400.0, 86_399.5, 86_402.0, 1));
        assert_eq!(unrolled_all(&[10.0, 9.0, 11.0], true).1, 0);
        assert_eq!(unrolled_all(&[86_399.0, 86_400.0, 0.0, 1.0], true).0[2..], [86_401.0, 86_402.0]);
        // A clock that was set back, one that began anew after an hour.
        assert_eq!(unrolled_all(&[100.0, 101.0, 37.0, 38.0], false).1, 0);
        assert_eq!(unrolled_all(&[3598.0, 3599.0, 0.0, 1.0], false).1, 0);
    }

    #[test]
    fn rows_before_a_clock_is_set_are_left_out_and_other_jumps_refused() {
        let (found, unset) = set([0.0, 1.0, 1.7e9, 1.7e9 + 1.0].as_slice().into()).unwrap();
        assert!(found.first().unwrap().is_nan() && unset == 2);
        assert_eq!(set([1.0e9, 1.1e9].as_slice().into()).unwrap_err().0, 1);
        assert_eq!(set([1.0, 1.7e9, 2.0].as_slice().into()).unwrap().1, 0);
    }
}
