use crate::{Invalid, Model};

/// Reads the inputs of `model` from CSV text, a column per input and a row per sample; further columns are passed
/// over. Returns N × inputs, row-major.
///
/// # Errors
/// Missing columns (all named), a cell that is no finite number (line and column named), no row.
pub fn parse_inputs(text: &str, model: &Model) -> Result<Vec<f64>, Invalid> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let header = reader.headers().map_err(not_csv)?.clone();
    let wanted = model.input_names();
    let place = |name: &str| header.iter().position(|h| h.trim_start_matches('\u{feff}') == name);
    let missing: Vec<&str> = wanted.iter().filter(|w| place(w).is_none()).copied().collect();
    if !missing.is_empty() {
        return Err(Invalid::new(
            "header",
            format!("no column {}", missing.join(", ")),
            format!("a column per input: {}", wanted.join(", ")),
            "add the columns (separated by commas)",
        ));
    }
    let places: Vec<(usize, &str)> = wanted.iter().filter_map(|w| place(w).map(|p| (p, *w))).collect();
    let mut inputs = Vec::new();
    for record in reader.records() {
        let record = record.map_err(not_csv)?;
        let line = record.position().map_or(0, csv::Position::line);
        for (place, name) in &places {
            inputs.push(finite(&record[*place]).ok_or_else(|| bad_cell(line, name, &record[*place]))?);
        }
    }
    if inputs.is_empty() {
        return Err(Invalid::new("rows", "none", "a row per sample", "add rows"));
    }
    Ok(inputs)
}

fn finite(cell: &str) -> Option<f64> {
    cell.parse::<f64>().ok().filter(|x| x.is_finite())
}

fn not_csv(error: csv::Error) -> Invalid {
    Invalid::new(
        "table",
        error.to_string(),
        "CSV with a header and as many cells in every row",
        "correct the file",
    )
}

fn bad_cell(line: u64, column: &str, cell: &str) -> Invalid {
    let found = if cell.is_empty() { "nothing".to_owned() } else { format!("`{cell}`") };
    Invalid::new(format!("line {line}, column `{column}`"), found, "a finite number", "correct the cell")
}
