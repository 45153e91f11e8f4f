//! Where the sub-experiments of a recording are.

use std::ops::Range;
use std::sync::Arc;

use refusal::Invalid;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::{Assembled, Grid, Labels, Samples, Section, Source};

/// A range of samples that is to be one sub-experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct SubExperiment {
    /// Its samples; the row at `samples.end` holds the state after the last.
    pub samples: Range<usize>,
    /// Name of the maneuver.
    pub maneuver: String,
}

/// How recordings become runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Segmentation {
    /// Where the sub-experiments are.
    pub cut: Cut,
    /// Sub-experiments of fewer samples are left out.
    pub least: usize,
    /// Whether every sub-experiment becomes a run of its own.
    pub each_is_a_run: bool,
}

/// Where the sub-experiments of recordings are.
#[derive(Clone, Debug, PartialEq)]
pub enum Cut {
    /// Each recording is one.
    Whole,
    /// Windows of equal length, one after the other. Their maneuvers' names begin with the recording's kind.
    Windows {
        /// Samples per window.
        samples: usize,
        /// Samples from which on what is left at the end of a section is a last, shorter window.
        tail: usize,
        /// Speed classes that the names end with.
        classes: Option<SpeedClasses>,
    },
    /// As a column of the logs labels them.
    Labels,
    /// By time.
    Intervals(Vec<Interval>),
}

/// A sub-experiment by time.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Interval {
    /// Name of the recording.
    pub run: String,
    /// Where it begins, from the recording's first row \[s\].
    #[schemars(range(min = -1e9, max = 1e9))]
    pub from_s: f64,
    /// Where it ends \[s\].
    #[schemars(range(min = -1e9, max = 1e9))]
    pub to_s: f64,
    /// Its maneuver.
    pub maneuver: String,
}

/// Labels of a recording, each valid from its time on.
pub(crate) struct Labelled {
    /// Times of the file that holds them \[s\].
    pub times: Arc<Samples>,
    /// Where the recording's clock begins \[s\].
    pub start_s: f64,
    /// One per time.
    pub labels: Labels,
}

/// Names for ranges of the mean speed over ground.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedClasses {
    /// Bounds between the classes, increasing \[m/s\].
    pub bounds_m_s: Vec<f64>,
    /// One name more than bounds.
    pub names: Vec<String>,
}

impl SpeedClasses {
    /// The class of rows with surge `u` and sway `v`.
    pub fn of(&self, u: impl ExactSizeIterator<Item = f64>, v: impl Iterator<Item = f64>) -> &str {
        let rows = u.len() as f64;
        let mean = u.zip(v).map(|(u, v)| libm::hypot(u, v)).sum::<f64>() / rows;
        &self.names[self.bounds_m_s.iter().filter(|bound| mean >= **bound).count()]
    }
}

impl Segmentation {
    /// The runs of a recording, each a sequence of sub-experiments without a break between them, and how many
    /// sub-experiments were too short.
    pub(crate) fn runs(
        &self,
        source: &Source,
        made: &Assembled,
        labels: Option<&Labelled>,
    ) -> (Vec<Vec<SubExperiment>>, usize) {
        let marked = self.cut.marked(source, &made.grid, labels);
        let least = match self.cut {
            Cut::Windows { tail, .. } => self.least.max(tail),
            _ => self.least.max(1),
        };
        let (mut runs, mut short) = (Vec::new(), 0);
        for section in &made.sections {
            let speeds = [&made.measured[0], &made.measured[1]];
            let parts = self.cut.parts(&source.kind, &marked, section, speeds);
            let count = parts.len();
            let kept: Vec<_> = parts.into_iter().filter(|part| part.samples.len() >= least).collect();
            short += count - kept.len();
            let joined = |a: &SubExperiment, b: &SubExperiment| {
                !self.each_is_a_run && a.samples.end == b.samples.start
            };
            runs.extend(kept.chunk_by(joined).map(<[SubExperiment]>::to_vec));
        }
        (runs, short)
    }
}

impl Cut {
    /// The sub-experiments of a recording that are marked in it, in order, regardless of what is known there.
    fn marked(&self, source: &Source, grid: &Grid, labels: Option<&Labelled>) -> Vec<SubExperiment> {
        match (self, labels) {
            (Self::Labels, Some(labels)) => labelled(grid, labels),
            (Self::Intervals(intervals), _) => {
                let of_source = intervals.iter().filter(|interval| interval.run == source.name);
                let mut parts: Vec<SubExperiment> =
                    of_source.map(|interval| within(grid, interval)).collect();
                parts.sort_by_key(|part| part.samples.start);
                parts
            }
            _ => Vec::new(),
        }
    }

    /// The sub-experiments of one section, in order. `u` and `v` are surge and sway on the grid \[m/s\].
    fn parts(
        &self,
        kind: &str,
        marked: &[SubExperiment],
        section: &Section,
        [u, v]: [&Samples; 2],
    ) -> Vec<SubExperiment> {
        let all = section.start..section.start + section.samples;
        match self {
            Self::Whole => vec![SubExperiment { samples: all, maneuver: kind.to_owned() }],
            Self::Windows { samples, classes, .. } => {
                let window = |start: usize| {
                    let range = start..(start + samples).min(all.end);
                    let maneuver = match classes {
                        Some(classes) => {
                            format!("{kind}/{}", classes.of(u.range(range.clone()), v.range(range.clone())))
                        }
                        None => kind.to_owned(),
                    };
                    SubExperiment { samples: range, maneuver }
                };
                all.clone().step_by((*samples).max(1)).map(window).collect()
            }
            Self::Labels | Self::Intervals(_) => {
                let overlap = |part: &SubExperiment| {
                    let samples = part.samples.start.max(all.start)..part.samples.end.min(all.end);
                    (!samples.is_empty()).then(|| SubExperiment { samples, maneuver: part.maneuver.clone() })
                };
                marked.iter().filter_map(overlap).collect()
            }
        }
    }
}

/// Refuses intervals of recordings that do not exist, and overlapping ones.
///
/// # Errors
/// Names the first.
pub fn check_intervals(intervals: &[Interval], sources: &[Source]) -> Result<(), Invalid> {
    let known: Vec<&str> = sources.iter().map(|source| source.name.as_str()).collect();
    for (i, Interval { run, from_s, to_s, .. }) in intervals.iter().enumerate() {
        if !known.contains(&run.as_str()) {
            let name = format!("`{run}`, which no file has");
            let expected = format!("one of {}", known.join(", "));
            return Err(Invalid {
                found: name,
                expected,
                ..Invalid::unknown("`run` of a [[segment]]", run, known)
            });
        }
        let overlaps = |other: &&Interval| other.run == *run && other.from_s < *to_s && *from_s < other.to_s;
        if let Some(other) = intervals[..i].iter().find(overlaps) {
            return Err(Invalid::new(
                format!("[[segment]] of run `{run}`"),
                format!("{} to {} s and {from_s} to {to_s} s", other.from_s, other.to_s),
                "intervals without overlap",
                "correct one of them",
            ));
        }
    }
    Ok(())
}

/// The samples of `interval`, both its ends included, as one sub-experiment.
fn within(grid: &Grid, interval: &Interval) -> SubExperiment {
    let rows = grid.rows_within(interval.from_s, interval.to_s);
    let samples = rows.start..rows.end.saturating_sub(1).max(rows.start);
    SubExperiment { samples, maneuver: interval.maneuver.clone() }
}

/// One sub-experiment per range of equal labels, each valid from its time on. Rows under an empty label, or
/// before the first label, belong to none.
fn labelled(grid: &Grid, Labelled { times, start_s, labels }: &Labelled) -> Vec<SubExperiment> {
    let mut parts: Vec<SubExperiment> = Vec::new();
    let mut begun = times.iter().map(|time| time - start_s).peekable();
    let mut place = 0;
    for (row, time) in grid.times().enumerate() {
        while begun.next_if(|begins| *begins <= time + 1e-6).is_some() {
            place += 1;
        }
        let label = if place == 0 { "" } else { labels.at(place - 1).trim() };
        match parts.last_mut() {
            Some(part) if part.maneuver == label && part.samples.end == row => part.samples.end += 1,
            _ if label.is_empty() => {}
            _ => parts.push(SubExperiment { samples: row..row + 1, maneuver: label.to_owned() }),
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranges(parts: &[SubExperiment]) -> Vec<(usize, usize, &str)> {
        parts.iter().map(|p| (p.samples.start, p.samples.end, p.maneuver.as_str())).collect()
    }

    fn source() -> Source {
        Source { name: "a".into(), files: Vec::new(), kind: "zigzag".into() }
    }

    fn made(u: Vec<f64>, rate_hz: f64, sections: Vec<Section>) -> Assembled {
        let rows = u.len();
        let still = || Samples::from(vec![0.0; rows]);
        Assembled {
            grid: Grid { start_s: 0.0, rate_hz, rows },
            measured: [u.into(), still(), still()],
            exogenous: Vec::new(),
            further: Vec::new(),
            sections,
        }
    }

    #[test]
    fn windows_are_whole_and_named_by_speed() {
        let u: Vec<f64> = (0..26).map(|k| 0.02 * f64::from(k)).collect();
        let names = ["slow", "medium", "fast"].map(String::from).into();
        let classes = Some(SpeedClasses { bounds_m_s: vec![0.15, 0.3], names });
        let cut = Cut::Windows { samples: 10, tail: 10, classes };
        let made = made(u, 1.0, vec![Section { start: 1, samples: 24 }]);
        let windows = Segmentation { cut, least: 1, each_is_a_run: false };
        let (runs, short) = windows.runs(&source(), &made, None);
        assert_eq!(ranges(&runs[0]), [(1, 11, "zigzag/slow"), (11, 21, "zigzag/fast")]);
        assert_eq!((runs.len(), short), (1, 1));
        let each = Segmentation { each_is_a_run: true, ..windows };
        assert_eq!(each.runs(&source(), &made, None).0.len(), 2);
        for (tail, expected) in [(4, 3), (5, 2)] {
            let cut = Cut::Windows { samples: 10, tail, classes: None };
            let (runs, short) = Segmentation { cut, ..each.clone() }.runs(&source(), &made, None);
            assert_eq!((runs.len(), short), (expected, 3 - expected));
            assert!(expected == 2 || ranges(&runs[2]) == [(21, 25, "zigzag")]);
        }
    }

    #[test]
    fn labels_hold_until_the_next_and_empty_ones_belong_to_nothing() {
        let mut labels = Labels::default();
        ["a", "a", "", "b"].into_iter().for_each(|label| labels.push(label));
        let times = Arc::new(vec![101.0, 102.0, 104.0, 105.5].into());
        let labels = Labelled { times, start_s: 100.0, labels };
        let made = made(vec![0.0; 9], 1.0, vec![Section { start: 2, samples: 5 }]);
        assert_eq!(ranges(&labelled(&made.grid, &labels)), [(1, 4, "a"), (6, 9, "b")]);
        let segmentation = Segmentation { cut: Cut::Labels, least: 2, each_is_a_run: false };
        let (runs, short) = segmentation.runs(&source(), &made, Some(&labels));
        assert_eq!(ranges(&runs[0]), [(2, 4, "a")]);
        assert_eq!((runs.len(), short), (1, 1));
    }

    #[test]
    fn an_interval_of_ten_seconds_has_ten_samples() {
        let grid = Grid { start_s: 0.0, rate_hz: 2.0, rows: 100 };
        let interval = |from_s, to_s| Interval { run: "a".into(), from_s, to_s, maneuver: "turn".into() };
        assert_eq!(within(&grid, &interval(5.0, 15.0)).samples, 10..30);
        assert!(within(&grid, &interval(500.0, 600.0)).samples.is_empty());
    }

    #[test]
    fn neighbours_make_one_run_and_others_do_not() {
        let interval = |from_s: f64, to_s: f64| Interval {
            run: "a".into(),
            from_s,
            to_s,
            maneuver: format!("from {from_s}"),
        };
        let cut = Cut::Intervals(vec![
            interval(5.0, 8.0),
            interval(0.0, 5.0),
            interval(9.0, 12.0),
            interval(12.0, 14.0),
        ]);
        // The recording is split within the last row of the third interval.
        let sections = vec![Section { start: 0, samples: 12 }, Section { start: 12, samples: 4 }];
        let joined = Segmentation { cut, least: 1, each_is_a_run: false };
        let (runs, short) = joined.runs(&source(), &made(vec![0.0; 17], 1.0, sections), None);
        let sizes: Vec<_> = runs.iter().map(|run| ranges(run)).collect();
        assert_eq!(sizes[0], [(0, 5, "from 0"), (5, 8, "from 5")]);
        assert_eq!(sizes[1..], [[(9, 12, "from 9")], [(12, 14, "from 12")]]);
        assert_eq!(short, 0);
    }
}
