//! The charts that `plan.toml` names, read from their files.

use std::path::Path;

use artifact::{Digest, Error, Provenance};
use chart::{Crs, DANGER_M, Grid, GridDeclaration, GridKind, Invalid, Layer, LayerKind, PolygonLayer};

use super::file::{ChartKind, ChartSpec, PlanFile};

/// Property with the least depth of an area, and with the depth over a danger, in electronic charts (S-57).
const LEAST: &str = "DRVAL1";
const OVER: &str = "VALSOU";

/// Reads the charts of `config`, whose files are relative to `config_file`, and notes their digests.
///
/// # Errors
/// No chart at all; files that cannot be read or are no charts of what is said of them.
pub fn read_charts(
    config_file: &Path,
    config: &PlanFile,
    provenance: &mut Provenance,
) -> Result<Vec<Layer>, Error> {
    if config.chart.is_empty() {
        let remedy = "add a [[chart]] with `file` and `kind`";
        return Err(Error::refuse(config_file, "[[chart]]", "none", "at least one chart", remedy));
    }
    let folder = config_file.parent().unwrap_or(Path::new(""));
    config.chart.iter().map(|spec| layer(folder, spec, provenance)).collect()
}

fn layer(folder: &Path, spec: &ChartSpec, provenance: &mut Provenance) -> Result<Layer, Error> {
    let path = folder.join(&spec.file);
    let bytes = std::fs::read(&path).map_err(|e| Error::io(&path, "read", e))?;
    let name = spec.file.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
    provenance.inputs.insert(format!("chart:{name}"), Digest::of_bytes(&bytes));
    let text = String::from_utf8(bytes)
        .map_err(|e| Error::refuse(&path, "file", e.to_string(), "text in UTF-8", "export it again"))?;
    let is_grid = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("asc"));
    let parsed = if is_grid {
        grid(&path, spec, &text)?
    } else {
        let layer = PolygonLayer::from_geojson(&text, &kind(&path, spec)?, spec.only.as_ref());
        layer.map(|layer| Layer::Polygons(layer.with_danger(spec.radius_m.unwrap_or(DANGER_M))))
    };
    parsed.map_err(|e| Error::invalid(&path, e))
}

fn kind(path: &Path, spec: &ChartSpec) -> Result<LayerKind, Error> {
    let wgs84 = |name: &str| ["WGS84", "EPSG:4326"].contains(&name.to_ascii_uppercase().as_str());
    if let Some(crs) = spec.crs.as_deref().filter(|name| !wgs84(name)) {
        let remedy = "leave `crs` out, or transform the file with `ogr2ogr -t_srs EPSG:4326`";
        return Err(Error::refuse(path, "`crs`", crs, "WGS84, as all GeoJSON is (RFC 7946)", remedy));
    }
    match spec.kind {
        ChartKind::Land => Ok(LayerKind::Land),
        ChartKind::NoGo => Ok(LayerKind::NoGo),
        ChartKind::Depth => {
            Ok(LayerKind::Depth { least: spec.least.clone().unwrap_or_else(|| LEAST.to_owned()) })
        }
        ChartKind::Danger => {
            Ok(LayerKind::Danger { least: spec.least.clone().unwrap_or_else(|| OVER.to_owned()) })
        }
        ChartKind::Elevation => Err(Error::refuse(
            path,
            "`kind`",
            "elevation, of polygons",
            "land, no-go, depth or danger",
            "elevations come as a grid (.asc)",
        )),
    }
}

fn grid(path: &Path, spec: &ChartSpec, text: &str) -> Result<Result<Layer, Invalid>, Error> {
    let kind = match spec.kind {
        ChartKind::Land => GridKind::LandMask,
        ChartKind::Depth => GridKind::Depth,
        ChartKind::Elevation => GridKind::Elevation,
        ChartKind::NoGo | ChartKind::Danger => {
            let found =
                format!("{}, of a grid", if spec.kind == ChartKind::NoGo { "no-go" } else { "danger" });
            let expected = "land, depth or elevation";
            return Err(Error::refuse(path, "`kind`", found, expected, "draw it as a polygon"));
        }
    };
    if let Some(radius_m) = spec.radius_m {
        let (found, expected) = (format!("{radius_m} m, of a grid"), "none: it is for points and lines");
        return Err(Error::refuse(path, "`radius_m`", found, expected, "leave it out"));
    }
    let Some(crs) = &spec.crs else {
        let remedy = "add `crs = \"EPSG:…\"` to its [[chart]]";
        return Err(Error::refuse(path, "`crs`", "none", "the system of the grid's coordinates", remedy));
    };
    let declared = Crs::new(crs).map(|crs| GridDeclaration { kind, crs, open_sea: spec.open_sea });
    Ok(declared.and_then(|declared| Grid::from_ascii(text, &declared)).map(Layer::Grid))
}
