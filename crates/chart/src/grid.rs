use serde::Deserialize;

use crate::grid_header::{Header, header};
use crate::{Crs, Invalid};

/// What the numbers of a grid are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GridKind {
    /// Depths \[m\], positive down: charts.
    Depth,
    /// Elevations \[m\], negative down: GEBCO, EMODnet and the like.
    Elevation,
    /// 1 is land, 0 is water of unknown depth.
    LandMask,
}

/// Farther from the sea's surface than any ground \[m\]: what stands for no data in files that do not say so.
pub(crate) const FARTHEST: f64 = 12_000.0;

/// How a grid file is to be read.
#[derive(Clone, Debug)]
pub struct GridDeclaration {
    /// What its numbers are.
    pub kind: GridKind,
    /// The system of its coordinates, where the file does not say.
    pub crs: Option<Crs>,
    /// The variable of a NetCDF file, where it has several.
    pub variable: Option<String>,
    /// Set where the area really is open sea, without land, drying or missing cells: otherwise a grid of
    /// only depths is refused as one of elevations of land.
    pub open_sea: bool,
}

/// A grid of depths or land. A value holds for its whole cell.
#[derive(Clone, Debug)]
pub struct Grid {
    /// The system of its coordinates.
    pub crs: Crs,
    /// Whether it tells depths (not only land).
    pub has_depth: bool,
    /// Coordinates of the south-western corner, in the CRS.
    pub corner: [f64; 2],
    /// Side of a cell, in the CRS's unit.
    pub cell: f64,
    /// Columns, from west to east.
    pub columns: usize,
    /// Rows, from south to north (the file has them from north to south).
    pub rows: usize,
    /// Per cell, row by row from the south, what is known.
    pub cells: Vec<GridCell>,
}

/// What a grid says about one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GridCell {
    /// No data: not charted, an obstacle.
    Missing,
    /// Land, of a land mask.
    Land,
    /// Water of unknown depth, of a land mask.
    Water,
    /// Depth \[m\], positive down; negative: drying.
    Depth(f64),
}

impl Grid {
    /// Reads an ESRI ASCII grid: one line per row, from north to south.
    ///
    /// # Errors
    /// A header without columns, rows, corner or cell size, or with a size that is not positive; rows or
    /// columns other than the header says; values that are no finite numbers; a land mask with values other
    /// than 0 and 1; depths that are all land, or all deep (unless declared open sea): the sign looks
    /// wrong; depths that no sea has: they stand for no data; no data at all.
    pub fn from_ascii(text: &str, declared: &GridDeclaration) -> Result<Self, Invalid> {
        let mut lines = text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()).peekable();
        let header = header(&mut lines)?;
        let crs = declared.crs.clone().ok_or_else(Crs::undeclared)?;
        check_degrees(&header, &crs)?;
        let values = values(lines, &header, text.len() / 2 + 1)?;
        Self::of(&header, values, crs, declared)
    }

    /// Of values from north to south.
    pub(crate) fn of(
        header: &Header,
        values: Vec<f64>,
        crs: Crs,
        declared: &GridDeclaration,
    ) -> Result<Self, Invalid> {
        check_degrees(header, &crs)?;
        if header.columns.checked_mul(header.rows) != Some(values.len()) || values.is_empty() {
            let (found, expected) =
                (format!("{} values", values.len()), format!("{} × {}", header.columns, header.rows));
            return Err(shape("grid".to_owned(), found, expected));
        }
        check_values(&values, header, declared)?;
        let cell = |v: &f64| meaning(*v, declared.kind, header.no_data);
        let cells = values.chunks(header.columns).rev().flatten().map(cell).collect();
        Ok(Self {
            crs,
            has_depth: declared.kind != GridKind::LandMask,
            corner: header.corner,
            cell: header.cell,
            columns: header.columns,
            rows: header.rows,
            cells,
        })
    }
}

/// Refuses coordinates in metres that are declared as degrees.
fn check_degrees(header: &Header, crs: &Crs) -> Result<(), Invalid> {
    let far = |k: usize, cells: usize| header.corner[k] + header.cell * cells as f64;
    let [west, south] = header.corner;
    let (east, north) = (far(0, header.columns), far(1, header.rows));
    // Cells may be centred on the last meridian or the poles.
    let half = header.cell / 2.0 + 1e-9;
    let inside =
        west >= -180.0 - half && east <= 360.0 + half && south >= -90.0 - half && north <= 90.0 + half;
    if inside || !crs.is_geographic() {
        return Ok(());
    }
    Err(Invalid::new(
        format!("CRS `{}`", crs.name()),
        format!("corners {west}, {south} and {east}, {north} (projected coordinates: mixed CRS)"),
        "longitude and latitude in degrees",
        "name the system of the grid's coordinates, such as `EPSG:32635`",
    ))
}

fn meaning(value: f64, kind: GridKind, no_data: f64) -> GridCell {
    match kind {
        _ if value == no_data => GridCell::Missing,
        GridKind::Depth => GridCell::Depth(value),
        GridKind::Elevation => GridCell::Depth(-value),
        GridKind::LandMask if value == 1.0 => GridCell::Land,
        GridKind::LandMask => GridCell::Water,
    }
}

/// All numbers, of which a text holds no more than `most`.
fn values<'a>(
    lines: impl Iterator<Item = (usize, &'a str)>,
    header: &Header,
    most: usize,
) -> Result<Vec<f64>, Invalid> {
    let mut values = Vec::with_capacity(header.columns.saturating_mul(header.rows).min(most));
    let mut rows = 0;
    for (number, line) in lines {
        let before = values.len();
        for token in line.split_ascii_whitespace() {
            values.push(number_of(token, number)?);
        }
        let columns = values.len() - before;
        if columns != header.columns {
            return Err(shape(
                format!("line {}", number + 1),
                format!("{columns} values"),
                format!("{} values, one line per row", header.columns),
            ));
        }
        rows += 1;
    }
    if rows == header.rows {
        return Ok(values);
    }
    Err(shape("grid".to_owned(), format!("{rows} rows"), format!("{} rows", header.rows)))
}

fn number_of(token: &str, line: usize) -> Result<f64, Invalid> {
    match token.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        _ => Err(Invalid::new(
            format!("line {}", line + 1),
            format!("`{token}`"),
            "finite numbers",
            "write cells without data as the NODATA_value, for instance with `gdal_translate -a_nodata -9999`",
        )),
    }
}

fn shape(thing: String, found: String, expected: String) -> Invalid {
    Invalid::new(thing, found, format!("{expected}, as the header says"), "export the whole file again")
}

fn check_values(values: &[f64], header: &Header, declared: &GridDeclaration) -> Result<(), Invalid> {
    let known = || values.iter().copied().filter(|v| *v != header.no_data);
    let (min, max) = known().fold((f64::MAX, f64::MIN), |(lo, hi), v| (lo.min(v), hi.max(v)));
    let found = format!("{min}..{max}");
    if min > max {
        return Err(Invalid::new("grid", "no cell with data", "cells with data", "export another area"));
    }
    let up_is_land = match declared.kind {
        GridKind::LandMask => return check_mask(known(), found),
        GridKind::Depth => (max <= 0.0, min > 0.0),
        GridKind::Elevation => (min >= 0.0, max < 0.0),
    };
    let far = known().filter(|v| v.abs() > FARTHEST).collect::<Vec<_>>();
    if let Some(value) = far.first() {
        return Err(Invalid::new(
            "grid",
            format!("{value} in {} of {} cells", far.len(), values.len()),
            format!("depths and heights of at most {FARTHEST} m"),
            "write cells without data as the NODATA_value, for instance with `gdal_translate -a_nodata -9999`",
        ));
    }
    let (name, other) = match declared.kind {
        GridKind::Depth => ("depth", "elevation"),
        _ => ("elevation", "depth"),
    };
    let whole = known().count() == values.len();
    if up_is_land.0 {
        let found = format!("{found}, all land as `{name}`");
        return Err(Invalid::new("grid", found, "some water", format!("declare it as `{other}`")));
    }
    if up_is_land.1 && whole && !declared.open_sea {
        let found = format!("{found}, all deep as `{name}`");
        let remedy = format!("declare it as `{other}`, or as open sea if it is");
        return Err(Invalid::new("grid", found, "some land, drying or missing cells", remedy));
    }
    Ok(())
}

fn check_mask(mut known: impl Iterator<Item = f64>, found: String) -> Result<(), Invalid> {
    match known.find(|v| *v != 0.0 && *v != 1.0) {
        None => Ok(()),
        Some(v) => Err(Invalid::new(
            "grid",
            format!("{v} among {found}"),
            "0 and 1 only in a land mask",
            "declare it as `depth` or `elevation`",
        )),
    }
}
