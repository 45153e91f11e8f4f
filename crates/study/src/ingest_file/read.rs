//! Reads the files of a recording into runs.
//!
//! [`logs`] decodes text and bags from bytes; Parquet is decoded here, since the scientific crates do not depend on
//! tables.

use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::path::Path;
use std::sync::Arc;

use files::{Digest, Digesting, Error, Scratch, exists, open};
use flate2::read::MultiGzDecoder;
use logs::{
    Columns, DatabaseFile, Format, Log, LogError, Plan, Recorded, SNIFFED, Segmentation, Source, Store,
    TimeUnit, begins_anew, foreign_format, read_bag, read_csv, read_database, read_nmea, record,
};
use refusal::{Invalid, foreign};

use super::tables::parquet;

/// Stores blocks of long channels.
#[derive(Debug)]
struct Aside(Arc<Scratch>);

impl Store for Aside {
    fn block(&self) -> usize {
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

/// Reads the files of `source` in `folder` into runs, and returns the files' digests. Data that does not fit in
/// memory is spilled to `scratch`.
///
/// # Errors
/// Files that cannot be read; what [`read_csv`], [`read_nmea`], [`read_bag`], [`Log::new`] and [`record`] refuse;
/// channels that cannot be spilled.
pub fn recorded(
    plan: &Plan,
    segmentation: &Segmentation,
    folder: &Path,
    source: &Source,
    scratch: &Arc<Scratch>,
) -> Result<(Recorded, Vec<Digest>), Error> {
    let store: Arc<dyn Store> = Arc::new(Aside(Arc::clone(scratch)));
    let recorded = of_files(plan, segmentation, folder, source, &store);
    // Checked first, since a refusal may be due to a failed spill.
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
    for (group, parts) in source.files.iter().enumerate() {
        if parts.is_empty() {
            logs.push(Log::absent(group, plan));
            continue;
        }
        let mut read = Vec::with_capacity(parts.len());
        for name in parts {
            let (columns, digest) = columns(&folder.join(name), plan, group, store)?;
            read.push((name.as_str(), columns));
            digests.push(digest);
        }
        let path = if let [only] = parts.as_slice() { folder.join(only) } else { folder.to_owned() };
        let columns = joined(read, plan, group);
        if columns.lines.rows() > plan.most_rows {
            return Err(crate::invalid(&path, &plan.too_many_rows(columns.lines.rows())));
        }
        logs.push(Log::new(columns, group, plan).map_err(|e| crate::invalid(&path, &e))?);
    }
    let first = source.files.iter().flatten().next().map_or("", String::as_str);
    let recorded = record(source, logs, plan, segmentation);
    Ok((recorded.map_err(|e| crate::invalid(&folder.join(first), &e))?, digests))
}

/// The rows of a recording's files, concatenated in the order of their names, or of their times if these contradict.
fn joined(mut parts: Vec<(&str, Columns)>, plan: &Plan, group: usize) -> Columns {
    let unit = plan.setup.files[group].time.unit.and_then(TimeUnit::seconds).unwrap_or(1.0);
    let follows = |parts: &[(&str, Columns)]| {
        let spans: Vec<[f64; 2]> = parts.iter().filter_map(|(_, columns)| columns.span()).collect();
        let steps = spans.windows(2).map(|pair| unit * (pair[1][0] - pair[0][1]));
        steps.into_iter().all(|step| step >= 0.0 || begins_anew(step, plan.setup.max_gap_s))
    };
    // Times of day restart at midnight and so cannot contradict names.
    let of_day = parts.iter().any(|(_, columns)| columns.clock.of_day);
    if parts.len() > 1 && !of_day && !follows(&parts) {
        let first = |columns: &Columns| columns.span().map_or(f64::INFINITY, |[first, _]| first);
        let mut sorted: Vec<usize> = (0..parts.len()).collect();
        sorted.sort_by(|a, b| first(&parts[*a].1).total_cmp(&first(&parts[*b].1)));
        let mut taken: Vec<Option<(&str, Columns)>> = parts.into_iter().map(Some).collect();
        parts = sorted.into_iter().filter_map(|place| taken[place].take()).collect();
    }
    let several = parts.len() > 1;
    let mut all =
        parts.into_iter().map(|(name, columns)| if several { columns.of_part(name) } else { columns });
    let first = all.next().unwrap_or_default();
    all.fold(first, |mut all, part| {
        all.append(part);
        all
    })
}

/// Refuses the file at `path` if its first bytes, packed or not, show another format than `format`, by the name of that, and
/// what is not a file. `is_from_top`: no lines are skipped.
///
/// # Errors
/// Such a file, or one that cannot be read.
pub fn check_format(path: &Path, format: Format, is_from_top: bool) -> Result<(), Error> {
    let unreadable = |e| Error::io(path, "read", e);
    let most = SNIFFED as u64;
    let mut head = Vec::new();
    open(path)?.take(most).read_to_end(&mut head).map_err(unreadable)?;
    if path.extension().is_some_and(|end| end == "gz") && !head.is_empty() {
        if !head.starts_with(&[0x1F, 0x8B]) {
            let found = "bytes that gzip did not write, in a file called .gz";
            let plain = Invalid::new("format", found, "a file compressed with gzip", "rename it without .gz");
            return Err(crate::invalid(path, &foreign_format(&head, format, is_from_top).unwrap_or(plain)));
        }
        let mut text = Vec::new();
        // Damage is reported when the file is read.
        let _ = MultiGzDecoder::new(head.as_slice()).take(most).read_to_end(&mut text);
        head = text;
    }
    foreign_format(&head, format, is_from_top).map_or(Ok(()), |invalid| Err(crate::invalid(path, &invalid)))
}

fn columns(
    path: &Path,
    plan: &Plan,
    group: usize,
    store: &Arc<dyn Store>,
) -> Result<(Columns, Digest), Error> {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let spec = &plan.setup.files[group];
    let format = spec.format_of(name);
    check_format(path, format, spec.skip_lines == 0)?;
    if format == Format::Parquet {
        return Ok((parquet(path, plan, group, store)?, Digest::of_file(path)?));
    }
    if format == Format::Db3 {
        let columns = read_database(&database(path)?, plan, group, Some(store));
        return Ok((columns.map_err(|error| refused(path, error))?, Digest::of_file(path)?));
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
        Format::Mcap | Format::Bag | Format::Ulg => read_bag(&mut bytes, format, plan, group, Some(store)),
        Format::Csv | Format::Parquet | Format::Db3 => read_csv(&mut bytes, length, plan, group, Some(store)),
    };
    // What is packed has a checksum at its end, behind the last row.
    let columns = columns.and_then(|columns| Ok((columns, io::copy(&mut bytes, &mut io::sink())?)));
    let (columns, _) = columns.map_err(|error| refused(path, error))?;
    drop(bytes);
    Ok((columns, source.digest().map_err(unreadable)?))
}

fn refused(path: &Path, error: LogError) -> Error {
    match error {
        LogError::Unreadable(error) if is_damage(&error) => crate::invalid(path, &damaged(&error)),
        LogError::Unreadable(error) => Error::io(path, "read", error),
        LogError::Invalid(invalid) => crate::invalid(path, &invalid),
    }
}

/// The SQLite file at `path`; refuses one that has changes in a file of its own beside it, and one that is compressed.
///
/// # Errors
/// These; a file that cannot be opened.
pub fn database(path: &Path) -> Result<DatabaseFile, Error> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    if name.ends_with(".gz") {
        let expected = "a bag of ROS 2 in SQLite that is not compressed";
        let invalid = Invalid::new("format", "a bag in a file called .gz", expected, "unpack it: `gunzip`");
        return Err(crate::invalid(path, &invalid));
    }
    let unreadable = |e| Error::io(path, "read", e);
    let bytes = open(path)?.metadata().map_err(unreadable)?.len();
    // Changes stand beside the file, not beside a link to it.
    let real = path.canonicalize().map_err(unreadable)?;
    for end in ["-wal", "-journal"] {
        let mut beside = real.clone().into_os_string();
        beside.push(end);
        let beside = Path::new(&beside);
        if exists(beside) && beside.metadata().is_ok_and(|changes| changes.len() > 0) {
            let beside = beside.file_name().unwrap_or_default().to_string_lossy();
            let found = format!("changes in `{}` that are not in the file", foreign(&beside));
            let remedy =
                "the recorder did not end: `sqlite3 FILE 'PRAGMA wal_checkpoint(TRUNCATE)'` writes them";
            let invalid = Invalid::new("database", found, "a bag that is closed", remedy);
            return Err(crate::invalid(path, &invalid));
        }
    }
    let plain = |byte: &u8| match byte.is_ascii_alphanumeric() {
        true => char::from(*byte).to_string(),
        false => format!("%{byte:02X}"),
    };
    let address = real.as_os_str().as_encoded_bytes().iter().map(plain).collect();
    Ok(DatabaseFile { address, bytes })
}

/// Whether the bytes are damaged, and not the disk, whose errors have an OS error number.
fn is_damage(error: &std::io::Error) -> bool {
    error.raw_os_error().is_none()
}

fn damaged(error: &std::io::Error) -> Invalid {
    let cut = error.kind() == ErrorKind::UnexpectedEof;
    let found = if cut { "an end within the compressed data".to_owned() } else { error.to_string() };
    Invalid::new("file", found, "a whole gzip file", "the file is truncated or damaged: copy it again")
}
