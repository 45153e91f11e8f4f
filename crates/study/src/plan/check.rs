//! Checks of numbers and names of `plan.toml` that are well-formed but invalid.

use std::ops::Bound::{self, Excluded, Included};
use std::ops::RangeBounds;

use chart::ring::{RingFault, ring_fault};
use plan::voyage::{AT_REST, Area};
use plan::{Mode, Tolerance};
use refusal::{Invalid, check_name};
use ship::engine::MOST_CURRENT_M_S;

use super::file::{AreaSpec, PlanFile};

/// The valid range of a number.
type Range = (Bound<f64>, Bound<f64>);
/// A number: its key, value, range and unit.
type Number = (&'static str, f64, Range, &'static str);

/// Least tolerance in standard deviations of a sensor: 95 of 100 measurements are closer.
const SEEN: f64 = 2.0;

/// Above 0 up to `most`.
fn above_0_to(most: f64) -> Range {
    (Excluded(0.0), Included(most))
}

/// From 0 up to `most`.
fn from_0_to(most: f64) -> Range {
    (Included(0.0), Included(most))
}

/// Refuses a number outside of its range.
fn check(thing: String, value: f64, range: Range, unit: &str) -> Result<(), Invalid> {
    if value.is_finite() && range.contains(&value) {
        return Ok(());
    }
    let expected = match range {
        (Excluded(least), Included(most)) => format!("a number above {least} to {most} {unit}"),
        (Included(least), Included(most)) => format!("from {least} to {most} {unit}"),
        _ => "another number".to_owned(),
    };
    Err(Invalid::new(thing, value.to_string(), expected, "correct it"))
}

impl PlanFile {
    /// Refuses invalid numbers, and speed modes that cannot be distinguished.
    pub(super) fn check(&self) -> Result<(), Invalid> {
        for (key, value, range, unit) in self.numbers() {
            check(format!("`{key}`"), value, range, unit)?;
        }
        self.changes().check()?;
        self.check_measurement()?;
        self.name.iter().try_for_each(|name| check_name("`name` of the trial", name))?;
        self.check_choices()?;
        for (name, piece_s) in self.maneuver.iter().filter_map(|m| Some((&m.name, m.piece_s?))) {
            check(format!("`piece_s` of maneuver `{name}`"), piece_s, above_0_to(1e7), "s")?;
        }
        for chart in &self.chart {
            let radii = [("radius_m", chart.radius_m), ("doubtful_radius_m", chart.doubtful_radius_m)];
            for (key, radius_m) in radii.iter().filter_map(|(key, value)| Some((key, (*value)?))) {
                let thing = format!("`{key}` of chart `{}`", chart.file.display());
                check(thing, radius_m, above_0_to(1e4), "m")?;
            }
        }
        for (limit, number) in self.speed_limit.iter().zip(1..) {
            limit.name.iter().try_for_each(|name| check_name("`name` of a speed limit", name))?;
            let name = limit.name.as_ref().map_or_else(|| number.to_string(), |name| format!("`{name}`"));
            check_corners(&format!("`corners` of speed limit {name}"), &limit.corners)?;
            let thing = format!("`max_speed_m_s` of speed limit {name}");
            check(thing, limit.max_speed_m_s, above_0_to(1000.0), "m/s")?;
        }
        let draughts = [("air_draught_m", self.hull.air_draught_m), ("draught_m", self.hull.draught_m)];
        for (key, draught_m) in draughts.into_iter().filter_map(|(key, value)| Some((key, value?))) {
            check(format!("`hull.{key}`"), draught_m, above_0_to(200.0), "m")?;
        }
        (0..self.speed_mode.len()).try_for_each(|index| self.check_mode(index))
    }

    fn check_measurement(&self) -> Result<(), Invalid> {
        let Some(measurement) = self.measurement else { return Ok(()) };
        let all = [
            ("std_u_m_s", measurement.std_u_m_s, "m/s"),
            ("std_v_m_s", measurement.std_v_m_s, "m/s"),
            ("std_r_rad_s", measurement.std_r_rad_s, "rad/s"),
        ];
        all.into_iter().try_for_each(|(key, value, unit)| {
            check(format!("`measurement.{key}`"), value, above_0_to(100.0), unit)
        })
    }

    fn numbers(&self) -> [Number; 24] {
        let (hull, safety, approach, sensors) = (self.hull, self.safety, self.approach, self.sensors);
        let [speed, towards] = self.known_current.map_or([0.0; 2], |c| [c.speed_m_s, c.towards_deg]);
        let within = |most: f64| (Included(-most), Included(most));
        [
            ("cell_m", self.cell_m, above_0_to(1e6), "m"),
            ("hull.length_m", hull.length_m, above_0_to(1000.0), "m"),
            ("hull.beam_m", hull.beam_m, above_0_to(1000.0), "m"),
            ("hull.reference_m", hull.reference_m, within(hull.length_m / 2.0), "m, a point of the hull"),
            ("safety.margin_m", safety.margin_m, from_0_to(1e5), "m"),
            ("safety.transit_depth_m", safety.transit_depth_m, from_0_to(12_000.0), "m"),
            ("safety.trial_depth_m", safety.trial_depth_m, from_0_to(12_000.0), "m"),
            ("safety.unknown_current_m_s", safety.unknown_current_m_s, from_0_to(MOST_CURRENT_M_S), "m/s"),
            ("safety.parameter_error", safety.parameter_error, from_0_to(0.99), "(1 is 100 %)"),
            (
                "safety.standard_errors",
                safety.standard_errors.unwrap_or(1.0),
                above_0_to(10.0),
                "standard errors",
            ),
            ("safety.runs", f64::from(safety.runs.unwrap_or(1)), (Included(1.0), Included(1e6)), "runs"),
            (
                "safety.aground_probability",
                safety.aground_probability.unwrap_or(0.5),
                (Included(1e-5), Included(0.5)),
                "",
            ),
            ("approach.run_in_s", approach.run_in_s, from_0_to(1e4), "s"),
            ("approach.tolerance_cells", approach.tolerance_cells, above_0_to(1e3), "cells"),
            ("approach.tolerance_deg", approach.tolerance_deg, above_0_to(360.0), "degrees"),
            ("approach.tolerance_m_s", approach.tolerance_m_s.unwrap_or(1.0), above_0_to(100.0), "m/s"),
            ("approach.tolerance_rad_s", approach.tolerance_rad_s.unwrap_or(1.0), above_0_to(10.0), "rad/s"),
            ("sensors.position_m", sensors.position_m, from_0_to(1e6), "m"),
            ("sensors.heading_deg", sensors.heading_deg, from_0_to(360.0), "degrees"),
            ("sensors.speed_m_s", sensors.speed_m_s, from_0_to(100.0), "m/s"),
            ("sensors.yaw_rate_rad_s", sensors.yaw_rate_rad_s, from_0_to(10.0), "rad/s"),
            ("known_current.speed_m_s", speed, from_0_to(MOST_CURRENT_M_S), "m/s"),
            ("known_current.towards_deg", towards, within(360.0), "degrees"),
            ("informative_s", self.informative_s.unwrap_or(1.0), above_0_to(1e9), "s"),
        ]
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
        if !(speed_m_s.is_finite() && *speed_m_s > 0.0) {
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
