//! Looks at a folder of logs: which files, which columns, of which ship.

use std::collections::BTreeSet;
use std::io::Read;
use std::path::{Path, PathBuf};

use artifact::{Error, open};
use flate2::read::MultiGzDecoder;
use logs::guess::{Guess, Head, Named, Needed};
use refusal::{foreign, listed};

use study::{invalid, refuse};

/// Bytes of a log that are looked at.
const LOOKED: u64 = 1 << 17;

/// Endings of files in CSV.
const CSV: [&str; 3] = [".csv", ".csv.gz", ".tsv"];

/// Endings of logs that only a person can describe.
const OTHERS: [&str; 9] = [".parquet", ".mcap", ".nmea", ".nmea.gz", ".bag", ".db3", ".ulg", ".bin", ".mat"];

/// What a folder of logs has.
#[derive(Debug)]
pub struct Looked {
    /// The folder.
    pub folder: PathBuf,
    /// Patterns of its files, such as `zigzag/*.csv`.
    pub patterns: Vec<String>,
    /// The files, sorted.
    pub files: Vec<String>,
    /// Rows of a usual one, about.
    usual_rows: f64,
    /// The columns of the first of them.
    pub head: Head,
    /// What they are likely to be.
    pub guess: Guess,
    /// Logs of other formats beside them.
    pub others: Vec<String>,
}

impl Looked {
    /// Looks at the logs in `folder` and in its subfolders, for a model that needs the channels `needed`.
    ///
    /// # Errors
    /// A folder that cannot be listed; no log in CSV; logs of several ships, or with different columns; columns that cannot
    /// be told apart.
    pub fn at(folder: &Path, needed: &[Needed]) -> Result<Self, Error> {
        if !folder.is_dir() {
            let remedy = "name the folder of the logs";
            return Err(refuse(folder, "--logs", "no such folder", "a folder with logs", remedy));
        }
        let mut names = Vec::new();
        list(folder, "", &mut names)?;
        names.sort();
        let ends = |name: &str, ends: &[&str]| ends.iter().any(|end| name.to_lowercase().ends_with(end));
        let (files, rest): (Vec<String>, Vec<String>) = names.into_iter().partition(|name| ends(name, &CSV));
        let others: Vec<String> = rest.into_iter().filter(|name| ends(name, &OTHERS)).collect();
        let Some(first) = files.first() else { return Err(no_log(folder, &others)) };
        let seen: Vec<Seen> =
            files.iter().map(|file| Seen::of(&folder.join(file))).collect::<Result<_, _>>()?;
        for (file, own) in files.iter().zip(&seen) {
            check_columns(folder, (first, &seen[0].head), (file, &own.head))?;
        }
        check_ships(folder, files.iter().zip(&seen))?;
        let mut rows: Vec<f64> = seen.iter().map(|own| own.rows).collect();
        rows.sort_by(f64::total_cmp);
        let (usual_rows, head) = (rows[rows.len() / 2], seen[0].head.clone());
        let guess = Guess::of(&head, needed);
        if guess.clock.is_none() {
            let found = format!("none that is called a time or increases among {}", listed(&head.columns));
            let remedy = "write ingest.toml yourself, with its `time` (docs/own-logs.md)";
            return Err(refuse(&folder.join(first), "time", &found, "a column with the time", remedy));
        }
        let (folder, patterns) = (folder.to_owned(), patterns(&files));
        Ok(Self { folder, patterns, files, usual_rows, head, guess, others })
    }

    /// The length of a usual recording \[s\], about.
    pub(super) fn usual_s(&self) -> f64 {
        self.usual_rows * self.guess.clock.as_ref().map_or(1.0, |clock| clock.step_s)
    }

    /// Recordings that a model may be tried on: every fifth of them, none of fewer than three. Names that study.mk cannot hold
    /// are passed over.
    pub(super) fn kept_apart(&self) -> Vec<&str> {
        let is_plain = |name: &&str| name.chars().all(|c| c.is_alphanumeric() || "-_.+".contains(c));
        let name = |file: &'_ String| {
            let lower = file.to_lowercase();
            let end = CSV.iter().find(|end| lower.ends_with(*end)).map_or(0, |end| end.len());
            file.rfind('/').map_or(0, |slash| slash + 1)..file.len() - end
        };
        let every = self.files.iter().skip(2).step_by(5);
        every.map(|file| &file[name(file)]).filter(is_plain).collect()
    }

    /// How many lines of `ingest.toml` are guessed.
    pub fn guessed(&self) -> usize {
        let placed = self.guess.placed.iter();
        let marks = placed.map(|own| usize::from(own.is_channel_guessed) + usize::from(own.is_unit_guessed));
        marks.sum::<usize>() + self.guess.clock.iter().filter(|clock| clock.is_unit_guessed).count()
    }
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
struct Seen {
    head: Head,
    /// Its rows, about.
    rows: f64,
}

impl Seen {
    /// The columns and first rows of the log at `path`.
    fn of(path: &Path) -> Result<Self, Error> {
        let unreadable = |e| Error::io(path, "read", e);
        let file = open(path)?;
        let length = file.metadata().map_err(unreadable)?.len();
        let mut bytes = Vec::new();
        let is_packed = path.extension().is_some_and(|end| end == "gz");
        match is_packed {
            // Damage is reported when the file is ingested.
            true => drop(MultiGzDecoder::new(file).take(LOOKED).read_to_end(&mut bytes)),
            false => drop(file.take(LOOKED).read_to_end(&mut bytes).map_err(unreadable)?),
        }
        let text = String::from_utf8_lossy(&bytes);
        let head = Head::of_csv(&text).map_err(|wrong| invalid(path, &wrong))?;
        let unseen = if is_packed { 1.0 } else { length as f64 / bytes.len() as f64 };
        Ok(Self { head, rows: unseen * (text.lines().count() - 1) as f64 })
    }
}

fn no_log(folder: &Path, others: &[String]) -> Error {
    let (found, remedy) = match others.first() {
        None => ("none".to_owned(), "name the folder of the logs"),
        Some(other) => {
            let remedy = "write ingest.toml yourself for logs of this format (docs/own-logs.md)";
            (format!("`{}` and no CSV", foreign(other)), remedy)
        }
    };
    refuse(folder, "logs", &found, "files that end with .csv, .csv.gz or .tsv", remedy)
}

/// Refuses a file with other columns than the first one.
fn check_columns(
    folder: &Path,
    (first, known): (&str, &Head),
    (file, own): (&str, &Head),
) -> Result<(), Error> {
    if own.columns == known.columns && own.separator == known.separator {
        return Ok(());
    }
    let lacks = |these: &Head, those: &Head| {
        let lacking = those.columns.iter().find(|column| !these.columns.contains(column));
        lacking.map(|column| format!("`{}`", foreign(column)))
    };
    let found = match (lacks(known, own), lacks(own, known)) {
        (Some(more), _) => format!("a column {more} that {} has not", foreign(first)),
        (None, Some(less)) => format!("no column {less}, which {} has", foreign(first)),
        (None, None) => {
            format!("the columns of {} in another order or with another separator", foreign(first))
        }
    };
    let expected = "logs of one ship with the same columns";
    let remedy =
        "name a folder with those of one ship, or write a [[file]] for each kind yourself (docs/own-logs.md)";
    Err(refuse(&folder.join(file), "columns", &found, expected, remedy))
}

/// Refuses logs that name several ships.
fn check_ships<'a>(folder: &Path, files: impl Iterator<Item = (&'a String, &'a Seen)>) -> Result<(), Error> {
    let mut known: Option<(String, String)> = None;
    for (file, Seen { head, .. }) in files {
        let Some(at) = head.columns.iter().position(|column| Named::of(column).is_identity()) else {
            continue;
        };
        let ships: BTreeSet<&str> = head.texts(at).collect();
        for ship in ships {
            match &known {
                None => known = Some((ship.to_owned(), file.clone())),
                Some((other, _)) if other == ship => {}
                Some((other, before)) => {
                    let found =
                        format!("`{}` beside `{}` of {}", foreign(ship), foreign(other), foreign(before));
                    let thing = format!("column `{}`", foreign(&head.columns[at]));
                    let remedy = "put the logs of each ship into a folder of its own";
                    return Err(refuse(&folder.join(file), &thing, &found, "logs of one ship", remedy));
                }
            }
        }
    }
    Ok(())
}

/// Patterns that match `files`: one for each folder and ending.
fn patterns(files: &[String]) -> Vec<String> {
    let pattern = |name: &String| {
        let end = CSV.iter().find(|end| name.to_lowercase().ends_with(*end)).map_or("", |end| {
            // As the file writes it.
            &name[name.len() - end.len()..]
        });
        let folder = name.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"));
        format!("{folder}*{end}")
    };
    files.iter().map(pattern).collect::<BTreeSet<_>>().into_iter().collect()
}
