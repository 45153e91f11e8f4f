//! One log file: its clock, its channels, what was left out.

use std::sync::Arc;

use rayon::prelude::*;
use refusal::{Invalid, foreign};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::axes::angles;
use crate::clock::{set, spread, unrolled};
use crate::columns::cell_of;
use crate::gate::{Gate, Limit, check_share};
use crate::samples::{View, steps};
use crate::suspicion::{LoggedShape, Turns};
use crate::{
    Backwards, Cells, ChannelSpec, ClockNotes, Columns, FileSpec, Labels, NonMonotonic, Numbering, Omissions,
    Plan, Repeated, Samples, Series, TimeSpec, TimeUnit, Unit, Unwrapping, WarningSummary, order,
};

/// Share of rows that may repeat the time of an earlier row without a setting in the configuration.
const FEW: f64 = 0.2;

/// A file's channels on its own clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// Its times, increasing \[s\].
    pub times: Arc<Samples>,
    /// One series per channel of the group, in order, in SI units.
    pub channels: Vec<Series>,
    /// How each channel looked as logged.
    pub(crate) seen: Vec<LoggedShape>,
    /// Labels of sub-experiments, one per time.
    pub labels: Option<Labels>,
    /// What was read and left out.
    pub counts: RowSummary,
    /// Values that were left out, by channel and reason.
    pub omitted: Omissions,
    /// Per channel, the number of rows, with a value or without.
    pub(crate) rows: Vec<usize>,
    /// Oddities of its sources.
    pub(crate) warnings: Vec<WarningSummary>,
    /// The moment of a leap second that its clock showed \[s\].
    pub(crate) leap_s: Option<f64>,
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
    /// Rows that had the time of the row before and were spread until the next.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub spread: u64,
    /// Left out: sentences with a wrong checksum.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub wrong_checksums: u64,
    /// Sentences of the clock that came late: they told no time.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub late: u64,
    /// Sentences that neither a channel nor the clock takes, and lines without a sentence.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub unused: u64,
    /// Of those that went backwards, put in order.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub sorted: u64,
    /// Left out: before the clock was set.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub unset: u64,
    /// Times at which the clock began anew and was counted on: midnight without a date, weeks, counters of so many bits.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rollovers: u64,
    /// Files with a second 60, which is a second of its own: what comes later is a second later than its clock showed.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub leap_seconds: u64,
    /// Rows whose decimals of the time are a whole number of nano-, micro- or milliseconds without leading zeros.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub unpadded: u64,
}

impl RowSummary {
    /// All rows that were left out.
    pub fn dropped(&self) -> u64 {
        let late = self.backwards.saturating_sub(self.sorted);
        self.empty + self.cut + self.without_time + self.repeated + self.wrong_checksums + self.unset + late
    }

    /// Corrections of the clock's times, in words.
    pub fn mended(&self) -> Option<String> {
        let counts = [
            (self.rollovers, "clock rollovers"),
            (self.leap_seconds, "leap seconds"),
            (self.unpadded, "times without leading zeros in their decimals"),
        ];
        let words =
            counts.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}"));
        words.reduce(|all, one| all + ", " + &one)
    }
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl std::ops::AddAssign for RowSummary {
    fn add_assign(&mut self, other: Self) {
        self.read += other.read;
        self.empty += other.empty;
        self.cut += other.cut;
        self.without_time += other.without_time;
        self.repeated += other.repeated;
        self.backwards += other.backwards;
        self.spread += other.spread;
        self.wrong_checksums += other.wrong_checksums;
        self.late += other.late;
        self.unused += other.unused;
        self.sorted += other.sorted;
        self.unset += other.unset;
        self.rollovers += other.rollovers;
        self.leap_seconds += other.leap_seconds;
        self.unpadded += other.unpadded;
    }
}

impl Log {
    /// The log of some of the channels, which stand in `columns` after their clock.
    pub(crate) fn of(
        columns: Columns,
        channels: &[usize],
        group: usize,
        plan: &Plan,
    ) -> Result<Self, Invalid> {
        let Columns {
            cells,
            lines,
            empty_rows,
            cut_rows,
            wrong_checksums,
            omitted: by_column,
            clock: notes,
            ..
        } = columns;
        let (spec, mut cells) = (&plan.setup.files[group], cells.into_iter());
        let clock = cells.next();
        let nanoseconds = spec.time.nanoseconds.as_ref().and_then(|_| cells.next());
        let mut times = times(&spec.time, clock, nanoseconds, &lines)?;
        let mut counts = RowSummary {
            read: (lines.rows() + empty_rows + cut_rows + wrong_checksums) as u64,
            empty: empty_rows as u64,
            cut: cut_rows as u64,
            wrong_checksums: wrong_checksums as u64,
            ..RowSummary::default()
        };
        times = if columns.is_stamped {
            offset(times, spec.time.offset_s)
        } else {
            running(times, &notes, plan, group, &lines, &mut counts)?
        };
        if spec.time.repeated == Repeated::Spread {
            let moved;
            (times, moved) = spread(times, columns.is_stamped);
            counts.spread = moved as u64;
        }
        let policy = if columns.is_sorted { NonMonotonic::Sort } else { plan.setup.non_monotonic };
        let rows = in_order(&times, &lines, plan, (group, policy), &mut counts)?;
        let times = Arc::new(rows.gathered(times));
        let rows = KeptRows { rows, lines, times, max_gap_s: plan.setup.max_gap_s };
        let labels = spec.label_column.is_some().then(|| cells.next_back()).flatten();
        let specs = channels.iter().map(|channel| {
            let column = (&spec.channel[*channel], &plan.units[group][*channel]);
            (column, &plan.limits[group][*channel])
        });
        let cells = with_angles(cells.collect(), spec, &rows.lines)?;
        let channels: Vec<_> = cells.into_iter().zip(specs).collect();
        let channel = |(cells, ((spec, unit), limit))| rows.channel(cells, spec, unit, limit);
        let judged: Vec<_> = channels.into_par_iter().map(channel).collect();
        let judged = judged.into_iter().collect::<Result<Vec<_>, _>>()?;
        let labels = labels.map(|labels| rows.labels(labels));
        let mut omitted = Omissions::default();
        omitted.append(&by_column, |column| {
            let channel = spec.channel.iter().find(|channel| channel.column == column);
            channel.map_or(column, |channel| &channel.channel)
        });
        let (mut channels, mut seen) = (Vec::with_capacity(judged.len()), Vec::with_capacity(judged.len()));
        for (series, shape, impossible) in judged {
            omitted.append(&impossible, |name| name);
            channels.push(series);
            seen.push(shape);
        }
        Ok(Self {
            rows: vec![rows.times.len(); channels.len()],
            times: rows.times,
            channels,
            seen,
            labels,
            counts,
            omitted,
            warnings: Vec::new(),
            leap_s: notes.leap_s.filter(|_| !notes.of_day),
        })
    }
}

/// `times` as those of a clock that runs on steadily, plus the declared offset; counts the corrections.
fn running(
    times: Samples,
    notes: &ClockNotes,
    plan: &Plan,
    group: usize,
    lines: &Numbering,
    counts: &mut RowSummary,
) -> Result<Samples, Invalid> {
    let spec = &plan.setup.files[group].time;
    let (times, padded) = notes.fractions.padded(times);
    let of_day = notes.of_day || plan.stamps(group).of_day();
    // Dates do not begin anew.
    let is_dated = spec.is_text() && !of_day;
    let (times, rollovers) =
        if is_dated { (times, 0) } else { unrolled(times, of_day, plan.setup.max_gap_s) };
    let (times, unset) = set(times).map_err(|(row, [before, after])| {
        Invalid::new(
            cell_of(lines.place(row), &spec.column),
            format!("{after} s after {before} s, years later"),
            "times of one recording",
            "correct the clock, or cut the file there",
        )
    })?;
    counts.unpadded = padded as u64;
    counts.rollovers = rollovers as u64;
    counts.unset = unset as u64;
    counts.leap_seconds = u64::from(notes.leap_s.is_some());
    Ok(offset(times, spec.offset_s))
}

fn offset(times: Samples, offset_s: f64) -> Samples {
    match offset_s {
        0.0 => times,
        offset_s => times.made(times.iter().map(|time| time + offset_s)),
    }
}

/// The rows of a file that are kept, in order of time.
enum KeptSamples {
    /// All of them.
    All,
    /// These, in the order of the file.
    These(Vec<u32>),
    /// These, sorted by time.
    Sorted(Vec<u32>),
}

impl KeptSamples {
    /// The file's row that is kept row `i`.
    fn row(&self, i: usize) -> usize {
        match self {
            Self::All => i,
            Self::These(rows) | Self::Sorted(rows) => rows[i] as usize,
        }
    }

    /// The kept ones of `values`, one per row of the file.
    fn gathered(&self, values: Samples) -> Samples {
        match self {
            Self::All => values,
            Self::These(rows) => {
                let mut view = View::new(&values);
                values.made(rows.iter().map(|row| view.at(*row as usize)))
            }
            // Rows may come from anywhere: all of them are held in memory.
            Self::Sorted(rows) => {
                let all = values.to_vec();
                values.made(rows.iter().map(|row| all[*row as usize]))
            }
        }
    }
}

/// The rows with a time in order, as `non_monotonic` of `plan` says; counts those that are left out.
fn in_order(
    times: &Samples,
    lines: &Numbering,
    plan: &Plan,
    (group, policy): (usize, NonMonotonic),
    counts: &mut RowSummary,
) -> Result<KeptSamples, Invalid> {
    let timed = times.iter().filter(|time| time.is_finite()).count();
    if timed > 0 && timed == times.len() && steps(times.iter()).all(|step| step > 0.0) {
        return Ok(KeptSamples::All);
    }
    counts.without_time = ((times.len() - timed) as u64).saturating_sub(counts.unset);
    if timed == 0 {
        let counted = format!("no rows with a time ({} read, {} empty)", counts.read, counts.empty);
        let remedy = "remove the file or narrow the pattern";
        return Err(Invalid::new("file", counted, "at least one row", remedy));
    }
    check_seams(times, lines, plan)?;
    let ordered = order(times, policy).map_err(|Backwards { row, time, latest }| {
        Invalid::new(
            cell_of(lines.place(row), &plan.setup.files[group].time.column),
            format!("{time} s after {latest} s"),
            "time that does not go backwards",
            "set `non_monotonic` to \"sort\" or \"drop\", or correct the file",
        )
    })?;
    (counts.repeated, counts.backwards) = (ordered.repeated as u64, ordered.backwards as u64);
    let few = ordered.repeated as f64 <= FEW * timed as f64;
    let spec = &plan.setup.files[group].time;
    if !few && spec.repeated == Repeated::Refuse {
        return Err(Invalid::new(
            format!("column `{}`", spec.column),
            format!("the time of an earlier row in {} of {timed} rows", ordered.repeated),
            "a time of its own for every row",
            "set `repeated` in [file.time] to \"spread\", which spreads the rows of one time evenly until the next, or to \"drop\", \
             which keeps the first",
        ));
    }
    let sorted = policy == NonMonotonic::Sort && ordered.backwards > 0;
    counts.sorted = if sorted { counts.backwards } else { 0 };
    Ok(if sorted { KeptSamples::Sorted(ordered.rows) } else { KeptSamples::These(ordered.rows) })
}

/// Refuses files of one recording that were logged at the same time.
fn check_seams(times: &Samples, lines: &Numbering, plan: &Plan) -> Result<(), Invalid> {
    let (mut latest, mut from) = (f64::NEG_INFINITY, 0);
    for (row, name) in lines.seams() {
        let ended = times.range(from..row).filter(|time| time.is_finite()).fold(latest, f64::max);
        let begins = times.range(row..times.len()).find(|time| time.is_finite());
        if let Some(begins) = begins.filter(|begins| *begins < ended - plan.setup.max_gap_s) {
            return Err(Invalid::new(
                "files of one recording",
                format!("`{}`, which begins at {begins} s, where others last until {ended} s", foreign(name)),
                "files that follow each other",
                "correct `run_from_file`, leave one out, or make it a [[file]] of its own",
            ));
        }
        (latest, from) = (ended, row);
    }
    Ok(())
}

/// The kept rows of a file, in order of time.
struct KeptRows {
    rows: KeptSamples,
    lines: Numbering,
    times: Arc<Samples>,
    max_gap_s: f64,
}

impl KeptRows {
    /// The channel in `cells` in SI units, how it looked as logged, and what is left out because it is impossible; angles
    /// are unwrapped before they are scaled.
    fn channel(
        &self,
        cells: Cells,
        spec: &ChannelSpec,
        unit: &Unit,
        limit: &Limit,
    ) -> Result<(Series, LoggedShape, Omissions), Invalid> {
        let Cells::Numbers(numbers) = cells else { unreachable!("channels are read as numbers") };
        let numbers = self.rows.gathered(numbers);
        let (mut turns, mut gate) = (Turns::new(unit), Gate::new(spec, unit, limit));
        numbers.iter().zip(self.times.iter()).for_each(|(number, time)| turns.see(gate.see(number), time));
        turns.check(&spec.column, |i| self.lines.place(self.rows.row(i)))?;
        let delayed = || Arc::new(numbers.made(self.times.iter().map(|time| time - spec.delay_s)));
        let times = if spec.delay_s == 0.0 { Arc::clone(&self.times) } else { delayed() };
        let mut unwrapping = (unit.si == "rad").then(Unwrapping::default);
        // For angles beyond a turn the scale belongs to the unit; else it is a gear ratio, and the angle wraps before it.
        let of_unit = spec.scale != 1.0 && turns.go_beyond();
        let [inner, outer] =
            if of_unit { [unit.factor * spec.scale, 1.0] } else { [unit.factor, spec.scale] };
        let values = numbers.iter().map(|number| {
            let value = gate.keep(number) * inner;
            let unwrapped = match unwrapping.as_mut().filter(|_| value.is_finite()) {
                Some(unwrapping) => unwrapping.next(value),
                None => value,
            };
            spec.sign * outer * unwrapped + spec.offset
        });
        let series = Series::shared(&times, numbers.made(values), spec.max_gap_s.unwrap_or(self.max_gap_s));
        let (values, omitted) = gate.counted();
        check_share(&spec.channel, values, omitted.as_slice(), spec.max_omitted, Some(limit))?;
        Ok((series, turns.seen(), omitted))
    }

    fn labels(&self, cells: Cells) -> Labels {
        let Cells::Labels(labels) = cells else { return Labels::default() };
        if matches!(self.rows, KeptSamples::All) {
            return labels;
        }
        let mut kept = Labels::default();
        (0..self.times.len()).for_each(|i| kept.push(labels.at(self.rows.row(i))));
        kept
    }
}

/// Times in seconds from the column of times, and from that of their nanoseconds if there is one.
fn times(
    spec: &TimeSpec,
    cells: Option<Cells>,
    nanoseconds: Option<Cells>,
    lines: &Numbering,
) -> Result<Samples, Invalid> {
    let Some(Cells::Numbers(times)) = cells else { unreachable!("times are read as numbers") };
    // A column that does not hold plain numbers is in seconds already.
    let unit = spec.unit.and_then(TimeUnit::seconds).unwrap_or(1.0);
    let Some(Cells::Numbers(nanoseconds)) = nanoseconds else {
        return Ok(if unit == 1.0 { times } else { times.made(times.iter().map(|time| time * unit)) });
    };
    if let Some((row, wrong)) =
        nanoseconds.iter().enumerate().find(|(_, ns)| !(ns.is_nan() || (0.0..1e9).contains(ns)))
    {
        let column = spec.nanoseconds.as_deref().unwrap_or_default();
        let expected = "nanoseconds of a second, from 0 to 999999999";
        let remedy = "correct the cell, or the time's `nanoseconds`";
        return Err(Invalid::new(cell_of(lines.place(row), column), format!("{wrong}"), expected, remedy));
    }
    let both = times.iter().zip(nanoseconds.iter());
    Ok(times.made(both.map(|(time, ns)| time * unit + 1e-9 * ns)))
}

/// The cells of all channels: those that have a column of their own, and after them the angles of the quaternions.
fn with_angles(mut cells: Vec<Cells>, spec: &FileSpec, lines: &Numbering) -> Result<Vec<Cells>, Invalid> {
    let mut parts = cells.split_off(spec.plain().len().min(cells.len())).into_iter();
    for quaternion in &spec.quaternion {
        if let [Some(w), Some(x), Some(y), Some(z)] = [(); 4].map(|()| parts.next()) {
            cells.extend(angles(quaternion, [w, x, y, z], |row| lines.place(row))?);
        }
    }
    Ok(cells)
}
