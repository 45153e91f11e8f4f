//! Bags in a folder of logs: what is in the first of them, and which are parts of one recording.

use std::fmt::Write;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use files::{Error, ForeignTable, Timed, budget, open};
use flate2::read::MultiGzDecoder;
use logs::by_motion::RECORDINGS;
use logs::guess::{BagGuess, Head, Needed, Placed, SentenceGuess};
use logs::{Format, LogError, Topic, bag_census, database_census, has_sentences, sentence_census};
use refusal::{foreign, listed};
use study::ingest_file::read::{check_format, database};
use study::{invalid, refuse};
use toml::Value;

use crate::failure::WorkProgress;

/// Endings of bags.
pub(super) const BAGS: [&str; 8] =
    [".mcap", ".mcap.gz", ".bag", ".bag.gz", ".bag.active", ".db3", ".ulg", ".ulg.gz"];

/// Bytes of bags that are looked at, beyond the first of them.
const MOST_BYTES: u64 = 1 << 30;

/// What is in `files` in `folder`, for a model that needs the channels `needed`: topics as in the first of them.
pub(super) fn guessed(
    folder: &Path,
    files: &[String],
    needed: &[Vec<Needed>],
    quiet: bool,
) -> Result<BagGuess, Error> {
    let (first, format) = (&files[0], Format::of(&files[0]));
    if let Some(other) = files.iter().find(|file| Format::of(file) != format) {
        let formats = format!("`{}` beside `{}`", foreign(other), foreign(first));
        let remedy =
            "name a folder with those of one format, or write ingest.toml yourself (docs/own-logs.md)";
        return Err(refuse(folder, "logs", &formats, "bags of one format", remedy));
    }
    let path = folder.join(first);
    let size = |file: &String| std::fs::metadata(folder.join(file)).map_or(0, |metadata| metadata.len());
    let mut longest: Vec<&String> = files[1..].iter().collect();
    longest.sort_by_key(|file| std::cmp::Reverse(size(file)));
    let mut left = MOST_BYTES;
    longest.retain(|file| {
        left = left.saturating_sub(size(file));
        left > 0
    });
    longest.truncate(RECORDINGS - 1);
    let progress = WorkProgress::new("logs", 1 + longest.len(), quiet);
    let recordings = [first].into_iter().chain(longest).map(|file| {
        let topics = topics(&folder.join(file), format);
        progress.advance(1);
        topics
    });
    let recordings = recordings.collect::<Result<Vec<_>, _>>()?;
    let of = |needed: &[Needed]| BagGuess::of(format, &recordings, needed);
    let guess = fewest(needed, of, |bag| bag.guess.missing.len());
    if guess.guess.placed.is_empty() && guess.guess.asked.is_empty() {
        let none = format!("none among {} topics", recordings[0].len());
        let expected = "a topic with a motion, such as one of nav_msgs/Odometry or vehicle_odometry";
        let remedy = "write ingest.toml yourself (docs/own-logs.md)";
        return Err(refuse(&path, "topic", &none, expected, remedy));
    }
    Ok(guess)
}

/// The guess for the first of `needed` that lacks nothing, or else the first of those that lack least.
pub(super) fn fewest<T>(
    needed: &[Vec<Needed>],
    guess: impl Fn(&[Needed]) -> T,
    missing: impl Fn(&T) -> usize,
) -> T {
    let (first, others) =
        needed.split_first().map_or((&[][..], needed), |(first, others)| (&first[..], others));
    let mut best = guess(first);
    for needed in others {
        if missing(&best) == 0 {
            break;
        }
        let other = guess(needed);
        if missing(&other) < missing(&best) {
            best = other;
        }
    }
    best
}

fn topics(path: &Path, format: Format) -> Result<Vec<Topic>, Error> {
    check_format(path, format, true)?;
    let topics = match format {
        Format::Db3 => database_census(&database(path)?, budget().bytes()),
        _ => bag_census(reader(path)?, format, budget().bytes()),
    };
    topics.map_err(|error| wrong(path, error))
}

/// The template of a recording's name. A bag of ROS 2 is a folder of its parts. Elsewhere files are parts where the first
/// is number 0.
fn run_from_file(files: &[String]) -> String {
    let end = files[0].rsplit_once('.').map_or("", |(_, end)| end);
    let depth = files[0].matches('/').count();
    let is_even = files.iter().all(|file| file.matches('/').count() == depth);
    if end == "db3" && depth > 0 && is_even {
        return format!("{}{{run}}/*.db3", "*/".repeat(depth - 1));
    }
    let is_numbered = |file: &String| {
        let stem = file.rsplit_once('.').map_or(file.as_str(), |(stem, _)| stem);
        stem.rsplit_once('_').is_some_and(|(_, number)| number.parse::<u32>().is_ok())
    };
    let is_first = |file: &String| file.ends_with(&format!("_0.{end}"));
    match files.len() > 1 && files.iter().all(is_numbered) && files.iter().any(is_first) {
        true => format!("{{run}}_*.{end}"),
        false => format!("{{run}}.{end}"),
    }
}

/// The groups of files of `ingest.toml`, one per topic.
pub(super) fn groups(guess: &BagGuess, patterns: &[String], files: &[String]) -> String {
    let patterns: Vec<String> = patterns.iter().map(|pattern| quoted(pattern)).collect();
    let (patterns, template) = (patterns.join(", "), run_from_file(files));
    let mut text = String::new();
    for topic in &guess.topics() {
        let _ = write!(text, "\n[[file]]\npattern = [{patterns}]\nrun_from_file = {}", quoted(&template));
        let mark = if template.contains('*') { MARK } else { "" };
        let _ = writeln!(text, "{mark}\ntopic = {}", quoted(&topic.topic));
        if let Some(publisher) = topic.publisher {
            let _ = writeln!(text, "publisher = \"{publisher}\"{MARK}: the first of several");
        }
        let unit = topic.clock_unit.map_or(String::new(), |unit| format!(", unit = {}", quoted(unit)));
        let _ = writeln!(text, "time = {{ column = {}{unit} }}", quoted(topic.clock));
        if let Some([w, x, y, z]) =
            topic.quaternion.as_ref().map(|parts| parts.each_ref().map(|part| quoted(part)))
        {
            let _ = writeln!(text, "quaternion = [{{ w = {w}, x = {x}, y = {y}, z = {z} }}]");
        }
        text += &channels(&topic.placed);
    }
    let names: Vec<String> = guess.unused().map(quoted).collect();
    if !names.is_empty() {
        let _ = writeln!(text, "\n# Topics that are not used: {}", names.join(", "));
    }
    text
}

/// The channels of a topic, on one line where they are few and have one mark.
fn channels(placed: &[Placed]) -> String {
    let is_short =
        placed.len() == 1 || placed.len() == 2 && placed.iter().all(|channel| mark(channel).is_empty());
    match placed {
        [] => String::new(),
        [.., last] if is_short => {
            let all: Vec<String> = placed.iter().map(channel).collect();
            format!("channel = [{}]{}\n", all.join(", "), mark(last))
        }
        _ => {
            let line = |placed: &Placed| format!("    {},{}\n", channel(placed), mark(placed));
            format!("channel = [\n{}]\n", placed.iter().map(line).collect::<String>())
        }
    }
}

fn mark(placed: &Placed) -> String {
    match (placed.is_channel_guessed, placed.is_unit_guessed) {
        _ if placed.by_motion.is_some() => {
            format!("{MARK}: {}", placed.by_motion.as_deref().unwrap_or_default())
        }
        (false, false) => String::new(),
        (true, false) => format!("{MARK}: by the name of the topic"),
        (_, true) => format!("{MARK}: by the name of the topic, which says no unit"),
    }
}

/// The bytes of the log at `path`, unpacked where its name ends with `.gz`.
pub(super) fn reader(path: &Path) -> Result<Box<dyn BufRead>, Error> {
    let file = open(path)?;
    Ok(match path.extension().is_some_and(|end| end == "gz") {
        true => Box::new(BufReader::new(MultiGzDecoder::new(file))),
        false => Box::new(BufReader::new(file)),
    })
}

/// What is wrong with the log at `path`.
pub(super) fn wrong(path: &Path, error: LogError) -> Error {
    match error {
        LogError::Unreadable(error) => Error::io(path, "read", error),
        LogError::Invalid(wrong) => invalid(path, &wrong),
    }
}

/// What is at the end of a line that was guessed.
pub(super) const MARK: &str = "  # guessed";

/// `text` in quotes as TOML has them.
pub(super) fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}

/// A channel as an item of a list.
fn channel(placed: &Placed) -> String {
    let [column, channel, unit] = [&placed.column, &placed.channel, &placed.unit].map(|text| quoted(text));
    let optional = if placed.is_optional { ", optional = true" } else { "" };
    let sign = if placed.is_reversed { ", sign = -1.0" } else { "" };
    format!("{{ column = {column}, channel = {channel}, unit = {unit}{sign}{optional} }}")
}

/// Endings of files in Parquet.
pub(super) const PARQUET: [&str; 1] = [".parquet"];

/// Rows that are looked at.
const ROWS: usize = 400;

/// The columns and first rows of the file at `path`, and how many rows it has.
pub(super) fn head(path: &Path) -> Result<(Head, usize), Error> {
    let table = ForeignTable::open(path)?;
    let columns = table.columns().to_vec();
    let cells: Vec<Vec<String>> = columns.iter().map(|column| first(&table, column)).collect();
    Ok((Head::of_cells(columns, &cells), table.rows()))
}

/// The first cells of `column`, times of a type as text; none of a type that holds nothing for a log.
fn first(table: &ForeignTable, column: &str) -> Vec<String> {
    let mut cells = Vec::new();
    let mut keep = |cell: String| {
        if cells.len() < ROWS {
            cells.push(cell);
        }
    };
    // What cannot be read is refused when the file is ingested, if it is needed there.
    let _ = match table.timed(column) {
        Some(Timed::Moments { .. } | Timed::OfDay { .. }) => {
            table.seconds(column, |second| keep(of_day(second)))
        }
        Some(Timed::Days) => Ok(()),
        None => table
            .numbers(column, |number| {
                keep(if number.is_finite() { number.to_string() } else { String::new() })
            })
            .or_else(|_| table.texts(column, |text| keep(text.to_owned()))),
    };
    cells
}

/// The numbers in one of `every` rows of the file at `path`, column by column: times in seconds, NaN for what is none.
pub(super) fn columns(path: &Path, every: usize) -> Result<Vec<Vec<f64>>, Error> {
    let table = ForeignTable::open(path)?;
    let of = |column: &String| {
        let (mut all, mut row) = (Vec::new(), 0_usize);
        let mut keep = |number: f64| {
            if row.is_multiple_of(every) {
                all.push(number);
            }
            row += 1;
        };
        // What is no number is refused when the file is ingested, if it is needed there.
        let _ = match table.timed(column) {
            Some(Timed::Moments { .. } | Timed::OfDay { .. }) => table.seconds(column, &mut keep),
            _ => table.numbers(column, &mut keep),
        };
        all.resize(table.rows().div_ceil(every), f64::NAN);
        all
    };
    Ok(table.columns().iter().map(of).collect())
}

/// A time \[s\] as text: of which day says nothing about the step between rows.
fn of_day(second: f64) -> String {
    let second = second.rem_euclid(86_400.0);
    let (hours, minutes) = ((second / 3600.0).floor(), (second / 60.0).floor() % 60.0);
    match second.is_finite() {
        true => format!("1970-01-01T{hours:02}:{minutes:02}:{:09.6}", second % 60.0),
        false => String::new(),
    }
}

/// Endings of logs of sentences.
pub(super) const SENTENCES: [&str; 2] = [".nmea", ".nmea.gz"];

/// Endings of files in which there may be sentences.
pub(super) const PERHAPS: [&str; 4] = [".log", ".txt", ".log.gz", ".txt.gz"];

/// Bytes of a file that are looked at for a sentence.
const LOOKED: u64 = 1 << 14;

/// Whether the file at `path` begins with sentences.
pub(super) fn is_of_sentences(path: &Path) -> bool {
    let mut bytes = Vec::new();
    let read = reader(path).map(|file| file.take(LOOKED).read_to_end(&mut bytes));
    // Damage is reported when the file is ingested.
    read.is_ok() && has_sentences(&String::from_utf8_lossy(&bytes))
}

/// What is in the log at `path`, for a model that needs the channels `needed`.
pub(super) fn guessed_sentences(path: &Path, needed: &[Vec<Needed>]) -> Result<SentenceGuess, Error> {
    check_format(path, Format::Nmea, true)?;
    let spoken = sentence_census(reader(path)?).map_err(|error| wrong(path, error))?;
    let remedy = "write ingest.toml yourself (docs/own-logs.md)";
    let of = |needed: &[Needed]| SentenceGuess::of(&spoken, needed);
    let Some(guess) = fewest(needed, of, |guess| guess.as_ref().map_or(0, |guess| guess.missing.len()))
    else {
        let expected = "sentences with a time: RMC, ZDA, GGA, GNS or GLL";
        let remedy = "write ingest.toml yourself, with the `format` of stamps (docs/own-logs.md)";
        return Err(refuse(path, "time", "none", expected, remedy));
    };
    match guess.placed.is_empty() {
        false => Ok(guess),
        true => {
            let none = format!("none among {}", listed(&guess.unused));
            Err(refuse(path, "field", &none, "one of a motion, such as GGA.latitude or HDT.heading", remedy))
        }
    }
}

/// The group of files of `ingest.toml`.
pub(super) fn group(guess: &SentenceGuess, patterns: &[String]) -> String {
    let listed = |all: &[String]| all.iter().map(|text| quoted(text)).collect::<Vec<_>>().join(", ");
    let mut text = format!("\n[[file]]\npattern = [{}]\n", listed(patterns));
    if !patterns.iter().all(|pattern| SENTENCES.iter().any(|end| pattern.to_lowercase().ends_with(end))) {
        text += "format = \"nmea\"\n";
    }
    let spread = if guess.is_spread { ", repeated = \"spread\"" } else { "" };
    let why = if guess.is_spread { ", and are spread until the next one" } else { "" };
    let _ = writeln!(text, "# Sentences without a time have that of the last {}{why}.", guess.clock);
    let _ = writeln!(text, "time = {{ column = {}{spread} }}{MARK}", quoted(guess.clock));
    if guess.is_unchecked {
        let _ = writeln!(text, "checksums = \"optional\"{MARK}: most sentences have none");
    }
    if !guess.prefer.is_empty() {
        let prefer = listed(&guess.prefer);
        let _ = writeln!(text, "prefer = [{prefer}]{MARK}: the talkers that say most come first");
    }
    let line = |placed: &Placed| {
        let why = if placed.is_channel_guessed { ": by the kind of sentence" } else { "" };
        let mark = if placed.is_channel_guessed { MARK } else { "" };
        format!("    {},{mark}{why}\n", channel(placed))
    };
    let _ = writeln!(text, "channel = [\n{}]", guess.placed.iter().map(line).collect::<String>());
    if !guess.unused.is_empty() {
        let _ = writeln!(text, "\n# Fields that are not used: {}", listed(&guess.unused));
    }
    text
}
