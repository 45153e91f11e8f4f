//! The charts that `plan.toml` names, read from their files.

use std::collections::BTreeMap;
use std::path::Path;

use chart::{
    Bounds, DANGER_M, DepthUnit, Layer, LayerKind, Measured, Plane, PolygonLayer, Reading, Rules, UnitFrom,
    Unread, read_objects,
};
use files::{Budget, Error, PROGRAM_BYTES, Provenance, Work};

use super::cells::{CellReader, PER_BYTE, cells_of, of_objects};
use super::chart_file::bytes;
use super::chart_grids::{GridFormat, refuse_netcdf};
use super::chart_text::chart_text;
use super::exchange_set::existing;
use super::file::{ChartKind, ChartSpec, PlanFile};
use crate::documents::PlanChart;

/// Charts as they were read.
pub struct Charts {
    /// Their layers.
    pub layers: Vec<Layer>,
    /// The treatment of the objects of electronic charts, and the units of depths.
    pub summaries: Vec<PlanChart>,
    /// Memory for reading them, without their grids \[bytes\].
    pub bytes: u64,
    /// Memory of their grids \[bytes\].
    grid_bytes: u64,
}

/// The limits of reading charts, and the area of interest.
#[derive(Clone, Copy)]
pub struct Means<'a> {
    /// The area, on its plane.
    pub area: (&'a Plane, &'a Bounds),
    /// The memory.
    pub budget: &'a Budget,
    /// Returns false when the time limit is reached.
    pub keep_going: &'a (dyn Fn() -> bool + Sync),
}

/// Why charts were not read.
#[derive(Debug)]
pub enum ChartsError {
    /// A file is refused, or cannot be read.
    Refused(Error),
    /// The time limit was reached.
    OutOfTime,
}

impl From<Error> for ChartsError {
    fn from(error: Error) -> Self {
        Self::Refused(error)
    }
}

/// The remedy for too little memory.
const LESS: &str = "raise --memory-mib, or cut the chart to the area";

/// Reads the charts of `config`, whose files are relative to `config_file`, and notes their digests.
///
/// # Errors
/// No chart; files that cannot be read, do not fit in memory, or do not match their keys; the time limit.
pub fn read_charts(
    config_file: &Path,
    config: &PlanFile,
    means: &Means,
    provenance: &mut Provenance,
) -> Result<Charts, ChartsError> {
    if config.chart.is_empty() {
        let remedy = "add a [[chart]] with `file` and `kind`";
        return Err(Error::refuse(config_file, "[[chart]]", "none", "at least one chart", remedy).into());
    }
    let folder = config_file.parent().unwrap_or(Path::new(""));
    let mut charts = Charts { layers: Vec::new(), summaries: Vec::new(), bytes: 0, grid_bytes: 0 };
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
            let bytes = charts.bytes + charts.grid_bytes;
            let named = path.canonicalize().ok().filter(|named| named.is_dir());
            let mut reader = CellReader { budget: means.budget, provenance, bytes, sets, named };
            for cell in cells {
                if !(means.keep_going)() {
                    return Err(ChartsError::OutOfTime);
                }
                let (layer, summary) = reader.cell(&cell, &rules)?;
                charts.layers.push(Layer::Polygons(layer));
                charts.summaries.push(summary);
            }
            (charts.bytes, sets) = (reader.bytes - charts.grid_bytes, reader.sets);
            continue;
        }
        charts.check_file(&path, means)?;
        charts.read(&path, spec, &rules, means, provenance)?;
    }
    Ok(charts)
}

impl Charts {
    /// Counts the memory for reading a file of polygons or objects.
    fn check_file(&mut self, path: &Path, means: &Means) -> Result<(), ChartsError> {
        if !(means.keep_going)() {
            return Err(ChartsError::OutOfTime);
        }
        refuse_netcdf(path)?;
        if GridFormat::of(path).is_none() {
            let length = std::fs::metadata(path).map_or(0, |about| about.len());
            self.bytes += PER_BYTE * length;
            let found = format!("{length} bytes");
            let work = Work { file: path, thing: "file", found: &found, remedy: LESS };
            means.budget.memory(work, self.taken())?;
        }
        Ok(())
    }

    /// Bytes so far, including those of the program.
    fn taken(&self) -> f64 {
        (PROGRAM_BYTES + self.bytes + self.grid_bytes) as f64
    }

    fn read(
        &mut self,
        path: &Path,
        spec: &ChartSpec,
        rules: &Rules,
        means: &Means,
        provenance: &mut Provenance,
    ) -> Result<(), ChartsError> {
        spec.check_keys(path, false)?;
        let area = Some(means.area);
        let reading =
            Reading { area, bytes: means.budget.bytes() - self.taken(), keep_going: means.keep_going };
        if let Some(format) = GridFormat::of(path) {
            let grid = format.read(path, &spec.grid(path)?, &reading, provenance)?;
            let grid = grid.map_err(|e| self.unread(path, e, means))?;
            self.grid_bytes += grid.bytes();
            self.summaries
                .extend(grid.measured.as_ref().map(|measured| PlanChart::measured(name(path), measured)));
            self.layers.push(Layer::Grid(grid));
            return Ok(());
        }
        let text = chart_text(bytes(path, provenance)?).map_err(|e| Error::invalid(path, e))?;
        if spec.kind == Some(ChartKind::Objects) {
            let objects = read_objects(&text, &reading).map_err(|e| self.unread(path, e, means))?;
            let (layer, summary) = of_objects(path, &objects, None, rules)?;
            self.layers.push(Layer::Polygons(layer));
            self.summaries.push(summary);
            return Ok(());
        }
        let kind = spec.layer_kind(path)?;
        let (unit, unit_from) = match spec.depth_unit {
            Some(unit) => (unit, UnitFrom::Declared),
            None => (DepthUnit::Metre, UnitFrom::Assumed),
        };
        let layer = PolygonLayer::read(&text, (&kind, unit), spec.only.as_ref(), &reading);
        let layer = layer.map_err(|e| self.unread(path, e, means))?;
        let radius_m = spec.radius_m.unwrap_or(DANGER_M);
        let layer = PolygonLayer { open_sea: spec.open_sea, ..layer.with_danger(radius_m) };
        if matches!(kind, LayerKind::Depth { .. } | LayerKind::Danger { .. }) {
            self.summaries.push(PlanChart::measured(name(path), &Measured::plainly(unit, unit_from)));
        }
        self.layers.push(Layer::Polygons(layer));
        Ok(())
    }

    /// The error of an unread chart, by its name.
    fn unread(&self, path: &Path, unread: Unread, means: &Means) -> ChartsError {
        match unread {
            Unread::Invalid(invalid) => Error::invalid(path, invalid).into(),
            Unread::OutOfTime => ChartsError::OutOfTime,
            Unread::TooLarge { found, bytes } => {
                let work = Work { file: path, thing: "grid", found: &found, remedy: LESS };
                let refused = means.budget.memory(work, self.taken() + bytes).err();
                let invalid = || Error::refuse(path, "grid", found.as_str(), "less of it", LESS);
                refused.unwrap_or_else(invalid).into()
            }
        }
    }
}

fn name(path: &Path) -> String {
    path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned())
}
