//! The files of a recording to its runs.
//!
//! Text and bags are decoded by [`logs`], which needs no more than bytes; Parquet here, for the sciences know no tables.

use std::io::{BufRead, BufReader, ErrorKind};
use std::path::Path;
use std::sync::Arc;

use artifact::{Digest, Digesting, Error, ForeignTable, Scratch, open};
use flate2::read::MultiGzDecoder;
use logs::{
    Cells, Columns, Content, Format, Labels, Log, LogError, Numbering, Plan, Recorded, Samples, Segmentation,
    Source, Stamps, Store, Wanted, places, read_bag, read_csv, read_nmea, record,
};
use refusal::Invalid;

/// Where pieces of long channels are put aside.
#[derive(Debug)]
struct Aside(Arc<Scratch>);

impl Store for Aside {
    fn piece(&self) -> usize {
        self.0.length()
    }

    fn put(&self, values: &[f64]) -> u64 {
        self.0.put(values)
    }

    fn get(&self, place: u64, values: &mut Vec<f64>) {
        self.0.get(place, values);
    }

    fn forget(&self, place: u64) {
        self.0.forget(place);
    }
}

/// Reads the files of `source`, which stand in `folder`, and makes runs of them; and the files' digests. What there is no
/// room for in memory is put aside in `scratch`.
///
/// # Errors
/// Files that cannot be read; what [`read_csv`], [`read_nmea`], [`read_bag`], [`Log::new`] and [`record`] refuse; channels that cannot be put aside.
pub fn recorded(
    plan: &Plan,
    segmentation: &Segmentation,
    folder: &Path,
    source: &Source,
    scratch: &Arc<Scratch>,
) -> Result<(Recorded, Vec<Digest>), Error> {
    let store: Arc<dyn Store> = Arc::new(Aside(Arc::clone(scratch)));
    let recorded = of_files(plan, segmentation, folder, source, &store);
    // First: what is refused may be what could not be kept.
    scratch.check()?;
    recorded
}

fn of_files(
    plan: &Plan,
    segmentation: &Segmentation,
    folder: &Path,
    source: &Source,
    store: &Arc<dyn Store>,
) -> Result<(Recorded, Vec<Digest>), Error> {
    let (mut logs, mut digests) = (Vec::with_capacity(source.files.len()), Vec::new());
    for (group, name) in source.files.iter().enumerate() {
        let path = folder.join(name);
        let (columns, digest) = columns(&path, plan, group, store)?;
        logs.push(Log::new(columns, group, plan).map_err(|e| crate::invalid(&path, &e))?);
        digests.push(digest);
    }
    let recorded = record(source, logs, plan, segmentation);
    Ok((recorded.map_err(|e| crate::invalid(&folder.join(&source.files[0]), &e))?, digests))
}

fn columns(
    path: &Path,
    plan: &Plan,
    group: usize,
    store: &Arc<dyn Store>,
) -> Result<(Columns, Digest), Error> {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let format = plan.setup.files[group].format_of(name);
    if format == Format::Parquet {
        return Ok((parquet(path, plan, group, store)?, Digest::of_file(path)?));
    }
    let unreadable = |e| Error::io(path, "read", e);
    const BUFFER: usize = 1 << 18;
    let file = open(path)?;
    let length = file.metadata().map_err(unreadable)?.len();
    let mut source = Digesting::new(file);
    let (mut bytes, length): (Box<dyn BufRead>, _) = match name.ends_with(".gz") {
        true => (Box::new(BufReader::with_capacity(BUFFER, MultiGzDecoder::new(&mut source))), None),
        false => (Box::new(BufReader::with_capacity(BUFFER, &mut source)), Some(length)),
    };
    let columns = match format {
        Format::Nmea => read_nmea(&mut bytes, plan, group, Some(store)),
        Format::Mcap => read_bag(&mut bytes, plan, group, Some(store)),
        Format::Csv | Format::Parquet => read_csv(&mut bytes, length, plan, group, Some(store)),
    };
    let columns = columns.map_err(|error| match error {
        LogError::Unreadable(error) if is_damage(&error) => crate::invalid(path, &damaged(&error)),
        LogError::Unreadable(error) => unreadable(error),
        LogError::Invalid(invalid) => crate::invalid(path, &invalid),
    })?;
    drop(bytes);
    Ok((columns, source.digest().map_err(unreadable)?))
}

/// Whether the bytes are at fault and not the disk, whose errors have a number of the system.
fn is_damage(error: &std::io::Error) -> bool {
    error.raw_os_error().is_none()
}

fn damaged(error: &std::io::Error) -> Invalid {
    let cut = error.kind() == ErrorKind::UnexpectedEof;
    let found = if cut { "an end within the compressed data".to_owned() } else { error.to_string() };
    Invalid::new("file", found, "a whole gzip file", "the file is truncated or damaged: copy it again")
}

fn parquet(path: &Path, plan: &Plan, group: usize, store: &Arc<dyn Store>) -> Result<Columns, Error> {
    let (table, wanted) = (ForeignTable::open(path)?, plan.wanted(group));
    let refused = |invalid| crate::invalid(path, &invalid);
    places(table.columns(), &wanted).map_err(refused)?;
    if table.rows() > plan.most_rows {
        return Err(refused(plan.too_many_rows(table.rows())));
    }
    let column = |w: &Wanted| {
        Ok::<_, Error>(match w.content {
            Content::Labels => Cells::Labels(labels(&table, &w.column)?),
            Content::Dates => {
                Cells::Numbers(dates((path, &table), &w.column, plan.stamps(group), plan, store)?)
            }
            Content::Numbers => {
                let mut numbers = Samples::new(store);
                table.numbers(&w.column, |number| numbers.push(number))?;
                Cells::Numbers(numbers)
            }
        })
    };
    let cells = wanted.iter().map(column).collect::<Result<_, _>>()?;
    Ok(Columns { cells, lines: Numbering::of_rows(table.rows()), ..Columns::default() })
}

fn labels(table: &ForeignTable, column: &str) -> Result<Labels, Error> {
    let mut labels = Labels::default();
    texts(table, column, |text| labels.push(text))?;
    Ok(labels)
}

fn dates(
    (path, table): (&Path, &ForeignTable),
    column: &str,
    stamps: &Stamps,
    plan: &Plan,
    store: &Arc<dyn Store>,
) -> Result<Samples, Error> {
    let (mut seconds, mut wrong) = (Samples::new(store), None);
    texts(table, column, |text| {
        let known = stamps.seconds(text);
        if let (Err(why), None) = (known, &wrong) {
            wrong = Some((seconds.len() + 1, text.to_owned(), why));
        }
        seconds.push(known.unwrap_or(f64::NAN));
    })?;
    match wrong {
        None => Ok(seconds),
        Some((row, found, why)) => {
            Err(crate::invalid(path, &stamps.refused(row, column, &found, why, plan.setup.written_in)))
        }
    }
}

/// Gives `each` the texts of a column, or numbers as text: labels may be either.
fn texts(table: &ForeignTable, column: &str, mut each: impl FnMut(&str)) -> Result<(), Error> {
    let Err(refused) = table.texts(column, &mut each) else { return Ok(()) };
    let label = |n: f64| each(&if n.is_finite() { n.to_string() } else { String::new() });
    table.numbers(column, label).map_err(|_| refused)
}
