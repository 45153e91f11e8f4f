//! One recording: logs to channels, channels to runs, and how good they are.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;
use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vessel::Segment;

use crate::assemble::on_one_clock;
use crate::segment::Labels;
use crate::source::called;
use crate::suspicion::{check_ratios, warnings};
use crate::{
    Assembled, ChannelSummary, Channels, Log, MotionSummary, Part, Plan, RowSummary, Segmentation, Series,
    Source, Unassembled, WarningSummary, consistency, noise_std, prepare,
};

/// What became of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// Its runs; none where all sub-experiments were too short.
    pub runs: Vec<RecordedRun>,
    /// What it became, and how good its data are; its runs have no numbers until [`crate::Totals::number`] gives them some.
    pub summary: RecordingSummary,
}

/// A run of N samples, channel by channel: a long one is most of the memory, and goes into a table as it is.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedRun {
    /// Its number; 0 until [`crate::Totals::number`] gives it one.
    pub number: i32,
    /// Its segments, in order.
    pub segments: Vec<Segment>,
    /// Inputs and measured disturbances, N values each.
    pub exogenous: Vec<Vec<f64>>,
    /// Surge, sway \[m/s\] and yaw rate \[rad/s\], N + 1 values each.
    pub measured: [Vec<f64>; 3],
    /// The channels of [`Plan::further`], N + 1 values each; NaN where absent.
    pub further: Vec<Vec<f64>>,
}

impl RecordedRun {
    /// Number of samples N.
    pub fn samples(&self) -> usize {
        self.measured[0].len() - 1
    }
}

/// The files that were recorded together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordingSummary {
    /// Its name.
    pub name: String,
    /// Its files, relative to the folder of the logs.
    pub files: Vec<String>,
    /// Numbers of the runs made of it.
    pub runs: Vec<u64>,
    /// From the moment at which all needed channels have begun to the end of the first that ends, in whole samples \[s\].
    pub duration_s: f64,
    /// Samples of its runs.
    pub samples: u64,
    /// Segments of its runs.
    pub segments: u64,
    /// Gaps that split it.
    pub splits: u64,
    /// Segments that were left out for being too short.
    pub short_segments: u64,
    /// Rows of its files.
    pub rows: RowSummary,
    /// Its channels, measured and computed, on their own clocks.
    pub channels: Vec<ChannelSummary>,
    /// Measured velocities beside the derivatives of position and heading, where there are both.
    pub motion: Vec<MotionSummary>,
    /// What is odd about its channels.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<WarningSummary>,
}

/// Makes runs of the `logs` of `source`, one per group of files.
///
/// # Errors
/// A recording without a stretch in which all channels are known; velocities in another unit than they should be.
pub fn record(
    source: &Source,
    logs: Vec<Log>,
    plan: &Plan,
    segmentation: &Segmentation,
) -> Result<Recorded, Invalid> {
    let start_s = logs.iter().filter_map(|log| log.times.first()).copied().fold(f64::INFINITY, f64::min);
    let labels = logs.iter().find_map(|log| labels(log, start_s));
    let setup = &plan.setup;
    let missing = missing(plan, &logs);
    let mut rows = RowSummary::default();
    logs.iter().for_each(|log| rows += log.counts);
    let channels = channels(plan, logs, start_s);
    let slowest = slowest(&channels);
    let exogenous: Vec<&str> = plan.exogenous.iter().map(|channel| channel.name.as_str()).collect();
    let further: Vec<&str> = plan.further.iter().map(|(name, _)| name.as_str()).collect();
    // The channels are looked at before they are put on one clock, and go before runs are cut: with long recordings that is
    // most of the memory.
    let on_one_clock = prepare(channels, &setup.conventions).and_then(|channels| {
        let motion = consistency(&channels, setup.conventions.window_s);
        let summaries = summaries(plan, &channels, &missing);
        let warnings = warnings(setup, &channels, &summaries);
        let needed = [exogenous.as_slice(), &further];
        let made = on_one_clock(channels, &setup.conventions, needed, plan.most_rows)?;
        Ok((made, motion, summaries, warnings))
    });
    let (made, motion, channels, warnings) = on_one_clock.map_err(|why| refused(source, &why, slowest))?;
    check_ratios(&motion)?;
    let (parts, short) = segmentation.runs(source, &made, labels.as_ref());
    let (duration_s, splits) =
        (made.grid.rows.saturating_sub(1) as f64 / made.grid.rate_hz, made.stretches.len().saturating_sub(1));
    let runs = cut(plan, made, &parts);
    let summary = RecordingSummary {
        name: source.name.clone(),
        files: source.files.clone(),
        runs: Vec::new(),
        duration_s,
        samples: runs.iter().map(|run| run.samples() as u64).sum(),
        segments: runs.iter().map(|run| run.segments.len() as u64).sum(),
        splits: splits as u64,
        short_segments: short as u64,
        rows,
        warnings,
        channels,
        motion: motion.into_iter().flatten().collect(),
    };
    Ok(Recorded { runs, summary })
}

/// Why `source` becomes no runs; `slowest` is the channel with the longest step, and that step \[s\].
fn refused(source: &Source, why: &Unassembled, slowest: Option<(String, f64)>) -> Invalid {
    if let Unassembled::TooLong { most, .. } = why {
        let expected = format!("at most {most} rows, which the memory has room for");
        let remedy = "check the clocks for jumps, lower `sample_rate_hz`, or raise --memory-mib";
        return Invalid::new(called(&source.name), why.to_string(), expected, remedy);
    }
    let remedy = match slowest {
        Some((name, step)) if *why == Unassembled::NoOverlap => {
            format!(
                "compare `max_gap_s` with the longest step, {step:.3} s in `{name}`, and check the clocks"
            )
        }
        _ => "check the file's columns and clocks".to_owned(),
    };
    let expected = "a stretch without gaps in which all needed channels are known";
    Invalid::new(called(&source.name), why.to_string(), expected, remedy)
}

fn labels(log: &Log, start_s: f64) -> Option<Labels> {
    let labels = log.labels.clone()?;
    Some(Labels { times: log.times.iter().map(|time| time - start_s).collect(), labels })
}

/// Per channel of the files, how many rows have no value.
fn missing(plan: &Plan, logs: &[Log]) -> Vec<(String, usize)> {
    let series = logs.iter().flat_map(|log| log.channels.iter().map(|series| (log.times.len(), series)));
    let lacking = series.map(|(rows, series)| rows - series.t.len());
    plan.setup.channels().map(|spec| spec.channel.clone()).zip(lacking).collect()
}

/// All channels by name, on the recording's clock.
fn channels(plan: &Plan, logs: Vec<Log>, start_s: f64) -> Channels {
    let names = plan.setup.channels().map(|spec| spec.channel.clone());
    // The times of a file that its channels share, and the same on the recording's clock.
    let mut moved: Option<[Arc<Vec<f64>>; 2]> = None;
    let mut on_clock = |mut series: Series| {
        let same = moved.take().filter(|[file, _]| Arc::ptr_eq(file, &series.t));
        let [file, own] = same.unwrap_or_else(|| {
            let own = series.t.iter().map(|time| time - start_s).collect();
            [Arc::clone(&series.t), Arc::new(own)]
        });
        series.t = Arc::clone(&own);
        moved = Some([file, own]);
        series
    };
    names.zip(logs.into_iter().flat_map(|log| log.channels).map(&mut on_clock)).collect()
}

/// The channel with the longest step, and that step \[s\].
fn slowest(channels: &Channels) -> Option<(String, f64)> {
    let steps = channels.iter().filter_map(|(name, series)| Some((name.clone(), 1.0 / series.rate_hz()?)));
    steps.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The runs that consist of `parts` each, which follow each other. A channel goes once it is cut.
fn cut(plan: &Plan, made: Assembled, parts: &[Vec<Part>]) -> Vec<RecordedRun> {
    let mut runs: Vec<RecordedRun> = parts.iter().map(|parts| uncut(parts)).collect();
    let rows: Vec<Range<usize>> = parts.iter().map(|parts| rows_of(parts)).collect();
    for (channel, input) in made.exogenous.into_iter().zip(&plan.exogenous) {
        for (run, rows) in runs.iter_mut().zip(&rows) {
            // With room for the row after the last sample, which tables have.
            let mut own = Vec::with_capacity(rows.len());
            own.extend(channel[rows.start..rows.end - 1].iter().map(|value| input.factor * value));
            run.exogenous.push(own);
        }
    }
    for (d, channel) in made.measured.into_iter().enumerate() {
        runs.iter_mut().zip(&rows).for_each(|(run, rows)| run.measured[d] = channel[rows.clone()].to_vec());
    }
    for channel in made.further {
        runs.iter_mut().zip(&rows).for_each(|(run, rows)| run.further.push(channel[rows.clone()].to_vec()));
    }
    runs
}

/// The rows of the run that consists of `parts`: one more than it has samples.
fn rows_of(parts: &[Part]) -> Range<usize> {
    parts[0].samples.start..parts[parts.len() - 1].samples.end + 1
}

fn uncut(parts: &[Part]) -> RecordedRun {
    let start = parts[0].samples.start;
    let segment =
        |part: &Part| Segment { maneuver: part.maneuver.clone(), start: part.samples.start - start };
    RecordedRun {
        number: 0,
        segments: parts.iter().map(segment).collect(),
        exogenous: Vec::new(),
        measured: [const { Vec::new() }; 3],
        further: Vec::new(),
    }
}

/// Samples from which on channels are looked at one by one.
const LONG: usize = 1 << 19;

fn summaries(plan: &Plan, channels: &Channels, missing: &[(String, usize)]) -> Vec<ChannelSummary> {
    let channels: Vec<(&String, &Series)> = channels.iter().collect();
    let of = |(name, series): (&String, &Series)| {
        let extreme = |f: fn(f64, f64) -> f64| series.values.iter().copied().reduce(f);
        ChannelSummary {
            name: name.clone(),
            unit: plan.unit_of(name).to_owned(),
            rate_hz: series.rate_hz(),
            missing: missing.iter().find(|(known, _)| known == name).map_or(0, |(_, count)| *count as u64),
            gaps: series.gaps() as u64,
            noise: noise_std(series),
            min: extreme(f64::min),
            max: extreme(f64::max),
        }
    };
    // Side by side what each needs besides its values would be as much again as those of all.
    match channels.iter().map(|(_, series)| series.values.len()).max() {
        Some(longest) if longest > LONG => channels.into_iter().map(of).collect(),
        _ => channels.into_par_iter().map(of).collect(),
    }
}
