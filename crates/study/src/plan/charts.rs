//! The charts that `plan.toml` names, read from their files.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::{Path, PathBuf};

use chart::{
    Bounds, DANGER_M, DepthUnit, Grid, GridDeclaration, GridKind, Invalid, Layer, LayerKind, Measured, Plane,
    PolygonLayer, Reading, Rules, UnitFrom, Unread, read_objects,
};
use files::{Budget, Digesting, Error, PROGRAM_BYTES, Provenance, Work};

use super::cells::{CellReader, PER_BYTE, cells_of, of_objects};
use super::exchange_set::{bytes, existing, note};
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
            let size = format!("{length} bytes");
            let work = Work { file: path, thing: "file", found: &size, remedy: LESS };
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
            self.summaries.extend(grid.measured.as_ref().map(|m| PlanChart::measured(name(path), m)));
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

// Metadata that GDAL writes next to a grid if the grid's own format does not support it.

/// Maximum bytes of such a file that are read.
const MOST: u64 = 1 << 20;

/// Refuses a grid with an `.aux.xml` that has a scale, or a unit that is not declared.
fn check_beside(path: &Path, declared: &GridDeclaration) -> Result<(), Error> {
    let beside = PathBuf::from([path.as_os_str(), ".aux.xml".as_ref()].into_iter().collect::<OsString>());
    if !files::exists(&beside) {
        return Ok(());
    }
    let mut bytes = Vec::new();
    let read = files::open(&beside)?.take(MOST).read_to_end(&mut bytes);
    read.map_err(|e| Error::io(&beside, "read", e))?;
    let text = String::from_utf8_lossy(&bytes);
    for (tag, usual) in [("Scale", 1.0), ("Offset", 0.0)] {
        if let Some(value) = text_of(&text, tag).filter(|value| value.parse() != Ok(usual)) {
            let given = format!("{} beside the grid", refusal::foreign(value));
            let remedy = "write both into one file, for instance with `gdal_translate -of GTiff`";
            return Err(Error::refuse(&beside, tag, given, format!("{usual}, or none"), remedy));
        }
    }
    let Some(unit_name) = text_of(&text, "UnitType").filter(|name| !name.is_empty()) else { return Ok(()) };
    let (unit, usual) = (DepthUnit::of_text(unit_name), declared.unit.unwrap_or(DepthUnit::Metre));
    if declared.kind == GridKind::LandMask || unit == Some(usual) {
        return Ok(());
    }
    let given = format!("`{}` beside the grid", refusal::foreign(unit_name));
    let expected = format!("`{}`, or the same as `depth_unit`", usual.name());
    Err(Error::refuse(&beside, "UnitType", given, expected, "say `depth_unit` in its [[chart]]"))
}

/// The text between two tags.
fn text_of<'t>(text: &'t str, tag: &str) -> Option<&'t str> {
    let (_, rest) = text.split_once(&format!("<{tag}>"))?;
    rest.split_once(&format!("</{tag}>")).map(|(inner, _)| inner.trim())
}

/// Byte order marks: UTF-32 before UTF-16, whose mark is its prefix.
const UTF_32: [&[u8]; 2] = [&[0xff, 0xfe, 0, 0], &[0, 0, 0xfe, 0xff]];

/// The text of a file: in UTF-8, with or without a byte order mark, or in UTF-16 with one.
///
/// # Errors
/// Bytes that are not such text; names UTF-16 without a mark, and UTF-32.
pub fn chart_text(bytes: Vec<u8>) -> Result<String, Invalid> {
    if UTF_32.iter().any(|mark| bytes.starts_with(mark)) {
        return Err(refuse("text in UTF-32".to_owned()));
    }
    match bytes.get(..2) {
        Some([0xff, 0xfe]) => wide(&bytes[2..], u16::from_le_bytes),
        Some([0xfe, 0xff]) => wide(&bytes[2..], u16::from_be_bytes),
        _ => narrow(bytes),
    }
}

fn narrow(mut bytes: Vec<u8>) -> Result<String, Invalid> {
    if bytes.starts_with(&[0xef, 0xbb, 0xbf]) {
        bytes.drain(..3);
    }
    let zeros = bytes.iter().take(64).filter(|byte| **byte == 0).count();
    if zeros > 16 {
        return Err(refuse("text in UTF-16 without a byte order mark".to_owned()));
    }
    String::from_utf8(bytes).map_err(|e| refuse(e.to_string()))
}

fn wide(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<String, Invalid> {
    let (pairs, rest) = bytes.as_chunks::<2>();
    if !rest.is_empty() {
        return Err(refuse("text in UTF-16 that is cut off".to_owned()));
    }
    let decoded = char::decode_utf16(pairs.iter().map(|pair| unit(*pair)));
    decoded.collect::<Result<_, _>>().map_err(|_| refuse("half a character of UTF-16".to_owned()))
}

fn refuse(found: String) -> Invalid {
    let expected = "text in UTF-8, or in UTF-16 with a byte order mark";
    Invalid::new("file", found, expected, "export it again, or convert it with `iconv -t UTF-8`")
}

/// The format of a grid.
#[derive(Clone, Copy)]
enum GridFormat {
    Ascii,
    Tiff,
}

impl GridFormat {
    /// By the file's extension; `None` if it is not a grid.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "asc" => Some(Self::Ascii),
            "tif" | "tiff" => Some(Self::Tiff),
            _ => None,
        }
    }

    /// Reads a grid, and notes the digest of its file.
    pub fn read(
        self,
        path: &Path,
        declared: &GridDeclaration,
        reading: &Reading,
        provenance: &mut Provenance,
    ) -> Result<Result<Grid, Unread>, Error> {
        check_beside(path, declared)?;
        Ok(match self {
            Self::Ascii => {
                let length = std::fs::metadata(path).map_or(0, |about| about.len()) as f64;
                if length > reading.bytes {
                    let size = format!("{length} bytes of text");
                    return Ok(Err(Unread::TooLarge { found: size, bytes: length }));
                }
                let text = chart_text(bytes(path, provenance)?).map_err(|e| Error::invalid(path, e))?;
                Grid::from_ascii(&text, declared, &Reading { bytes: reading.bytes - length, ..*reading })
            }
            Self::Tiff => Grid::from_tiff(BufReader::new(open(path, provenance)?), declared, reading),
        })
    }
}

/// Refuses a file of NetCDF, classic or in HDF5, whatever its name.
fn refuse_netcdf(path: &Path) -> Result<(), Error> {
    const SIGNATURES: [&[u8]; 4] = [b"CDF\x01", b"CDF\x02", b"CDF\x05", b"\x89HDF\r\n\x1A\n"];
    let mut first = Vec::new();
    files::open(path)?.take(8).read_to_end(&mut first).map_err(|e| Error::io(path, "read", e))?;
    if !SIGNATURES.iter().any(|signature| first.starts_with(signature)) {
        return Ok(());
    }
    let expected = "GeoTIFF (.tif), ESRI ASCII (.asc), GeoJSON, or a cell of an electronic chart (.000)";
    let named = path.with_extension("tif");
    let tiff = if named == path { path.with_extension("geo.tif") } else { named };
    let remedy = format!("convert it: `gdal_translate {} {}`", path.display(), tiff.display());
    Err(Error::refuse(path, "chart", "NetCDF", expected, remedy))
}

/// Opens the file of a chart, and notes its digest.
fn open(path: &Path, provenance: &mut Provenance) -> Result<File, Error> {
    let failed = |e| Error::io(path, "read", e);
    let mut file = files::open(path)?;
    let digest = Digesting::new(&file).digest().map_err(failed)?;
    file.rewind().map_err(failed)?;
    note(path, digest, provenance);
    Ok(file)
}
