//! Cells of a grid while it is read, and whether they are depths at all.

use std::sync::Arc;

use crate::grid::{
    Block, FARTHEST, Header, LAND, Measured, MissingWord, Packing, bytes_of, check_degrees, header, window,
};
use crate::{Crs, Grid, GridDeclaration, GridKind, Invalid, Reading, Unread};

/// Most cells beyond the window that are read to find out whether a grid has depths.
const MOST_BEYOND: usize = 1 << 24;

/// The cells of a grid that were read so far.
pub(crate) struct Cells<'a> {
    header: Header,
    crs: Crs,
    declared: &'a GridDeclaration,
    packing: Packing,
    measured: Measured,
    reading: &'a Reading<'a>,
    /// The part of the grid to keep.
    window: Block,
    kept: Vec<f32>,
    known: u64,
    missing: u64,
    /// Least and greatest value, in metres.
    range: [f64; 2],
    /// The first value that no sea has, and the number of these.
    far: Option<f64>,
    many_far: u64,
    /// The first value of a mask that is neither land nor water.
    odd: Option<f64>,
}

impl<'a> Cells<'a> {
    /// No cells yet; refuses a window that exceeds the memory.
    pub fn new(
        header: Header,
        crs: Crs,
        packing: Packing,
        declared: &'a GridDeclaration,
        reading: &'a Reading<'a>,
    ) -> Result<Self, Unread> {
        check_degrees(&header, &crs)?;
        let measured = packing.measured(declared)?;
        let window = match reading.area {
            Some((plane, area)) => window(&header, &crs, plane, area)?.unwrap_or([0..0, 0..0]),
            None => [0..header.columns, 0..header.rows],
        };
        let kept = nothing([0, 1].map(|k: usize| window[k].len()), reading)?;
        let range = [f64::INFINITY, f64::NEG_INFINITY];
        Ok(Self {
            header,
            crs,
            declared,
            packing,
            measured,
            reading,
            window,
            kept,
            known: 0,
            missing: 0,
            range,
            far: None,
            many_far: 0,
            odd: None,
        })
    }

    /// Refuses to read `bytes` of a file at once if these and the cells exceed the memory.
    pub fn check_memory(&self, bytes: f64) -> Result<(), Unread> {
        let cells = bytes_of(self.kept.len() as f64);
        self.reading.check_memory(cells + bytes, || {
            format!("{} cells around the area, in blocks of {bytes} bytes", self.kept.len())
        })
    }

    /// Reads blocks of the file: all that meet the window, and others until it is certain that these are
    /// depths. If these are more than [`MOST_BEYOND`] cells, a sample of blocks all over the grid decides.
    pub fn read<N: Iterator<Item = f64>>(
        mut self,
        blocks: impl Iterator<Item = Block> + Clone,
        mut numbers: impl FnMut(&Block) -> Result<N, Unread>,
    ) -> Result<Grid, Unread> {
        let window = self.window.clone();
        let is_within = move |block: &Block| {
            (0..2).all(|k| block[k].start < window[k].end && window[k].start < block[k].end)
        };
        let beyond = blocks.clone().filter(|block| !is_within(block));
        let sizes = beyond.clone().map(|[columns, rows]| columns.len() * rows.len());
        let stride = sizes.sum::<usize>().div_ceil(MOST_BEYOND).max(1);
        for block in blocks.filter(&is_within) {
            self.reading.check_time()?;
            self.take(&block, numbers(&block)?);
        }
        for block in beyond.step_by(stride) {
            if self.is_plain() {
                break;
            }
            self.reading.check_time()?;
            self.take(&block, numbers(&block)?);
        }
        Ok(self.finish()?)
    }

    /// Takes the numbers of a block, row by row from the north as in the file.
    pub fn take(&mut self, [columns, rows]: &Block, mut numbers: impl Iterator<Item = f64>) {
        let metres = self.measured.unit.metres();
        for row in rows.clone().rev() {
            let kept =
                self.window[1].contains(&row).then(|| (row - self.window[1].start) * self.window[0].len());
            for column in columns.clone() {
                let Some(raw) = numbers.next() else { return };
                let cell = self.cell(self.packing.number(raw, metres));
                if let Some(start) = kept.filter(|_| self.window[0].contains(&column)) {
                    self.kept[start + column - self.window[0].start] = cell;
                }
            }
        }
    }

    /// The value to keep of a number, if it is one.
    fn cell(&mut self, number: Option<f64>) -> f32 {
        let Some(value) = number else {
            self.missing += 1;
            return f32::NAN;
        };
        self.known += 1;
        self.range = [self.range[0].min(value), self.range[1].max(value)];
        match self.declared.kind {
            GridKind::LandMask => {
                if value != 0.0 && value != f64::from(LAND) {
                    self.odd.get_or_insert(value);
                }
                return value as f32;
            }
            _ if value.abs() > FARTHEST => {
                self.far.get_or_insert(value);
                self.many_far += 1;
            }
            _ => {}
        }
        if self.declared.kind == GridKind::Elevation { -value as f32 } else { value as f32 }
    }

    /// Whether the numbers read so far show that these are depths.
    fn is_plain(&self) -> bool {
        let [low, high] = self.range;
        let gap = self.missing > 0 || self.declared.open_sea;
        match self.declared.kind {
            GridKind::LandMask => self.known > 0,
            GridKind::Depth => high > 0.0 && (low <= 0.0 || gap),
            GridKind::Elevation => low < 0.0 && (high >= 0.0 || gap),
        }
    }

    /// The grid.
    pub fn finish(self) -> Result<Grid, Invalid> {
        self.check()?;
        let has_depth = self.declared.kind != GridKind::LandMask;
        Ok(Grid {
            crs: self.crs,
            has_depth,
            corner: self.header.corner,
            cell: self.header.cell,
            columns: self.header.columns,
            rows: self.header.rows,
            window: self.window,
            cells: Arc::from(self.kept),
            measured: has_depth.then_some(self.measured),
        })
    }

    fn check(&self) -> Result<(), Invalid> {
        let [low, high] = self.range;
        let range = format!("{low}..{high}");
        if self.known == 0 {
            return Err(Invalid::new("grid", "no cell with data", "cells with data", "export another area"));
        }
        if let Some(value) = self.odd {
            return Err(Invalid::new(
                "grid",
                format!("{value} among {range}"),
                "0 and 1 only in a land mask",
                "declare it as `depth` or `elevation`",
            ));
        }
        if let Some(value) = self.far {
            return Err(Invalid::new(
                "grid",
                format!("{value} in {} of {} cells", self.many_far, self.known + self.missing),
                format!("depths and heights of at most {FARTHEST} m"),
                "write cells without data as the NODATA_value, for instance with `gdal_translate -a_nodata -9999`",
            ));
        }
        self.check_sign(&range)
    }

    fn check_sign(&self, values: &str) -> Result<(), Invalid> {
        let [low, high] = self.range;
        let (all_land, all_deep) = match self.declared.kind {
            GridKind::LandMask => return Ok(()),
            GridKind::Depth => (high <= 0.0, low > 0.0),
            GridKind::Elevation => (low >= 0.0, high < 0.0),
        };
        let (name, other) = match self.declared.kind {
            GridKind::Depth => ("depth", "elevation"),
            _ => ("elevation", "depth"),
        };
        if all_land {
            let values = format!("{values}, all land as `{name}`");
            return Err(Invalid::new("grid", values, "some water", format!("declare it as `{other}`")));
        }
        if all_deep && self.missing == 0 && !self.declared.open_sea {
            let values = format!("{values}, all deep as `{name}`");
            let remedy = format!("declare it as `{other}`, or as open sea if it is");
            return Err(Invalid::new("grid", values, "some land, drying or missing cells", remedy));
        }
        Ok(())
    }
}

/// An array of cells without data, if it fits in the memory.
fn nothing([columns, rows]: [usize; 2], reading: &Reading) -> Result<Vec<f32>, Unread> {
    let size = format!("{columns} × {rows} cells around the area");
    let bytes = bytes_of(columns as f64 * rows as f64);
    let mut cells = Vec::new();
    let fits = bytes <= reading.bytes && cells.try_reserve_exact(columns.saturating_mul(rows)).is_ok();
    if !fits {
        return Err(Unread::TooLarge { found: size, bytes });
    }
    cells.resize(columns * rows, f32::NAN);
    Ok(cells)
}

// ESRI ASCII: grids as text, one line per row, from north to south.

/// Rows between two checks of the time limit.
const AT_ONCE: usize = 64;

impl Grid {
    /// Reads an ESRI ASCII grid: one line per row, from north to south. Such files state neither unit nor datum.
    ///
    /// # Errors
    /// A header without columns, rows, corner or cell size, or with a size that is not positive; rows or
    /// columns that differ from the header; values that are not finite numbers, unless the header declares
    /// them as no data; a land mask with values other than 0 and 1; depths that are all land, or all deep
    /// (unless declared open sea): the sign looks wrong; depths that no sea has, which mean no data; no data
    /// at all. Grids that exceed memory or time.
    pub fn from_ascii(text: &str, declared: &GridDeclaration, reading: &Reading) -> Result<Self, Unread> {
        let text = text.trim_start_matches('\u{feff}');
        let mut lines = text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()).peekable();
        let (header, word) = header(&mut lines)?;
        let crs = declared.crs.clone().ok_or_else(Crs::undeclared)?;
        let packing = Packing { missing: word.number(), ..Packing::default() };
        let (columns, rows) = (header.columns, header.rows);
        if columns.saturating_mul(rows) > text.len() {
            let size = format!("a file of {} bytes", text.len());
            return Err(shape("grid".to_owned(), size, format!("{columns} × {rows} values")).into());
        }
        let mut cells = Cells::new(header, crs, packing, declared, reading)?;
        let mut numbers = Vec::with_capacity(columns.min(text.len() / 2 + 1));
        let mut read = 0;
        for (number, line) in lines {
            if read % AT_ONCE == 0 {
                reading.check_time()?;
            }
            row(line, number, word, &mut numbers)?;
            check_columns(number, numbers.len(), columns)?;
            if read < rows {
                let row = rows - 1 - read;
                cells.take(&[0..columns, row..row + 1], numbers.iter().copied());
            }
            read += 1;
        }
        if read != rows {
            return Err(shape("grid".to_owned(), format!("{read} rows"), format!("{rows} rows")).into());
        }
        Ok(cells.finish()?)
    }
}

/// The numbers of a row.
fn row(line: &str, number: usize, word: MissingWord, numbers: &mut Vec<f64>) -> Result<(), Invalid> {
    numbers.clear();
    for token in line.split_ascii_whitespace() {
        numbers.push(match token.parse::<f64>() {
            Ok(value) if value.is_finite() => value,
            _ if word.is(token) => f64::NAN,
            _ => return Err(no_number(token, number)),
        });
    }
    Ok(())
}

fn no_number(token: &str, line: usize) -> Invalid {
    Invalid::new(
        format!("line {}", line + 1),
        format!("`{}`", refusal::foreign(token)),
        "finite numbers",
        "write cells without data as the NODATA_value, for instance with `gdal_translate -a_nodata -9999`",
    )
}

fn check_columns(number: usize, found: usize, columns: usize) -> Result<(), Invalid> {
    if found == columns {
        return Ok(());
    }
    let expected = format!("{columns} values, one line per row");
    Err(shape(format!("line {}", number + 1), format!("{found} values"), expected))
}

fn shape(thing: String, found: String, expected: String) -> Invalid {
    Invalid::new(thing, found, format!("{expected}, as the header says"), "export the whole file again")
}
