//! Areas of `plan.toml`: boxes, and polygons by their corners.

use chart::ring::{RingFault, ring_fault};
use plan::voyage::Area;
use refusal::Invalid;

use super::file::AreaSpec;

const CORNERS: &str = "corners = [[longitude, latitude], ...], three or more in degrees";

impl AreaSpec {
    /// The area of the keys.
    ///
    /// # Errors
    /// Neither a box nor a polygon, or both; an invalid one.
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
            let found = format!("{west_deg} to {east_deg} E, {south_deg} to {north_deg} N");
            let expected = "west below east (or across 180°), south below north, in degrees";
            return refuse(found, expected, "correct it");
        }
        Ok(Area { west_deg, south_deg, east_deg, north_deg, corners: Vec::new() })
    }
}

/// Refuses corners, called `thing`, that are not a valid polygon.
pub(super) fn check_corners(thing: &str, corners: &[[f64; 2]]) -> Result<(), Invalid> {
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
