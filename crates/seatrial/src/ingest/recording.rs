//! One recording: files to channels, channels to runs.

use std::path::Path;

use artifact::Digest;
use logs::{Assembled, Channels, Series, Unassembled, assemble, consistency};

use super::channels::Plan;
use super::config::IngestFile;
use super::files::Source;
use super::load::{Loaded, load};
use super::quality;
use super::segments::{Labels, RunPart, runs};
use super::suspicion::check_ratios;
use crate::failure::Failure;
use study::documents::RecordingSummary;

/// What became of a recording.
pub struct Outcome {
    /// Its channels on one clock.
    pub made: Assembled,
    /// Its runs; none where all sub-experiments were too short.
    pub runs: Vec<RunPart>,
    /// What its data are like; run numbers are not given yet.
    pub summary: RecordingSummary,
    /// Digests of its files.
    pub digests: Vec<(String, Digest)>,
}

/// Reads the files of `source`, which stand in `folder`, and makes runs of them.
///
/// # Errors
/// See [`load`]; a recording without a stretch in which all channels are known; velocities in another unit than they
/// should be.
pub fn ingest(config: &IngestFile, plan: &Plan, folder: &Path, source: &Source) -> Result<Outcome, Failure> {
    let mut files = Vec::with_capacity(source.files.len());
    let mut digests = Vec::with_capacity(source.files.len());
    for (i, name) in source.files.iter().enumerate() {
        let path = folder.join(name);
        files.push(load(&path, config, &config.file[i], &plan.units[i])?);
        digests.push((format!("log:{name}"), Digest::of_file(&path)?));
    }
    let start_s = files.iter().filter_map(|file| file.times.first()).copied().fold(f64::INFINITY, f64::min);
    let labels = files.iter().find_map(|file| labels(file, start_s));
    let missing = quality::missing(config, &files);
    let counts = quality::rows(&files);
    let channels = channels(config, files, start_s);
    let slowest = slowest(&channels);
    let made = assemble(channels, &plan.recipe)
        .map_err(|error| unassembled(&folder.join(&source.files[0]), source, &error, slowest))?;
    let motion = consistency(&made.channels, config.velocities.window_s);
    check_ratios(&folder.join(&source.files[0]), &motion)?;
    let (runs, short) = runs(config, source, &made, labels.as_ref());
    let summary = quality::summary(config, plan, source, &made, &runs, short, counts, &missing, motion);
    Ok(Outcome { made, runs, summary, digests })
}

fn labels(file: &Loaded, start_s: f64) -> Option<Labels> {
    let labels = file.labels.clone()?;
    Some(Labels { times: file.times.iter().map(|time| time - start_s).collect(), labels })
}

/// All channels by name, on the recording's clock.
fn channels(config: &IngestFile, files: Vec<Loaded>, start_s: f64) -> Channels {
    let mut channels = Channels::new();
    for (spec, file) in config.file.iter().zip(files) {
        for (channel, mut series) in spec.channel.iter().zip(file.channels) {
            series.t.iter_mut().for_each(|time| *time -= start_s);
            channels.insert(channel.channel.clone(), series);
        }
    }
    channels
}

/// The channel with the longest step, and that step \[s\].
fn slowest(channels: &Channels) -> Option<(String, f64)> {
    let step = |series: &Series| series.rate_hz().map(|rate| 1.0 / rate);
    let steps = channels.iter().filter_map(|(name, series)| Some((name.clone(), step(series)?)));
    steps.max_by(|a, b| a.1.total_cmp(&b.1))
}

fn unassembled(path: &Path, source: &Source, error: &Unassembled, slowest: Option<(String, f64)>) -> Failure {
    let remedy = match slowest {
        Some((name, step)) if *error == Unassembled::NoOverlap => {
            format!(
                "compare `max_gap_s` with the longest step, {step:.3} s in `{name}`, and check the clocks"
            )
        }
        _ => "check the file's columns and clocks".to_owned(),
    };
    Failure::refuse(
        path,
        &format!("run `{}`", source.name),
        &error.to_string(),
        "a stretch without gaps in which all needed channels are known",
        &remedy,
    )
}
