//! How good the data of a recording are.

use logs::{Assembled, Consistency, Series, noise_std};
use rayon::prelude::*;

use super::channels::Plan;
use super::config::IngestFile;
use super::files::Source;
use super::load::{Loaded, RowCounts};
use super::segments::RunPart;
use super::suspicion::warnings;
use study::documents::{ChannelSummary, MotionSummary, RecordingSummary, RowSummary};

/// Per channel, how many rows have no value.
pub fn missing(config: &IngestFile, files: &[Loaded]) -> Vec<(String, usize)> {
    let of = |(spec, file): (&super::config::FileSpec, &Loaded)| {
        let rows = file.times.len();
        let lacking = |series: &Series| rows - series.t.len();
        let names = spec.channel.iter().map(|channel| channel.channel.clone());
        names.zip(file.channels.iter().map(lacking)).collect::<Vec<_>>()
    };
    config.file.iter().zip(files).flat_map(of).collect()
}

/// What was read and left out, over all files of a recording.
pub fn rows(files: &[Loaded]) -> RowSummary {
    let sum = |f: &dyn Fn(&RowCounts) -> usize| files.iter().map(|file| f(&file.counts) as u64).sum();
    RowSummary {
        read: sum(&|c| c.read),
        empty: sum(&|c| c.empty),
        cut: sum(&|c| c.cut),
        without_time: sum(&|c| c.without_time),
        repeated: sum(&|c| c.repeated),
        backwards: sum(&|c| c.backwards),
    }
}

/// All that `ingest.json` says about a recording, but for the numbers of its runs.
#[allow(clippy::too_many_arguments)]
pub fn summary(
    config: &IngestFile,
    plan: &Plan,
    source: &Source,
    made: &Assembled,
    runs: &[RunPart],
    short: usize,
    rows: RowSummary,
    missing: &[(String, usize)],
    motion: [Option<Consistency>; 3],
) -> RecordingSummary {
    let channel = |(name, series): (&String, &Series)| {
        let missing = missing.iter().find(|(known, _)| known == name).map_or(0, |(_, count)| *count as u64);
        channel(name, plan.unit_of(config, name), series, missing)
    };
    let names: Vec<(&String, &Series)> = made.channels.iter().collect();
    let channels: Vec<ChannelSummary> = names.into_par_iter().map(channel).collect();
    let states = ["u", "v", "r"].into_iter().zip(motion);
    RecordingSummary {
        name: source.name.clone(),
        files: source.files.clone(),
        runs: Vec::new(),
        duration_s: made.grid.rows.saturating_sub(1) as f64 / made.grid.rate_hz,
        samples: runs.iter().map(|run| run.samples as u64).sum(),
        segments: runs.iter().map(|run| run.segments.len() as u64).sum(),
        splits: made.stretches.len().saturating_sub(1) as u64,
        short_segments: short as u64,
        rows,
        warnings: warnings(config, &made.channels, &channels),
        channels,
        motion: states
            .filter_map(|(state, found)| {
                found.map(|c| MotionSummary {
                    state: state.to_owned(),
                    rms: c.rms,
                    robust_std: c.robust_std,
                    bias: c.bias,
                    lag_s: c.lag_s,
                    gain: c.gain,
                })
            })
            .collect(),
    }
}

fn channel(name: &str, unit: String, series: &Series, missing: u64) -> ChannelSummary {
    let extreme = |f: fn(f64, f64) -> f64| series.values.iter().copied().reduce(f);
    ChannelSummary {
        name: name.to_owned(),
        unit,
        rate_hz: series.rate_hz(),
        missing,
        gaps: series.gaps() as u64,
        noise: noise_std(series),
        min: extreme(f64::min),
        max: extreme(f64::max),
    }
}
