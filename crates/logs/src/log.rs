//! One log file: its clock, its channels, what was left out.

use std::sync::Arc;

use rayon::prelude::*;
use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::columns::cell_of;
use crate::samples::{View, steps};
use crate::suspicion::Turns;
use crate::{
    Backwards, Cells, ChannelSpec, Columns, Labels, NonMonotonic, Numbering, Plan, Samples, Series, TimeSpec,
    Unit, Unwrapping, order,
};

/// A file's channels on its own clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// Its times, increasing \[s\].
    pub times: Arc<Samples>,
    /// One series per channel of the group, in order, in SI units.
    pub channels: Vec<Series>,
    /// The largest modulus of each channel as it was logged, in SI units.
    pub largest: Vec<f64>,
    /// Labels of sub-experiments, one per time.
    pub labels: Option<Labels>,
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
            read: (lines.rows() + empty_rows + cut_rows) as u64,
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
        let channels = channels.into_par_iter().map(channel).collect::<Result<Vec<_>, _>>()?;
        let (channels, largest) = channels.into_iter().unzip();
        let labels = labels.map(|labels| rows.labels(labels));
        Ok(Self { times: rows.times, channels, largest, labels, counts })
    }
}

/// Which rows of a file stay, in the order of time.
enum Kept {
    /// All of them.
    All,
    /// These, as they follow each other in the file.
    These(Vec<u32>),
    /// These, as time orders them.
    Sorted(Vec<u32>),
}

impl Kept {
    /// The row of the file that row `i` of those kept is.
    fn row(&self, i: usize) -> usize {
        match self {
            Self::All => i,
            Self::These(rows) | Self::Sorted(rows) => rows[i] as usize,
        }
    }

    /// What is kept of `values`, one per row of the file.
    fn gathered(&self, values: Samples) -> Samples {
        match self {
            Self::All => values,
            Self::These(rows) => {
                let mut view = View::new(&values);
                values.made(rows.iter().map(|row| view.at(*row as usize)))
            }
            // Rows may come from anywhere: they are all held in memory.
            Self::Sorted(rows) => {
                let all = values.to_vec();
                values.made(rows.iter().map(|row| all[*row as usize]))
            }
        }
    }
}

/// The rows with a time in its order, as `non_monotonic` of `plan` says; counts those that are left out.
fn in_order(
    times: &Samples,
    lines: &Numbering,
    plan: &Plan,
    group: usize,
    counts: &mut RowSummary,
) -> Result<Kept, Invalid> {
    let timed = times.iter().filter(|time| time.is_finite()).count();
    if timed > 0 && timed == times.len() && steps(times.iter()).all(|step| step > 0.0) {
        return Ok(Kept::All);
    }
    counts.without_time = (times.len() - timed) as u64;
    if timed == 0 {
        let found = format!("no rows with a time ({} read, {} empty)", counts.read, counts.empty);
        let remedy = "remove the file or narrow the pattern";
        return Err(Invalid::new("file", found, "at least one row", remedy));
    }
    let ordered = order(times, plan.setup.non_monotonic).map_err(|Backwards { row, time, latest }| {
        Invalid::new(
            cell_of(lines.line(row), &plan.setup.files[group].time.column),
            format!("{time} s after {latest} s"),
            "time that does not go backwards",
            "set `non_monotonic` to \"sort\" or \"drop\", or correct the file",
        )
    })?;
    (counts.repeated, counts.backwards) = (ordered.repeated as u64, ordered.backwards as u64);
    let sorted = plan.setup.non_monotonic == NonMonotonic::Sort && ordered.backwards > 0;
    Ok(if sorted { Kept::Sorted(ordered.rows) } else { Kept::These(ordered.rows) })
}

/// The rows that stay of a file, in the order of time.
struct Rows {
    rows: Kept,
    lines: Numbering,
    times: Arc<Samples>,
    max_gap_s: f64,
}

impl Rows {
    /// The channel that stands in `cells` in SI units, and the largest modulus there; angles are unwrapped before they are
    /// scaled.
    fn channel(&self, cells: Cells, spec: &ChannelSpec, unit: &Unit) -> Result<(Series, f64), Invalid> {
        let Cells::Numbers(numbers) = cells else { unreachable!("channels are read as numbers") };
        let numbers = self.rows.gathered(numbers);
        let mut turns = Turns::new(unit);
        numbers.iter().for_each(|number| turns.see(number));
        turns.check(&spec.column, |i| self.lines.line(self.rows.row(i)))?;
        let delayed = || Arc::new(numbers.made(self.times.iter().map(|time| time - spec.delay_s)));
        let times = if spec.delay_s == 0.0 { Arc::clone(&self.times) } else { delayed() };
        let mut unwrapping = (unit.si == "rad").then(Unwrapping::default);
        let values = numbers.iter().map(|number| {
            let value = number * unit.factor;
            let unwrapped = match unwrapping.as_mut().filter(|_| value.is_finite()) {
                Some(unwrapping) => unwrapping.next(value),
                None => value,
            };
            spec.sign * spec.scale * unwrapped + spec.offset
        });
        let series = Series::shared(&times, numbers.made(values), spec.max_gap_s.unwrap_or(self.max_gap_s));
        Ok((series, unit.factor * turns.largest()))
    }

    fn labels(&self, cells: Cells) -> Labels {
        let Cells::Labels(labels) = cells else { return Labels::default() };
        if matches!(self.rows, Kept::All) {
            return labels;
        }
        let mut kept = Labels::default();
        (0..self.times.len()).for_each(|i| kept.push(labels.at(self.rows.row(i))));
        kept
    }
}

/// Times in seconds from what the column of times holds.
fn times(spec: &TimeSpec, cells: Option<Cells>) -> Samples {
    let Some(Cells::Numbers(times)) = cells else { unreachable!("times are read as numbers") };
    // Dates are in seconds already.
    let unit = spec.unit.seconds().unwrap_or(1.0);
    times.made(times.iter().map(|time| time * unit + spec.offset_s))
}
