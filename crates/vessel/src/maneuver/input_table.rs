use crate::{DerivedChannel, Invalid, Model};

/// Reads the inputs of `model` from CSV text, a column per input and a row per sample; further columns are passed
/// over. Returns N × inputs, row-major.
///
/// # Errors
/// Missing columns (all named), a cell that is no finite number (line and column named), no row; a measured disturbance or a
/// derived channel that is something else than in a simulated trial.
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
    // Of every channel that has a column: its place among the channels, that of the column, its name.
    let channels = model.variables[3..].iter().map(|v| v.name.as_str()).enumerate();
    let columns: Vec<(usize, usize, &str)> =
        channels.filter_map(|(channel, name)| Some((channel, place(name)?, name))).collect();
    let mut inputs = Vec::new();
    let (mut found, mut expected) = (vec![0.0; model.exogenous()], vec![0.0; model.exogenous()]);
    for record in reader.records() {
        let record = record.map_err(not_csv)?;
        let line = record.position().map_or(0, csv::Position::line);
        for (channel, place, name) in &columns {
            found[*channel] = finite(&record[*place]).ok_or_else(|| bad_cell(line, name, &record[*place]))?;
        }
        expected[..model.inputs].copy_from_slice(&found[..model.inputs]);
        model.complete(&mut expected);
        for (channel, _, name) in &columns {
            let (found, expected) = (found[*channel], expected[*channel]);
            if !DerivedChannel::agrees(found, expected) {
                return Err(another(line, name, found, expected));
            }
        }
        inputs.extend_from_slice(&found[..model.inputs]);
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

/// A column that a simulated trial would not follow.
fn another(line: u64, column: &str, found: f64, expected: f64) -> Invalid {
    Invalid::new(
        format!("line {line}, column `{column}`"),
        found.to_string(),
        format!("{expected}, as the vessel's file has it in simulated trials"),
        "remove the column, or correct the definition in the vessel's file",
    )
}
