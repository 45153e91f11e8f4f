use std::iter::Peekable;

use crate::Invalid;

/// What stands for cells without data where the file has something else.
pub(crate) const MISSING: f64 = f64::MAX;

/// Refuses cells that are not as high as wide; their side.
pub(crate) fn check_square(width: f64, height: f64) -> Result<f64, Invalid> {
    let side = (width * height).sqrt();
    if side.is_finite() && side > 0.0 && (width - height).abs() <= 1e-4 * side {
        return Ok(side);
    }
    let found = format!("cells of {width} × {height}");
    Err(Invalid::new("grid", found, "square cells", "resample it, for instance with `gdalwarp -tr`"))
}

/// Header of a grid.
pub(crate) struct Header {
    pub columns: usize,
    pub rows: usize,
    /// South-western corner of the grid.
    pub corner: [f64; 2],
    pub cell: f64,
    pub no_data: f64,
}

/// Reads `key value` lines up to the first row of numbers.
pub(crate) fn header<'a>(
    lines: &mut Peekable<impl Iterator<Item = (usize, &'a str)>>,
) -> Result<Header, Invalid> {
    let mut found = Keys::default();
    let is_key = |line: &str| line.trim_start().starts_with(|c: char| c.is_ascii_alphabetic());
    while let Some((number, line)) = lines.next_if(|(_, l)| is_key(l) && !is_number(l)) {
        found.take(number, line)?;
    }
    found.finish()
}

fn is_number(line: &str) -> bool {
    line.split_ascii_whitespace().next().is_some_and(|t| t.parse::<f64>().is_ok())
}

#[derive(Default)]
struct Keys {
    columns: Option<f64>,
    rows: Option<f64>,
    corner: [Option<f64>; 2],
    centre: [Option<f64>; 2],
    cell: Option<f64>,
    no_data: Option<f64>,
}

impl Keys {
    fn take(&mut self, number: usize, line: &str) -> Result<(), Invalid> {
        let mut words = line.split_ascii_whitespace();
        let key = words.next().unwrap_or_default().to_ascii_lowercase();
        let value = words.next().and_then(|v| v.parse().ok()).filter(|v: &f64| v.is_finite());
        let (Some(value), None) = (value, words.next()) else {
            let found = format!("`{}`", line.trim());
            return Err(refuse(format!("line {}", number + 1), found, "a key and one finite number"));
        };
        let slot = match key.as_str() {
            "ncols" => &mut self.columns,
            "nrows" => &mut self.rows,
            "xllcorner" => &mut self.corner[0],
            "yllcorner" => &mut self.corner[1],
            "xllcenter" => &mut self.centre[0],
            "yllcenter" => &mut self.centre[1],
            "cellsize" => &mut self.cell,
            "nodata_value" => &mut self.no_data,
            _ => {
                let expected =
                    "ncols, nrows, xllcorner, yllcorner (or xllcenter, yllcenter), cellsize, NODATA_value";
                return Err(refuse(format!("line {}", number + 1), format!("key `{key}`"), expected));
            }
        };
        match slot.replace(value) {
            None => Ok(()),
            Some(_) => Err(refuse(format!("key `{key}`"), "twice".to_owned(), "every key once")),
        }
    }

    fn finish(self) -> Result<Header, Invalid> {
        let cell = present(self.cell, "cellsize")?;
        if cell <= 0.0 {
            return Err(refuse("`cellsize`".to_owned(), cell.to_string(), "a size above 0"));
        }
        let corner = |k: usize, key: &str| match (self.corner[k], self.centre[k]) {
            (None, Some(centre)) => Ok(centre - cell / 2.0),
            (corner, _) => present(corner, key),
        };
        Ok(Header {
            columns: count(self.columns, "ncols")?,
            rows: count(self.rows, "nrows")?,
            corner: [corner(0, "xllcorner")?, corner(1, "yllcorner")?],
            cell,
            no_data: self.no_data.unwrap_or(-9999.0),
        })
    }
}

fn present(value: Option<f64>, key: &str) -> Result<f64, Invalid> {
    value.ok_or_else(|| refuse(format!("key `{key}`"), "none".to_owned(), "an ESRI ASCII grid's header"))
}

fn count(value: Option<f64>, key: &str) -> Result<usize, Invalid> {
    let value = present(value, key)?;
    if (1.0..=1e6).contains(&value) && value.fract() == 0.0 {
        return Ok(value as usize);
    }
    Err(refuse(format!("`{key}`"), value.to_string(), "a whole number from 1 to 1000000"))
}

fn refuse(thing: String, found: String, expected: &str) -> Invalid {
    Invalid::new(thing, found, expected, "export the file again as an ESRI ASCII grid (GDAL's AAIGrid)")
}
