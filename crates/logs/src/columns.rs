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

/// Columns that a file does not have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("no `{}` among `{}`", missing.join("`, `"), header.join("`, `"))]
pub struct MissingColumns {
    /// All that are missing, each once.
    pub missing: Vec<String>,
    /// Those that there are.
    pub header: Vec<String>,
}

/// The place of each wanted column in `header`.
///
/// # Errors
/// Names all columns that are missing at once.
pub fn places(header: &[String], wanted: &[Wanted]) -> Result<Vec<usize>, MissingColumns> {
    let place = |wanted: &Wanted| header.iter().position(|column| *column == wanted.column);
    let places: Vec<usize> = wanted.iter().filter_map(place).collect();
    if places.len() == wanted.len() {
        return Ok(places);
    }
    let mut missing: Vec<String> = Vec::new();
    for Wanted { column, .. } in wanted {
        if !header.contains(column) && !missing.contains(column) {
            missing.push(column.clone());
        }
    }
    Err(MissingColumns { missing, header: header.to_vec() })
}
