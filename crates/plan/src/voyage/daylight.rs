//! Sunrise and sunset, by the low-precision formulas of the Astronomical Almanac: to 0.01° from 1950 to 2050.

use std::f64::consts::TAU;

/// Elevation of the sun's centre when its upper edge rises or sets in usual refraction \[deg\].
const HORIZON_DEG: f64 = -0.833;
/// 2000-01-01 12:00 \[s since 1970, UTC\].
const J2000_S: f64 = 946_728_000.0;
const DAY_S: f64 = 86_400.0;
/// Steps towards noon, sunrise and sunset: each leaves about a hundredth of the error.
const STEPS: u32 = 6;

/// The daylight of the day whose noon is nearest to a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Daylight {
    /// From sunrise to sunset \[s since 1970, UTC\].
    Between([f64; 2]),
    /// All day.
    Always,
    /// Never on this day.
    Never,
}

impl Daylight {
    /// At a longitude and latitude \[deg\], on the day of `at_s` \[s since 1970, UTC\].
    pub fn of([lon_deg, lat_deg]: [f64; 2], at_s: f64) -> Self {
        let lon = lon_deg.to_radians();
        let when = |target: &dyn Fn(f64) -> f64, from_s: f64| {
            (0..STEPS).fold(from_s, |at_s, _| {
                let ahead = libm::remainder(hour_angle(lon, at_s) - target(at_s), TAU);
                at_s - ahead / TAU * DAY_S
            })
        };
        let noon_s = when(&|_| 0.0, at_s);
        let cosine = |at_s: f64| {
            let (declination, lat) = (sun(at_s)[0], lat_deg.to_radians());
            let up = libm::sin(HORIZON_DEG.to_radians()) - libm::sin(lat) * libm::sin(declination);
            up / (libm::cos(lat) * libm::cos(declination))
        };
        match cosine(noon_s) {
            high if high >= 1.0 => Self::Never,
            low if low <= -1.0 => Self::Always,
            _ => {
                let half = |at_s: f64| libm::acos(cosine(at_s).clamp(-1.0, 1.0));
                Self::Between([when(&|at_s| -half(at_s), noon_s), when(&half, noon_s)])
            }
        }
    }
}

/// The hour angle of the sun west of the meridian of `lon` \[rad\].
fn hour_angle(lon: f64, at_s: f64) -> f64 {
    let days = (at_s - J2000_S) / DAY_S;
    let greenwich_deg = 280.460_618_37 + 360.985_647_366_29 * days;
    libm::remainder(greenwich_deg.to_radians() + lon - sun(at_s)[1], TAU)
}

/// Declination and right ascension of the sun \[rad\].
fn sun(at_s: f64) -> [f64; 2] {
    let days = (at_s - J2000_S) / DAY_S;
    let anomaly = (357.528 + 0.985_600_3 * days).to_radians();
    let centre_deg = 1.915 * libm::sin(anomaly) + 0.020 * libm::sin(2.0 * anomaly);
    let longitude = (280.460 + 0.985_647_4 * days + centre_deg).to_radians();
    let obliquity = (23.439 - 4e-7 * days).to_radians();
    let (sin, cos) = libm::sincos(longitude);
    [libm::asin(libm::sin(obliquity) * sin), libm::atan2(libm::cos(obliquity) * sin, cos)]
}
