//! One log file: its clock, its channels, what was left out.

use std::path::Path;

use artifact::ForeignTable;
use logs::{Series, TimeUnit, Unit, order};
use rayon::prelude::*;
use vessel::nearest;

use super::config::{ChannelSpec, FileSpec, IngestFile};
use super::csv;
use super::suspicion::check_turns;
use crate::failure::Failure;

/// A column that is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
    /// Its name.
    pub column: String,
    /// Whether it holds text.
    pub text: bool,
}

/// The values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// NaN where there is no value.
    Numbers(Vec<f64>),
    /// Empty where there is none.
    Texts(Vec<String>),
}

/// The columns of a file as asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Raw {
    /// In the order asked for.
    pub columns: Vec<Cells>,
    /// Line (CSV) or row (Parquet) of every row, from 1.
    pub lines: Vec<usize>,
    /// Rows without any value, left out.
    pub empty_rows: usize,
    /// Rows cut short at the end of the file, left out.
    pub cut_rows: usize,
}

impl Raw {
    /// No rows yet.
    pub fn new(wanted: &[Wanted]) -> Self {
        let empty = |w: &Wanted| if w.text { Cells::Texts(Vec::new()) } else { Cells::Numbers(Vec::new()) };
        Self { columns: wanted.iter().map(empty).collect(), lines: Vec::new(), empty_rows: 0, cut_rows: 0 }
    }
}

/// A file's channels on its own clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// Its times, increasing \[s\].
    pub times: Vec<f64>,
    /// One series per channel of the group, in order, in SI units.
    pub channels: Vec<Series>,
    /// Labels of sub-experiments, one per time.
    pub labels: Option<Vec<String>>,
    /// What was read and left out.
    pub counts: RowCounts,
}

/// What was read of a file, and what of it was left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RowCounts {
    /// Rows in the file.
    pub read: usize,
    /// Rows without any value.
    pub empty: usize,
    /// Rows cut short at the end.
    pub cut: usize,
    /// Rows with values but no time.
    pub without_time: usize,
    /// Rows whose time an earlier row has.
    pub repeated: usize,
    /// Rows earlier than a row before them: left out, or put in order.
    pub backwards: usize,
}

/// Reads a file of group `spec`. `units` are those of its channels, in order.
///
/// # Errors
/// What [`csv::read`] and [`ForeignTable`] refuse, a time that is none, time going backwards, no rows.
pub fn load(path: &Path, config: &IngestFile, spec: &FileSpec, units: &[Unit]) -> Result<Loaded, Failure> {
    let wanted = wanted(spec);
    let parquet = path.extension().is_some_and(|e| e == "parquet" || e == "parq" || e == "pq");
    let raw = if parquet { read_parquet(path, &wanted)? } else { csv::read(path, spec.separator, &wanted)? };
    let times = times(path, spec, &raw)?;
    let mut counts = RowCounts {
        read: raw.lines.len() + raw.empty_rows + raw.cut_rows,
        empty: raw.empty_rows,
        cut: raw.cut_rows,
        ..RowCounts::default()
    };
    let timed: Vec<usize> = (0..times.len()).filter(|row| times[*row].is_finite()).collect();
    counts.without_time = times.len() - timed.len();
    if timed.is_empty() {
        return Err(Failure::refuse(
            path,
            "file",
            &format!("no rows with a time ({} read, {} empty)", counts.read, counts.empty),
            "at least one row",
            "remove the file or narrow the pattern",
        ));
    }
    let clock: Vec<f64> = timed.iter().map(|row| times[*row]).collect();
    let ordered = order(&clock, config.non_monotonic).map_err(|back| {
        let line = raw.lines[timed[back.row]];
        backwards(path, spec, line, back.time, back.latest)
    })?;
    (counts.repeated, counts.backwards) = (ordered.repeated, ordered.backwards);
    let rows: Vec<usize> = ordered.rows.iter().map(|row| timed[*row]).collect();
    let times: Vec<f64> = rows.iter().map(|row| times[*row]).collect();
    let channels = channels(path, config, spec, units, &raw, &rows, &times)?;
    let labels = spec.label_column.is_some().then(|| match raw.columns.last() {
        Some(Cells::Texts(texts)) => rows.iter().map(|row| texts[*row].clone()).collect(),
        _ => Vec::new(),
    });
    Ok(Loaded { times, channels, labels, counts })
}

/// Time, the channels, and the labels if there are any.
fn wanted(spec: &FileSpec) -> Vec<Wanted> {
    let wanted = |column: &String, text: bool| Wanted { column: column.clone(), text };
    let time = wanted(&spec.time.column, spec.time.unit == TimeUnit::Iso8601);
    let channels = spec.channel.iter().map(|channel| wanted(&channel.column, false));
    let labels = spec.label_column.iter().map(|column| wanted(column, true));
    [time].into_iter().chain(channels).chain(labels).collect()
}

fn read_parquet(path: &Path, wanted: &[Wanted]) -> Result<Raw, Failure> {
    let table = ForeignTable::open(path)?;
    if wanted.iter().any(|w| !table.columns().contains(&w.column)) {
        return Err(missing_columns(path, table.columns(), wanted));
    }
    let column = |w: &Wanted| -> Result<Cells, Failure> {
        Ok(if w.text {
            Cells::Texts(texts(&table, &w.column)?)
        } else {
            Cells::Numbers(table.numbers(&w.column)?)
        })
    };
    let columns = wanted.iter().map(column).collect::<Result<_, _>>()?;
    Ok(Raw { columns, lines: (1..=table.rows()).collect(), empty_rows: 0, cut_rows: 0 })
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

fn times(path: &Path, spec: &FileSpec, raw: &Raw) -> Result<Vec<f64>, Failure> {
    let offset_s = spec.time.offset_s;
    let texts = match (&raw.columns[0], spec.time.unit.seconds()) {
        (Cells::Numbers(numbers), Some(unit)) => {
            return Ok(numbers.iter().map(|n| n * unit + offset_s).collect());
        }
        (Cells::Texts(texts), _) => texts,
        (Cells::Numbers(_), None) => unreachable!("dates are read as text"),
    };
    let time = |(text, line): (&String, &usize)| match TimeUnit::of_text(text) {
        Some(time) => Ok(time + offset_s),
        None if text.is_empty() => Ok(f64::NAN),
        None => Err(Failure::refuse(
            path,
            &format!("line {line}, column `{}`", spec.time.column),
            &format!("`{text}`"),
            "a date and time such as 2020-07-31T13:04:24.5Z",
            "correct the cell, or the time's `unit` in ingest.toml",
        )),
    };
    texts.iter().zip(&raw.lines).map(time).collect()
}

fn backwards(path: &Path, spec: &FileSpec, line: usize, time: f64, latest: f64) -> Failure {
    Failure::refuse(
        path,
        &format!("line {line}, column `{}`", spec.time.column),
        &format!("{time} s after {latest} s"),
        "time that does not go backwards",
        "set `non_monotonic` to \"sort\" or \"drop\", or correct the file",
    )
}

/// The channels in SI units; angles are unwrapped before they are scaled.
#[allow(clippy::too_many_arguments)]
fn channels(
    path: &Path,
    config: &IngestFile,
    spec: &FileSpec,
    units: &[Unit],
    raw: &Raw,
    rows: &[usize],
    times: &[f64],
) -> Result<Vec<Series>, Failure> {
    let lines: Vec<usize> = rows.iter().map(|row| raw.lines[*row]).collect();
    let channel = |(i, (spec, unit)): (usize, (&ChannelSpec, &Unit))| {
        let Cells::Numbers(numbers) = &raw.columns[i + 1] else {
            unreachable!("channels are read as numbers")
        };
        let mut values: Vec<f64> = rows.iter().map(|row| numbers[*row]).collect();
        check_turns(path, spec, unit, &values, &lines)?;
        values.iter_mut().for_each(|value| *value *= unit.factor);
        let times: Vec<f64> = times.iter().map(|time| time - spec.delay_s).collect();
        let series = Series::new(&times, &values, spec.max_gap_s.unwrap_or(config.max_gap_s));
        let series = if unit.si == "rad" { series.unwrapped() } else { series };
        Ok(series.map(|value| spec.sign * spec.scale * value + spec.offset))
    };
    let specs: Vec<(&ChannelSpec, &Unit)> = spec.channel.iter().zip(units).collect();
    specs.into_par_iter().enumerate().map(channel).collect()
}

/// Names all columns that are missing at once.
pub fn missing_columns(path: &Path, header: &[String], wanted: &[Wanted]) -> Failure {
    let mut missing: Vec<&str> = Vec::new();
    for wanted in wanted {
        if !header.contains(&wanted.column) && !missing.contains(&wanted.column.as_str()) {
            missing.push(&wanted.column);
        }
    }
    let near = |column: &&str| match nearest(column, header.iter().map(String::as_str)) {
        Some(near) => format!("did you mean `{near}` instead of `{column}`?"),
        None => format!("add `{column}`"),
    };
    let remedies: Vec<String> = missing.iter().map(near).collect();
    Failure::refuse(
        path,
        if missing.len() == 1 { "column" } else { "columns" },
        &format!("no `{}`", missing.join("`, `")),
        &format!("columns among `{}`", header.join("`, `")),
        &remedies.join(" "),
    )
}
