use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

use refusal::{Invalid, names_in, nearest};
use ship::engine::Run;
use thiserror::Error;

use super::recorded::read;
use super::{Part, PartView, Parts, Recorded};

/// Measured runs, each with the name of its source: a recording, or the run itself. Their samples may be stored elsewhere.
#[derive(Clone, Debug)]
pub struct PooledRuns<R = Vec<Run>> {
    recorded: R,
    designs: Vec<String>,
    sources: Vec<String>,
    runs: Vec<KnownRun>,
    are_inputs_held: bool,
}

/// A run without its samples.
#[derive(Clone, Debug)]
struct KnownRun {
    /// Its index among the recorded runs.
    index: usize,
    /// The block that holds it.
    block: usize,
    place: usize,
    number: i32,
    /// Its design's index in `designs`.
    design: usize,
    source: usize,
    samples: usize,
    /// First samples of its segments.
    starts: Vec<usize>,
}

/// Why runs cannot be selected by name.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SelectError {
    /// No run or recording has this name.
    #[error("no run or recording `{name}` among {runs} runs; the nearest is `{nearest}`")]
    Unknown {
        /// The name.
        name: String,
        /// Number of runs.
        runs: usize,
        /// The nearest known name.
        nearest: String,
    },
    /// All were left out.
    #[error("no run is left")]
    NoneLeft,
}

impl SelectError {
    /// What is invalid.
    pub fn invalid(&self) -> Invalid {
        match self {
            Self::Unknown { name, runs, nearest } => Invalid::new(
                format!("run `{name}`"),
                "no such run or recording",
                format!("one of {runs} runs, by number or recording"),
                format!("did you mean `{nearest}`?"),
            ),
            Self::NoneLeft => Invalid::new("runs", "none left", "at least one", "leave out fewer runs"),
        }
    }
}

impl PooledRuns {
    /// Pools `runs`. `recordings` maps a run's number to the recording that it was cut from; other runs are their own sources.
    pub fn new(runs: Vec<Run>, recordings: &BTreeMap<i32, String>) -> Self {
        let Ok(pooled) = Self::of(runs, recordings);
        pooled
    }

    /// The segments, each cut into equal parts of at most `most` samples.
    pub fn segments(&self, most: Option<usize>) -> Vec<Vec<Part>> {
        let mut segments = Vec::new();
        for known in &self.runs {
            let run = &self.recorded[known.place];
            for (segment, samples) in run.segments.iter().zip(known.segments()) {
                let part = |samples| {
                    Part::new(&segment.maneuver, &self.sources[known.source], run.view().part(samples))
                };
                segments.push(equal(samples.start, samples.end, most).map(part).collect());
            }
        }
        segments
    }

    /// The parts of all [`PooledRuns::segments`].
    pub fn parts(&self, most: Option<usize>) -> Vec<Part> {
        self.segments(most).into_iter().flatten().collect()
    }

    /// Windows of `length` samples of every source, see [`PooledRuns::each_source`].
    pub fn windows(&self, length: Option<usize>) -> Vec<(String, Vec<Part>)> {
        let mut all = Vec::new();
        let Ok(()) = self.each_source(length, |source, windows| all.push((source.to_owned(), windows)));
        all
    }
}

impl<R: Recorded> PooledRuns<R> {
    /// The runs that are `recorded`, see [`PooledRuns::new`].
    ///
    /// # Errors
    /// A block that cannot be read.
    pub fn of(recorded: R, recordings: &BTreeMap<i32, String>) -> Result<Self, R::Error> {
        let blocks: Vec<usize> = (0..recorded.blocks()).collect();
        let (mut runs, mut designs) = (Vec::new(), Names::default());
        read(&recorded, &blocks, |block, of_block| {
            for (place, run) in of_block.iter().enumerate() {
                let (design, starts) = (designs.place(&run.design), run.starts());
                let (number, samples) = (run.run, run.samples());
                let index = runs.len();
                runs.push(KnownRun { index, block, place, number, design, source: 0, samples, starts });
            }
        })?;
        let (several, mut sources) = (designs.names.len() > 1, Names::default());
        for run in &mut runs {
            run.source = sources.place(&match recordings.get(&run.number) {
                Some(name) => name.clone(),
                None if several => format!("{}/{}", designs.names[run.design], run.number),
                None => run.number.to_string(),
            });
        }
        let (designs, sources) = (designs.names, sources.names);
        Ok(Self { recorded, designs, sources, runs, are_inputs_held: false })
    }

    /// The same, of simulated runs: each row of inputs acts during its whole sample, as it is. Of logs it does not: they
    /// are samples of inputs that go on between them, and that thrusters follow late.
    #[must_use]
    pub fn with_inputs_held(self, are_inputs_held: bool) -> Self {
        Self { are_inputs_held, ..self }
    }

    /// Whether each row of inputs acts during its whole sample.
    pub fn are_inputs_held(&self) -> bool {
        self.are_inputs_held
    }

    /// Keeps the runs or recordings named in `only` (all if empty), except those in `without`: each a name, or several with
    /// commas between.
    ///
    /// # Errors
    /// A name that no run has, also not with those after it as parts of a name with commas; no run left.
    pub fn select(&mut self, only: &[String], without: &[String]) -> Result<(), SelectError> {
        let sources = &self.sources;
        let named =
            |name: &String, run: &KnownRun| *name == sources[run.source] || *name == run.number.to_string();
        let known = |name: &str| self.runs.iter().any(|run| named(&name.to_owned(), run));
        let [only, without] = [only, without]
            .map(|names| names.iter().flat_map(|name| names_in(name, known)).collect::<Vec<String>>());
        for name in only.iter().chain(&without) {
            if !self.runs.iter().any(|run| named(name, run)) {
                let nearest =
                    nearest(name, sources.iter().map(String::as_str)).unwrap_or_default().to_owned();
                return Err(SelectError::Unknown { name: name.clone(), runs: self.runs.len(), nearest });
            }
        }
        self.runs.retain(|run| {
            let within = |names: &[String]| names.iter().any(|name| named(name, run));
            (only.is_empty() || within(&only)) && !within(&without)
        });
        if self.runs.is_empty() { Err(SelectError::NoneLeft) } else { Ok(()) }
    }

    /// The selected runs.
    ///
    /// # Errors
    /// A block that cannot be read.
    pub fn kept(&self) -> Result<Vec<Run>, R::Error> {
        let (wanted, mut all) = ((0..self.runs.len()).collect::<Vec<_>>(), Vec::new());
        self.visit(&wanted, |i| *i, |_, run| all.push(run.clone()))?;
        Ok(all)
    }

    /// Whether a run of this number is selected.
    pub fn has(&self, number: i32) -> bool {
        self.runs.iter().any(|run| run.number == number)
    }

    /// Names of the designs of all runs, whether selected or not.
    pub fn designs(&self) -> impl Iterator<Item = &str> {
        self.designs.iter().map(String::as_str)
    }

    /// Name of the design of the first run.
    pub fn design(&self) -> &str {
        self.runs.first().map_or("", |run| &self.designs[run.design])
    }

    /// The selected ones of the recorded runs, counted from 0: first and last of each consecutive range.
    pub fn selected(&self) -> Vec<[u64; 2]> {
        let mut ranges: Vec<[u64; 2]> = Vec::new();
        for index in self.runs.iter().map(|run| run.index as u64) {
            match ranges.last_mut() {
                Some([_, last]) if *last + 1 == index => *last = index,
                _ => ranges.push([index, index]),
            }
        }
        ranges
    }

    /// Number of runs.
    pub fn count(&self) -> usize {
        self.runs.len()
    }

    /// The amount of data, in words.
    pub fn amount(&self) -> String {
        format!("{} runs of {} samples in all", self.count(), self.samples().0)
    }

    /// Number of sources.
    pub fn sources(&self) -> usize {
        self.by_source().len()
    }

    /// Samples of all runs, and of those of the longest source.
    pub fn samples(&self) -> (usize, usize) {
        let of = |runs: &Vec<usize>| runs.iter().map(|i| self.runs[*i].samples).sum::<usize>();
        let sources: Vec<usize> = self.by_source().iter().map(|(_, runs)| of(runs)).collect();
        (sources.iter().sum(), sources.into_iter().max().unwrap_or(0))
    }

    /// The indices of the runs of every source, in the order of appearance.
    fn by_source(&self) -> Vec<(&str, Vec<usize>)> {
        let (mut places, mut sources) = (HashMap::new(), Vec::<(&str, Vec<_>)>::new());
        for (i, run) in self.runs.iter().enumerate() {
            let place = *places.entry(run.source).or_insert(sources.len());
            if place == sources.len() {
                sources.push((&self.sources[run.source], Vec::new()));
            }
            sources[place].1.push(i);
        }
        sources
    }

    /// The segments, each cut into equal parts of at most `most` samples.
    pub fn cut(&self, most: Option<usize>) -> CutRuns<'_, R> {
        self.cut_into(most, |known| known.segments().collect())
    }

    /// The runs, regardless of their segments, cut in the same way.
    pub fn whole(&self, most: Option<usize>) -> CutRuns<'_, R> {
        self.cut_into(most, |known| std::iter::once(0..known.samples).collect())
    }

    fn cut_into(&self, most: Option<usize>, of: impl Fn(&KnownRun) -> Vec<Range<usize>>) -> CutRuns<'_, R> {
        let mut places = Vec::new();
        for (run, known) in self.runs.iter().enumerate() {
            for (segment, samples) in of(known).into_iter().enumerate() {
                let pieces = equal(samples.start, samples.end, most);
                places.extend(pieces.map(|samples| SourcePlace { run, segment, samples }));
            }
        }
        CutRuns { runs: self, places }
    }

    /// Calls `look` with the consecutive windows of `length` samples of every source. Runs are joined first if one
    /// begins with the state that the previous one ended with. Remaining samples are dropped; without a length, the
    /// window is the whole run. Windows have no label: they may contain several maneuvers.
    ///
    /// # Errors
    /// A block that cannot be read.
    pub fn each_source(
        &self,
        length: Option<usize>,
        mut look: impl FnMut(&str, Vec<Part>),
    ) -> Result<(), R::Error> {
        let sources = self.by_source();
        let mut rest = sources.as_slice();
        while !rest.is_empty() {
            let samples = |(_, runs): &(&str, Vec<usize>)| runs.iter().map(|i| self.runs[*i].samples).sum();
            let (now, later) = rest.split_at(self.fitting(rest.iter().map(samples)));
            let mut wanted: Vec<usize> = now.iter().flat_map(|(_, runs)| runs.iter().copied()).collect();
            wanted.sort_unstable();
            let mut held = HashMap::new();
            self.visit(&wanted, |i| *i, |k, run| drop(held.insert(wanted[k], run.clone())))?;
            for (source, runs) in now {
                let runs_of_source = runs.iter().filter_map(|i| held.remove(i).map(|run| (*i, run)));
                look(
                    source,
                    joined(runs_of_source).iter().flat_map(|whole| cut(source, whole, length)).collect(),
                );
            }
            rest = later;
        }
        Ok(())
    }

    /// Maximum number of samples held in memory at a time.
    pub fn window(&self) -> usize {
        self.recorded.window()
    }

    /// Whether all are in memory.
    pub fn held(&self) -> bool {
        self.recorded.held()
    }

    /// The number of leading items with these `samples` that fit into memory at a time: at least one.
    fn fitting(&self, samples: impl Iterator<Item = usize>) -> usize {
        let mut held = 0;
        let fits = |samples: &usize| {
            held += samples;
            held <= self.window()
        };
        samples.take_while(fits).count().max(1)
    }

    /// Calls `look` with the index into `wanted` and its run; `run` gives the run's index, which must ascend.
    fn visit(
        &self,
        wanted: &[usize],
        run: impl Fn(&usize) -> usize,
        mut look: impl FnMut(usize, &Run),
    ) -> Result<(), R::Error> {
        let block = |thing: &usize| self.runs[run(thing)].block;
        let mut blocks: Vec<usize> = wanted.iter().map(block).collect();
        blocks.dedup();
        let (mut rest, mut done) = (wanted, 0);
        read(&self.recorded, &blocks, |at, runs| {
            let (now, later) = rest.split_at(rest.partition_point(|thing| block(thing) <= at));
            for thing in now {
                look(done, &runs[self.runs[run(thing)].place]);
                done += 1;
            }
            rest = later;
        })
    }
}

impl KnownRun {
    /// The sample ranges of its segments.
    fn segments(&self) -> impl Iterator<Item = Range<usize>> {
        let ends = self.starts.iter().skip(1).copied().chain([self.samples]);
        self.starts.iter().zip(ends).map(|(start, end)| *start..end)
    }
}

/// Names in the order of appearance.
#[derive(Default)]
struct Names {
    names: Vec<String>,
    places: HashMap<String, usize>,
}

impl Names {
    fn place(&mut self, name: &str) -> usize {
        if let Some(place) = self.places.get(name) {
            return *place;
        }
        self.places.insert(name.to_owned(), self.names.len());
        self.names.push(name.to_owned());
        self.names.len() - 1
    }
}

/// Parts of runs that may be stored elsewhere.
#[derive(Clone, Debug)]
pub struct CutRuns<'a, R> {
    runs: &'a PooledRuns<R>,
    places: Vec<SourcePlace>,
}

/// The position of a part.
#[derive(Clone, Debug)]
struct SourcePlace {
    run: usize,
    segment: usize,
    samples: Range<usize>,
}

impl<R: Recorded> CutRuns<'_, R> {
    /// Calls `look` with the index into `wanted`, which must ascend, and the part there.
    fn ascending(&self, wanted: &[usize], mut look: impl FnMut(usize, PartView)) -> Result<(), R::Error> {
        self.runs.visit(
            wanted,
            |i| self.places[*i].run,
            |k, run| {
                let SourcePlace { run: place, segment, samples } = &self.places[wanted[k]];
                let known = &self.runs.runs[*place];
                let view = run.view().part(samples.clone());
                look(
                    k,
                    PartView {
                        label: &run.segments[*segment].maneuver,
                        source: &self.runs.sources[known.source],
                        run: view,
                    },
                );
            },
        )
    }
}

impl<R: Recorded> Parts for CutRuns<'_, R> {
    type Error = R::Error;

    fn count(&self) -> usize {
        self.places.len()
    }

    fn samples(&self, i: usize) -> usize {
        self.places[i].samples.len()
    }

    fn at(&self, places: &[usize], look: &mut dyn FnMut(PartView)) -> Result<(), R::Error> {
        let mut rest = places;
        while !rest.is_empty() {
            let ascending = rest.windows(2).take_while(|pair| pair[0] <= pair[1]).count() + 1;
            let held = self.runs.fitting(rest.iter().map(|i| self.samples(*i)));
            let (now, later) = rest.split_at(ascending.max(held));
            rest = later;
            if ascending >= held {
                self.ascending(now, |_, part| look(part))?;
                continue;
            }
            let mut wanted = now.to_vec();
            wanted.sort_unstable();
            wanted.dedup();
            let mut held = Vec::with_capacity(wanted.len());
            self.ascending(&wanted, |_, part| held.push(Part::new(part.label, part.source, part.run)))?;
            for i in now {
                // Every wanted part was read.
                if let Ok(at) = wanted.binary_search(i) {
                    look(held[at].whole());
                }
            }
        }
        Ok(())
    }
}

/// The runs of a source, with consecutive ones joined.
fn joined(runs: impl Iterator<Item = (usize, Run)>) -> Vec<Run> {
    let mut joined: Vec<(usize, Run)> = Vec::new();
    for (i, run) in runs {
        let continues = |(before, last): &&mut (usize, Run)| {
            *before + 1 == i && last.measured[last.measured.len() - 3..] == run.measured[..3]
        };
        match joined.last_mut().filter(continues) {
            Some((before, last)) => {
                *before = i;
                if !(last.instrument_exogenous.is_empty() && run.instrument_exogenous.is_empty()) {
                    let inputs = [last.view().instrument_exogenous, run.view().instrument_exogenous].concat();
                    last.instrument_exogenous = inputs;
                }
                last.exogenous.extend_from_slice(&run.exogenous);
                last.measured.extend_from_slice(&run.measured[3..]);
            }
            None => joined.push((i, run)),
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

/// `start..end` in equal parts of at most `most` samples.
fn equal(start: usize, end: usize, most: Option<usize>) -> impl Iterator<Item = Range<usize>> {
    let length = end - start;
    let count = most.map_or(1, |most| length.div_ceil(most.max(1))).max(1);
    (0..count).map(move |i| start + i * length / count..start + (i + 1) * length / count)
}
