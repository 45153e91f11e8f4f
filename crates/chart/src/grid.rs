//! Grids of depths or land: their declaration, header, units and the window that is kept.

use std::iter::Peekable;
use std::ops::Range;
use std::sync::Arc;

use serde::Deserialize;

use crate::crs::UnitFrom;
use crate::{Bounds, Crs, DepthUnit, Invalid, Plane};

/// The value of land in the cells of a mask.
pub(crate) const LAND: f32 = 1.0;

/// A grid of depths or land, as far as it was read. A value is valid for its whole cell.
#[derive(Clone, Debug)]
pub struct Grid {
    /// The system of its coordinates.
    pub crs: Crs,
    /// Whether it has depths (and not only land).
    pub has_depth: bool,
    /// Coordinates of the south-western corner, in the CRS.
    pub corner: [f64; 2],
    /// Side of a cell, in the CRS's unit.
    pub cell: f64,
    /// Columns, from west to east.
    pub columns: usize,
    /// Rows, from south to north (the file has them from north to south).
    pub rows: usize,
    /// Unit and datum of its depths; a land mask has none.
    pub measured: Option<Measured>,
    /// The columns and rows that are kept.
    pub(crate) window: Block,
    /// Per cell of the window, row by row from the south: depth \[m\], or 1 for land and 0 for water, or NaN without data.
    pub(crate) cells: Arc<[f32]>,
}

/// The content of one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GridCell {
    /// No data: not charted, an obstacle.
    Missing,
    /// Land, of a land mask.
    Land,
    /// Water of unknown depth, of a land mask.
    Water,
    /// Depth \[m\], positive down; negative: drying. To seven digits.
    Depth(f64),
}

impl Grid {
    /// Bytes of its cells and of their kept corners.
    pub fn bytes(&self) -> u64 {
        bytes_of(self.cells.len() as f64) as u64
    }

    /// The kept cells, row by row from the south.
    pub fn cells(&self) -> impl Iterator<Item = GridCell> {
        self.cells.iter().map(|value| GridCell::of(*value, self.has_depth))
    }
}

impl GridCell {
    /// The content of a kept value.
    pub(crate) fn of(value: f32, has_depth: bool) -> Self {
        match value {
            value if value.is_nan() => Self::Missing,
            value if has_depth => Self::Depth(decimal(value)),
            LAND => Self::Land,
            _ => Self::Water,
        }
    }
}

/// The shortest decimal number that is kept as `value`: the one in the file, if that has at most seven digits.
fn decimal(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

/// The quantity in a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GridKind {
    /// Depths, positive down: charts.
    Depth,
    /// Elevations, negative down: GEBCO, EMODnet and the like.
    Elevation,
    /// 1 is land, 0 is water of unknown depth.
    LandMask,
}

/// Farther from the sea's surface than any ground \[m\]: such numbers mean no data in files that do not declare it.
pub(crate) const FARTHEST: f64 = 12_000.0;

/// How a grid file is to be read.
#[derive(Clone, Debug)]
pub struct GridDeclaration {
    /// What its numbers are.
    pub kind: GridKind,
    /// The CRS of its coordinates, if the file does not state it.
    pub crs: Option<Crs>,
    /// The unit of its depths or elevations, if the file does not state it; metres by default.
    pub unit: Option<DepthUnit>,
    /// Set where the area really is open sea, without land, drying or missing cells: otherwise a grid of only
    /// depths is refused, because it may be elevations of land.
    pub open_sea: bool,
}

/// Unit and datum of the depths or heights of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The unit after scale and offset.
    pub unit: DepthUnit,
    /// The origin of the unit.
    pub unit_from: UnitFrom,
    /// Factor of the file's numbers.
    pub scale: f64,
    /// Added after scaling.
    pub offset: f64,
    /// The vertical datum, if the file states one.
    pub datum: Option<String>,
}

impl Measured {
    /// For a file that says nothing about its numbers.
    pub fn plainly(unit: DepthUnit, unit_from: UnitFrom) -> Self {
        Self { unit, unit_from, scale: 1.0, offset: 0.0, datum: None }
    }
}

/// How a file encodes its numbers.
#[derive(Clone, Debug)]
pub(crate) struct Packing {
    pub scale: f64,
    pub offset: f64,
    pub unit: Option<DepthUnit>,
    pub datum: Option<String>,
    /// The number in the file that means no data.
    pub missing: Option<f64>,
}

impl Default for Packing {
    fn default() -> Self {
        Self { scale: 1.0, offset: 0.0, unit: None, datum: None, missing: None }
    }
}

impl Packing {
    /// The measurement that file and declaration agree on; a land mask has no unit.
    pub fn measured(&self, declared: &GridDeclaration) -> Result<Measured, Invalid> {
        if !(self.scale.is_finite() && self.scale != 0.0 && self.offset.is_finite()) {
            let scaling = format!("{} and {}", self.scale, self.offset);
            let expected = "finite numbers, the scale not 0";
            return Err(Invalid::new("scale and offset", scaling, expected, "correct them in the file"));
        }
        let (unit, unit_from) = match declared.kind {
            GridKind::LandMask => (DepthUnit::Metre, UnitFrom::File),
            GridKind::Depth | GridKind::Elevation => {
                let crs = declared.crs.as_ref().and_then(|crs| crs.vertical_unit());
                let stated = match (self.unit, crs) {
                    (Some(unit), Some(crs)) if unit != crs => {
                        return Err(Invalid::new(
                            "`crs`",
                            format!("heights in `{}`", crs.name()),
                            format!("`{}`, as the file says", unit.name()),
                            "name the horizontal system alone, or correct the file",
                        ));
                    }
                    (unit, crs) => unit.or(crs),
                };
                DepthUnit::agreed(stated, declared.unit)?
            }
        };
        let (scale, offset, datum) = (self.scale, self.offset, self.datum.clone());
        Ok(Measured { unit, unit_from, scale, offset, datum })
    }

    /// Decodes a number of the file, in units of `metres`, to metres (of a mask, unchanged) if it is data.
    pub fn number(&self, raw: f64, metres: f64) -> Option<f64> {
        let is_missing = raw.is_nan() || self.missing == Some(raw);
        (!is_missing).then_some((raw * self.scale + self.offset) * metres)
    }
}

/// Refuses cells that are not square; returns their side.
pub(crate) fn check_square(width: f64, height: f64) -> Result<f64, Invalid> {
    let side = (width * height).sqrt();
    if side.is_finite() && side > 0.0 && (width - height).abs() <= 1e-4 * side {
        return Ok(side);
    }
    let cells = format!("cells of {width} × {height}");
    Err(Invalid::new("grid", cells, "square cells", "resample it, for instance with `gdalwarp -tr`"))
}

/// Refuses coordinates in metres that are declared as degrees.
pub(crate) fn check_degrees(header: &Header, crs: &Crs) -> Result<(), Invalid> {
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

/// Most columns, and most rows, of a grid.
pub(crate) const MOST_ON_A_SIDE: usize = 1_000_000;

/// The position of the cells of a grid.
#[derive(Clone, Debug)]
pub(crate) struct Header {
    pub columns: usize,
    pub rows: usize,
    /// South-western corner of the grid.
    pub corner: [f64; 2],
    pub cell: f64,
}

/// The marker of no data in the rows of text: a number or a word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MissingWord {
    Number(f64),
    Word,
}

impl MissingWord {
    /// For an ESRI grid whose header does not declare one.
    const USUAL: Self = Self::Number(-9999.0);

    fn of(text: &str) -> Option<Self> {
        let number = text.parse().ok().filter(|v: &f64| v.is_finite()).map(Self::Number);
        number.or_else(|| is_word(text).then_some(Self::Word))
    }

    /// The number that stands for no data.
    pub fn number(self) -> Option<f64> {
        if let Self::Number(number) = self { Some(number) } else { None }
    }

    /// Whether `token`, which is not a number, means no data.
    pub fn is(self, token: &str) -> bool {
        self == Self::Word && is_word(token)
    }
}

/// Whether a word means no number, as programs write it.
fn is_word(text: &str) -> bool {
    ["nan", "-nan", "+nan", "null", "none", "na", "n/a", "1.#qnan", "-1.#ind", "nan(ind)", "-nan(ind)"]
        .contains(&text.to_ascii_lowercase().as_str())
}

/// Reads `key value` lines up to the first row of numbers.
pub(crate) fn header<'a>(
    lines: &mut Peekable<impl Iterator<Item = (usize, &'a str)>>,
) -> Result<(Header, MissingWord), Invalid> {
    let mut keys = Keys::default();
    let is_key = |line: &str| line.trim_start().starts_with(|c: char| c.is_ascii_alphabetic());
    while let Some((number, line)) = lines.next_if(|(_, l)| is_key(l) && !is_row(l)) {
        keys.take(number, line)?;
    }
    keys.finish()
}

fn is_row(line: &str) -> bool {
    let first = line.split_ascii_whitespace().next();
    first.is_some_and(|token| token.parse::<f64>().is_ok() || is_word(token))
}

#[derive(Default)]
struct Keys {
    columns: Option<f64>,
    rows: Option<f64>,
    corner: [Option<f64>; 2],
    centre: [Option<f64>; 2],
    cell: Option<f64>,
    missing: Option<MissingWord>,
}

impl Keys {
    fn take(&mut self, number: usize, line: &str) -> Result<(), Invalid> {
        let mut words = line.split_ascii_whitespace();
        let key = words.next().unwrap_or_default().to_ascii_lowercase();
        let word = words.next().filter(|_| words.next().is_none());
        if key == "nodata_value" {
            let Some(missing) = word.and_then(MissingWord::of) else {
                let expected = "NODATA_value and a number, `nan` or `null`";
                return Err(refuse(format!("line {}", number + 1), quoted(line), expected));
            };
            return once(&key, self.missing.replace(missing).is_some());
        }
        let value = word.and_then(|word| word.parse().ok()).filter(|v: &f64| v.is_finite());
        let Some(value) = value else {
            let expected = "a key and one finite number";
            return Err(refuse(format!("line {}", number + 1), quoted(line), expected));
        };
        let slot = match key.as_str() {
            "ncols" => &mut self.columns,
            "nrows" => &mut self.rows,
            "xllcorner" => &mut self.corner[0],
            "yllcorner" => &mut self.corner[1],
            "xllcenter" => &mut self.centre[0],
            "yllcenter" => &mut self.centre[1],
            "cellsize" => &mut self.cell,
            _ => {
                let expected =
                    "ncols, nrows, xllcorner, yllcorner (or xllcenter, yllcenter), cellsize, NODATA_value";
                let unknown = format!("key {}", quoted(&key));
                return Err(refuse(format!("line {}", number + 1), unknown, expected));
            }
        };
        once(&key, slot.replace(value).is_some())
    }

    fn finish(self) -> Result<(Header, MissingWord), Invalid> {
        let cell = present(self.cell, "cellsize")?;
        if cell <= 0.0 {
            return Err(refuse("`cellsize`".to_owned(), cell.to_string(), "a size above 0"));
        }
        let corner = |k: usize, key: &str| match (self.corner[k], self.centre[k]) {
            (None, Some(centre)) => Ok(centre - cell / 2.0),
            (corner, _) => present(corner, key),
        };
        let header = Header {
            columns: count(self.columns, "ncols")?,
            rows: count(self.rows, "nrows")?,
            corner: [corner(0, "xllcorner")?, corner(1, "yllcorner")?],
            cell,
        };
        Ok((header, self.missing.unwrap_or(MissingWord::USUAL)))
    }
}

/// A quoted excerpt of the file.
fn quoted(text: &str) -> String {
    format!("`{}`", refusal::foreign(text.trim()))
}

fn once(key: &str, again: bool) -> Result<(), Invalid> {
    if again { Err(refuse(format!("key `{key}`"), "twice".to_owned(), "every key once")) } else { Ok(()) }
}

fn present(value: Option<f64>, key: &str) -> Result<f64, Invalid> {
    value.ok_or_else(|| refuse(format!("key `{key}`"), "none".to_owned(), "an ESRI ASCII grid's header"))
}

fn count(value: Option<f64>, key: &str) -> Result<usize, Invalid> {
    let value = present(value, key)?;
    if (1.0..=MOST_ON_A_SIDE as f64).contains(&value) && value.fract() == 0.0 {
        return Ok(value as usize);
    }
    Err(refuse(format!("`{key}`"), value.to_string(), "a whole number from 1 to 1000000"))
}

fn refuse(thing: String, found: String, expected: &str) -> Invalid {
    Invalid::new(thing, found, expected, "export the file again as an ESRI ASCII grid (GDAL's AAIGrid)")
}

/// Columns from the west and rows from the south.
pub(crate) type Block = [Range<usize>; 2];

/// Points per side of the area's edge that are projected to find the part of a grid that covers it.
const PER_SIDE: usize = 32;

/// Most cells whose corners are kept rather than computed on demand.
pub(crate) const MOST_KEPT: usize = 4_000_000;
/// Bytes of a cell, and of a corner that is kept.
const CELL_BYTES: f64 = 4.0;
const CORNER_BYTES: f64 = 16.0;

/// Bytes of a window of so many cells, with its kept corners.
pub(crate) fn bytes_of(cells: f64) -> f64 {
    let corners = if cells > MOST_KEPT as f64 { 0.0 } else { CORNER_BYTES };
    cells * (CELL_BYTES + corners)
}

/// Columns and rows that cover the area, with two cells to spare.
pub(crate) fn window(
    grid: &Header,
    crs: &Crs,
    plane: &Plane,
    area: &Bounds,
) -> Result<Option<Block>, Invalid> {
    let in_crs = |p: [f64; 2]| {
        let (lon, lat) = plane.to_geographic(p);
        let [x, y] = crs.to_own(lon, lat)?;
        // Longitudes in the grid's range: -179 or 181.
        let centre = grid.corner[0] + grid.cell * grid.columns as f64 / 2.0;
        let turn = if crs.is_geographic() { 360.0 * ((x - centre) / 360.0).round() } else { 0.0 };
        Ok([x - turn, y])
    };
    let edge = area.edge(PER_SIDE).into_iter().map(in_crs).collect::<Result<Vec<_>, Invalid>>()?;
    let Some(needed) = Bounds::enclosing(&edge) else { return Ok(None) };
    let range = |k: usize, count: usize| {
        let low = ((needed.min[k] - grid.corner[k]) / grid.cell).floor() - 2.0;
        let high = ((needed.max[k] - grid.corner[k]) / grid.cell).ceil() + 2.0;
        low.clamp(0.0, count as f64) as usize..high.clamp(0.0, count as f64) as usize
    };
    let ranges = [range(0, grid.columns), range(1, grid.rows)];
    Ok((!ranges[0].is_empty() && !ranges[1].is_empty()).then_some(ranges))
}
