use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

use thiserror::Error;
use vessel::{Run, nearest};

use super::Part;

/// Measured runs, each with the name of the source that it was cut from: a recording, or the run itself.
#[derive(Clone, Debug)]
pub struct PooledRuns {
    runs: Vec<(String, Run)>,
}

/// Why runs cannot be selected by name.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SelectError {
    /// No run or recording is called that.
    #[error("no run or recording `{name}` among {runs} runs; the nearest is `{nearest}`")]
    Unknown {
        /// The name.
        name: String,
        /// Number of runs there are.
        runs: usize,
        /// The nearest known name.
        nearest: String,
    },
    /// All were left out.
    #[error("no run is left")]
    NoneLeft,
}

impl PooledRuns {
    /// `runs`, by number the `recordings` that they were cut from; others are sources of their own.
    pub fn new(runs: Vec<Run>, recordings: &BTreeMap<i32, String>) -> Self {
        let several = runs.iter().any(|run| run.design != runs[0].design);
        let name = |run: &Run| match recordings.get(&run.run) {
            Some(name) => name.clone(),
            None if several => format!("{}/{}", run.design, run.run),
            None => run.run.to_string(),
        };
        Self { runs: runs.into_iter().map(|run| (name(&run), run)).collect() }
    }

    /// Keeps the runs or recordings called `only` (all where there are none) without those of `without`.
    ///
    /// # Errors
    /// A name that no run has; nothing left.
    pub fn select(&mut self, only: &[String], without: &[String]) -> Result<(), SelectError> {
        let named = |name: &String, source: &str, run: &Run| name == source || *name == run.run.to_string();
        for name in only.iter().chain(without) {
            if !self.runs.iter().any(|(source, run)| named(name, source, run)) {
                let sources = self.runs.iter().map(|(source, _)| source.as_str());
                let nearest = nearest(name, sources).unwrap_or_default().to_owned();
                return Err(SelectError::Unknown { name: name.clone(), runs: self.runs.len(), nearest });
            }
        }
        self.runs.retain(|(source, run)| {
            let within = |names: &[String]| names.iter().any(|name| named(name, source, run));
            (only.is_empty() || within(only)) && !within(without)
        });
        if self.runs.is_empty() { Err(SelectError::NoneLeft) } else { Ok(()) }
    }

    /// Name of the design of the first run.
    pub fn design(&self) -> &str {
        self.runs.first().map_or("", |(_, run)| run.design.as_str())
    }

    /// The sources, in the order of appearance.
    pub fn sources(&self) -> Vec<String> {
        self.by_source().into_iter().map(|(source, _)| source.to_owned()).collect()
    }

    /// The runs of every source with their places among all, in the order of appearance.
    fn by_source(&self) -> Vec<(&str, Vec<(usize, &Run)>)> {
        let (mut places, mut sources) = (HashMap::new(), Vec::<(&str, Vec<_>)>::new());
        for (i, (source, run)) in self.runs.iter().enumerate() {
            let place = *places.entry(source.as_str()).or_insert(sources.len());
            if place == sources.len() {
                sources.push((source, Vec::new()));
            }
            sources[place].1.push((i, run));
        }
        sources
    }

    /// The segments, each cut into equal parts of at most `most` samples.
    pub fn segments(&self, most: Option<usize>) -> Vec<Vec<Part>> {
        let mut segments = Vec::new();
        for (source, run) in &self.runs {
            let ends = run.segments.iter().skip(1).map(|s| s.start).chain([run.samples()]);
            for (segment, end) in run.segments.iter().zip(ends) {
                let part = |samples| Part::new(&segment.maneuver, source, run.view().part(samples));
                segments.push(equal(segment.start, end, most).into_iter().map(part).collect());
            }
        }
        segments
    }

    /// The parts of all [`PooledRuns::segments`].
    pub fn parts(&self, most: Option<usize>) -> Vec<Part> {
        self.segments(most).into_iter().flatten().collect()
    }

    /// Windows of `length` samples of every source, side by side from where its runs begin, which are joined where one
    /// begins with the state that the last one ended with. Whatever is left is no window; without a length all of it is. Windows
    /// have no label: they may hold several maneuvers.
    pub fn windows(&self, length: Option<usize>) -> impl Iterator<Item = (String, Vec<Part>)> {
        self.by_source().into_iter().map(move |(source, runs)| {
            let windows = joined(&runs).iter().flat_map(|whole| cut(source, whole, length)).collect();
            (source.to_owned(), windows)
        })
    }
}

/// The runs of a source, those that follow each other as one.
fn joined(runs: &[(usize, &Run)]) -> Vec<Run> {
    let mut joined: Vec<(usize, Run)> = Vec::new();
    for (i, run) in runs {
        let continues = |(before, last): &&mut (usize, Run)| {
            *before + 1 == *i && last.measured[last.measured.len() - 3..] == run.measured[..3]
        };
        match joined.last_mut().filter(continues) {
            Some((before, last)) => {
                *before = *i;
                last.exogenous.extend_from_slice(&run.exogenous);
                last.measured.extend_from_slice(&run.measured[3..]);
            }
            None => joined.push((*i, (*run).clone())),
        }
    }
    joined.into_iter().map(|(_, run)| run).collect()
}

fn cut(source: &str, whole: &Run, length: Option<usize>) -> Vec<Part> {
    let samples = whole.samples();
    let length = length.unwrap_or(samples);
    let window = |i: usize| Part::new("", source, whole.view().part(i * length..(i + 1) * length));
    (0..samples / length.max(1)).map(window).collect()
}

/// `start..end` in equal pieces of at most `most` samples.
fn equal(start: usize, end: usize, most: Option<usize>) -> Vec<Range<usize>> {
    let length = end - start;
    let count = most.map_or(1, |most| length.div_ceil(most.max(1))).max(1);
    (0..count).map(|i| start + i * length / count..start + (i + 1) * length / count).collect()
}
