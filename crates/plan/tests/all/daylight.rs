//! Sunrise and sunset, against the sun's elevation by other formulas and against almanacs.

use plan::voyage::Daylight;

/// Elevation of the sun's centre \[deg\] by Meeus' formulas with the equation of time, as NOAA's calculator has them.
fn elevation_deg([lon, lat]: [f64; 2], at_s: f64) -> f64 {
    let century = (at_s / 86_400.0 + 2_440_587.5 - 2_451_545.0) / 36_525.0;
    let mean = (280.46646 + century * (36_000.769_83 + century * 0.0003032)).to_radians();
    let anomaly = (357.52911 + century * (35_999.050_29 - 0.0001537 * century)).to_radians();
    let eccentricity = 0.016708634 - century * (0.000042037 + 0.0000001267 * century);
    let centre = anomaly.sin() * (1.914602 - century * (0.004817 + 0.000014 * century))
        + (2.0 * anomaly).sin() * (0.019993 - 0.000101 * century)
        + (3.0 * anomaly).sin() * 0.000289;
    let node = (125.04 - 1934.136 * century).to_radians();
    let apparent = mean + (centre - 0.00569 - 0.00478 * node.sin()).to_radians();
    let obliquity = (23.439291 - 0.0130042 * century + 0.00256 * node.cos()).to_radians();
    let declination = (obliquity.sin() * apparent.sin()).asin();
    let y = (obliquity / 2.0).tan().powi(2);
    let equation = y * (2.0 * mean).sin() - 2.0 * eccentricity * anomaly.sin()
        + 4.0 * eccentricity * y * anomaly.sin() * (2.0 * mean).cos()
        - 0.5 * y * y * (4.0 * mean).sin()
        - 1.25 * eccentricity * eccentricity * (2.0 * anomaly).sin();
    let hour = (at_s / 240.0 + lon + equation.to_degrees() + 180.0).to_radians();
    let lat = lat.to_radians();
    (lat.sin() * declination.sin() + lat.cos() * declination.cos() * hour.cos()).asin().to_degrees()
}

/// Noon in UTC of a day of 2026 \[s since 1970\].
fn noon_s(day: u32) -> f64 {
    1_767_225_600.0 + 86_400.0 * f64::from(day - 1) + 43_200.0
}

#[test]
fn law_the_suns_edge_is_on_the_horizon_at_sunrise_and_sunset_and_above_it_between() {
    let mut polar = [0, 0];
    for day in (1..=365).step_by(7) {
        for lat in [-78.0, -60.0, -33.9, 0.0, 25.0, 47.3, 60.0, 66.0, 70.0] {
            for lon in [-179.5, -122.4, 0.0, 25.0, 151.2] {
                let (place, at_s) = ([lon, lat], noon_s(day) - lon * 240.0);
                let through = || (-48..=48).map(|k| elevation_deg(place, at_s + 900.0 * f64::from(k)));
                match Daylight::of(place, at_s) {
                    Daylight::Between([rise, set]) => {
                        // Where the sun hardly sets, its edge is near the horizon for hours.
                        let most = if set - rise < 23.0 * 3600.0 { 0.03 } else { 0.3 };
                        for edge in [rise, set] {
                            assert!((elevation_deg(place, edge) + 0.833).abs() < most, "{day} {place:?}");
                        }
                        assert!(rise < set && set - rise < 86_400.0);
                        assert!(elevation_deg(place, (rise + set) / 2.0) > -0.833, "{day} {place:?}");
                        assert!((at_s - (rise + set) / 2.0).abs() < 1800.0, "{day} {place:?}");
                    }
                    Daylight::Always => {
                        polar[0] += 1;
                        assert!(through().all(|up| up > -1.3), "{day} {place:?}");
                    }
                    Daylight::Never => {
                        polar[1] += 1;
                        assert!(through().all(|up| up < -0.8), "{day} {place:?}");
                    }
                }
            }
        }
    }
    assert!(polar.iter().all(|days| *days > 20), "{polar:?}");
}

/// Minutes after midnight UTC of sunrise and sunset.
#[test]
fn oracle_sunrise_and_sunset_are_those_of_almanacs() {
    for (what, place, day, minutes) in [
        ("Helsinki, 21 June", [24.94, 60.17], 172, [54.0, 19.0 * 60.0 + 50.0]),
        ("Helsinki, 21 December", [24.94, 60.17], 355, [7.0 * 60.0 + 24.0, 13.0 * 60.0 + 13.0]),
        ("London, 21 June", [-0.13, 51.51], 172, [3.0 * 60.0 + 43.0, 20.0 * 60.0 + 21.5]),
        ("London, 21 December", [-0.13, 51.51], 355, [8.0 * 60.0 + 4.0, 15.0 * 60.0 + 53.5]),
        ("New York, 21 December", [-74.01, 40.71], 355, [12.0 * 60.0 + 16.5, 21.0 * 60.0 + 31.5]),
    ] {
        let midnight = noon_s(day) - 43_200.0;
        let Daylight::Between(own) = Daylight::of(place, noon_s(day)) else { panic!("{what}") };
        for (own, minutes) in own.iter().zip(minutes) {
            assert!(((own - midnight) / 60.0 - minutes).abs() < 2.0, "{what}: {}", (own - midnight) / 60.0);
        }
    }
}
