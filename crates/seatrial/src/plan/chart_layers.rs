//! The charts of `plan.toml`, read from their files.

use std::path::Path;

use artifact::{Digest, Provenance};
use chart::{Crs, Grid, GridDeclaration, GridKind, Invalid, Layer, LayerKind, PolygonLayer};

use super::config::{ChartKind, ChartSpec, PlanFile};
use crate::failure::Failure;

/// What is invalid in `file`.
pub(super) fn invalid(file: &Path, invalid: &Invalid) -> Failure {
    Failure::refuse(file, &invalid.thing, &invalid.found, &invalid.expected, &invalid.remedy)
}

/// Reads every chart; files are relative to `config_file`.
pub(super) fn layers(
    config_file: &Path,
    config: &PlanFile,
    provenance: &mut Provenance,
) -> Result<Vec<Layer>, Failure> {
    if config.chart.is_empty() {
        let remedy = "add a [[chart]] with `file` and `kind`";
        return Err(Failure::refuse(config_file, "[[chart]]", "none", "at least one chart", remedy));
    }
    let folder = config_file.parent().unwrap_or(Path::new(""));
    config.chart.iter().map(|spec| layer(folder, spec, provenance)).collect()
}

fn layer(folder: &Path, spec: &ChartSpec, provenance: &mut Provenance) -> Result<Layer, Failure> {
    let path = folder.join(&spec.file);
    let bytes = std::fs::read(&path).map_err(|e| artifact::Error::io(&path, "read", e))?;
    let name = spec.file.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
    provenance.inputs.insert(format!("chart:{name}"), Digest::of_bytes(&bytes));
    let text = String::from_utf8(bytes)
        .map_err(|e| Failure::refuse(&path, "file", &e.to_string(), "text in UTF-8", "export it again"))?;
    let is_grid = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("asc"));
    let parsed = if is_grid {
        grid(&path, spec, &text)?
    } else {
        PolygonLayer::from_geojson(&text, &kind(&path, spec)?, spec.only.as_ref()).map(Layer::Polygons)
    };
    parsed.map_err(|e| invalid(&path, &e))
}

fn kind(path: &Path, spec: &ChartSpec) -> Result<LayerKind, Failure> {
    let wgs84 = |name: &str| ["WGS84", "EPSG:4326"].contains(&name.to_ascii_uppercase().as_str());
    if let Some(crs) = spec.crs.as_deref().filter(|name| !wgs84(name)) {
        let remedy = "leave `crs` out, or transform the file with `ogr2ogr -t_srs EPSG:4326`";
        return Err(Failure::refuse(path, "`crs`", crs, "WGS84, as all GeoJSON is (RFC 7946)", remedy));
    }
    match spec.kind {
        ChartKind::Land => Ok(LayerKind::Land),
        ChartKind::NoGo => Ok(LayerKind::NoGo),
        ChartKind::Depth => {
            Ok(LayerKind::Depth { least: spec.least.clone(), greatest: Some(spec.greatest.clone()) })
        }
        ChartKind::Elevation => Err(Failure::refuse(
            path,
            "`kind`",
            "elevation, of polygons",
            "land, no-go or depth",
            "elevations come as a grid (.asc)",
        )),
    }
}

fn grid(path: &Path, spec: &ChartSpec, text: &str) -> Result<Result<Layer, Invalid>, Failure> {
    let kind = match spec.kind {
        ChartKind::Land => GridKind::LandMask,
        ChartKind::Depth => GridKind::Depth,
        ChartKind::Elevation => GridKind::Elevation,
        ChartKind::NoGo => {
            let expected = "land, depth or elevation";
            return Err(Failure::refuse(
                path,
                "`kind`",
                "no-go, of a grid",
                expected,
                "draw it as a polygon",
            ));
        }
    };
    let Some(crs) = &spec.crs else {
        let remedy = "add `crs = \"EPSG:…\"` to its [[chart]]";
        return Err(Failure::refuse(path, "`crs`", "none", "the system of the grid's coordinates", remedy));
    };
    let declared = Crs::new(crs).map(|crs| GridDeclaration { kind, crs, open_sea: spec.open_sea });
    Ok(declared.and_then(|declared| Grid::from_ascii(text, &declared)).map(Layer::Grid))
}
