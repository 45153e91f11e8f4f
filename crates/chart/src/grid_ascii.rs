//! ESRI ASCII: grids as text, one line per row, from north to south.

use crate::grid_cells::Cells;
use crate::grid_header::{MissingWord, header};
use crate::grid_packing::Packing;
use crate::{Crs, Grid, GridDeclaration, Invalid, Reading, Unread};

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
            let found = format!("a file of {} bytes", text.len());
            return Err(shape("grid".to_owned(), found, format!("{columns} × {rows} values")).into());
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
