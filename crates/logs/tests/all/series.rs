//! Channels on their own clocks.

use logs::Series;

#[test]
fn nothing_is_extrapolated_and_gaps_stay_open() {
    let series = Series::new(&[1.0, 2.0, 5.0, 6.0], &[10.0, 20.0, 50.0, 60.0], 1.5);
    let found = series.at([0.5, 1.0, 1.25, 2.0, 3.0, 5.0, 5.5, 6.0, 6.5]);
    let expected = [f64::NAN, 10.0, 12.5, 20.0, f64::NAN, 50.0, 55.0, 60.0, f64::NAN];
    for (found, expected) in found.zip(expected) {
        assert!(found == expected || found.is_nan() && expected.is_nan(), "{found} {expected}");
    }
    assert_eq!(series.sections(), [0..2, 2..4]);
    assert_eq!(series.gaps(), 1);
}

#[test]
fn law_averaging_keeps_straight_lines_even_at_the_ends() {
    let t: Vec<f64> = (0..50).map(|i| 0.1 * f64::from(i)).collect();
    let line: Vec<f64> = t.iter().map(|t| 3.0 - 2.0 * t).collect();
    let averaged = Series::new(&t, &line, 0.5).averaged(1.0);
    for (found, expected) in averaged.values.to_vec().iter().zip(&line) {
        approx::assert_abs_diff_eq!(found, expected, epsilon = 1e-12);
    }
}

#[test]
fn missing_values_leave_the_clock_of_their_channel() {
    let series = Series::new(&[0.0, 1.0, 2.0], &[1.0, f64::NAN, 3.0], 2.0);
    assert_eq!(series.t.to_vec(), [0.0, 2.0]);
    assert!(series.at([1.0]).eq([2.0]));
}
