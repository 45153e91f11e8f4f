//! The table of tides that `plan.toml` names.

use std::path::Path;

use chart::route::Timestamp;
use files::{Digest, Error, Provenance};
use plan::voyage::{Task, Tide, TideRow, current_m_s};
use refusal::Invalid;
use ship::engine::MOST_CURRENT_M_S;

use super::file::PlanFile;
use super::task::second;

/// Columns of a table: time and height, and the stream if known.
const COLUMNS: [&str; 4] = ["time", "level_m", "stream_m_s", "towards_deg"];
/// Upper bound on a plausible tide level \[m\].
const MOST_LEVEL_M: f64 = 30.0;

/// `task` in the tide that `config` names, if it names one; the table's file is relative to `config_file`, and its digest is
/// noted.
///
/// # Errors
/// A table that cannot be read, is invalid, or does not cover the trial; a trial without departure or end.
pub fn in_tide(
    config_file: &Path,
    config: &PlanFile,
    task: Task,
    provenance: &mut Provenance,
) -> Result<Task, Error> {
    let Some(spec) = &config.tide else { return Ok(task) };
    let of_config = |invalid| Error::invalid(config_file, invalid);
    let Some(departure) = task.departure else {
        let remedy = "say when the trial begins, such as departure = \"2026-06-01T08:00:00Z\"";
        let expected = "a time, since there is a [tide]";
        return Err(Error::refuse(config_file, "`departure`", "none", expected, remedy));
    };
    let until = second("tide.until", &spec.until).map_err(of_config)?;
    if until <= departure {
        let expected = format!("a time after the departure, {}", in_words(departure as f64));
        let found = in_words(until as f64);
        return Err(Error::refuse(config_file, "`tide.until`", found, expected, "correct it"));
    }
    let path = config_file.parent().unwrap_or(Path::new("")).join(&spec.file);
    let bytes = files::read(&path)?;
    provenance.inputs.insert("tide".to_owned(), Digest::of_bytes(&bytes));
    let table = table(&bytes).map_err(|invalid| Error::invalid(&path, invalid))?;
    let tide = Tide::worst(&table, departure as f64, (until - departure) as f64).ok_or_else(|| {
        let [first, last] =
            [table.first(), table.last()].map(|row| in_words(row.map_or(0.0, |row| row.at_s)));
        let expected =
            format!("one that covers {} to {}", in_words(departure as f64), in_words(until as f64));
        let remedy = "take a longer table, or another `departure` or `until`";
        Error::refuse(&path, "table", format!("{first} to {last}"), expected, remedy)
    })?;
    Ok(task.with_tide(tide))
}

/// A time in seconds since 1970, in words.
pub(super) fn in_words(at_s: f64) -> String {
    Timestamp::from_second(at_s as i64).map_or_else(|_| format!("{at_s} s"), |at| at.to_string())
}

/// The rows of a table, whose times ascend.
fn table(bytes: &[u8]) -> Result<Vec<TideRow>, Invalid> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes);
    let header = reader.headers().map_err(no_table)?.clone();
    let place = |name: &str| header.iter().position(|own| own.trim_start_matches('\u{feff}') == name);
    let needed = |name: &str| {
        place(name).ok_or_else(|| {
            let found = header.iter().collect::<Vec<_>>().join(", ");
            let expected = "columns time, level_m, and stream_m_s, towards_deg where the stream is known";
            Invalid::new(format!("column `{name}`"), found, expected, "name the columns so in the first line")
        })
    };
    let stream = place(COLUMNS[2]).is_some() || place(COLUMNS[3]).is_some();
    let places = [Some(needed(COLUMNS[0])?), Some(needed(COLUMNS[1])?)].into_iter().chain(if stream {
        [Some(needed(COLUMNS[2])?), Some(needed(COLUMNS[3])?)]
    } else {
        [None, None]
    });
    let places: Vec<Option<usize>> = places.collect();
    let mut rows: Vec<TideRow> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(no_table)?;
        let line = record.position().map_or(0, csv::Position::line);
        let row = row(&record, &places, line)?;
        if rows.last().is_some_and(|last| last.at_s >= row.at_s) {
            let found = in_words(row.at_s);
            let expected = "a later time than in the line before";
            return Err(Invalid::new(format!("line {line}, `time`"), found, expected, "sort the table"));
        }
        rows.push(row);
    }
    Ok(rows)
}

fn row(record: &csv::StringRecord, places: &[Option<usize>], line: u64) -> Result<TideRow, Invalid> {
    let cell = |column: usize| places[column].map(|place| record.get(place).unwrap_or(""));
    let number = |column: usize, least: f64, most: f64| {
        let Some(text) = cell(column) else { return Ok(0.0) };
        let value = text.parse::<f64>().ok().filter(|value| (least..=most).contains(value));
        value.ok_or_else(|| {
            let expected = format!("a number from {least} to {most}");
            let thing = format!("line {line}, `{}`", COLUMNS[column]);
            Invalid::new(thing, format!("`{text}`"), expected, "correct it")
        })
    };
    let at_s = second(&format!("line {line}, time"), cell(0).unwrap_or(""))? as f64;
    let level_m = number(1, -MOST_LEVEL_M, MOST_LEVEL_M)?;
    let (speed, towards_deg) = (number(2, 0.0, MOST_CURRENT_M_S)?, number(3, 0.0, 360.0)?);
    Ok(TideRow { at_s, level_m, stream_m_s: current_m_s(speed, towards_deg) })
}

fn no_table(error: csv::Error) -> Invalid {
    Invalid::new("table", error.to_string(), "rows of as many cells as the first line", "export it again")
}
