//! A log from the columns of a file: on one clock, or of several sensors, each with a clock of its own.

use std::f64::consts::TAU;
use std::sync::Arc;

use refusal::Invalid;

use crate::suspicion::LoggedShape;
use crate::{
    Apart, ChannelSpec, Columns, Log, Omissions, Plan, RowSummary, Samples, Series, WarningKind,
    WarningSummary,
};

/// A sensor's values of a channel.
struct Choice {
    rank: usize,
    source: String,
    series: Series,
    seen: LoggedShape,
    rows: usize,
}

impl Log {
    /// The log made of `columns`, which are those that [`Plan::wanted`] names for `group`.
    ///
    /// # Errors
    /// Time going backwards, no rows, angles in another unit.
    pub fn new(columns: Columns, group: usize, plan: &Plan) -> Result<Self, Invalid> {
        if !columns.apart.is_empty() {
            return joined(columns, group, plan);
        }
        let all: Vec<usize> = (0..plan.setup.files[group].channel.len()).collect();
        Self::of(columns, &all, group, plan)
    }
}

impl Log {
    /// The log of a recording that has no files of `group`: its channels have no values.
    pub fn absent(group: usize, plan: &Plan) -> Self {
        let spec = &plan.setup.files[group];
        let names: Vec<&str> = spec.channel.iter().map(|channel| channel.channel.as_str()).collect();
        let text = format!("no files of `{}`: without `{}`", spec.pattern.join("`, `"), names.join("`, `"));
        let channel = names.first().copied().unwrap_or_default().to_owned();
        let gap = |channel: &ChannelSpec| channel.max_gap_s.unwrap_or(plan.setup.max_gap_s);
        Self {
            times: Arc::new(Samples::default()),
            channels: spec.channel.iter().map(|channel| Series::new(&[], &[], gap(channel))).collect(),
            seen: vec![LoggedShape::default(); names.len()],
            rows: vec![0; names.len()],
            labels: None,
            counts: RowSummary::default(),
            omitted: Omissions::default(),
            warnings: vec![WarningSummary { kind: WarningKind::Source, channel, count: 1, text }],
            leap_s: None,
        }
    }
}

/// The log made of `columns` whose sensors all have clocks of their own.
fn joined(columns: Columns, group: usize, plan: &Plan) -> Result<Log, Invalid> {
    let spec = &plan.setup.files[group];
    let mut choices: Vec<Vec<Choice>> = spec.channel.iter().map(|_| Vec::new()).collect();
    let (mut times, mut omitted) = (Arc::new(Samples::default()), Omissions::default());
    let mut counts = RowSummary {
        read: (columns.wrong_checksums + columns.cut_rows) as u64,
        cut: columns.cut_rows as u64,
        wrong_checksums: columns.wrong_checksums as u64,
        late: columns.late as u64,
        unused: columns.unused as u64,
        ..RowSummary::default()
    };
    for Apart { source, channels, columns } in columns.apart {
        let repeated = columns.repeated as u64;
        counts += RowSummary { read: repeated, repeated, ..RowSummary::default() };
        let places: Vec<usize> = channels.iter().map(|(channel, _)| *channel).collect();
        let Some(log) = of_sensor(columns, &places, group, plan, &mut counts)? else { continue };
        omitted.append(&log.omitted, |channel| channel);
        let rows = log.times.len();
        // The recording begins with the sensor that begins first.
        if times.first().is_none_or(|first| log.times.first().is_some_and(|begin| begin < first)) {
            times = log.times;
        }
        for (((channel, rank), series), seen) in channels.into_iter().zip(log.channels).zip(log.seen) {
            let choice = |rank| Choice { rank, source: source.clone(), series, seen, rows };
            choices[channel].extend(rank.map(choice));
        }
    }
    if times.is_empty() {
        let counted = format!("no rows with a time ({} read)", counts.read);
        return Err(Invalid::new(
            "file",
            counted,
            "at least one row",
            "remove the file or narrow the pattern",
        ));
    }
    let mut warnings = columns.warnings;
    let mut joined = Log {
        times,
        channels: Vec::new(),
        seen: Vec::new(),
        rows: Vec::new(),
        labels: None,
        counts,
        omitted,
        warnings: Vec::new(),
        leap_s: columns.clock.leap_s.filter(|_| !columns.clock.of_day),
    };
    for ((candidates, spec), unit) in choices.into_iter().zip(&spec.channel).zip(&plan.units[group]) {
        let gap = spec.max_gap_s.unwrap_or(plan.setup.max_gap_s);
        let turn = (unit.si == "rad").then_some(TAU);
        let (series, seen, rows) = chosen(candidates, spec, turn, gap, &mut warnings);
        joined.channels.push(series);
        joined.seen.push(seen);
        joined.rows.push(rows);
    }
    Ok(Log { warnings, ..joined })
}

/// The log of one sensor; `None` where none of its rows has a time.
fn of_sensor(
    columns: Columns,
    channels: &[usize],
    group: usize,
    plan: &Plan,
    counts: &mut RowSummary,
) -> Result<Option<Log>, Invalid> {
    let is_timed = match columns.cells.first() {
        Some(crate::Cells::Numbers(times)) => times.iter().any(f64::is_finite),
        _ => false,
    };
    if !is_timed {
        let rows = columns.lines.rows() as u64;
        *counts += RowSummary { read: rows, without_time: rows, ..RowSummary::default() };
        return Ok(None);
    }
    let log = Log::of(columns, channels, group, plan)?;
    *counts += log.counts;
    Ok(Some(log))
}

/// The channel from the best of its sources, its gaps filled from the others; how it looked as logged, and
/// how many rows it has.
fn chosen(
    mut candidates: Vec<Choice>,
    spec: &ChannelSpec,
    turn: Option<f64>,
    gap: f64,
    warnings: &mut Vec<WarningSummary>,
) -> (Series, LoggedShape, usize) {
    candidates.sort_by_key(|choice| choice.rank);
    let mut candidates = candidates.into_iter();
    let Some(first) = candidates.next() else {
        return (Series::new(&[], &[], gap), LoggedShape::default(), 0);
    };
    let (mut series, mut rows) = (first.series, first.rows);
    for other in candidates {
        let before = series.t.len();
        series = filled(&series, &other.series, turn);
        let count = (series.t.len() - before) as u64;
        rows += series.t.len() - before;
        let channel = spec.channel.clone();
        let text = format!("is from {} in {count} values where {} has none", other.source, first.source);
        let text = format!("`{channel}` {text}");
        if count > 0 {
            warnings.push(WarningSummary { kind: WarningKind::Source, channel, count, text });
        }
    }
    (series, first.seen, rows)
}

/// `first` with the values of `other` in its gaps, before it and after it; angles, which wrap after a `turn`,
/// continue without jumps.
fn filled(first: &Series, other: &Series, turn: Option<f64>) -> Series {
    let mut merged: Vec<(f64, f64)> = Vec::with_capacity(first.t.len());
    let mut others = other.t.iter().zip(other.values.iter()).peekable();
    let mut before = f64::NEG_INFINITY;
    for (time, value) in first.t.iter().zip(first.values.iter()) {
        let is_gap = time - before > first.max_gap_s;
        while let Some(at) = others.next_if(|(at, _)| *at < time) {
            if is_gap && at.0 > before {
                merged.push(at);
            }
        }
        while others.next_if(|(at, _)| *at == time).is_some() {}
        merged.push((time, value));
        before = time;
    }
    merged.extend(others.filter(|(at, _)| *at > before));
    if let Some(turn) = turn {
        let mut last = f64::NAN;
        for (_, value) in &mut merged {
            let turns = ((last - *value) / turn).round();
            *value += if turns.is_finite() { turn * turns } else { 0.0 };
            last = *value;
        }
    }
    let times = first.t.made(merged.iter().map(|(time, _)| *time));
    let values = first.values.made(merged.iter().map(|(_, value)| *value));
    Series { t: Arc::new(times), values, max_gap_s: first.max_gap_s }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_filled_from_the_other_and_angles_go_on() {
        let first = Series::new(&[0.0, 1.0, 6.0, 7.0], &[6.2, 6.25, 6.5, 6.55], 1.5);
        let other =
            Series::new(&[-1.0, 0.5, 2.0, 3.0, 6.0, 8.0], &[6.1 - TAU, 0.0, 0.02, 0.07, 0.2, 0.32], 1.5);
        let both = filled(&first, &other, Some(TAU));
        assert_eq!(both.t.to_vec(), [-1.0, 0.0, 1.0, 2.0, 3.0, 6.0, 7.0, 8.0]);
        let steps: Vec<f64> = both.values.to_vec().windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps.iter().all(|step| step.abs() < 0.3), "{steps:?}");
    }
}
