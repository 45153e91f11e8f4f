//! The charts that `plan.toml` names, read from their files.

use std::collections::BTreeMap;
use std::path::Path;

use artifact::{Budget, Error, PROGRAM_BYTES, Provenance, Work};
use chart::{
    Crs, DANGER_M, Grid, GridDeclaration, GridKind, Invalid, Layer, LayerKind, PolygonLayer, Rules,
    objects_of_geojson,
};

use super::cells::{PER_BYTE, Reading, cells_of, of_objects};
use super::chart_file::bytes;
use super::exchange_set::existing;
use super::file::{ChartKind, ChartSpec, PlanFile};
use crate::documents::PlanChart;

/// Property with the least depth of an area, and with the depth over a danger, in electronic charts (S-57).
const LEAST: &str = "DRVAL1";
const OVER: &str = "VALSOU";

/// Charts as they were read.
pub struct Charts {
    /// What they show.
    pub layers: Vec<Layer>,
    /// What became of the objects of electronic charts.
    pub objects: Vec<PlanChart>,
    /// Memory that it took to read them \[bytes\].
    pub bytes: u64,
}

/// Reads the charts of `config`, whose files are relative to `config_file`, and notes their digests.
///
/// # Errors
/// No chart at all; files that cannot be read, do not fit in the memory of `budget` or are no charts of what is said of them.
pub fn read_charts(
    config_file: &Path,
    config: &PlanFile,
    budget: &Budget,
    provenance: &mut Provenance,
) -> Result<Charts, Error> {
    if config.chart.is_empty() {
        let remedy = "add a [[chart]] with `file` and `kind`";
        return Err(Error::refuse(config_file, "[[chart]]", "none", "at least one chart", remedy));
    }
    let folder = config_file.parent().unwrap_or(Path::new(""));
    let mut charts = Charts { layers: Vec::new(), objects: Vec::new(), bytes: 0 };
    let mut sets = BTreeMap::new();
    for spec in &config.chart {
        let rules = Rules {
            changed: spec.rules.clone(),
            air_draught_m: config.hull.air_draught_m,
            radius_m: spec.radius_m,
            doubtful_radius_m: spec.doubtful_radius_m,
        };
        let path = existing(folder.join(&spec.file));
        if let Some(cells) = cells_of(&path)? {
            spec.check_keys(&path, true)?;
            let mut reading = Reading { budget, provenance, bytes: charts.bytes, sets };
            for cell in cells {
                let (layer, told) = reading.cell(&cell, &rules)?;
                charts.layers.push(Layer::Polygons(layer));
                charts.objects.push(told);
            }
            (charts.bytes, sets) = (reading.bytes, reading.sets);
            continue;
        }
        if GridFormat::of(&path).is_none() {
            let length = std::fs::metadata(&path).map_or(0, |about| about.len());
            charts.bytes += PER_BYTE * length;
            let (found, remedy) =
                (format!("{length} bytes"), "raise --memory-mib, or cut the chart to the area");
            let work = Work { file: &path, thing: "file", found: &found, remedy };
            budget.memory(work, (PROGRAM_BYTES + charts.bytes) as f64)?;
        }
        charts.read(&path, spec, &rules, provenance)?;
    }
    Ok(charts)
}

impl Charts {
    fn read(
        &mut self,
        path: &Path,
        spec: &ChartSpec,
        rules: &Rules,
        provenance: &mut Provenance,
    ) -> Result<(), Error> {
        spec.check_keys(path, false)?;
        if let Some(format) = GridFormat::of(path) {
            let declared = declared(path, spec)?;
            let grid = format.read(bytes(path, provenance)?, &declared);
            self.layers.push(Layer::Grid(grid.map_err(|e| Error::invalid(path, e))?));
            return Ok(());
        }
        let text = String::from_utf8(bytes(path, provenance)?)
            .map_err(|e| Error::refuse(path, "file", e.to_string(), "text in UTF-8", "export it again"))?;
        if spec.kind == Some(ChartKind::Objects) {
            let objects = objects_of_geojson(&text).map_err(|e| Error::invalid(path, e))?;
            let (layer, told) = of_objects(path, &objects, None, rules)?;
            self.layers.push(Layer::Polygons(layer));
            self.objects.push(told);
            return Ok(());
        }
        self.layers.push(polygons(path, spec, &text)?.map_err(|e| Error::invalid(path, e))?);
        Ok(())
    }
}

impl ChartSpec {
    /// Refuses keys that say nothing about such a file, be it a cell or another.
    fn check_keys(&self, path: &Path, is_cell: bool) -> Result<(), Error> {
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
        if self.variable.is_some() && !matches!(GridFormat::of(path), Some(GridFormat::NetCdf)) {
            return refuse(
                "`variable`",
                "one of a file without variables",
                "a NetCDF file (.nc)",
                "leave it out",
            );
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
}

fn polygons(path: &Path, spec: &ChartSpec, text: &str) -> Result<Result<Layer, Invalid>, Error> {
    let layer = PolygonLayer::from_geojson(text, &kind(path, spec)?, spec.only.as_ref());
    let radius_m = spec.radius_m.unwrap_or(DANGER_M);
    let open_sea = spec.open_sea;
    Ok(layer.map(|layer| Layer::Polygons(PolygonLayer { open_sea, ..layer.with_danger(radius_m) })))
}

fn kind(path: &Path, spec: &ChartSpec) -> Result<LayerKind, Error> {
    let wgs84 = |name: &str| ["WGS84", "EPSG:4326"].contains(&name.to_ascii_uppercase().as_str());
    if let Some(crs) = spec.crs.as_deref().filter(|name| !wgs84(name)) {
        let remedy = "leave `crs` out, or transform the file with `ogr2ogr -t_srs EPSG:4326`";
        return Err(Error::refuse(path, "`crs`", crs, "WGS84, as all GeoJSON is (RFC 7946)", remedy));
    }
    let named = |usual: &str| spec.least.clone().unwrap_or_else(|| usual.to_owned());
    match spec.kind {
        Some(ChartKind::Land) => Ok(LayerKind::Land),
        Some(ChartKind::NoGo) => Ok(LayerKind::NoGo),
        Some(ChartKind::Depth) => Ok(LayerKind::Depth { least: named(LEAST) }),
        Some(ChartKind::Danger) => Ok(LayerKind::Danger { least: named(OVER) }),
        _ => Err(Error::refuse(
            path,
            "`kind`",
            "elevation, of polygons",
            "land, no-go, depth, danger or objects",
            "elevations come as a grid (.asc, .tif, .nc)",
        )),
    }
}

/// How a grid is written.
#[derive(Clone, Copy)]
enum GridFormat {
    Ascii,
    Tiff,
    NetCdf,
}

impl GridFormat {
    /// By the file's extension; `None` of no grid.
    fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "asc" => Some(Self::Ascii),
            "tif" | "tiff" => Some(Self::Tiff),
            "nc" => Some(Self::NetCdf),
            _ => None,
        }
    }

    fn read(self, bytes: Vec<u8>, declared: &GridDeclaration) -> Result<Grid, Invalid> {
        match self {
            Self::Ascii => {
                let text = String::from_utf8(bytes)
                    .map_err(|e| Invalid::new("file", e.to_string(), "text in UTF-8", "export it again"))?;
                Grid::from_ascii(&text, declared)
            }
            Self::Tiff => Grid::from_tiff(&bytes, declared),
            Self::NetCdf => Grid::from_netcdf(bytes, declared),
        }
    }
}

/// What `spec` says of a grid.
fn declared(path: &Path, spec: &ChartSpec) -> Result<GridDeclaration, Error> {
    let kind = match spec.kind {
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
    if let Some(radius_m) = spec.radius_m {
        let (found, expected) = (format!("{radius_m} m, of a grid"), "none: it is for points and lines");
        return Err(Error::refuse(path, "`radius_m`", found, expected, "leave it out"));
    }
    let crs = spec.crs.as_deref().map(Crs::new).transpose().map_err(|e| Error::invalid(path, e))?;
    Ok(GridDeclaration { kind, crs, variable: spec.variable.clone(), open_sea: spec.open_sea })
}
