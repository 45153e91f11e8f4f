//! Checks of numbers and names of `plan.toml` that are well-formed but invalid.

use chart::ring::{RingFault, ring_fault};
use plan::voyage::{AT_REST, Area};
use plan::{Mode, Tolerance};
use refusal::{Invalid, check_bounds, check_name};

use super::file::{AreaSpec, PlanFile};

/// Least tolerance in standard deviations of a sensor: 95 of 100 measurements are closer.
const SEEN: f64 = 2.0;

impl PlanFile {
    /// Refuses invalid numbers, and speed modes that cannot be distinguished.
    pub(super) fn check(&self) -> Result<(), Invalid> {
        check_bounds(self)?;
        let (reference_m, half) = (self.hull.reference_m, self.hull.length_m / 2.0);
        if reference_m.abs() > half {
            let expected = format!("-{half} to {half} m, a point of the hull");
            return Err(Invalid::new("`hull.reference_m`", reference_m.to_string(), expected, "correct it"));
        }
        let stds = self.measurement.map_or([1.0; 3], |m| [m.std_u_m_s, m.std_v_m_s, m.std_r_rad_s]);
        if let Some(exact) = stds.iter().position(|std| *std == 0.0) {
            let thing = format!("`measurement.std_{}_s`", ["u_m", "v_m", "r_rad"][exact]);
            return Err(Invalid::new(thing, "0", "a sensor with noise, above 0", "correct it"));
        }
        self.name.iter().try_for_each(|name| check_name("`name` of the trial", name))?;
        self.check_choices()?;
        for (limit, number) in self.speed_limit.iter().zip(1..) {
            limit.name.iter().try_for_each(|name| check_name("`name` of a speed limit", name))?;
            let name = limit.name.as_ref().map_or_else(|| number.to_string(), |name| format!("`{name}`"));
            check_corners(&format!("`corners` of speed limit {name}"), &limit.corners)?;
        }
        (0..self.speed_mode.len()).try_for_each(|index| self.check_mode(index))
    }

    /// Refuses tolerances that the ship's sensors cannot verify, such as one that follows from the handling.
    pub(super) fn check_sensors(&self, tolerance: &Tolerance) -> Result<(), Invalid> {
        let sensors = self.sensors;
        for (key, tolerance, sensor, deviation, unit) in [
            ("tolerance_cells", tolerance.distance_m, "position_m", sensors.position_m, "m"),
            (
                "tolerance_deg",
                tolerance.heading_rad.to_degrees(),
                "heading_deg",
                sensors.heading_deg,
                "degrees",
            ),
            ("tolerance_m_s", tolerance.surge_m_s, "speed_m_s", sensors.speed_m_s, "m/s"),
            ("tolerance_rad_s", tolerance.yaw_rate_rad_s, "yaw_rate_rad_s", sensors.yaw_rate_rad_s, "rad/s"),
        ] {
            let least = SEEN * deviation;
            // Angles are converted from radians.
            if tolerance < least * (1.0 - 1e-12) {
                return Err(Invalid::new(
                    format!("`approach.{key}`"),
                    format!("{tolerance} {unit}"),
                    format!("at least {least} {unit}, {SEEN} standard deviations of `sensors.{sensor}`"),
                    "raise the tolerance, or measure better",
                ));
            }
        }
        Ok(())
    }

    fn check_choices(&self) -> Result<(), Invalid> {
        let refuse = |key: &str, found: String, expected: &str| {
            Err(Invalid::new(format!("`{key}`"), found, expected, "correct it"))
        };
        if ![4, 8, 16].contains(&self.headings) {
            return refuse("headings", self.headings.to_string(), "4, 8 or 16");
        }
        if self.raster_per_cell == 0 || self.raster_per_cell % 2 == 1 || self.raster_per_cell > 64 {
            return refuse(
                "raster_per_cell",
                self.raster_per_cell.to_string(),
                "an even number from 2 to 64",
            );
        }
        if let (Some(errors), true) = (self.safety.standard_errors, self.safety.parameter_error > 0.0) {
            let given = format!("{errors} besides `parameter_error` {}", self.safety.parameter_error);
            return refuse("safety.standard_errors", given, "one of both");
        }
        if let (Some(least_m), None) = (self.safety.under_keel_m, self.hull.draught_m) {
            let given = format!("{least_m} without `hull.draught_m`");
            return refuse("safety.under_keel_m", given, "the ship's draught, too");
        }
        if self.safety.trial_depth_m < self.safety.transit_depth_m {
            return Err(Invalid::new(
                "`safety.trial_depth_m`",
                self.safety.trial_depth_m.to_string(),
                format!("at least the transit depth, {}", self.safety.transit_depth_m),
                "informative maneuvers need the deeper water",
            ));
        }
        Ok(())
    }

    fn check_mode(&self, index: usize) -> Result<(), Invalid> {
        let (mode, earlier) = (&self.speed_mode[index], &self.speed_mode[..index]);
        let refuse = |found: String, expected: &str, remedy: &str| {
            Err(Invalid::new(format!("speed mode `{}`", mode.name), found, expected, remedy))
        };
        let Mode { name, speed_m_s } = mode;
        check_name("`name` of a speed mode", name)?;
        if *speed_m_s <= 0.0 {
            let remedy = "being at rest is always there where the vessel can hold it: leave it out";
            return refuse(format!("{speed_m_s} m/s"), "a speed above 0 m/s", remedy);
        }
        let remedy = "correct it or leave it out";
        if name == AT_REST {
            return refuse("the name of being at rest".to_owned(), "another name", remedy);
        }
        if *speed_m_s > 50.0 {
            return refuse(format!("{speed_m_s} m/s"), "at most 50 m/s", remedy);
        }
        if earlier.iter().any(|m| m.name == *name) {
            return refuse("the name twice".to_owned(), "every name once", remedy);
        }
        match earlier.iter().find(|m| m.speed_m_s == *speed_m_s) {
            None => Ok(()),
            Some(other) => {
                let given = format!("{speed_m_s} m/s, the speed of mode `{}`", other.name);
                refuse(given, "every speed once", remedy)
            }
        }
    }
}

// Areas of `plan.toml`: boxes, and polygons by their corners.

const CORNERS: &str = "corners = [[longitude, latitude], ...], three or more in degrees";

impl AreaSpec {
    /// The area of the keys.
    pub(super) fn area(&self) -> Result<Area, Invalid> {
        let edges = [
            ("west_deg", self.west_deg),
            ("south_deg", self.south_deg),
            ("east_deg", self.east_deg),
            ("north_deg", self.north_deg),
        ];
        let refuse = |found: String, expected: &str, remedy: &str| {
            Err(Invalid::new("`area`", found, expected, remedy))
        };
        if let Some(corners) = &self.corners {
            if let Some((key, _)) = edges.iter().find(|(_, edge)| edge.is_some()) {
                let expected = "the polygon's corners, or the four edges of a box";
                return refuse(format!("both `corners` and `{key}`"), expected, "leave one of them out");
            }
            check_corners("`area.corners`", corners)?;
            return Ok(around(corners));
        }
        if let Some((key, _)) = edges.iter().find(|(_, edge)| edge.is_none()) {
            let expected = "west_deg, south_deg, east_deg and north_deg, or corners";
            return refuse(format!("no `{key}`"), expected, &format!("add it, or {CORNERS}"));
        }
        let [west_deg, south_deg, east_deg, north_deg] = edges.map(|(_, edge)| edge.unwrap_or(f64::NAN));
        let on_earth = [west_deg, east_deg].iter().all(|lon| lon.abs() <= 180.0)
            && [south_deg, north_deg].iter().all(|lat| lat.abs() <= 90.0);
        // West of an area across the antimeridian is the greater longitude; 180° is both.
        let ordered = south_deg < north_deg && (west_deg < east_deg || west_deg - east_deg > 180.0);
        if !(on_earth && ordered) {
            let given = format!("{west_deg} to {east_deg} E, {south_deg} to {north_deg} N");
            let expected = "west below east (or across 180°), south below north, in degrees";
            return refuse(given, expected, "correct it");
        }
        Ok(Area { west_deg, south_deg, east_deg, north_deg, corners: Vec::new() })
    }
}

/// Refuses corners, called `thing`, that are not a valid polygon.
fn check_corners(thing: &str, corners: &[[f64; 2]]) -> Result<(), Invalid> {
    let refuse =
        |found: String, expected: &str, remedy: &str| Err(Invalid::new(thing, found, expected, remedy));
    if corners.len() < 3 {
        return refuse(format!("{} corners", corners.len()), "at least three", &format!("write {CORNERS}"));
    }
    let on_earth = |[lon, lat]: &[f64; 2]| lon.abs() <= 180.0 && lat.abs() <= 90.0;
    if let Some([lon, lat]) = corners.iter().find(|corner| !on_earth(corner)) {
        let expected = "longitude within ±180 and latitude within ±90 degrees, longitude first";
        return refuse(format!("the corner [{lon}, {lat}]"), expected, "correct it");
    }
    let flat = beyond_180(corners);
    let [[west, east], _] = span(&flat);
    if east - west > 180.0 {
        let expected = "at most 180 degrees";
        return refuse(
            format!("corners over {} degrees of longitude", east - west),
            expected,
            "correct them",
        );
    }
    let ring: Vec<[f64; 2]> = flat.iter().chain(flat.first()).copied().collect();
    let corner = |edge: usize| format!("corner {}", edge + 1);
    match ring_fault(&[ring]) {
        None => Ok(()),
        Some(RingFault::Crossing { one, other, .. }) => refuse(
            format!("the edges after {} and {} cross", corner(one.1), corner(other.1)),
            "a polygon that does not cross itself",
            "list the corners in their order along its edge",
        ),
        Some(_) => refuse("corners on one line".to_owned(), "a polygon with an area", "correct them"),
    }
}

/// Corners with longitudes beyond 180° if they are across the antimeridian.
fn beyond_180(corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let [[west, east], _] = span(corners);
    let turned =
        |[lon, lat]: [f64; 2]| [if east - west > 180.0 && lon < 0.0 { lon + 360.0 } else { lon }, lat];
    corners.iter().copied().map(turned).collect()
}

/// Least and greatest longitude, and latitude.
fn span(corners: &[[f64; 2]]) -> [[f64; 2]; 2] {
    [0, 1].map(|k: usize| {
        let of = corners.iter().map(|corner| corner[k]);
        [of.clone().fold(f64::INFINITY, f64::min), of.fold(f64::NEG_INFINITY, f64::max)]
    })
}

/// The polygon and its bounding box.
fn around(corners: &[[f64; 2]]) -> Area {
    let [[west_deg, east_deg], [south_deg, north_deg]] = span(&beyond_180(corners));
    let east_deg = if east_deg > 180.0 { east_deg - 360.0 } else { east_deg };
    Area { west_deg, south_deg, east_deg, north_deg, corners: corners.to_vec() }
}
