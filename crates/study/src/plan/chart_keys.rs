//! The keys of a `[[chart]]`, and which of them apply to its file.

use std::path::Path;

use chart::{Crs, GridDeclaration, GridKind, LayerKind};
use files::Error;

use super::file::{ChartKind, ChartSpec};

/// Property with the least depth of an area, and with the depth over a danger, in electronic charts (S-57).
const LEAST: &str = "DRVAL1";
const OVER: &str = "VALSOU";

impl ChartSpec {
    /// Refuses keys that do not apply to such a file.
    pub(super) fn check_keys(&self, path: &Path, is_cell: bool) -> Result<(), Error> {
        let objects = is_cell || self.kind == Some(ChartKind::Objects);
        let refuse = |thing: &str, found: &str, expected: &str, remedy: &str| {
            Err(Error::refuse(path, thing, found, expected, remedy))
        };
        if is_cell && self.kind.is_some_and(|kind| kind != ChartKind::Objects) {
            let expected = "none, or `objects`: a cell shows objects of many classes";
            return refuse(
                "`kind`",
                "another kind, of a cell",
                expected,
                "leave it out, and say in `rules` what differs",
            );
        }
        if objects && (self.least.is_some() || self.only.is_some() || self.crs.is_some()) {
            let expected = "`rules`, `radius_m`, `doubtful_radius_m` only";
            return refuse("[[chart]]", "`least`, `only` or `crs`, of objects", expected, "leave them out");
        }
        if !objects && (!self.rules.is_empty() || self.doubtful_radius_m.is_some()) {
            let expected = "a cell (`.000`), or `kind = \"objects\"`";
            return refuse("[[chart]]", "`rules` or `doubtful_radius_m`", expected, "leave them out");
        }
        let measures =
            [ChartKind::Depth, ChartKind::Elevation, ChartKind::Danger].map(Some).contains(&self.kind);
        if let Some(unit) = self.depth_unit.filter(|_| !measures) {
            let found = format!("`{}`, of a chart without depths of its own unit", unit.name());
            let expected = "`kind` of depth, elevation or danger; objects say their unit themselves";
            return refuse("`depth_unit`", &found, expected, "leave it out");
        }
        if !objects && self.kind.is_none() {
            let expected = "land, no-go, depth, danger, elevation or objects";
            return refuse(
                "`kind`",
                "none",
                expected,
                "say what the file shows; cells (`.000`) need no kind",
            );
        }
        Ok(())
    }

    /// The kind of the polygons of a file.
    pub(super) fn layer_kind(&self, path: &Path) -> Result<LayerKind, Error> {
        let is_near = |name: &&str| Crs::new(name).is_ok_and(|crs| crs.is_near_wgs84());
        if let Some(crs) = self.crs.as_deref().filter(|name| !is_near(name)) {
            let remedy = "leave `crs` out, or transform the file with `ogr2ogr -t_srs EPSG:4326`";
            let expected = "WGS84, as all GeoJSON is (RFC 7946), or degrees within a metre or two of it";
            return Err(Error::refuse(path, "`crs`", crs, expected, remedy));
        }
        let named = |usual: &str| self.least.clone().unwrap_or_else(|| usual.to_owned());
        match self.kind {
            Some(ChartKind::Land) => Ok(LayerKind::Land),
            Some(ChartKind::NoGo) => Ok(LayerKind::NoGo),
            Some(ChartKind::Depth) => Ok(LayerKind::Depth { least: named(LEAST) }),
            Some(ChartKind::Danger) => Ok(LayerKind::Danger { least: named(OVER) }),
            _ => Err(Error::refuse(
                path,
                "`kind`",
                "elevation, of polygons",
                "land, no-go, depth, danger or objects",
                "elevations come as a grid (.asc, .tif)",
            )),
        }
    }

    /// The declaration of a grid.
    pub(super) fn grid(&self, path: &Path) -> Result<GridDeclaration, Error> {
        let kind = match self.kind {
            Some(ChartKind::Land) => GridKind::LandMask,
            Some(ChartKind::Depth) => GridKind::Depth,
            Some(ChartKind::Elevation) => GridKind::Elevation,
            other => {
                let found =
                    format!("{}, of a grid", if other == Some(ChartKind::NoGo) { "no-go" } else { "danger" });
                let expected = "land, depth or elevation";
                return Err(Error::refuse(path, "`kind`", found, expected, "draw it as a polygon"));
            }
        };
        if let Some(radius_m) = self.radius_m {
            let (found, expected) = (format!("{radius_m} m, of a grid"), "none: it is for points and lines");
            return Err(Error::refuse(path, "`radius_m`", found, expected, "leave it out"));
        }
        let crs = self.crs.as_deref().map(Crs::new).transpose().map_err(|e| Error::invalid(path, e))?;
        Ok(GridDeclaration { kind, crs, unit: self.depth_unit, open_sea: self.open_sea })
    }
}
