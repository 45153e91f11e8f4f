//! One recording: logs to channels, channels to runs, and their quality.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;
use refusal::{Invalid, check_name};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{Run, Segment};
use ship::model::DerivedChannel;

use crate::assemble::{on_one_clock, sources};
use crate::axes::{Contradictions, check_axes, drift, rescaled};
use crate::gate::{check_share, keep_alive, keep_possible};
use crate::quality::{Derivatives, check_pace};
use crate::segment::Labelled;
use crate::source::{Spans, called};
use crate::suspicion::{LoggedShape, check_ratios, warnings};
use crate::{
    Assembled, ChannelSpec, ChannelSummary, Channels, Grid, Log, MotionSummary, Omission, Omissions, Plan,
    Reason, RowSummary, Samples, Segmentation, Series, Setup, Source, SubExperiment, Unassembled,
    WarningSummary, noise_std, prepare,
};

/// The result of one recording.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Its runs; empty where all sub-experiments were too short.
    pub runs: Vec<RecordedRun>,
    /// Its summary and the quality of its data; its runs are numbered by [`crate::Totals::number`].
    pub summary: RecordingSummary,
}

/// A run of N samples: rows of a recording on one clock, which its runs share.
#[derive(Clone, Debug)]
pub struct RecordedRun {
    /// Its number; 0 until [`crate::Totals::number`] gives it one.
    pub number: i32,
    /// Its segments, in order.
    pub segments: Vec<Segment>,
    /// N + 1 rows.
    rows: Range<usize>,
    made: Arc<Assembled>,
    /// Factors of inputs and measured disturbances.
    factors: Arc<[f64]>,
    /// Channels derived from them.
    derived: Arc<[DerivedChannel]>,
}

impl RecordedRun {
    /// Number of samples N.
    pub fn samples(&self) -> usize {
        self.rows.len() - 1
    }

    /// Input, measured disturbance or derived channel `i`, N values.
    pub fn exogenous(&self, i: usize) -> Box<dyn Iterator<Item = f64> + '_> {
        let Some(values) = self.made.exogenous.get(i) else { return self.derived(i) };
        let factor = self.factors[i];
        Box::new(values.range(self.rows.start..self.rows.end - 1).map(move |value| factor * value))
    }

    /// Derived channel `i`, N values, each computed from its sources at the same sample.
    fn derived(&self, i: usize) -> Box<dyn Iterator<Item = f64> + '_> {
        let Some(channel) = self.derived.iter().find(|channel| channel.variable == i + 3) else {
            return Box::new(std::iter::empty());
        };
        let mut sources: Vec<_> = channel.sources.iter().map(|source| self.exogenous(source - 3)).collect();
        let mut row = vec![0.0; sources.len()];
        Box::new((1..self.rows.len()).map(move |_| {
            row.iter_mut()
                .zip(&mut sources)
                .for_each(|(value, source)| *value = source.next().unwrap_or(f64::NAN));
            channel.formula.evaluate(&row)
        }))
    }

    /// Surge, sway \[m/s\] or yaw rate \[rad/s\], N + 1 values.
    pub fn measured(&self, d: usize) -> impl Iterator<Item = f64> {
        self.made.measured[d].range(self.rows.clone())
    }

    /// The run of `design` in memory, with the first `width` of its inputs, measured disturbances and derived channels.
    pub fn run(&self, design: &str, width: usize) -> Run {
        let rows = |columns: Vec<Vec<f64>>, rows: usize| -> Vec<f64> {
            (0..rows).flat_map(|k| columns.iter().map(move |column| column[k])).collect()
        };
        let exogenous = (0..width).map(|i| self.exogenous(i).collect()).collect();
        let measured = rows((0..3).map(|d| self.measured(d).collect()).collect(), self.rows.len());
        Run {
            design: design.to_owned(),
            run: self.number,
            segments: self.segments.clone(),
            instrument_exogenous: Vec::new(),
            exogenous: rows(exogenous, self.samples()),
            initial: [0, 1, 2].map(|d| measured[d]),
            measured,
        }
    }

    /// Channel `i` of [`Plan::further`], N + 1 values; NaN where absent.
    pub fn further(&self, i: usize) -> impl Iterator<Item = f64> {
        self.made.further[i].range(self.rows.clone())
    }

    /// The same run with its own rows copied into memory, so that the recording can be dropped.
    pub fn detached(&self) -> Self {
        let copied = |channel: &Samples| Samples::from(channel.range(self.rows.clone()).collect::<Vec<_>>());
        let made = Assembled {
            grid: Grid { rows: self.rows.len(), ..self.made.grid },
            measured: self.made.measured.each_ref().map(copied),
            exogenous: self.made.exogenous.iter().map(copied).collect(),
            further: self.made.further.iter().map(copied).collect(),
            sections: Vec::new(),
        };
        Self { rows: 0..self.rows.len(), made: Arc::new(made), ..self.clone() }
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
    /// What is known of it and in none of its runs: outside of segments, or in those that were too short \[s\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub left_out_s: f64,
    /// Rows of its files.
    pub rows: RowSummary,
    /// Values that were left out, by channel and reason.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub omitted: Vec<Omission>,
    /// Its channels, measured and computed, on their own clocks.
    pub channels: Vec<ChannelSummary>,
    /// Measured velocities beside the derivatives of position and heading, where there are both.
    pub motion: Vec<MotionSummary>,
    /// What is odd about its channels.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<WarningSummary>,
    /// Why no estimate is made of it unless asked, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub doubtful: Vec<String>,
    /// How it contradicts the other recordings, in words; it is used like these unless it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contradicts: Option<String>,
    /// Why it cannot be judged whether it contradicts the others, in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unjudged: Option<String>,
}

fn is_zero(seconds: &f64) -> bool {
    *seconds == 0.0
}

/// Refuses a smoothing window that is longer than the recording.
fn check_window(channels: &Channels, window_s: f64) -> Result<(), Invalid> {
    let span = |name: &str| {
        let t = &channels.get(name)?.t;
        Some(t.last()? - t.first()?).filter(|span| *span > 0.0)
    };
    match ["x", "y", "psi"].into_iter().filter_map(span).find(|span| window_s > *span) {
        None => Ok(()),
        Some(span) => Err(Invalid::new(
            "`velocities.window_s`",
            format!("{window_s} s"),
            format!("at most the {span:.1} s of the recording"),
            "state a window of a second or a few",
        )),
    }
}

/// Makes runs of the `logs` of `source`, one per group of files.
///
/// # Errors
/// A recording without a section in which all channels are known; velocities in another unit than declared.
pub fn record(
    source: &Source,
    logs: Vec<Log>,
    plan: &Plan,
    segmentation: &Segmentation,
) -> Result<Recorded, Invalid> {
    check_leaps(source, &logs)?;
    let start_s = logs.iter().filter_map(|log| log.times.first()).fold(f64::INFINITY, f64::min);
    let labels = logs.iter().find_map(|log| {
        Some(Labelled { times: Arc::clone(&log.times), start_s, labels: log.labels.clone()? })
    });
    let setup = &plan.setup;
    let rows_of = rows_of(plan, &logs);
    let seen: Vec<LoggedShape> = logs.iter().flat_map(|log| &log.seen).copied().collect();
    let mut rows = RowSummary::default();
    logs.iter().for_each(|log| rows += log.counts);
    let mut omitted = Omissions::default();
    logs.iter().for_each(|log| omitted.append(&log.omitted, |channel| channel));
    let of_logs: Vec<WarningSummary> = logs.iter().flat_map(|log| log.warnings.clone()).collect();
    let channels = possible(channels(plan, logs, start_s), setup, &mut omitted)?;
    let doubts = doubts(setup, &channels, omitted.as_slice());
    let missing = missing(rows_of, &channels);
    let logged = plan.exogenous.len() - plan.derived.len();
    let exogenous: Vec<&str> = plan.exogenous[..logged].iter().map(|channel| channel.name.as_str()).collect();
    let further: Vec<&str> = plan.further.iter().map(|(name, _)| name.as_str()).collect();
    let refused =
        |why: &Unassembled, summaries: &[ChannelSummary]| refused(source, why, slowest(plan, summaries));
    let channels = prepare(channels, &setup.conventions).map_err(|why| refused(&why, &[]))?;
    let derivatives = Derivatives::of(&channels, setup.conventions.window_s);
    let (motion, turned) = match &derivatives {
        Some(derivatives) => {
            let turned = check_axes(&channels, derivatives, &setup.conventions)?;
            (derivatives.compared(&channels), turned)
        }
        None => ([None; 3], None),
    };
    let turned_heading = derivatives.as_ref().and_then(|derivatives| drift(&channels, derivatives));
    let changed =
        |spec: &ChannelSpec| Some((spec.channel.clone(), rescaled(spec, &channels, derivatives.as_ref())?));
    let changed: Vec<_> = setup.channels().filter_map(changed).collect();
    drop(derivatives);
    let summaries = summaries(plan, &channels, &missing);
    check_pace(setup, &channels, &summaries)?;
    check_window(&channels, setup.conventions.window_s)?;
    let spans =
        Spans::of(&channels, sources(&channels).into_iter().chain(exogenous.iter().copied()), start_s);
    spans.check(source)?;
    let mut contradictions = Contradictions::of(&motion, turned, setup.conventions.rate_hz);
    contradictions.also(spans.uncovered(setup.max_gap_s), turned_heading, changed);
    let warnings = warnings(setup, &channels, &summaries, &seen, &contradictions.warnings);
    let warnings = [warnings, of_logs].concat();
    let needed = [exogenous.as_slice(), &further];
    let made = on_one_clock(channels, &setup.conventions, needed, plan.most_rows)
        .map_err(|why| refused(&why, &summaries))?;
    check_ratios(&motion)?;
    let (parts, short) = segmentation.runs(source, &made, labels.as_ref());
    let maneuver = || format!("{}, a maneuver", called(&source.name));
    parts.iter().flatten().try_for_each(|part| check_name(maneuver(), &part.maneuver))?;
    let (duration_s, splits) = (made.grid.rows.saturating_sub(1) as f64 / made.grid.rate_hz, made.splits());
    let known: usize = made.sections.iter().map(|section| section.samples).sum();
    let runs = cut(plan, made, &parts);
    let samples: usize = runs.iter().map(RecordedRun::samples).sum();
    let summary = RecordingSummary {
        name: source.name.clone(),
        files: source.files.concat(),
        runs: Vec::new(),
        duration_s,
        samples: samples as u64,
        segments: runs.iter().map(|run| run.segments.len() as u64).sum(),
        splits: splits as u64,
        short_segments: short as u64,
        left_out_s: known.saturating_sub(samples) as f64 / setup.conventions.rate_hz,
        rows,
        omitted: omitted.into_vec(),
        warnings,
        doubtful: doubts.into_iter().chain(contradictions.broken).collect(),
        contradicts: None,
        unjudged: None,
        channels: summaries,
        motion: motion.into_iter().flatten().collect(),
    };
    Ok(Recorded { runs, summary })
}

/// Refuses clocks of which one had a leap second and another, which continues past it, had not.
fn check_leaps(source: &Source, logs: &[Log]) -> Result<(), Invalid> {
    let Some(leap_s) = logs.iter().find_map(|log| log.leap_s) else { return Ok(()) };
    let has_none = |log: &&Log| log.leap_s.is_none() && log.times.last().is_some_and(|last| last >= leap_s);
    match logs.iter().find(has_none) {
        None => Ok(()),
        Some(_) => Err(Invalid::new(
            called(&source.name),
            "a second 60 in files of one group and none in those of another",
            "clocks that treat leap seconds alike",
            "cut the recording there",
        )),
    }
}

/// Why `source` yields no runs; `slowest` is the channel with the longest step, and that step \[s\].
fn refused(source: &Source, why: &Unassembled, slowest: Option<(String, f64)>) -> Invalid {
    if let Unassembled::TooLong { most, .. } = why {
        let expected = format!("at most {most} rows, as many as memory and disk hold");
        let remedy = "check the clocks for jumps, lower `sample_rate_hz`, or raise --memory-mib";
        return Invalid::new(called(&source.name), why.to_string(), expected, remedy);
    }
    if let Unassembled::OutsideTable { range: [low, high], .. } = why {
        let expected = format!("a thruster within its table, from {low} to {high}");
        let remedy = "check the channel's unit and sign, or extend the table in [[thruster]]";
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
    let expected = "a section without gaps in which all needed channels are known";
    Invalid::new(called(&source.name), why.to_string(), expected, remedy)
}

/// Per channel of the files, the number of rows.
fn rows_of(plan: &Plan, logs: &[Log]) -> Vec<(String, usize)> {
    let rows = logs.iter().flat_map(|log| log.rows.iter().copied());
    plan.setup.channels().map(|spec| spec.channel.clone()).zip(rows).collect()
}

/// Of these, the number without a value.
fn missing(rows_of: Vec<(String, usize)>, channels: &Channels) -> Vec<(String, usize)> {
    let mut lacking = rows_of;
    for (name, rows) in &mut lacking {
        *rows = rows.saturating_sub(channels.get(name).map_or(0, |series| series.t.len()));
    }
    lacking
}

/// Share of a channel's values from which on leaving them out makes the rest doubtful.
const DOUBTFUL: f64 = 0.05;

/// The channels that lost many values, in words; losses that the configuration or the quality of a fix
/// explains do not count.
fn doubts(setup: &Setup, channels: &Channels, omitted: &[Omission]) -> Vec<String> {
    let of = |spec: &ChannelSpec| {
        let stated = |reason: Reason| match reason {
            Reason::Missing => spec.missing.is_some(),
            Reason::Range => spec.valid.is_some(),
            reason => [Reason::Quality, Reason::Incomplete, Reason::Time].contains(&reason),
        };
        let omissions = omitted.iter().filter(|one| one.channel == spec.channel);
        let (configured, unforeseen) =
            omissions.fold((0, 0), |(configured, unforeseen), one| match stated(one.reason) {
                true => (configured + one.count, unforeseen),
                false => (configured, unforeseen + one.count),
            });
        let kept = channels.get(&spec.channel).map_or(0, |series| series.t.len() as u64);
        let all = kept + configured + unforeseen;
        (unforeseen as f64 > DOUBTFUL * all as f64)
            .then(|| format!("`{}` lacks {unforeseen} of {all} values, which were left out", spec.channel))
    };
    setup.channels().filter_map(of).collect()
}

/// The values of `channels` that are possible for a ship; the rest is left out and counted.
fn possible(mut channels: Channels, setup: &Setup, omitted: &mut Omissions) -> Result<Channels, Invalid> {
    let before: Vec<(&ChannelSpec, usize)> =
        setup.channels().filter_map(|spec| Some((spec, channels.get(&spec.channel)?.t.len()))).collect();
    let mut rejected = Omissions::default();
    keep_possible(&mut channels, setup.max_speed_m_s, &mut rejected);
    keep_alive(&mut channels, &mut rejected);
    for (spec, values) in before {
        check_share(&spec.channel, values as u64, rejected.as_slice(), spec.max_omitted, None)?;
    }
    omitted.append(&rejected, |name| name);
    Ok(channels)
}

/// All channels by name, on the recording's clock.
fn channels(plan: &Plan, logs: Vec<Log>, start_s: f64) -> Channels {
    let names = plan.setup.channels().map(|spec| spec.channel.clone());
    // The times that the channels of a file share, and the same on the recording's clock.
    let mut moved: Option<[Arc<Samples>; 2]> = None;
    let mut on_clock = |mut series: Series| {
        let same = moved.take().filter(|[file, _]| Arc::ptr_eq(file, &series.t));
        let [file, shifted] = same.unwrap_or_else(|| {
            let shifted = series.t.made(series.t.iter().map(|time| time - start_s));
            [Arc::clone(&series.t), Arc::new(shifted)]
        });
        series.t = Arc::clone(&shifted);
        moved = Some([file, shifted]);
        series
    };
    names.zip(logs.into_iter().flat_map(|log| log.channels).map(&mut on_clock)).collect()
}

/// The logged channel with the longest step, and that step \[s\].
fn slowest(plan: &Plan, summaries: &[ChannelSummary]) -> Option<(String, f64)> {
    let logged =
        |name: &str| plan.setup.channels().any(|spec| spec.channel == name) || ["x", "y"].contains(&name);
    let steps = summaries.iter().filter(|channel| logged(&channel.name));
    let steps = steps.filter_map(|channel| Some((channel.name.clone(), 1.0 / channel.rate_hz?)));
    steps.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The runs that consist of `parts` each, which follow each other without a break.
fn cut(plan: &Plan, made: Assembled, parts: &[Vec<SubExperiment>]) -> Vec<RecordedRun> {
    let factors: Arc<[f64]> = plan.exogenous.iter().map(|input| input.factor).collect();
    let (made, derived) = (Arc::new(made), Arc::<[DerivedChannel]>::from(plan.derived.as_slice()));
    let run = |parts: &Vec<SubExperiment>| {
        let start = parts[0].samples.start;
        let segments = parts
            .iter()
            .map(|part| Segment { maneuver: part.maneuver.clone(), start: part.samples.start - start });
        RecordedRun {
            number: 0,
            segments: segments.collect(),
            // A run has one row more than samples.
            rows: start..parts[parts.len() - 1].samples.end + 1,
            made: Arc::clone(&made),
            factors: Arc::clone(&factors),
            derived: Arc::clone(&derived),
        }
    };
    parts.iter().map(run).collect()
}

/// Channels that are summarized in parallel: each holds a few blocks in memory.
const SIDE_BY_SIDE: usize = 16;

fn summaries(plan: &Plan, channels: &Channels, missing: &[(String, usize)]) -> Vec<ChannelSummary> {
    // Many channels share a clock.
    let mut clocks: Vec<(Arc<Samples>, Option<f64>)> = Vec::new();
    for series in channels.values() {
        if !clocks.iter().any(|(t, _)| Arc::ptr_eq(t, &series.t)) {
            clocks.push((Arc::clone(&series.t), series.rate_hz()));
        }
    }
    let of = |(name, series): &(&String, &Series)| {
        let extreme = |f: fn(f64, f64) -> f64| series.values.iter().reduce(f);
        let clock = clocks.iter().find(|(t, _)| Arc::ptr_eq(t, &series.t));
        ChannelSummary {
            name: (*name).clone(),
            unit: plan.unit_of(name).to_owned(),
            rate_hz: clock.and_then(|(_, rate_hz)| *rate_hz),
            missing: missing.iter().find(|(known, _)| known == *name).map_or(0, |(_, count)| *count as u64),
            gaps: series.gaps() as u64,
            noise: noise_std(series),
            min: extreme(f64::min),
            max: extreme(f64::max),
        }
    };
    let channels: Vec<(&String, &Series)> = channels.iter().collect();
    let some = |some: &[(&String, &Series)]| some.par_iter().map(of).collect::<Vec<_>>();
    channels.chunks(SIDE_BY_SIDE).flat_map(some).collect()
}

/// Numbers runs and counts them.
#[derive(Clone, Debug, Default)]
pub struct Totals {
    /// Runs so far; the number of the next run.
    pub runs: u32,
    /// Samples of all runs.
    pub samples: u64,
    /// Per maneuver, in the order of appearance.
    pub maneuvers: Vec<ManeuverCount>,
}

/// How much there is of a maneuver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ManeuverCount {
    /// Its name.
    pub name: String,
    /// Number of segments.
    pub segments: u64,
    /// Their samples.
    pub samples: u64,
}

impl Totals {
    /// Counts the runs of a recording and numbers them.
    pub fn number(&mut self, recorded: &mut Recorded) {
        for run in &mut recorded.runs {
            run.number = self.runs as i32;
            recorded.summary.runs.push(u64::from(self.runs));
            self.runs += 1;
            self.samples += run.samples() as u64;
            let ends = run.segments.iter().skip(1).map(|next| next.start).chain([run.samples()]);
            for (segment, end) in run.segments.iter().zip(ends) {
                let count = self.count(&segment.maneuver);
                count.segments += 1;
                count.samples += (end - segment.start) as u64;
            }
        }
    }

    fn count(&mut self, maneuver: &str) -> &mut ManeuverCount {
        let place = self.maneuvers.iter().position(|count| count.name == maneuver).unwrap_or_else(|| {
            self.maneuvers.push(ManeuverCount { name: maneuver.to_owned(), segments: 0, samples: 0 });
            self.maneuvers.len() - 1
        });
        &mut self.maneuvers[place]
    }
}
