//! Local parabolas.

use logs::window_samples;

use crate::parabolas;

#[test]
fn law_a_parabola_is_kept_with_its_slope_on_any_clock() {
    let t: Vec<f64> = (0..40).map(|i| 0.1 * f64::from(i) + 0.03 * f64::from(i * i % 7)).collect();
    let y: Vec<f64> = t.iter().map(|t| 1.0 - 2.0 * t + 0.5 * t * t).collect();
    let (values, slopes) = parabolas(&t, &y, 9);
    for i in 0..t.len() {
        approx::assert_abs_diff_eq!(values[i], y[i], epsilon = 1e-12);
        approx::assert_abs_diff_eq!(slopes[i], t[i] - 2.0, epsilon = 1e-11);
    }
}

#[test]
fn windows_are_odd_and_never_smaller_than_a_parabola_needs() {
    assert_eq!(window_samples(1.0, 10.0), 11);
    assert_eq!(window_samples(0.01, 10.0), 3);
    assert_eq!(parabolas(&[0.0, 1.0], &[0.0, 1.0], 5), (Vec::new(), Vec::new()));
}
