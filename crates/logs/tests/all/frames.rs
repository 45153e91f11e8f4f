//! Axes of positions, headings and velocities.

use std::f64::consts::FRAC_PI_2;

use logs::{Body, Frame, Heading};

#[test]
fn law_from_north_east_to_east_north_and_back_is_the_identity() {
    for k in 0..20 {
        let (x, y, psi) = (f64::from(k) - 7.0, 0.3 * f64::from(k * k), 0.4 * f64::from(k) - 3.0);
        let [east, north] = Frame::Enu.north_east(x, y);
        assert_eq!(Frame::Enu.north_east(east, north), [x, y]);
        let there = Heading::EastCounterclockwise.from_north(psi);
        approx::assert_abs_diff_eq!(Heading::EastCounterclockwise.from_north(there), psi, epsilon = 1e-14);
    }
    assert_eq!(Body::Flu.starboard() * Body::Flu.starboard(), 1.0);
}

#[test]
fn heading_east_and_sailing_ahead_goes_east_in_both() {
    let enu = Heading::EastCounterclockwise.from_north(0.0);
    approx::assert_abs_diff_eq!(enu, FRAC_PI_2);
    assert_eq!(Frame::Enu.north_east(1.0, 0.0), [0.0, 1.0]);
}
