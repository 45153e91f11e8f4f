//! Angles without jumps.

use logs::Unwrapping;

fn unwrap(angles: &mut [f64]) {
    let mut unwrapping = Unwrapping::default();
    angles.iter_mut().for_each(|angle| *angle = unwrapping.next(*angle));
}

#[test]
fn a_circle_sailed_three_times_is_a_straight_line_of_headings() {
    let straight: Vec<f64> = (0..200).map(|i| 0.1 * f64::from(i)).collect();
    let mut wrapped: Vec<f64> = straight.iter().map(|a| a.sin().atan2(a.cos())).collect();
    unwrap(&mut wrapped);
    for (found, expected) in wrapped.iter().zip(&straight) {
        approx::assert_abs_diff_eq!(found, expected, epsilon = 1e-12);
    }
}

#[test]
fn law_angles_without_jumps_stay_as_they_are() {
    let angles = [0.3, -0.6, 0.6, 3.0, 5.0];
    let mut same = angles;
    unwrap(&mut same);
    assert_eq!(same, angles);
}
