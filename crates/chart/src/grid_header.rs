use std::iter::Peekable;

use crate::{Crs, Invalid};

/// Refuses cells that are not square; returns their side.
pub(crate) fn check_square(width: f64, height: f64) -> Result<f64, Invalid> {
    let side = (width * height).sqrt();
    if side.is_finite() && side > 0.0 && (width - height).abs() <= 1e-4 * side {
        return Ok(side);
    }
    let found = format!("cells of {width} × {height}");
    Err(Invalid::new("grid", found, "square cells", "resample it, for instance with `gdalwarp -tr`"))
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
    let mut found = Keys::default();
    let is_key = |line: &str| line.trim_start().starts_with(|c: char| c.is_ascii_alphabetic());
    while let Some((number, line)) = lines.next_if(|(_, l)| is_key(l) && !is_row(l)) {
        found.take(number, line)?;
    }
    found.finish()
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
                let found = format!("key {}", quoted(&key));
                return Err(refuse(format!("line {}", number + 1), found, expected));
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
