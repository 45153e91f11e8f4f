use std::f64::consts::{PI, TAU};

/// WGS 84: semi-major axis \[m\] and first eccentricity squared.
const SEMI_MAJOR_M: f64 = 6_378_137.0;
const ECCENTRICITY_2: f64 = 6.694_379_990_141_316_5e-3;

/// A plane tangent to the WGS 84 ellipsoid, with the radii of curvature at one point. Within 5 km of it positions are good
/// to a few metres, distances between near points to 1e-3 of themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalPlane {
    latitude: f64,
    longitude: f64,
    north_m: f64,
    east_m: f64,
}

impl LocalPlane {
    /// The plane that touches at `latitude`, `longitude` \[rad\].
    ///
    /// Radii of curvature (Torge & Müller, Geodesy, 4.1.3), with w² = 1 − e² sin²φ: in the meridian
    /// M = a (1 − e²) / w³, across it N = a / w.
    pub fn at(latitude: f64, longitude: f64) -> Self {
        let w2 = 1.0 - ECCENTRICITY_2 * latitude.sin().powi(2);
        let across = SEMI_MAJOR_M / w2.sqrt();
        Self {
            latitude,
            longitude,
            north_m: across * (1.0 - ECCENTRICITY_2) / w2,
            east_m: across * latitude.cos(),
        }
    }

    /// North and east of the point \[m\] at `latitude`, `longitude` \[rad\].
    pub fn north_east(&self, latitude: f64, longitude: f64) -> [f64; 2] {
        let east = (longitude - self.longitude + PI).rem_euclid(TAU) - PI;
        [self.north_m * (latitude - self.latitude), self.east_m * east]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_minute_of_latitude_is_about_a_nautical_mile() {
        let plane = LocalPlane::at(60.0_f64.to_radians(), 25.0_f64.to_radians());
        let minute = (1.0_f64 / 60.0).to_radians();
        let [north, east] = plane.north_east(60.0_f64.to_radians() + minute, 25.0_f64.to_radians() + minute);
        assert!((north - 1857.0).abs() < 1.0 && (east - 930.0).abs() < 1.0, "{north} {east}");
    }

    #[test]
    fn law_the_date_line_is_no_edge() {
        let plane = LocalPlane::at(0.5, PI - 1e-6);
        let [_, east] = plane.north_east(0.5, -PI + 1e-6);
        assert!((0.0..20.0).contains(&east), "{east}");
    }
}
