//! NetCDF: bathymetry in the form of GEBCO and EMODnet.

use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use netcdf_reader::unpack::SignParams;
use netcdf_reader::{
    Error, NcFile, NcOpenOptions, NcSliceInfo, NcSliceInfoElem, NcVariable, RangeRequestStorage,
};

use crate::grid_cells::{Cells, Rows};
use crate::grid_header::{Header, MOST_ON_A_SIDE, check_square};
use crate::grid_netcdf_attributes::{named, packing};
use crate::grid_window::Block;
use crate::{Crs, Grid, GridDeclaration, Invalid, Reading, Unread};

/// Share of a step by which a coordinate may deviate from an even spacing.
const UNEVEN: f64 = 0.02;
/// Cells that are read at once.
const AT_ONCE: usize = 1 << 18;
/// Approximate bytes per cell while reading: as in the file, and twice as a number.
const BYTES_AT_ONCE: f64 = 24.0;
/// Most bytes of a chunk, and of all cached ones, decoded.
const MOST_BYTES: f64 = 64.0 * 1_048_576.0;

impl Grid {
    /// Reads one variable over latitude and longitude (or y and x) of a NetCDF file, classic or version 4.
    /// Coordinates are the centres of cells; those in degrees are in WGS84 unless declared otherwise. Scale,
    /// offset, unit, direction, and missing and valid values follow the file's attributes.
    ///
    /// # Errors
    /// A file that is not NetCDF, or damaged; no such variable, or several where none is named; coordinates
    /// that are not evenly spaced, or differ in spacing; a system in metres that is not declared; an unknown
    /// unit or direction, or one that contradicts the declaration; as [`Grid::from_ascii`].
    pub fn from_netcdf<R: Read + Seek + Send + 'static>(
        source: R,
        declared: &GridDeclaration,
        reading: &Reading,
    ) -> Result<Self, Unread> {
        let bytes = (reading.bytes / 4.0).min(MOST_BYTES) as usize;
        let options = NcOpenOptions {
            chunk_cache_bytes: bytes,
            max_chunk_bytes: (reading.bytes / 2.0) as usize,
            max_read_bytes: (reading.bytes / 2.0) as usize,
            max_object_header_bytes: bytes,
            ..NcOpenOptions::default()
        };
        let source = ranges(source).map_err(|e| refuse(&e.into()))?;
        let file = NcFile::from_storage_with_options(Arc::new(source), options).map_err(|e| refuse(&e))?;
        let variable = chosen(&file, declared.variable.as_deref())?;
        let packing = packing(&file, variable, declared.kind)?;
        let [rows, columns] = [0, 1].map(|k| variable.dimensions()[k].name.clone());
        let (y, x) = (Axis::read(&file, &rows)?, Axis::read(&file, &columns)?);
        if y.is_east || x.step < 0.0 {
            let found = format!("{rows} before {columns}, or {columns} from east to west");
            let expected = "latitude or y first, longitude or x from west to east";
            return Err(
                Invalid::new(named(variable), found, expected, "export it again in this order").into()
            );
        }
        let crs = match &declared.crs {
            Some(crs) => crs.clone(),
            None if x.is_east => Crs::new("WGS84")?,
            None => return Err(Crs::undeclared().into()),
        };
        let cell = check_square(x.step, y.step.abs())?;
        let south = y.first.min(y.first + y.step * (y.count - 1) as f64);
        let corner = [x.first - cell / 2.0, south - cell / 2.0];
        let header = Header { columns: x.count, rows: y.count, corner, cell };
        let cells = Cells::new(header, crs, packing, declared, reading)?;
        cells.check_memory(AT_ONCE as f64 * BYTES_AT_ONCE + bytes as f64)?;
        let order = if y.step > 0.0 { Rows::FromSouth } else { Rows::FromNorth };
        let blocks = blocks(cells.window(), [x.count, y.count]);
        let sign = SignParams::from_variable(variable);
        cells.read(blocks.into_iter(), order, |block| {
            let all = file.read_variable_slice_as_f64(variable.name(), &slice(block, order, y.count));
            let all = all.map_err(|e| refuse(&e))?;
            let (all, _) = all.into_raw_vec_and_offset();
            Ok(all.into_iter().map(move |value| sign.map_or(value, |sign| sign.reinterpret(value))))
        })
    }
}

/// A file of which only the requested ranges are read.
fn ranges<R: Read + Seek + Send + 'static>(mut source: R) -> std::io::Result<RangeRequestStorage> {
    let length = source.seek(SeekFrom::End(0))?;
    let source = Mutex::new(source);
    Ok(RangeRequestStorage::new(length, move |offset, count| {
        let mut source = source.lock().unwrap_or_else(PoisonError::into_inner);
        source.seek(SeekFrom::Start(offset))?;
        let mut bytes = vec![0; count];
        source.read_exact(&mut bytes)?;
        Ok(bytes)
    }))
}

/// All cells in blocks of rows: those of the window's columns, and those to its west and east.
fn blocks([columns, rows]: &Block, [width, height]: [usize; 2]) -> Vec<Block> {
    let parts = [0..columns.start, columns.clone(), columns.end..width];
    let bands = [0..rows.start, rows.clone(), rows.end..height];
    let cut = |columns: Range<usize>, rows: Range<usize>| {
        let at_once = (AT_ONCE / columns.len().max(1)).max(1);
        let starts = rows.clone().step_by(at_once);
        starts.map(move |start| [columns.clone(), start..(start + at_once).min(rows.end)])
    };
    let parts = parts.into_iter().filter(|columns| !columns.is_empty());
    parts
        .flat_map(|columns| bands.clone().into_iter().flat_map(move |rows| cut(columns.clone(), rows)))
        .collect()
}

/// The position of a block in the file.
fn slice([columns, rows]: &Block, order: Rows, count: usize) -> NcSliceInfo {
    let rows = match order {
        Rows::FromSouth => rows.clone(),
        Rows::FromNorth => count - rows.end..count - rows.start,
    };
    let part = |range: Range<usize>| NcSliceInfoElem::Slice {
        start: range.start as u64,
        end: range.end as u64,
        step: 1,
    };
    NcSliceInfo { selections: vec![part(rows), part(columns.clone())] }
}

/// The requested variable, over two dimensions that have coordinates.
fn chosen<'f>(file: &'f NcFile, name: Option<&str>) -> Result<&'f NcVariable, Invalid> {
    let variables = file.variables().map_err(|e| refuse(&e))?;
    let has_coordinates = |own: &NcVariable| {
        let known = |dimension: &str| variables.iter().any(|v| v.is_coordinate_variable_for(dimension));
        own.ndim() == 2 && own.dimensions().iter().all(|dimension| known(&dimension.name))
    };
    let grids: Vec<&NcVariable> = variables.iter().filter(|own| has_coordinates(own)).collect();
    let names = || grids.iter().map(|own| refusal::foreign(own.name())).collect::<Vec<_>>().join(", ");
    let found = match name {
        Some(name) => grids.iter().copied().find(|own| own.name() == name).ok_or(format!("no grid `{name}`")),
        None if grids.len() == 1 => Ok(grids[0]),
        None => Err(format!("{} grids", grids.len())),
    };
    found.map_err(|found| {
        let expected = match grids.is_empty() {
            true => "a variable over two dimensions with coordinates".to_owned(),
            false => format!("one of {}", names()),
        };
        Invalid::new("`variable`", found, expected, "name the one with depths or elevations as `variable`")
    })
}

/// Evenly spaced coordinates.
struct Axis {
    first: f64,
    step: f64,
    count: usize,
    /// Whether they are longitudes in degrees.
    is_east: bool,
}

impl Axis {
    fn read(file: &NcFile, name: &str) -> Result<Self, Invalid> {
        let variable = file.coordinate_variable(name).map_err(|e| refuse(&e))?;
        let uneven = |found: String| {
            let expected = "evenly spaced coordinates, two at least";
            Err(Invalid::new(named(variable), found, expected, "resample it, for instance with `gdalwarp`"))
        };
        let count = variable.num_elements().map_err(|e| refuse(&e.into()))?;
        if !(2..=MOST_ON_A_SIDE as u64).contains(&count) {
            return uneven(format!("{count} of them"));
        }
        let all = file.read_variable_unpacked(variable.name()).map_err(|e| refuse(&e))?;
        let all: Vec<f64> = all.iter().copied().collect();
        let count = all.len();
        let (first, step) = (all[0], (all[count - 1] - all[0]) / (count - 1) as f64);
        let off = |(k, value): (usize, &f64)| (value - first - step * k as f64).abs();
        let worst = all.iter().enumerate().map(off).fold(0.0, f64::max);
        if !(step.abs() > 0.0 && worst <= UNEVEN * step.abs()) {
            return uneven(format!("steps of {step} on average, one {worst} off"));
        }
        let units = variable.attribute("units").and_then(|own| own.value.as_string());
        let is_east = units.is_some_and(|units| units.starts_with("degree") && units.ends_with("east"));
        Ok(Self { first, step, count, is_east: is_east || ["lon", "longitude"].contains(&name) })
    }
}

fn refuse(error: &Error) -> Invalid {
    Invalid::new(
        "NetCDF",
        error.to_string(),
        "a whole NetCDF file, classic or of version 4",
        "export it again, for instance with `gdal_translate -of netCDF`",
    )
}
