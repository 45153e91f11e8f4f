use std::collections::BTreeMap;
use std::path::Path;

use artifact::{Provenance, read_document};
use identification::pooled::{Part, Window};
use vessel::{Vessel, nearest};

use super::PoolFlags;
use crate::failure::Failure;
use study::documents::{ChannelSummary, IngestDocument, RecordingSummary};
use study::trajectories::{Layout, TrajectoryReader, label};
use vessel::Run;

/// Measured runs, each with the name of what it was cut from.
pub struct Data {
    runs: Vec<(String, Run)>,
    rate_hz: f64,
    part_samples: Option<usize>,
    constant: Vec<String>,
}

/// Consecutive samples of one source: a run, or runs of one recording that continue each other.
#[derive(Clone, Debug)]
pub struct Stretch {
    /// What it was cut from.
    pub source: String,
    /// Inputs and measured disturbances: N × exogenous, row-major.
    pub exogenous: Vec<f64>,
    /// Measured states: (N+1) × 3, row-major.
    pub measured: Vec<f64>,
}

impl Data {
    /// Reads `file` and selects runs.
    ///
    /// # Errors
    /// Files that are refused; names that no run has; nothing left.
    pub fn read(
        file: &Path,
        vessel: &Vessel,
        flags: &PoolFlags,
        provenance: &mut Provenance,
    ) -> Result<Self, Failure> {
        let reader = TrajectoryReader::open(file, &Layout::new(&vessel.model), vessel.sample_rate_hz)?;
        reader.whole()?;
        provenance.inputs.insert("trajectories".into(), reader.digest());
        let mut runs = Vec::new();
        for block in 0..reader.blocks() {
            runs.extend(reader.runs(block)?);
        }
        label(runs.iter().map(|run: &Run| run.design.as_str()), provenance);
        let (names, constant) = recordings(flags, provenance)?;
        let several = runs.iter().any(|run| run.design != runs[0].design);
        let name = |run: &Run| match names.get(&run.run) {
            Some(name) => name.clone(),
            None if several => format!("{}/{}", run.design, run.run),
            None => run.run.to_string(),
        };
        let runs = runs.into_iter().map(|run| (name(&run), run)).collect();
        let part_samples = flags.part_samples(vessel.sample_rate_hz)?;
        let mut data = Self { runs, rate_hz: vessel.sample_rate_hz, part_samples, constant };
        data.select(file, flags)?;
        Ok(data)
    }

    fn select(&mut self, file: &Path, flags: &PoolFlags) -> Result<(), Failure> {
        let named = |name: &String, source: &str, run: &Run| name == source || *name == run.run.to_string();
        for name in flags.runs.iter().chain(&flags.leave_out) {
            if !self.runs.iter().any(|(source, run)| named(name, source, run)) {
                let sources = self.runs.iter().map(|(source, _)| source.as_str());
                return Err(Failure::refuse(
                    file,
                    &format!("run `{name}`"),
                    "no such run or recording",
                    &format!("one of {} runs, by number or recording", self.runs.len()),
                    &format!("did you mean `{}`?", nearest(name, sources).unwrap_or_default()),
                ));
            }
        }
        self.runs.retain(|(source, run)| {
            let within = |names: &[String]| names.iter().any(|name| named(name, source, run));
            (flags.runs.is_empty() || within(&flags.runs)) && !within(&flags.leave_out)
        });
        if self.runs.is_empty() {
            let remedy = "leave out fewer runs";
            return Err(Failure::refuse(file, "runs", "none left", "at least one", remedy));
        }
        Ok(())
    }

    /// Sampling rate \[Hz\].
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Logged channels that never vary, with their value; none without `--recordings`.
    pub fn constant(&self) -> &[String] {
        &self.constant
    }

    /// Name of the design of the first run.
    pub fn design(&self) -> &str {
        self.runs.first().map_or("", |(_, run)| run.design.as_str())
    }

    /// The sources, in the order of appearance.
    pub fn sources(&self) -> Vec<String> {
        let mut sources: Vec<String> = Vec::new();
        for (source, _) in &self.runs {
            if !sources.contains(source) {
                sources.push(source.clone());
            }
        }
        sources
    }

    /// The sub-experiments: segments, cut where they are longer than asked for.
    pub fn parts(&self, vessel: &Vessel) -> Vec<Part> {
        self.pieces(vessel).concat()
    }

    /// The segments, each in the pieces that it is cut into.
    pub fn pieces(&self, vessel: &Vessel) -> Vec<Vec<Part>> {
        self.cut(vessel, self.part_samples)
    }

    /// The segments, uncut.
    pub fn segments(&self, vessel: &Vessel) -> Vec<Part> {
        self.cut(vessel, None).concat()
    }

    fn cut(&self, vessel: &Vessel, most: Option<usize>) -> Vec<Vec<Part>> {
        let width = vessel.model.exogenous();
        let mut segments = Vec::new();
        for (source, run) in &self.runs {
            let ends = run.segments.iter().skip(1).map(|s| s.start).chain([run.samples()]);
            for (segment, end) in run.segments.iter().zip(ends) {
                let part = |(start, end): (usize, usize)| {
                    let exogenous = run.exogenous[start * width..end * width].to_vec();
                    let measured = run.measured[3 * start..3 * (end + 1)].to_vec();
                    Part::new(&segment.maneuver, source, exogenous, measured)
                };
                segments.push(pieces(segment.start, end, most).into_iter().map(part).collect());
            }
        }
        segments
    }

    /// The runs, joined where one of the same source begins with the state that the last one ended with.
    pub fn stretches(&self) -> Vec<Stretch> {
        let mut stretches: Vec<Stretch> = Vec::new();
        for (source, run) in &self.runs {
            let continues = |last: &&mut Stretch| {
                last.source == *source && last.measured[last.measured.len() - 3..] == run.measured[..3]
            };
            match stretches.last_mut().filter(continues) {
                Some(last) => {
                    last.exogenous.extend_from_slice(&run.exogenous);
                    last.measured.extend_from_slice(&run.measured[3..]);
                }
                None => stretches.push(Stretch {
                    source: source.clone(),
                    exogenous: run.exogenous.clone(),
                    measured: run.measured.clone(),
                }),
            }
        }
        stretches
    }
}

impl Stretch {
    /// Its windows of `length` samples, side by side from its start; the rest is left out. All of it without a length.
    pub fn windows(&self, width: usize, length: Option<usize>) -> Vec<Window> {
        let samples = self.measured.len() / 3 - 1;
        let length = length.unwrap_or(samples);
        let window = |i: usize| Window {
            exogenous: self.exogenous[i * length * width..(i + 1) * length * width].to_vec(),
            measured: self.measured[3 * i * length..3 * ((i + 1) * length + 1)].to_vec(),
        };
        (0..samples / length.max(1)).map(window).collect()
    }
}

/// `start..end` in equal pieces of at most `most` samples.
fn pieces(start: usize, end: usize, most: Option<usize>) -> Vec<(usize, usize)> {
    let length = end - start;
    let count = most.map_or(1, |most| length.div_ceil(most.max(1))).max(1);
    (0..count).map(|i| (start + i * length / count, start + (i + 1) * length / count)).collect()
}

/// Recording of every run and the channels that never vary, where `--recordings` tells.
fn recordings(
    flags: &PoolFlags,
    provenance: &mut Provenance,
) -> Result<(BTreeMap<i32, String>, Vec<String>), Failure> {
    let Some(path) = &flags.recordings else { return Ok((BTreeMap::new(), Vec::new())) };
    let loaded = read_document::<IngestDocument>(path)?;
    provenance.inputs.insert("recordings".into(), loaded.digest);
    let named = |r: &RecordingSummary| {
        let name = r.name.clone();
        r.runs.iter().map(move |run| (*run as i32, name.clone())).collect::<Vec<_>>()
    };
    let recordings = &loaded.data.recordings;
    Ok((recordings.iter().flat_map(named).collect(), constant_channels(recordings)))
}

/// A channel whose range over all recordings is below this share of its size never varies.
const STEADY: f64 = 1e-3;

/// `n` at 10.23 1/s, for every channel that is constant and not 0 over all `recordings`.
fn constant_channels(recordings: &[RecordingSummary]) -> Vec<String> {
    let channels = || recordings.iter().flat_map(|r| &r.channels);
    let constant = |channel: &&ChannelSummary| {
        let own = || channels().filter(|c| c.name == channel.name);
        let low = own().filter_map(|c| c.min).fold(f64::INFINITY, f64::min);
        let high = own().filter_map(|c| c.max).fold(f64::NEG_INFINITY, f64::max);
        let size = low.abs().max(high.abs());
        own().count() == recordings.len() && size > 0.0 && high - low < STEADY * size
    };
    let told = |c: &ChannelSummary| format!("`{}` at {:.4} {}", c.name, c.max.unwrap_or(0.0), c.unit);
    recordings.first().map_or(Vec::new(), |r| r.channels.iter().filter(constant).map(told).collect())
}
