//! Noisy measurements of a ship, smoothed.

use plan::{Fixed, Navigation, Sensors};
use ship::engine::Streams;

#[test]
fn oracle_smoothed_measurements_scatter_as_stated_about_a_ship_that_is_predicted_well() {
    let sensors = Sensors { position_m: 3.0, heading_rad: 0.02, speed_m_s: 0.1, yaw_rate_rad_s: 0.0 };
    assert!(Navigation::new(Sensors::default(), 8.0, Streams::new(1, "exact"), 0).is_none());
    let mut navigation = Navigation::new(sensors, 8.0, Streams::new(1, "noise"), 0).unwrap();
    let (smoothed, mut truly) =
        (navigation.smoothed(), Fixed { state: [2.0, 0.1, 0.01], ..Fixed::default() });
    let (mut sums, count) = ([0.0; 3], 20_000);
    for _ in 0..count {
        let seen = navigation.estimate(truly);
        assert_eq!(seen.state[2], 0.01);
        let off = [seen.pose.psi - truly.pose.psi, seen.state[0] - 2.0, seen.pose.x - truly.pose.x];
        sums.iter_mut().zip(off).for_each(|(sum, off)| *sum += off * off / f64::from(count));
        navigation.predict(seen, truly.state, 1.0);
        let (sin, cos) = libm::sincos(truly.pose.psi);
        truly.pose.x += 2.0 * cos - 0.1 * sin;
        truly.pose.y += 2.0 * sin + 0.1 * cos;
        truly.pose.psi += 0.01;
    }
    let [heading, speed, north] = sums.map(f64::sqrt);
    assert!((heading / smoothed.heading_rad - 1.0).abs() < 0.05, "{heading}");
    // A prediction from the true speed keeps nothing of an estimate: K of every measurement is left.
    assert!((speed / (0.1 / 8.0) - 1.0).abs() < 0.05, "{speed}");
    assert!((north / smoothed.position_m - 1.0).abs() < 0.1, "{north}");
}
