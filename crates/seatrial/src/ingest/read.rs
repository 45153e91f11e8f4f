//! The files of a recording to its runs.
//!
//! CSV is decoded by [`logs`], which needs no more than bytes; Parquet here, for the sciences know no tables.

use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind};
use std::path::Path;

use artifact::{Digest, Error, ForeignTable};
use flate2::read::MultiGzDecoder;
use logs::{
    Cells, Columns, CsvError, Log, Plan, Recorded, Segmentation, Source, Wanted, places, read_csv, record,
};
use refusal::Invalid;

use crate::failure::Failure;

/// Reads the files of `source`, which stand in `folder`, and makes runs of them; also the files' digests.
///
/// # Errors
/// Files that cannot be read; what [`read_csv`], [`Log::new`] and [`record`] refuse.
pub fn recorded(
    plan: &Plan,
    segmentation: &Segmentation,
    folder: &Path,
    source: &Source,
) -> Result<(Recorded, Vec<(String, Digest)>), Failure> {
    let mut logs = Vec::with_capacity(source.files.len());
    let mut digests = Vec::with_capacity(source.files.len());
    for (group, name) in source.files.iter().enumerate() {
        let path = folder.join(name);
        let columns = columns(&path, plan, group)?;
        let log = Log::new(&columns, group, plan);
        logs.push(log.map_err(|e| Failure::invalid(&path, &e))?);
        digests.push((format!("log:{name}"), Digest::of_file(&path)?));
    }
    let recorded = record(source, logs, plan, segmentation)
        .map_err(|e| Failure::invalid(&folder.join(&source.files[0]), &e))?;
    Ok((recorded, digests))
}

fn columns(path: &Path, plan: &Plan, group: usize) -> Result<Columns, Failure> {
    let extension = path.extension().and_then(|extension| extension.to_str());
    if let Some("parquet" | "parq" | "pq") = extension {
        return parquet(path, &plan.wanted(group));
    }
    const BUFFER: usize = 1 << 18;
    let file = File::open(path).map_err(|e| Error::io(path, "read", e))?;
    let bytes: Box<dyn BufRead> = match extension {
        Some("gz") => Box::new(BufReader::with_capacity(BUFFER, MultiGzDecoder::new(file))),
        _ => Box::new(BufReader::with_capacity(BUFFER, file)),
    };
    read_csv(bytes, plan, group).map_err(|error| match error {
        CsvError::Unreadable(error) if is_damage(&error) => Failure::invalid(path, &damaged(&error)),
        CsvError::Unreadable(error) => Error::io(path, "read", error).into(),
        CsvError::Invalid(invalid) => Failure::invalid(path, &invalid),
    })
}

/// Whether the bytes are at fault and not the disk.
fn is_damage(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::UnexpectedEof | ErrorKind::InvalidData | ErrorKind::InvalidInput)
}

fn damaged(error: &std::io::Error) -> Invalid {
    let cut = error.kind() == ErrorKind::UnexpectedEof;
    let found = if cut { "an end within the compressed data".to_owned() } else { error.to_string() };
    Invalid::new("file", found, "a whole gzip file", "the file is truncated or damaged: copy it again")
}

fn parquet(path: &Path, wanted: &[Wanted]) -> Result<Columns, Failure> {
    let table = ForeignTable::open(path)?;
    places(table.columns(), wanted).map_err(|e| Failure::invalid(path, &e))?;
    let column = |w: &Wanted| {
        Ok::<_, Failure>(match w.text {
            true => Cells::Texts(texts(&table, &w.column)?),
            false => Cells::Numbers(table.numbers(&w.column)?),
        })
    };
    let cells = wanted.iter().map(column).collect::<Result<_, _>>()?;
    Ok(Columns { cells, lines: (1..=table.rows()).collect(), empty_rows: 0, cut_rows: 0 })
}

/// Texts, or numbers as text: labels may be either.
fn texts(table: &ForeignTable, column: &str) -> Result<Vec<String>, Failure> {
    let refused = match table.texts(column) {
        Ok(texts) => return Ok(texts),
        Err(refused) => refused,
    };
    let label = |n: &f64| if n.is_finite() { n.to_string() } else { String::new() };
    table.numbers(column).map(|numbers| numbers.iter().map(label).collect()).map_err(|_| refused.into())
}
