use refusal::{Invalid, nearest};

/// A column that is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
    /// Its name.
    pub column: String,
    /// Whether it holds text.
    pub text: bool,
}

/// The values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// NaN where there is no value.
    Numbers(Vec<f64>),
    /// Empty where there is none.
    Texts(Vec<String>),
}

/// The columns of a file as asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// In the order asked for.
    pub cells: Vec<Cells>,
    /// Line (CSV) or row (Parquet) of every row, from 1.
    pub lines: Vec<usize>,
    /// Rows without any value, left out.
    pub empty_rows: usize,
    /// Rows cut short at the end of the file, left out.
    pub cut_rows: usize,
}

/// What messages call a cell.
pub(crate) fn cell_of(line: usize, column: &str) -> String {
    format!("line {line}, column `{column}`")
}

/// The place of each wanted column in `header`.
///
/// # Errors
/// Names all columns that are missing at once.
pub fn places(header: &[String], wanted: &[Wanted]) -> Result<Vec<usize>, Invalid> {
    let place = |wanted: &Wanted| header.iter().position(|column| *column == wanted.column);
    let places: Vec<usize> = wanted.iter().filter_map(place).collect();
    if places.len() == wanted.len() {
        return Ok(places);
    }
    let mut missing: Vec<&str> = Vec::new();
    for Wanted { column, .. } in wanted {
        if !header.contains(column) && !missing.contains(&column.as_str()) {
            missing.push(column);
        }
    }
    let remedy = |column: &&str| match nearest(column, header.iter().map(String::as_str)) {
        Some(near) => format!("did you mean `{near}` instead of `{column}`?"),
        None => format!("add `{column}`"),
    };
    Err(Invalid::new(
        if missing.len() == 1 { "column" } else { "columns" },
        format!("no `{}`", missing.join("`, `")),
        format!("columns among `{}`", header.join("`, `")),
        missing.iter().map(remedy).collect::<Vec<_>>().join(" "),
    ))
}
