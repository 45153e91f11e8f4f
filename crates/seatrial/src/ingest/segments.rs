//! Where the sub-experiments of a recording are.

use std::path::Path;

use logs::{Assembled, Cut, Part, SpeedClasses, cut, labelled, within};
use vessel::nearest;

use super::config::IngestFile;
use super::files::Source;
use crate::failure::Failure;

/// A run: consecutive sub-experiments, and the row after the last of them.
#[derive(Clone, Debug, PartialEq)]
pub struct RunPart {
    /// First row on the recording's clock.
    pub start: usize,
    /// Number of samples.
    pub samples: usize,
    /// Maneuver and first sample, from the run's start, of each segment.
    pub segments: Vec<(String, usize)>,
}

/// Labels of a recording, from their times on.
pub struct Labels {
    /// Times on the recording's clock \[s\].
    pub times: Vec<f64>,
    /// One per time.
    pub labels: Vec<String>,
}

/// The runs of a recording, and how many sub-experiments were too short.
pub fn runs(
    config: &IngestFile,
    source: &Source,
    made: &Assembled,
    labels: Option<&Labels>,
) -> (Vec<RunPart>, usize) {
    let way = way(config, source, made, labels);
    let least = config.min_s.map_or(1, |min_s| (min_s * config.sample_rate_hz - 1e-6).ceil() as usize);
    let speeds = [made.measured[0].as_slice(), made.measured[1].as_slice()];
    let (mut runs, mut short) = (Vec::new(), 0);
    for stretch in &made.stretches {
        let (parts, left_out) = cut(&way, stretch, speeds, least);
        short += left_out;
        join(&mut runs, parts, config.each_segment_is_a_run);
    }
    (runs, short)
}

fn way(config: &IngestFile, source: &Source, made: &Assembled, labels: Option<&Labels>) -> Cut {
    if let Some(labels) = labels {
        return Cut::Labels(labelled(&made.grid, &labels.times, &labels.labels));
    }
    if let Some(window_s) = config.window_s {
        let samples = ((window_s * config.sample_rate_hz).round() as usize).max(1);
        return Cut::Windows { samples, kind: source.kind.clone(), classes: classes(config) };
    }
    if config.segment.is_empty() {
        return Cut::Whole { maneuver: source.kind.clone() };
    }
    let own = config.segment.iter().filter(|segment| segment.run == source.name);
    let mut parts: Vec<Part> =
        own.map(|segment| within(&made.grid, segment.from_s, segment.to_s, &segment.maneuver)).collect();
    parts.sort_by_key(|part| part.samples.start);
    Cut::Labels(parts)
}

fn classes(config: &IngestFile) -> Option<SpeedClasses> {
    let bounds_m_s = config.speed_classes_m_s.clone();
    let names: Vec<String> = match (&config.speed_class_names, bounds_m_s.len()) {
        (Some(names), _) => names.clone(),
        (None, 0) => return None,
        (None, 1) => ["slow", "fast"].map(String::from).into(),
        (None, _) => ["slow", "medium", "fast"].map(String::from).into(),
    };
    Some(SpeedClasses { bounds_m_s, names })
}

/// Appends `parts`; those that follow each other without a break make one run, unless each is to be one.
fn join(runs: &mut Vec<RunPart>, parts: Vec<Part>, each: bool) {
    let first = runs.len();
    for part in parts {
        let (start, samples) = (part.samples.start, part.samples.len());
        let joins = runs.len() > first && !each;
        match runs.last_mut().filter(|run| joins && run.start + run.samples == start) {
            Some(run) => {
                run.segments.push((part.maneuver, run.samples));
                run.samples += samples;
            }
            None => runs.push(RunPart { start, samples, segments: vec![(part.maneuver, 0)] }),
        }
    }
}

/// Refuses [[segment]]s of recordings that there are not, and such that overlap.
///
/// # Errors
/// Names the first.
pub fn check(config: &IngestFile, path: &Path, sources: &[Source]) -> Result<(), Failure> {
    for (i, segment) in config.segment.iter().enumerate() {
        if !sources.iter().any(|source| source.name == segment.run) {
            let names = || sources.iter().map(|source| source.name.as_str());
            return Err(Failure::refuse(
                path,
                "`run` of a [[segment]]",
                &format!("`{}`, which no file has", segment.run),
                &format!("one of {}", names().collect::<Vec<_>>().join(", ")),
                &format!("did you mean `{}`?", nearest(&segment.run, names()).unwrap_or_default()),
            ));
        }
        let overlaps = |other: &&super::config::SegmentSpec| {
            other.run == segment.run && other.from_s < segment.to_s && segment.from_s < other.to_s
        };
        if let Some(other) = config.segment[..i].iter().find(overlaps) {
            return Err(Failure::refuse(
                path,
                &format!("[[segment]] of run `{}`", segment.run),
                &format!("{} to {} s and {} to {} s", other.from_s, other.to_s, segment.from_s, segment.to_s),
                "intervals without overlap",
                "correct one of them",
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(start: usize, end: usize) -> Part {
        Part { samples: start..end, maneuver: format!("from {start}") }
    }

    #[test]
    fn neighbours_make_one_run_and_others_do_not() {
        let mut runs = Vec::new();
        join(&mut runs, vec![part(0, 5), part(5, 8), part(9, 12)], false);
        join(&mut runs, vec![part(12, 14)], false);
        let found: Vec<_> = runs.iter().map(|r| (r.start, r.samples, r.segments.len())).collect();
        assert_eq!(found, [(0, 8, 2), (9, 3, 1), (12, 2, 1)]);
        assert_eq!(runs[0].segments[1], ("from 5".to_owned(), 5));
        let mut runs = Vec::new();
        join(&mut runs, vec![part(0, 5), part(5, 8)], true);
        assert_eq!(runs.len(), 2);
    }
}
