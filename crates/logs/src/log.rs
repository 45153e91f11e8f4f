//! One log file: its clock, its channels, what was left out.

use rayon::prelude::*;
use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::columns::cell_of;
use crate::suspicion::check_turns;
use crate::{Backwards, Cells, ChannelSpec, Columns, Plan, Series, TimeSpec, TimeUnit, Unit, order};

/// A file's channels on its own clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// Its times, increasing \[s\].
    pub times: Vec<f64>,
    /// One series per channel of the group, in order, in SI units.
    pub channels: Vec<Series>,
    /// Labels of sub-experiments, one per time.
    pub labels: Option<Vec<String>>,
    /// What was read and left out.
    pub counts: RowSummary,
}

/// Rows that were read, and left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RowSummary {
    /// All rows.
    pub read: u64,
    /// Left out: no value at all.
    pub empty: u64,
    /// Left out: cut short at the end of the file.
    pub cut: u64,
    /// Left out: no time.
    pub without_time: u64,
    /// Left out: the time of an earlier row.
    pub repeated: u64,
    /// Earlier than a row before: left out or put in order, as `non_monotonic` says.
    pub backwards: u64,
}

impl std::ops::AddAssign for RowSummary {
    fn add_assign(&mut self, other: Self) {
        self.read += other.read;
        self.empty += other.empty;
        self.cut += other.cut;
        self.without_time += other.without_time;
        self.repeated += other.repeated;
        self.backwards += other.backwards;
    }
}

impl Log {
    /// The log that stands in `columns`, those that [`Plan::wanted`] names for `group`.
    ///
    /// # Errors
    /// A time that is none, time going backwards, no rows, angles in another unit.
    pub fn new(columns: &Columns, group: usize, plan: &Plan) -> Result<Self, Invalid> {
        let spec = &plan.setup.files[group];
        let times = times(&spec.time, columns, plan.setup.written_in)?;
        let timed: Vec<usize> = (0..times.len()).filter(|row| times[*row].is_finite()).collect();
        let mut counts = RowSummary {
            read: (columns.lines.len() + columns.empty_rows + columns.cut_rows) as u64,
            empty: columns.empty_rows as u64,
            cut: columns.cut_rows as u64,
            without_time: (times.len() - timed.len()) as u64,
            ..RowSummary::default()
        };
        if timed.is_empty() {
            let found = format!("no rows with a time ({} read, {} empty)", counts.read, counts.empty);
            let remedy = "remove the file or narrow the pattern";
            return Err(Invalid::new("file", found, "at least one row", remedy));
        }
        let clock: Vec<f64> = timed.iter().map(|row| times[*row]).collect();
        let ordered =
            order(&clock, plan.setup.non_monotonic).map_err(|Backwards { row, time, latest }| {
                Invalid::new(
                    cell_of(columns.lines[timed[row]], &spec.time.column),
                    format!("{time} s after {latest} s"),
                    "time that does not go backwards",
                    "set `non_monotonic` to \"sort\" or \"drop\", or correct the file",
                )
            })?;
        (counts.repeated, counts.backwards) = (ordered.repeated as u64, ordered.backwards as u64);
        let rows: Vec<usize> = ordered.rows.iter().map(|row| timed[*row]).collect();
        let times: Vec<f64> = rows.iter().map(|row| times[*row]).collect();
        let rows = Rows { columns, rows: &rows, times: &times };
        let specs: Vec<(&ChannelSpec, &Unit)> = spec.channel.iter().zip(&plan.units[group]).collect();
        let channel = |(i, (spec, unit))| rows.channel(1 + i, spec, unit, plan.setup.max_gap_s);
        let channels = specs.into_par_iter().enumerate().map(channel).collect::<Result<_, _>>()?;
        let labels = spec.label_column.is_some().then(|| rows.labels());
        Ok(Self { times, channels, labels, counts })
    }
}

/// The rows that stay of a file, in the order of time.
struct Rows<'a> {
    columns: &'a Columns,
    rows: &'a [usize],
    times: &'a [f64],
}

impl Rows<'_> {
    /// The channel in column `place` in SI units; angles are unwrapped before they are scaled.
    fn channel(
        &self,
        place: usize,
        spec: &ChannelSpec,
        unit: &Unit,
        max_gap_s: f64,
    ) -> Result<Series, Invalid> {
        let Cells::Numbers(numbers) = &self.columns.cells[place] else {
            unreachable!("channels are read as numbers")
        };
        let mut values: Vec<f64> = self.rows.iter().map(|row| numbers[*row]).collect();
        check_turns(&spec.column, unit, &values, |i| self.columns.lines[self.rows[i]])?;
        values.iter_mut().for_each(|value| *value *= unit.factor);
        let times: Vec<f64> = self.times.iter().map(|time| time - spec.delay_s).collect();
        let series = Series::new(&times, &values, spec.max_gap_s.unwrap_or(max_gap_s));
        let series = if unit.si == "rad" { series.unwrapped() } else { series };
        Ok(series.map(|value| spec.sign * spec.scale * value + spec.offset))
    }

    /// The last column.
    fn labels(&self) -> Vec<String> {
        match self.columns.cells.last() {
            Some(Cells::Texts(texts)) => self.rows.iter().map(|row| texts[*row].clone()).collect(),
            _ => Vec::new(),
        }
    }
}

fn times(spec: &TimeSpec, columns: &Columns, written_in: &str) -> Result<Vec<f64>, Invalid> {
    let texts = match (&columns.cells[0], spec.unit.seconds()) {
        (Cells::Numbers(numbers), Some(unit)) => {
            return Ok(numbers.iter().map(|n| n * unit + spec.offset_s).collect());
        }
        (Cells::Texts(texts), _) => texts,
        (Cells::Numbers(_), None) => unreachable!("dates are read as text"),
    };
    let time = |(text, line): (&String, &usize)| match TimeUnit::of_text(text) {
        Some(time) => Ok(time + spec.offset_s),
        None if text.is_empty() => Ok(f64::NAN),
        None => Err(Invalid::new(
            cell_of(*line, &spec.column),
            format!("`{text}`"),
            "a date and time such as 2020-07-31T13:04:24.5Z",
            format!("correct the cell, or the time's `unit` in {written_in}"),
        )),
    };
    texts.iter().zip(&columns.lines).map(time).collect()
}
