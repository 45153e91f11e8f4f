//! One log file: its clock, its channels, what was left out.

use std::sync::Arc;

use rayon::prelude::*;
use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::columns::cell_of;
use crate::suspicion::check_turns;
use crate::{Backwards, Cells, ChannelSpec, Columns, Plan, Series, TimeSpec, Unit, order};

/// A file's channels on its own clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// Its times, increasing \[s\].
    pub times: Arc<Vec<f64>>,
    /// One series per channel of the group, in order, in SI units.
    pub channels: Vec<Series>,
    /// Labels of sub-experiments, one per time.
    pub labels: Option<Vec<Arc<str>>>,
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
    /// Time going backwards, no rows, angles in another unit.
    pub fn new(columns: Columns, group: usize, plan: &Plan) -> Result<Self, Invalid> {
        let Columns { cells, lines, empty_rows, cut_rows } = columns;
        let (spec, mut cells) = (&plan.setup.files[group], cells.into_iter());
        let times = times(&spec.time, cells.next());
        let mut counts = RowSummary {
            read: (lines.len() + empty_rows + cut_rows) as u64,
            empty: empty_rows as u64,
            cut: cut_rows as u64,
            ..RowSummary::default()
        };
        let rows = in_order(&times, &lines, plan, group, &mut counts)?;
        let times = Arc::new(rows.gathered(times));
        let rows = Rows { rows, lines, times, max_gap_s: plan.setup.max_gap_s };
        let labels = spec.label_column.is_some().then(|| cells.next_back()).flatten();
        let specs = spec.channel.iter().zip(&plan.units[group]);
        let channels: Vec<(Cells, (&ChannelSpec, &Unit))> = cells.zip(specs).collect();
        let channel = |(cells, (spec, unit))| rows.channel(cells, spec, unit);
        let channels = channels.into_par_iter().map(channel).collect::<Result<_, _>>()?;
        let labels = labels.map(|labels| rows.labels(labels));
        Ok(Self { times: rows.times, channels, labels, counts })
    }
}

/// Which rows of a file stay, in the order of time.
enum Kept {
    /// All of them.
    All,
    /// These.
    These(Vec<usize>),
}

impl Kept {
    /// The row of the file that row `i` of those kept is.
    fn row(&self, i: usize) -> usize {
        match self {
            Self::All => i,
            Self::These(rows) => rows[i],
        }
    }

    /// What is kept of `values`, one per row of the file.
    fn gathered<T: Clone>(&self, values: Vec<T>) -> Vec<T> {
        match self {
            Self::All => values,
            Self::These(rows) => rows.iter().map(|row| values[*row].clone()).collect(),
        }
    }
}

/// The rows with a time in its order, as `non_monotonic` of `plan` says; counts those that are left out.
fn in_order(
    times: &[f64],
    lines: &[u32],
    plan: &Plan,
    group: usize,
    counts: &mut RowSummary,
) -> Result<Kept, Invalid> {
    if !times.is_empty() && times.iter().all(|t| t.is_finite()) && times.windows(2).all(|t| t[0] < t[1]) {
        return Ok(Kept::All);
    }
    let timed: Vec<usize> = (0..times.len()).filter(|row| times[*row].is_finite()).collect();
    counts.without_time = (times.len() - timed.len()) as u64;
    if timed.is_empty() {
        let found = format!("no rows with a time ({} read, {} empty)", counts.read, counts.empty);
        let remedy = "remove the file or narrow the pattern";
        return Err(Invalid::new("file", found, "at least one row", remedy));
    }
    let clock: Vec<f64> = timed.iter().map(|row| times[*row]).collect();
    let ordered = order(&clock, plan.setup.non_monotonic).map_err(|Backwards { row, time, latest }| {
        Invalid::new(
            cell_of(lines[timed[row]] as usize, &plan.setup.files[group].time.column),
            format!("{time} s after {latest} s"),
            "time that does not go backwards",
            "set `non_monotonic` to \"sort\" or \"drop\", or correct the file",
        )
    })?;
    (counts.repeated, counts.backwards) = (ordered.repeated as u64, ordered.backwards as u64);
    Ok(Kept::These(ordered.rows.iter().map(|row| timed[*row]).collect()))
}

/// The rows that stay of a file, in the order of time.
struct Rows {
    rows: Kept,
    lines: Vec<u32>,
    times: Arc<Vec<f64>>,
    max_gap_s: f64,
}

impl Rows {
    /// The channel that stands in `cells` in SI units; angles are unwrapped before they are scaled.
    fn channel(&self, cells: Cells, spec: &ChannelSpec, unit: &Unit) -> Result<Series, Invalid> {
        let Cells::Numbers(numbers) = cells else { unreachable!("channels are read as numbers") };
        let mut values = self.rows.gathered(numbers);
        check_turns(&spec.column, unit, &values, |i| self.lines[self.rows.row(i)] as usize)?;
        values.iter_mut().for_each(|value| *value *= unit.factor);
        let delayed = || Arc::new(self.times.iter().map(|time| time - spec.delay_s).collect());
        let times = if spec.delay_s == 0.0 { Arc::clone(&self.times) } else { delayed() };
        let series = Series::shared(&times, values, spec.max_gap_s.unwrap_or(self.max_gap_s));
        let series = if unit.si == "rad" { series.unwrapped() } else { series };
        Ok(series.map(|value| spec.sign * spec.scale * value + spec.offset))
    }

    fn labels(&self, cells: Cells) -> Vec<Arc<str>> {
        match cells {
            Cells::Labels(labels) => self.rows.gathered(labels),
            Cells::Numbers(_) => Vec::new(),
        }
    }
}

/// Times in seconds from what the column of times holds.
fn times(spec: &TimeSpec, cells: Option<Cells>) -> Vec<f64> {
    let Some(Cells::Numbers(mut times)) = cells else { unreachable!("times are read as numbers") };
    // Dates are in seconds already.
    let unit = spec.unit.seconds().unwrap_or(1.0);
    times.iter_mut().for_each(|time| *time = *time * unit + spec.offset_s);
    times
}
