//! Looks at a folder of logs: which files, which columns or topics, of which ship.

use std::collections::BTreeSet;
use std::io::{IsTerminal, stderr, stdin};
use std::path::{Path, PathBuf};

use files::{Error, open};
use logs::Format;
use logs::by_motion::{LoggedTable, RECORDINGS, ROWS};
use logs::guess::{BagGuess, ColumnChoice, Guess, Head, Named, Needed, Placed, SentenceGuess};
use refusal::{foreign, listed};
use study::ingest_file::read::check_format;
use study::refuse;

use crate::failure::{WorkProgress, on_stderr};
use crate::pipeline::starting::bags::{
    self, BAGS, PARQUET, PERHAPS, SENTENCES, fewest, is_of_sentences, reader, wrong,
};

/// Channels of the relative wind, of which a model needs both.
const WIND: [&str; 2] = ["wind", "wind_from"];

/// Endings of files in CSV.
const CSV: [&str; 3] = [".csv", ".csv.gz", ".tsv"];

/// Endings of logs that only a person can describe.
const OTHERS: [&str; 2] = [".bin", ".mat"];

/// Most questions to the terminal.
const QUESTIONS: usize = 3;

/// What is in the first of the logs.
#[derive(Debug)]
pub enum LogGuess {
    /// Columns, and what they are likely to be.
    Table(Head, Guess),
    /// Topics, and what they are likely to be.
    Bag(BagGuess),
    /// Fields of sentences, and what they are likely to be.
    Sentences(SentenceGuess),
}

/// What a folder of logs has.
#[derive(Debug)]
pub struct Looked {
    /// The folder.
    pub folder: PathBuf,
    /// Patterns of its files, such as `zigzag/*.csv`.
    pub patterns: Vec<String>,
    /// The files, sorted.
    pub files: Vec<String>,
    /// The length of a usual one \[s\], about.
    pub(super) usual_s: f64,
    /// What is in the first of them.
    pub found: LogGuess,
    /// Logs of other formats beside them.
    pub others: Vec<String>,
}

/// Least size of the file of a recording that is kept apart, as a part of a usual one: windows are up to 0.9 as long as that.
const LONG: f64 = 0.95;

impl Looked {
    /// Looks at the logs in `folder` and in its subfolders, for a model that needs the channels of one of `needed`: of the first that are all
    /// there, or else of those of which fewest are missing. Shows progress unless `quiet`.
    pub fn at(folder: &Path, needed: &[Vec<Needed>], quiet: bool) -> Result<Self, Error> {
        if !folder.is_dir() {
            let remedy = "name the folder of the logs";
            return Err(refuse(folder, "--logs", "no such folder", "a folder with logs", remedy));
        }
        let mut names = Vec::new();
        list(folder, "", &mut names)?;
        names.sort();
        let all = names.clone();
        let (mut files, mut rest): (Vec<String>, Vec<String>) =
            names.into_iter().partition(|name| ends(name, &CSV));
        if files.is_empty() {
            (files, rest) = rest.into_iter().partition(|name| ends(name, &PARQUET));
        }
        let (bags, rest): (Vec<String>, Vec<String>) = rest.into_iter().partition(|name| ends(name, &BAGS));
        let is_said = |name: &String| {
            ends(name, &SENTENCES) || ends(name, &PERHAPS) && is_of_sentences(&folder.join(name))
        };
        let (said, rest): (Vec<String>, Vec<String>) = rest.into_iter().partition(is_said);
        let others = rest.into_iter().filter(|name| ends(name, &OTHERS) || ends(name, &PARQUET));
        match (files.is_empty(), bags.is_empty(), said.is_empty()) {
            (false, ..) => {
                let others = bags.into_iter().chain(said).chain(others).collect();
                Self::of_tables(folder, (files, others), needed, quiet)
            }
            (true, false, _) => {
                Self::of_bags(folder, (bags, said.into_iter().chain(others).collect()), needed, quiet)
            }
            (true, true, false) => Self::of_sentences(folder, said, others.collect(), needed),
            (true, true, true) => Err(no_log(folder, &all)),
        }
    }

    fn of_tables(
        folder: &Path,
        (files, others): (Vec<String>, Vec<String>),
        needed: &[Vec<Needed>],
        quiet: bool,
    ) -> Result<Self, Error> {
        let first = &files[0];
        let seen: Vec<SeenTable> =
            files.iter().map(|file| SeenTable::of(&folder.join(file))).collect::<Result<_, _>>()?;
        for (file, log) in files.iter().zip(&seen) {
            check_columns(folder, (first, &seen[0].head), (file, &log.head))?;
        }
        check_ships(folder, files.iter().zip(&seen))?;
        let mut rows: Vec<f64> = seen.iter().map(|log| log.rows).collect();
        rows.sort_by(f64::total_cmp);
        let (usual_rows, head) = (rows[rows.len() / 2], seen[0].head.clone());
        let table = table(folder, &files, &seen, quiet)?;
        let guess = fewest(needed, |needed| Guess::of(&head, &table, needed), |guess| guess.missing.len());
        let Some(clock) = &guess.clock else {
            let lacking = format!("none that is called a time or increases among {}", listed(&head.columns));
            let remedy = "write ingest.toml yourself, with its `time` (docs/own-logs.md)";
            return Err(refuse(&folder.join(first), "time", &lacking, "a column with the time", remedy));
        };
        let usual_s = usual_rows * clock.step_s;
        let (folder, patterns) = (folder.to_owned(), patterns(&files, &[CSV.as_slice(), &PARQUET].concat()));
        Ok(Self { folder, patterns, files, usual_s, found: LogGuess::Table(head, guess), others })
    }

    fn of_bags(
        folder: &Path,
        (files, others): (Vec<String>, Vec<String>),
        needed: &[Vec<Needed>],
        quiet: bool,
    ) -> Result<Self, Error> {
        let guess = bags::guessed(folder, &files, needed, quiet)?;
        let (folder, patterns, usual_s) = (folder.to_owned(), patterns(&files, &BAGS), guess.length_s);
        Ok(Self { folder, patterns, files, usual_s, found: LogGuess::Bag(guess), others })
    }

    fn of_sentences(
        folder: &Path,
        files: Vec<String>,
        others: Vec<String>,
        needed: &[Vec<Needed>],
    ) -> Result<Self, Error> {
        let guess = bags::guessed_sentences(&folder.join(&files[0]), needed)?;
        let patterns = patterns(&files, &[SENTENCES.as_slice(), &PERHAPS].concat());
        let (folder, usual_s, found) = (folder.to_owned(), guess.length_s, LogGuess::Sentences(guess));
        Ok(Self { folder, patterns, files, usual_s, found, others })
    }

    /// Asks the terminal, if there is one, which column is a channel that several may be.
    pub(super) fn ask(&mut self, quiet: bool) {
        let guess = match &mut self.found {
            LogGuess::Table(_, guess) => guess,
            LogGuess::Bag(bag) => &mut bag.guess,
            LogGuess::Sentences(_) => return,
        };
        let mut at = 0;
        for _ in 0..QUESTIONS {
            let Some(question) = guess.asked.get(at) else { return };
            if quiet || !stdin().is_terminal() || !stderr().is_terminal() {
                return;
            }
            let channel = &question.channel;
            on_stderr(format_args!("Which column is `{channel}`? Its number, or nothing for none of these:"));
            for (number, choice) in question.choices.iter().enumerate() {
                let ColumnChoice { placed: Placed { topic, column, unit, .. }, why } = choice;
                let [topic, column] = [topic, column].map(|name| foreign(name));
                let topic = if topic.is_empty() { topic } else { format!(" of `{topic}`") };
                on_stderr(format_args!("  {}  `{column}`{topic} in {unit}: {why}", number + 1));
            }
            let mut line = String::new();
            let answered = stdin().read_line(&mut line).ok().and_then(|_| line.trim().parse::<usize>().ok());
            match answered.filter(|number| (1..=question.choices.len()).contains(number)) {
                Some(number) => guess.answer(at, number - 1),
                None => at += 1,
            }
        }
    }

    /// Recordings that a model may be tried on: one of every five, none of fewer than three. Names that a list with commas cannot hold
    /// are passed over, and recordings whose file is shorter than a usual one, which may have no window.
    pub(super) fn kept_apart(&self) -> Vec<&str> {
        let is_plain = |name: &&str| name.chars().all(|c| c.is_alphanumeric() || "-_.+".contains(c));
        let name = |file: &'_ String| {
            let lower = file.to_lowercase();
            let known = CSV.iter().chain(&PARQUET).chain(&BAGS).chain(&SENTENCES).chain(&PERHAPS);
            let end = known.filter(|end| lower.ends_with(*end)).map(|end| end.len()).max().unwrap_or(0);
            file.rfind('/').map_or(0, |slash| slash + 1)..file.len() - end
        };
        let size =
            |file: &String| std::fs::metadata(self.folder.join(file)).map_or(0, |metadata| metadata.len());
        let mut sizes: Vec<u64> = self.files.iter().map(size).collect();
        sizes.sort_unstable();
        let usual = sizes[sizes.len() / 2] as f64;
        let is_long = |file: &&String| size(file) as f64 > LONG * usual;
        let five = self.files.chunks(5).filter(|files| files.len() > 2);
        let one = five.filter_map(|files| {
            let (before, after) = files.split_at(2);
            let all = after.iter().chain(before).filter(is_long);
            all.map(|file| &file[name(file)]).find(is_plain)
        });
        one.collect()
    }

    /// How many lines of `ingest.toml` are guessed.
    pub fn guessed(&self) -> usize {
        let marks = |placed: &[Placed]| -> usize {
            let marks = placed.iter().map(|channel| {
                usize::from(channel.is_channel_guessed) + usize::from(channel.is_unit_guessed)
            });
            marks.sum()
        };
        match &self.found {
            LogGuess::Table(_, guess) => {
                marks(&guess.placed) + guess.clock.iter().filter(|clock| clock.is_unit_guessed).count()
            }
            LogGuess::Bag(bag) => marks(&bag.guess.placed),
            LogGuess::Sentences(guess) => {
                // The clock, and what else stands on a line of its own.
                marks(&guess.placed)
                    + 1
                    + usize::from(guess.is_unchecked)
                    + usize::from(!guess.prefer.is_empty())
            }
        }
    }

    /// Whether the relative wind's speed and direction are logged: then the model takes both.
    pub(super) fn take_wind(&mut self) -> bool {
        let is_whole = WIND.iter().all(|channel| self.placed().any(|placed| placed.channel == *channel));
        let placed: Vec<&mut Placed> = match &mut self.found {
            LogGuess::Table(_, guess) => guess.placed.iter_mut().collect(),
            LogGuess::Bag(bag) => bag.guess.placed.iter_mut().collect(),
            LogGuess::Sentences(guess) => guess.placed.iter_mut().collect(),
        };
        for channel in
            placed.into_iter().filter(|channel| is_whole && WIND.contains(&channel.channel.as_str()))
        {
            channel.is_optional = false;
        }
        is_whole
    }

    /// The channel of the wind that is not used, for the other is not logged, and what it lacks.
    pub fn half_a_wind(&self) -> Option<[&'static str; 2]> {
        let has = |channel: &str| self.placed().any(|placed| placed.channel == channel);
        match WIND.map(has) {
            [true, false] => Some([WIND[0], "direction"]),
            [false, true] => Some([WIND[1], "speed"]),
            _ => None,
        }
    }

    /// The channels that were found.
    pub(super) fn placed(&self) -> Box<dyn Iterator<Item = &Placed> + '_> {
        match &self.found {
            LogGuess::Table(_, guess) => Box::new(guess.placed.iter()),
            LogGuess::Bag(bag) => Box::new(bag.guess.placed.iter()),
            LogGuess::Sentences(guess) => Box::new(guess.placed.iter()),
        }
    }

    /// Channels of the model that were not found.
    pub fn missing(&self) -> &[Needed] {
        match &self.found {
            LogGuess::Table(_, guess) => &guess.missing,
            LogGuess::Bag(bag) => &bag.guess.missing,
            LogGuess::Sentences(guess) => &guess.missing,
        }
    }
}

fn ends(name: &str, ends: &[&str]) -> bool {
    ends.iter().any(|end| name.to_lowercase().ends_with(end))
}

/// Appends the files below `folder/below` to `names`.
fn list(folder: &Path, below: &str, names: &mut Vec<String>) -> Result<(), Error> {
    let here = folder.join(below);
    let unreadable = |e| Error::io(&here, "list", e);
    for entry in std::fs::read_dir(&here).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let Ok(name) = entry.file_name().into_string() else { continue };
        let name = if below.is_empty() { name } else { format!("{below}/{name}") };
        let kind = entry.file_type().map_err(unreadable)?;
        if kind.is_dir() && !name.starts_with('.') {
            list(folder, &name, names)?;
        } else if !kind.is_dir() {
            names.push(name);
        }
    }
    Ok(())
}

/// What was seen of a log.
struct SeenTable {
    head: Head,
    /// Its rows, about.
    rows: f64,
}

impl SeenTable {
    /// The columns and first rows of the log at `path`.
    fn of(path: &Path) -> Result<Self, Error> {
        check_format(path, Format::of(&path.to_string_lossy()), true)?;
        if ends(&path.to_string_lossy(), &PARQUET) {
            let (head, rows) = bags::head(path)?;
            return Ok(Self { head, rows: rows as f64 });
        }
        let unreadable = |e| Error::io(path, "read", e);
        let length = open(path)?.metadata().map_err(unreadable)?.len();
        let head = Head::read(reader(path)?).map_err(|error| wrong(path, error))?;
        let packed = if path.extension().is_some_and(|end| end == "gz") { PACKED } else { 1.0 };
        let rows = (packed * length as f64 / head.row_bytes.max(1.0)).round() - f64::from(head.has_header);
        Ok(Self { head, rows })
    }
}

/// How many times longer a packed log is, about.
const PACKED: f64 = 4.0;

/// The columns of the longest `files`, as they were `seen`.
fn table(folder: &Path, files: &[String], seen: &[SeenTable], quiet: bool) -> Result<LoggedTable, Error> {
    let mut longest: Vec<usize> = (0..files.len()).collect();
    longest.sort_by(|a, b| seen[*b].rows.total_cmp(&seen[*a].rows));
    longest.truncate(RECORDINGS);
    let progress = WorkProgress::new("logs", longest.len(), quiet);
    let read = |at: usize| {
        let (path, SeenTable { head, rows }) = (folder.join(&files[at]), &seen[at]);
        let every = (rows / ROWS as f64).floor().max(1.0) as usize;
        let columns = match ends(&files[at], &PARQUET) {
            true => bags::columns(&path, every)?,
            false => head.numbers_of(reader(&path)?, every).map_err(|error| wrong(&path, error))?,
        };
        progress.advance(1);
        Ok((every, columns))
    };
    Ok(LoggedTable::of(longest.into_iter().map(read).collect::<Result<_, Error>>()?))
}

/// The refusal of a folder without a log that is read: the first of `all` whose format is known, by its name.
fn no_log(folder: &Path, all: &[String]) -> Error {
    let foreign_log = all.iter().find_map(|name| check_format(&folder.join(name), Format::Csv, true).err());
    foreign_log.unwrap_or_else(|| {
        let logs = match all {
            [] => "none".to_owned(),
            [first, more @ ..] => {
                format!("`{}` and {} more files, of formats that are not known", foreign(first), more.len())
            }
        };
        let expected = "files that end with .csv, .csv.gz, .tsv, .parquet, .mcap, .bag, .db3, .ulg or .nmea";
        refuse(folder, "logs", &logs, expected, "name the folder of the logs, or their files so")
    })
}

/// Refuses a file with other columns than the first one.
fn check_columns(
    folder: &Path,
    (first, known): (&str, &Head),
    (file, head): (&str, &Head),
) -> Result<(), Error> {
    if head.columns == known.columns
        && head.separator == known.separator
        && head.has_header == known.has_header
    {
        return Ok(());
    }
    let lacks = |these: &Head, those: &Head| {
        let lacking = those.columns.iter().find(|column| !these.columns.contains(column));
        lacking.map(|column| format!("`{}`", foreign(column)))
    };
    let difference = match (lacks(known, head), lacks(head, known)) {
        (Some(more), _) => format!("a column {more} that {} has not", foreign(first)),
        (None, Some(less)) => format!("no column {less}, which {} has", foreign(first)),
        (None, None) => {
            format!("the columns of {} in another order or with another separator", foreign(first))
        }
    };
    let expected = "logs of one ship with the same columns";
    let remedy =
        "name a folder with those of one ship, or write a [[file]] for each kind yourself (docs/own-logs.md)";
    Err(refuse(&folder.join(file), "columns", &difference, expected, remedy))
}

/// Refuses logs that name several ships.
fn check_ships<'a>(
    folder: &Path,
    files: impl Iterator<Item = (&'a String, &'a SeenTable)>,
) -> Result<(), Error> {
    let mut known: Option<(String, String)> = None;
    for (file, SeenTable { head, .. }) in files {
        let Some(at) = head.columns.iter().position(|column| Named::of(column).is_identity()) else {
            continue;
        };
        let ships: BTreeSet<&str> = head.texts(at).collect();
        for ship in ships {
            match &known {
                None => known = Some((ship.to_owned(), file.clone())),
                Some((other, _)) if other == ship => {}
                Some((other, before)) => {
                    let ships =
                        format!("`{}` beside `{}` of {}", foreign(ship), foreign(other), foreign(before));
                    let thing = format!("column `{}`", foreign(&head.columns[at]));
                    let remedy = "put the logs of each ship into a folder of its own";
                    return Err(refuse(&folder.join(file), &thing, &ships, "logs of one ship", remedy));
                }
            }
        }
    }
    Ok(())
}

/// Patterns that match `files`: one for each folder and ending.
fn patterns(files: &[String], known: &[&str]) -> Vec<String> {
    let pattern = |name: &String| {
        let end = known.iter().find(|end| name.to_lowercase().ends_with(*end)).map_or("", |end| {
            // As the file writes it.
            &name[name.len() - end.len()..]
        });
        let folder = name.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"));
        format!("{folder}*{end}")
    };
    files.iter().map(pattern).collect::<BTreeSet<_>>().into_iter().collect()
}
