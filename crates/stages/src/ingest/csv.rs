//! CSV files as text: the columns that are asked for.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::load::{Cells, Raw, Wanted, missing_columns};
use crate::failure::Failure;

/// What stands for no value.
const NOTHING: [&str; 8] = ["", "nan", "na", "n/a", "null", "inf", "+inf", "-inf"];

/// Reads the `wanted` columns of a CSV file with a header, compressed where its name ends in `.gz`.
///
/// # Errors
/// A file that cannot be read or is cut short, missing columns (all at once), a cell that is no number, a row that is too
/// long or too short. The last row may be too short: then it is left out and counted.
pub fn read(path: &Path, separator: char, wanted: &[Wanted]) -> Result<Raw, Failure> {
    let text = text_of(path)?;
    let mut lines = text.lines().enumerate();
    let header = lines.next().map(|(_, line)| cells(line.trim_start_matches('\u{feff}'), separator));
    let header: Vec<String> = header.unwrap_or_default().iter().map(|cell| cell.trim().to_owned()).collect();
    let places = places(path, &header, wanted)?;
    let mut raw = Raw::new(wanted);
    let mut lines = lines.peekable();
    while let Some((number, line)) = lines.next() {
        let row = cells(line, separator);
        if row.iter().all(|cell| cell.trim().is_empty()) {
            raw.empty_rows += 1;
        } else if row.len() == header.len() {
            raw.lines.push(number + 1);
            for (i, place) in places.iter().enumerate() {
                push(&mut raw.columns[i], &row[*place])
                    .map_err(|found| no_number(path, number + 1, &header[*place], &found))?;
            }
        } else if row.len() < header.len() && lines.peek().is_none() {
            raw.cut_rows += 1;
        } else {
            return Err(Failure::refuse(
                path,
                &format!("line {}", number + 1),
                &format!("{} cells", row.len()),
                &format!("{}, as in the header", header.len()),
                "correct the line, or `separator` in ingest.toml",
            ));
        }
    }
    Ok(raw)
}

fn push(cells: &mut Cells, cell: &str) -> Result<(), String> {
    let cell = cell.trim();
    match cells {
        Cells::Texts(texts) => texts.push(cell.to_owned()),
        Cells::Numbers(numbers) => match cell.parse::<f64>() {
            Ok(number) => numbers.push(number),
            Err(_) if NOTHING.contains(&cell.to_ascii_lowercase().as_str()) => numbers.push(f64::NAN),
            Err(_) => return Err(cell.to_owned()),
        },
    }
    Ok(())
}

fn no_number(path: &Path, line: usize, column: &str, found: &str) -> Failure {
    let comma = found.replacen(',', ".", 1).parse::<f64>().is_ok();
    let remedy = if comma { "export with decimal points" } else { "correct the cell or leave it empty" };
    Failure::refuse(
        path,
        &format!("line {line}, column `{column}`"),
        &format!("`{found}`"),
        "a number",
        remedy,
    )
}

fn places(path: &Path, header: &[String], wanted: &[Wanted]) -> Result<Vec<usize>, Failure> {
    let place = |wanted: &Wanted| header.iter().position(|column| *column == wanted.column);
    let places: Vec<Option<usize>> = wanted.iter().map(place).collect();
    if places.contains(&None) {
        return Err(missing_columns(path, header, wanted));
    }
    Ok(places.into_iter().flatten().collect())
}

/// The cells of a line; a cell in quotes may contain the separator, and quotes written twice.
fn cells(line: &str, separator: char) -> Vec<std::borrow::Cow<'_, str>> {
    if !line.contains('"') {
        return line.split(separator).map(Into::into).collect();
    }
    let mut cells = vec![String::new()];
    let mut quoted = false;
    let mut characters = line.chars().peekable();
    while let Some(c) = characters.next() {
        let last = cells.len() - 1;
        match c {
            '"' if quoted && characters.peek() == Some(&'"') => {
                characters.next();
                cells[last].push('"');
            }
            '"' => quoted = !quoted,
            c if c == separator && !quoted => cells.push(String::new()),
            c => cells[last].push(c),
        }
    }
    cells.into_iter().map(Into::into).collect()
}

fn text_of(path: &Path) -> Result<String, Failure> {
    let unreadable = |e| Failure::from(artifact::Error::io(path, "read", e));
    let mut bytes = Vec::new();
    let mut file = File::open(path).map_err(unreadable)?;
    if path.extension().is_some_and(|extension| extension == "gz") {
        MultiGzDecoder::new(file).read_to_end(&mut bytes).map_err(|e| damaged(path, e))?;
    } else {
        file.read_to_end(&mut bytes).map_err(unreadable)?;
    }
    String::from_utf8(bytes).map_err(|e| {
        let line = 1 + e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|b| **b == b'\n').count();
        let found = format!("a byte that is not UTF-8 (line {line})");
        Failure::refuse(path, "text", &found, "UTF-8 text", "save the file as UTF-8")
    })
}

fn damaged(path: &Path, error: std::io::Error) -> Failure {
    use std::io::ErrorKind::{InvalidData, InvalidInput, UnexpectedEof};
    let found = match error.kind() {
        UnexpectedEof => "an end within the compressed data".to_owned(),
        InvalidData | InvalidInput => error.to_string(),
        _ => return artifact::Error::io(path, "read", error).into(),
    };
    Failure::refuse(
        path,
        "file",
        &found,
        "a whole gzip file",
        "the file is truncated or damaged: copy it again",
    )
}
