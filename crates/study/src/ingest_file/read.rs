//! The files of a recording to its runs.
//!
//! CSV is decoded by [`logs`], which needs no more than bytes; Parquet here, for the sciences know no tables.

use std::cell::RefCell;
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind};
use std::path::Path;
use std::sync::Arc;

use artifact::{Digest, Digesting, Error, ForeignTable};
use flate2::read::MultiGzDecoder;
use logs::{
    Cells, Columns, Content, CsvError, Log, Plan, Recorded, Segmentation, Source, Wanted, no_date, places,
    read_csv, record, seconds_of,
};
use refusal::Invalid;

/// Reads the files of `source`, which stand in `folder`, and makes runs of them; and the files' digests.
///
/// # Errors
/// Files that cannot be read; what [`read_csv`], [`Log::new`] and [`record`] refuse.
pub fn recorded(
    plan: &Plan,
    segmentation: &Segmentation,
    folder: &Path,
    source: &Source,
) -> Result<(Recorded, Vec<Digest>), Error> {
    let (mut logs, mut digests) = (Vec::with_capacity(source.files.len()), Vec::new());
    for (group, name) in source.files.iter().enumerate() {
        let path = folder.join(name);
        let (columns, digest) = columns(&path, plan, group)?;
        logs.push(Log::new(columns, group, plan).map_err(|e| crate::invalid(&path, &e))?);
        digests.push(digest);
    }
    let recorded = record(source, logs, plan, segmentation);
    Ok((recorded.map_err(|e| crate::invalid(&folder.join(&source.files[0]), &e))?, digests))
}

fn columns(path: &Path, plan: &Plan, group: usize) -> Result<(Columns, Digest), Error> {
    let extension = path.extension().and_then(|extension| extension.to_str());
    if let Some("parquet" | "parq" | "pq") = extension {
        return Ok((parquet(path, plan, group)?, Digest::of_file(path)?));
    }
    let unreadable = |e| Error::io(path, "read", e);
    const BUFFER: usize = 1 << 18;
    let file = File::open(path).map_err(unreadable)?;
    let length = file.metadata().map_err(unreadable)?.len();
    let mut source = Digesting::new(file);
    let (bytes, length): (Box<dyn BufRead>, _) = match extension {
        Some("gz") => (Box::new(BufReader::with_capacity(BUFFER, MultiGzDecoder::new(&mut source))), None),
        _ => (Box::new(BufReader::with_capacity(BUFFER, &mut source)), Some(length)),
    };
    let columns = read_csv(bytes, length, plan, group).map_err(|error| match error {
        CsvError::Unreadable(error) if is_damage(&error) => crate::invalid(path, &damaged(&error)),
        CsvError::Unreadable(error) => unreadable(error),
        CsvError::Invalid(invalid) => crate::invalid(path, &invalid),
    })?;
    Ok((columns, source.digest().map_err(unreadable)?))
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

fn parquet(path: &Path, plan: &Plan, group: usize) -> Result<Columns, Error> {
    let (table, wanted) = (ForeignTable::open(path)?, plan.wanted(group));
    let refused = |invalid| crate::invalid(path, &invalid);
    places(table.columns(), &wanted).map_err(refused)?;
    if table.rows() > plan.most_rows {
        return Err(refused(plan.too_many_rows(table.rows())));
    }
    let column = |w: &Wanted| {
        Ok::<_, Error>(match w.content {
            Content::Labels => Cells::Labels(labels(&table, &w.column)?),
            Content::Dates => Cells::Numbers(dates(path, &table, &w.column, plan)?),
            Content::Numbers => Cells::Numbers(table.numbers(&w.column)?),
        })
    };
    let cells = wanted.iter().map(column).collect::<Result<_, _>>()?;
    Ok(Columns { cells, lines: (1..=table.rows() as u32).collect(), empty_rows: 0, cut_rows: 0 })
}

fn labels(table: &ForeignTable, column: &str) -> Result<Vec<Arc<str>>, Error> {
    let last = RefCell::new(Arc::<str>::from(""));
    texts(table, column, |text| {
        let mut last = last.borrow_mut();
        if **last != *text {
            *last = Arc::from(text);
        }
        Arc::clone(&last)
    })
}

fn dates(path: &Path, table: &ForeignTable, column: &str, plan: &Plan) -> Result<Vec<f64>, Error> {
    let seconds = texts(table, column, |text| seconds_of(text).unwrap_or(f64::INFINITY))?;
    let Some(row) = seconds.iter().position(|s| s.is_infinite()) else { return Ok(seconds) };
    let found = &texts(table, column, str::to_owned)?[row];
    Err(crate::invalid(path, &no_date(row + 1, column, found, plan.setup.written_in)))
}

/// What `made` makes of texts, or of numbers as text: labels may be either.
fn texts<V: Clone>(table: &ForeignTable, column: &str, made: impl Fn(&str) -> V) -> Result<Vec<V>, Error> {
    let refused = match table.texts(column, &made) {
        Ok(texts) => return Ok(texts),
        Err(refused) => refused,
    };
    let label = |n: &f64| made(&if n.is_finite() { n.to_string() } else { String::new() });
    table.numbers(column).map(|numbers| numbers.iter().map(label).collect()).map_err(|_| refused)
}
