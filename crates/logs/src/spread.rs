//! Rows that share a time, spread until the next one: clocks that were logged more coarsely than the rows.

use numerics::statistics::streamed_median as median_again;

use crate::Samples;

/// Consecutive rows with one time.
struct Shared {
    time: f64,
    rows: usize,
}

/// Steps that are longer than this many usual ones are gaps.
const GAP: f64 = 1.5;

/// `times` \[s\] with the rows of each spread evenly until the next, and how many were moved. In an
/// incomplete second, at the ends of a recording and at gaps, rows keep the usual distance: at an end they
/// follow their time, at a beginning they lead up to the next one, unless all rows follow a stamp with their
/// time (`is_stamped`).
pub(crate) fn spread(times: Samples, is_stamped: bool) -> (Samples, usize) {
    let shared = shared(&times);
    let known = times.iter().filter(|time| time.is_finite()).count();
    let steps = || shared.windows(2).map(|pair| pair[1].time - pair[0].time);
    let step = median_again(|| steps().filter(|step| *step > 0.0));
    let (Some(step), true) = (step, known > shared.len()) else { return (times, 0) };
    let usual = median_again(|| shared.iter().map(|own| own.rows as f64)).unwrap_or(1.0);
    let afters = steps().map(Some).chain([None]);
    let befores = [None].into_iter().chain(steps().map(Some));
    let gap = |other: Option<f64>| other.is_none_or(|own| !(own > 0.0 && own <= GAP * step));
    let mut rows = shared.iter().zip(befores.zip(afters)).flat_map(|(own, (before, after))| {
        let count = own.rows as f64;
        let (first, between) = match after {
            after if gap(after) => {
                // Several seconds, where the times between were lost.
                let space = after.filter(|after| *after > 0.0).map_or(f64::INFINITY, |after| after / count);
                (own.time, (step / usual).min(space))
            }
            Some(after) if !is_stamped && gap(before) && count < usual => {
                (own.time + after * (1.0 - count / usual), after / usual)
            }
            after => (own.time, after.unwrap_or(step) / count),
        };
        (0..own.rows).map(move |row| first + row as f64 * between)
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

    fn spread_all(times: Vec<f64>) -> (Vec<f64>, usize) {
        let (times, moved) = spread(times.into(), false);
        (times.to_vec(), moved)
    }

    #[test]
    fn law_rows_at_a_constant_rate_get_their_times_back() {
        // 4 Hz from 2.5 s on, with a gap from 6 to 9.5 s; of the first second and of that after the gap there are two rows.
        let truth: Vec<f64> = (10..24).chain(38..47).map(|row| 0.25 * f64::from(row)).collect();
        let (found, moved) = spread_all(truth.iter().map(|time| time.floor()).collect());
        assert_eq!(found, truth);
        assert_eq!(moved, truth.len() - 7);
    }

    #[test]
    fn rows_of_a_stamp_that_was_lost_keep_their_distance() {
        // 5 Hz; the stamp of second 3 is lost, and second 0 has but four rows.
        let stamps: Vec<f64> =
            (0..40).filter(|row| *row != 2).map(|row| [0.0, 1.0, 2.0, 2.0, 4.0][(row / 5).min(4)]).collect();
        let stamps: Vec<f64> = stamps.into_iter().take(24).collect();
        let (found, _) = spread(stamps.into(), true);
        let found = found.to_vec();
        assert_eq!((found[0], found[4]), (0.0, 1.0));
        for (row, time) in found[9..19].iter().enumerate() {
            assert!((time - 2.0 - 0.2 * row as f64).abs() < 1e-9, "{found:?}");
        }
    }

    #[test]
    fn rows_without_a_time_and_clocks_that_are_fine_enough_stay() {
        let (found, _) = spread_all(vec![0.0, f64::NAN, 0.0, 1.0, 1.0]);
        assert!(found[1].is_nan() && found[2] == 0.5 && found[4] == 1.5, "{found:?}");
        assert_eq!(spread_all(vec![0.0, 0.5, 1.5]), (vec![0.0, 0.5, 1.5], 0));
    }
}
