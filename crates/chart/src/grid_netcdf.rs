//! NetCDF: grids of the ocean's floor in the form of GEBCO and EMODnet.

use netcdf_reader::{Error, NcFile, NcVariable};

use crate::grid_header::{Header, MISSING, check_square};
use crate::{Crs, Grid, GridDeclaration, Invalid};

/// Part of a step that a coordinate may be off an even spacing.
const UNEVEN: f64 = 0.02;

impl Grid {
    /// Reads one variable over latitude and longitude (or y and x) of a NetCDF file, classic or of version 4. Coordinates are
    /// the middles of cells; those in degrees are in WGS84 unless declared otherwise. Scale, offset and missing values are
    /// taken as the file's attributes say.
    ///
    /// # Errors
    /// No NetCDF, or a damaged one; no such variable, or several where none is named; coordinates that are not evenly spaced,
    /// or not alike both ways; a system in metres that is not declared; as [`Grid::from_ascii`].
    pub fn from_netcdf(bytes: Vec<u8>, declared: &GridDeclaration) -> Result<Self, Invalid> {
        let file = NcFile::from_vec(bytes).map_err(|e| refuse(&e))?;
        let variable = chosen(&file, declared.variable.as_deref())?;
        let [rows, columns] = [0, 1].map(|k| variable.dimensions()[k].name.clone());
        let (y, x) = (Axis::read(&file, &rows)?, Axis::read(&file, &columns)?);
        if y.is_east || x.step < 0.0 {
            let found = format!("{rows} before {columns}, or {columns} from east to west");
            let expected = "latitude or y first, longitude or x from west to east";
            return Err(Invalid::new(named(variable), found, expected, "export it again in this order"));
        }
        let crs = match &declared.crs {
            Some(crs) => crs.clone(),
            None if x.is_east => Crs::new("WGS84")?,
            None => return Err(Crs::undeclared()),
        };
        let cell = check_square(x.step, y.step.abs())?;
        let all = file.read_variable_unpacked_masked(variable.name()).map_err(|e| refuse(&e))?;
        let mut values: Vec<f64> =
            all.iter().map(|value| if value.is_nan() { MISSING } else { *value }).collect();
        if y.step > 0.0 {
            values = values.chunks(x.count).rev().flatten().copied().collect();
        }
        let south = y.first.min(y.first + y.step * (y.count - 1) as f64);
        let corner = [x.first - cell / 2.0, south - cell / 2.0];
        let header = Header { columns: x.count, rows: y.count, corner, cell, no_data: MISSING };
        Self::of(&header, values, crs, declared)
    }
}

/// The variable that is meant, over two dimensions that have coordinates.
fn chosen<'f>(file: &'f NcFile, name: Option<&str>) -> Result<&'f NcVariable, Invalid> {
    let variables = file.variables().map_err(|e| refuse(&e))?;
    let has_coordinates = |own: &NcVariable| {
        let known = |dimension: &str| variables.iter().any(|v| v.is_coordinate_variable_for(dimension));
        own.ndim() == 2 && own.dimensions().iter().all(|dimension| known(&dimension.name))
    };
    let grids: Vec<&NcVariable> = variables.iter().filter(|own| has_coordinates(own)).collect();
    let names = || grids.iter().map(|own| own.name()).collect::<Vec<_>>().join(", ");
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
        let all = file.read_variable_as_f64(variable.name()).map_err(|e| refuse(&e))?;
        let all: Vec<f64> = all.iter().copied().collect();
        let count = all.len();
        let uneven = |found: String| {
            let expected = "evenly spaced coordinates, two at least";
            Err(Invalid::new(named(variable), found, expected, "resample it, for instance with `gdalwarp`"))
        };
        if count < 2 {
            return uneven(format!("{count} of them"));
        }
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

fn named(variable: &NcVariable) -> String {
    format!("variable `{}`", variable.name())
}

fn refuse(error: &Error) -> Invalid {
    Invalid::new(
        "NetCDF",
        error.to_string(),
        "a whole NetCDF file, classic or of version 4",
        "export it again, for instance with `gdal_translate -of netCDF`",
    )
}
