use geographiclib_rs::{DirectGeodesic, Geodesic, InverseGeodesic};

use crate::Invalid;

/// A local plane about an origin, x east and y north \[m\]: the azimuthal equidistant projection of WGS84.
///
/// Distances and directions from the origin are those of the geodesic. Across the radius, at a distance r of
/// the origin, lengths are too long by r²/(6 R²): 4·10⁻⁷ at 10 km, 1·10⁻⁵ at 50 km, 4·10⁻⁵ at 100 km.
/// Distances between any two points within r are wrong by no more than that share. North on the plane is true
/// north at the origin only: elsewhere it differs by the convergence [`Plane::north_rad`], about x
/// tan(latitude)/R (0.16° at x = 10 km, 60° north).
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    lon_deg: f64,
    lat_deg: f64,
    earth: Geodesic,
}

impl Plane {
    /// The plane about `lon_deg`, `lat_deg` (WGS84).
    ///
    /// # Errors
    /// An origin that is not finite or outside ±180° and ±90°.
    pub fn new(lon_deg: f64, lat_deg: f64) -> Result<Self, Invalid> {
        if lon_deg.abs() <= 180.0 && lat_deg.abs() <= 90.0 {
            return Ok(Self { lon_deg, lat_deg, earth: Geodesic::wgs84() });
        }
        Err(Invalid::new(
            "origin of the plane",
            format!("longitude {lon_deg}, latitude {lat_deg}"),
            "degrees within ±180 and ±90, longitude first",
            "correct the origin",
        ))
    }

    /// The place of a longitude and latitude \[deg\] on the plane \[m\]; NaN for a latitude beyond ±90°.
    pub fn to_plane(&self, lon_deg: f64, lat_deg: f64) -> [f64; 2] {
        let (distance, azimuth, _, _) = self.earth.inverse(self.lat_deg, self.lon_deg, lat_deg, lon_deg);
        let (sin, cos) = libm::sincos(f64::to_radians(azimuth));
        [distance * sin, distance * cos]
    }

    /// Direction of true north at a place on the plane \[m\], clockwise from the plane's own north \[rad\]:
    /// subtract it from a heading on the plane to get the true heading.
    pub fn north_rad(&self, place: [f64; 2]) -> f64 {
        // Half a minute of latitude to either side: the chord has the direction of the meridian halfway. At a
        // pole the other side is missing.
        const STEP_DEG: f64 = 0.5 / 60.0;
        let (lon, lat) = self.to_geographic(place);
        let [south, north] =
            [lat - STEP_DEG, lat + STEP_DEG].map(|lat| self.to_plane(lon, lat.clamp(-90.0, 90.0)));
        libm::atan2(north[0] - south[0], north[1] - south[1])
    }

    /// Distance on the plane of two places of longitude and latitude \[m\].
    pub fn distance_m(&self, a: [f64; 2], b: [f64; 2]) -> f64 {
        let (a, b) = (self.to_plane(a[0], a[1]), self.to_plane(b[0], b[1]));
        libm::hypot(a[0] - b[0], a[1] - b[1])
    }

    /// Longitude (within ±180) and latitude \[deg\] of a place on the plane \[m\].
    pub fn to_geographic(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        let azimuth = libm::atan2(x, y).to_degrees();
        let (lat, lon): (f64, f64) =
            self.earth.direct(self.lat_deg, self.lon_deg, azimuth, libm::hypot(x, y));
        // To a micrometre: the geodesic uses the system's sines, whose last bits differ between processors.
        let rounded = |degrees: f64| (degrees * 1e11).round() / 1e11;
        (rounded(lon), rounded(lat))
    }
}

/// Length of the geodesic between two places given as (longitude, latitude) \[deg\], in metres.
pub(crate) fn distance_m(a: (f64, f64), b: (f64, f64)) -> f64 {
    Geodesic::wgs84().inverse(a.1, a.0, b.1, b.0)
}
