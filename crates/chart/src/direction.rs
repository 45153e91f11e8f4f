//! Whether a file declares its numbers as positive up or down.

use crate::{GridKind, Invalid};

/// Which way numbers grow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Heights.
    Up,
    /// Depths.
    Down,
}

impl Direction {
    /// Refuses numbers whose attributes `positive` and `standard_name` contradict `kind`.
    ///
    /// # Errors
    /// Names the attribute.
    pub fn check(kind: GridKind, positive: Option<&str>, name: Option<&str>) -> Result<(), Invalid> {
        let (own, declared, other) = match kind {
            GridKind::LandMask => return Ok(()),
            GridKind::Depth => (Self::Down, "depth", "elevation"),
            GridKind::Elevation => (Self::Up, "elevation", "depth"),
        };
        let refuse = |thing: &str, found: &str, expected: &str| {
            let found = format!("`{}`, of a grid declared as `{declared}`", refusal::foreign(found));
            let remedy = format!("declare it as `{other}`, or correct the file");
            Err(Invalid::new(thing, found, expected, remedy))
        };
        if let Some(text) = positive.map(str::trim).filter(|text| !text.is_empty()) {
            match text.to_ascii_lowercase().as_str() {
                "up" if own == Self::Up => {}
                "down" if own == Self::Down => {}
                _ => return refuse("`positive`", text, "`up` of elevations, `down` of depths"),
            }
        }
        match name.and_then(|name| Some((name, Self::named(name)?))) {
            Some((name, direction)) if direction != own => {
                refuse("`standard_name`", name, "the name of what is declared")
            }
            _ => Ok(()),
        }
    }

    /// By the standard names of CF.
    fn named(name: &str) -> Option<Self> {
        let name = name.trim().to_ascii_lowercase();
        if name == "depth" || name.starts_with("depth_below") || name.starts_with("sea_floor_depth_below") {
            return Some(Self::Down);
        }
        let heights = ["height", "altitude", "surface_altitude", "bedrock_altitude", "ground_level_altitude"];
        let above = ["height_above_mean_sea_level", "height_above_geo", "height_above_reference_ellipsoid"];
        let is_height = heights.contains(&name.as_str()) || above.iter().any(|own| name.starts_with(own));
        is_height.then_some(Self::Up)
    }
}
