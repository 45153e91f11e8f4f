//! Reads the files of a recording into runs.
//!
//! [`logs`] decodes text and bags from bytes; Parquet is decoded here, since the scientific crates do not depend on
//! tables.

use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::path::Path;
use std::sync::Arc;

use files::{Digest, Digesting, Error, ForeignTable, Scratch, Timed, exists, open};
use flate2::read::MultiGzDecoder;
use logs::{
    Cells, ClockNotes, Columns, Content, DatabaseFile, Format, Labels, Log, LogError, Moments, Numbering,
    Plan, Recorded, SNIFFED, Samples, Segmentation, Source, Store, TimeUnit, WantedColumn, begins_anew,
    foreign_format, places, read_bag, read_csv, read_database, read_nmea, record,
};
use refusal::{Invalid, foreign};

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
            let given = "bytes that gzip did not write, in a file called .gz";
            let plain = Invalid::new("format", given, "a file compressed with gzip", "rename it without .gz");
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
            let given = format!("changes in `{}` that are not in the file", foreign(&beside));
            let remedy =
                "the recorder did not end: `sqlite3 FILE 'PRAGMA wal_checkpoint(TRUNCATE)'` writes them";
            let invalid = Invalid::new("database", given, "a bag that is closed", remedy);
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
    let given = if cut { "an end within the compressed data".to_owned() } else { error.to_string() };
    Invalid::new("file", given, "a whole gzip file", "the file is truncated or damaged: copy it again")
}

// Logs in Parquet: the requested columns, and times by their types.

/// Reads the columns of the file at `path` that `plan` needs from group `group`; numbers are spilled to `store`.
fn parquet(path: &Path, plan: &Plan, group: usize, store: &Arc<dyn Store>) -> Result<Columns, Error> {
    let (table, wanted) = (ForeignTable::open(path)?, plan.wanted(group));
    let refused = |invalid| crate::invalid(path, &invalid);
    places(table.columns(), &wanted).map_err(refused)?;
    if table.rows() > plan.most_rows {
        return Err(refused(plan.too_many_rows(table.rows())));
    }
    let mut clock = ClockNotes::default();
    let mut column = |(place, w): (usize, &WantedColumn)| {
        let timed = table.timed(&w.column).filter(|_| place == 0);
        Ok::<_, Error>(match w.content {
            _ if timed.is_some() => {
                let of_type = TypedTime { path, table: &table, column: &w.column, plan, group };
                Cells::Numbers(of_type.seconds(timed, &mut clock, store)?)
            }
            Content::Labels => Cells::Labels(labels(&table, &w.column)?),
            Content::Dates => {
                Cells::Numbers(dates((path, &table), &w.column, (plan, group), &mut clock, store)?)
            }
            Content::Numbers => {
                let mut numbers = Samples::new(store);
                table.numbers(&w.column, |number| numbers.push(number))?;
                Cells::Numbers(numbers)
            }
        })
    };
    let cells = wanted.iter().enumerate().map(&mut column).collect::<Result<_, _>>()?;
    Ok(Columns { cells, lines: Numbering::of_rows(table.rows()), clock, ..Columns::default() })
}

fn labels(table: &ForeignTable, column: &str) -> Result<Labels, Error> {
    let mut labels = Labels::default();
    texts(table, column, |text| labels.push(text))?;
    Ok(labels)
}

/// A column of times whose type has a unit.
struct TypedTime<'a> {
    path: &'a Path,
    table: &'a ForeignTable,
    column: &'a str,
    plan: &'a Plan,
    group: usize,
}

impl TypedTime<'_> {
    fn seconds(
        &self,
        timed: Option<Timed>,
        clock: &mut ClockNotes,
        store: &Arc<dyn Store>,
    ) -> Result<Samples, Error> {
        let spec = &self.plan.setup.files[self.group].time;
        let refuse = |found: &str, expected: &str, remedy: &str| {
            let thing = format!("column `{}`", foreign(self.column));
            Err(crate::invalid(self.path, &Invalid::new(thing, found, expected, remedy)))
        };
        let (per_second, is_shown) = match timed {
            Some(Timed::Moments { per_second, is_utc }) => (per_second, !is_utc),
            Some(Timed::OfDay { per_second }) => {
                clock.of_day = true;
                (per_second, false)
            }
            Some(Timed::Days) | None => {
                return refuse("days without a time", "times", "write date and time into one column");
            }
        };
        let unit = match per_second {
            1000 => TimeUnit::Ms,
            1_000_000 => TimeUnit::Us,
            _ => TimeUnit::Ns,
        };
        if spec.format.is_some()
            || spec.nanoseconds.is_some()
            || ![Some(unit), Some(TimeUnit::Iso8601)].contains(&spec.unit)
        {
            let given = format!("times that are no text, in {unit:?} by their type").to_lowercase();
            let remedy = "set `unit = \"iso8601\"` in its `time`: the type says the rest";
            return refuse(&given, "the time's `unit` or `format` as it is stated", remedy);
        }
        let (mut seconds, mut wrong) = (Samples::new(store), None);
        // If a unit is stated, times are expected in it.
        let unit = spec.unit.and_then(TimeUnit::seconds).unwrap_or(1.0);
        let stamps = self.plan.stamps(self.group);
        self.table.seconds(self.column, |shown| {
            let known = if is_shown { stamps.shown(shown) } else { Ok(shown) };
            if let (Err(why), None) = (known, &wrong) {
                wrong = Some((seconds.len() + 1, shown, why));
            }
            seconds.push(known.unwrap_or(f64::NAN) / unit);
        })?;
        match wrong {
            None => Ok(seconds),
            Some((row, shown, why)) => {
                let shown = format!("{shown} s after 1970");
                let refused = stamps.refused(row, self.column, &shown, why, self.plan.setup.written_in);
                Err(crate::invalid(self.path, &refused))
            }
        }
    }
}

fn dates(
    (path, table): (&Path, &ForeignTable),
    column: &str,
    (plan, group): (&Plan, usize),
    clock: &mut ClockNotes,
    store: &Arc<dyn Store>,
) -> Result<Samples, Error> {
    let (mut seconds, mut wrong) = (Samples::new(store), None);
    let stamps = plan.stamps(group);
    let mut moments = Moments::new(stamps);
    texts(table, column, |text| {
        let known = moments.next(text);
        clock.fractions.see(text, '.');
        if let (Err(why), None) = (known, &wrong) {
            wrong = Some((seconds.len() + 1, text.to_owned(), why));
        }
        seconds.push(known.unwrap_or(f64::NAN));
    })?;
    clock.leap_s = moments.leap_s();
    match wrong {
        None => Ok(seconds),
        Some((row, found, why)) => {
            Err(crate::invalid(path, &stamps.refused(row, column, &found, why, plan.setup.written_in)))
        }
    }
}

/// Calls `each` with the texts of a column, or numbers as text: labels may be either.
fn texts(table: &ForeignTable, column: &str, mut each: impl FnMut(&str)) -> Result<(), Error> {
    let Err(refused) = table.texts(column, &mut each) else { return Ok(()) };
    let label = |n: f64| each(&if n.is_finite() { n.to_string() } else { String::new() });
    table.numbers(column, label).map_err(|_| refused)
}
