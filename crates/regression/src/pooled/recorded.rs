use std::borrow::Cow;
use std::convert::Infallible;
use std::ops::Range;

use rayon::prelude::*;
use ship::engine::{Diverged, Run, RunView, check_diverged, simulate_one};
use ship::model::{DegreeOfFreedom, Model};

/// Runs that can be read repeatedly, block by block.
pub trait Recorded: Sync {
    /// Why a block cannot be read.
    type Error: Send;
    /// Number of blocks.
    fn blocks(&self) -> usize;
    /// The runs of block `i`.
    fn block(&self, i: usize) -> Result<Cow<'_, [Run]>, Self::Error>;
    /// Whether all are in memory.
    fn held(&self) -> bool {
        false
    }
    /// Samples that are held in memory at a time if they are needed in another order than they are stored in: some 60 MB.
    fn window(&self) -> usize {
        1 << 20
    }
}

/// Runs in memory are one block.
impl Recorded for Vec<Run> {
    type Error = Infallible;

    fn blocks(&self) -> usize {
        1
    }

    fn block(&self, _: usize) -> Result<Cow<'_, [Run]>, Infallible> {
        Ok(Cow::Borrowed(self))
    }

    fn held(&self) -> bool {
        true
    }
}

/// Calls `look` with the indices of `blocks` and their runs, in this order. Each thread reads one at a time.
pub(super) fn read<R: Recorded>(
    recorded: &R,
    blocks: &[usize],
    mut look: impl FnMut(usize, &[Run]),
) -> Result<(), R::Error> {
    for few in blocks.chunks(rayon::current_num_threads()) {
        let read: Vec<_> = few.par_iter().map(|block| recorded.block(*block)).collect();
        for (block, runs) in few.iter().zip(read) {
            look(*block, &runs?);
        }
    }
    Ok(())
}

/// A sub-experiment that borrows its samples.
#[derive(Clone, Copy, Debug)]
pub struct PartView<'a> {
    /// Its maneuver.
    pub label: &'a str,
    /// The recording that it was cut from.
    pub source: &'a str,
    /// Its samples.
    pub run: RunView<'a>,
}

/// Sub-experiments that an estimate iterates over repeatedly, storing little of each.
pub trait Parts: Sync {
    /// Why one cannot be read.
    type Error: Send;
    /// Number of parts.
    fn count(&self) -> usize;
    /// Samples of part `i`.
    fn samples(&self, i: usize) -> usize;
    /// Calls `look` with the parts at the indices `places`, in this order.
    fn at(&self, places: &[usize], look: &mut dyn FnMut(PartView)) -> Result<(), Self::Error>;

    /// Calls `look` with every part, in order.
    fn each(&self, look: &mut dyn FnMut(PartView)) -> Result<(), Self::Error> {
        self.at(&(0..self.count()).collect::<Vec<_>>(), look)
    }
}

/// A selection of parts, some possibly several times.
#[derive(Clone, Copy, Debug)]
pub struct Drawn<'a, P: ?Sized> {
    /// The parts that are selected from.
    pub parts: &'a P,
    /// The indices of the selected parts.
    pub places: &'a [usize],
}

impl<P: Parts + ?Sized> Parts for Drawn<'_, P> {
    type Error = P::Error;

    fn count(&self) -> usize {
        self.places.len()
    }

    fn samples(&self, i: usize) -> usize {
        self.parts.samples(self.places[i])
    }

    fn at(&self, places: &[usize], look: &mut dyn FnMut(PartView)) -> Result<(), P::Error> {
        self.parts.at(&places.iter().map(|i| self.places[*i]).collect::<Vec<_>>(), look)
    }
}

/// Parts cut into windows, each a part by itself.
#[derive(Clone, Debug)]
pub struct Windowed<'a, P: ?Sized> {
    parts: &'a P,
    /// The part of each window, and its samples.
    windows: Vec<(usize, Range<usize>)>,
}

impl<'a, P: Parts + ?Sized> Windowed<'a, P> {
    /// The windows of each part one after another, each of `most` samples, at least 1, but for the last of a part.
    pub fn new(parts: &'a P, most: usize) -> Self {
        let of = |i: usize| {
            let samples = parts.samples(i);
            (0..samples).step_by(most).map(move |first| (i, first..(first + most).min(samples)))
        };
        Self { parts, windows: (0..parts.count()).flat_map(of).collect() }
    }
}

impl<P: Parts + ?Sized> Parts for Windowed<'_, P> {
    type Error = P::Error;

    fn count(&self) -> usize {
        self.windows.len()
    }

    fn samples(&self, i: usize) -> usize {
        self.windows[i].1.len()
    }

    fn at(&self, places: &[usize], look: &mut dyn FnMut(PartView)) -> Result<(), P::Error> {
        let wanted: Vec<usize> = places.iter().map(|i| self.windows[*i].0).collect();
        let mut windows = places.iter().map(|i| &self.windows[*i].1);
        self.parts.at(&wanted, &mut |part| {
            if let Some(samples) = windows.next() {
                look(PartView { run: part.run.part(samples.clone()), ..part });
            }
        })
    }
}

/// One sub-experiment of N samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its maneuver.
    pub label: String,
    /// The recording that it was cut from: parts of one source are left out together.
    pub source: String,
    /// Inputs and measured disturbances: N × exogenous, row-major.
    pub exogenous: Vec<f64>,
    /// Those that instruments are simulated with, N × exogenous; empty where they are the above.
    pub instrument_exogenous: Vec<f64>,
    /// Measured states u, v \[m/s\], r \[rad/s\]: (N+1) × 3, row-major.
    pub measured: Vec<f64>,
}

/// The nominal simulation over a part left every bound, so that there are no instruments.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "instruments: the nominal simulation over `{maneuver}` of {recording} diverges at sample {} in {}",
    .at.sample,
    DegreeOfFreedom::ALL[.at.state].name()
)]
pub struct LostInstruments {
    /// The part's maneuver.
    pub maneuver: String,
    /// The recording that it was cut from.
    pub recording: String,
    /// Sample within the part, and state.
    pub at: Diverged,
}

impl Part {
    /// A part that owns its samples.
    pub fn new(label: &str, source: &str, measured: RunView) -> Self {
        Self {
            label: label.to_owned(),
            source: source.to_owned(),
            exogenous: measured.exogenous.to_vec(),
            instrument_exogenous: measured.own_instrument_inputs(),
            measured: measured.measured.to_vec(),
        }
    }

    /// Number of regression pairs N.
    pub fn samples(&self) -> usize {
        self.view().samples()
    }

    /// Its samples.
    pub fn view(&self) -> RunView<'_> {
        let whole = RunView::measured(&self.measured, &self.exogenous);
        match self.instrument_exogenous.as_slice() {
            [] => whole,
            instrument_exogenous => RunView { instrument_exogenous, ..whole },
        }
    }

    /// The whole part, borrowed.
    pub fn whole(&self) -> PartView<'_> {
        PartView { label: &self.label, source: &self.source, run: self.view() }
    }
}

impl PartView<'_> {
    /// Simulates `model` with `parameters` from the first measured state, for instruments: (N+1) × 3.
    ///
    /// # Errors
    /// The simulation diverges.
    pub fn simulated(&self, model: &Model, parameters: &[f64]) -> Result<Vec<f64>, LostInstruments> {
        let states = simulate_one(model, parameters, self.run.initial, self.run.instrument_exogenous);
        match check_diverged(states.iter().copied()) {
            None => Ok(states),
            Some(at) => {
                let (maneuver, recording) = (self.label.to_owned(), self.source.to_owned());
                Err(LostInstruments { maneuver, recording, at })
            }
        }
    }
}

impl Parts for Vec<Part> {
    type Error = Infallible;

    fn count(&self) -> usize {
        self.len()
    }

    fn samples(&self, i: usize) -> usize {
        self[i].samples()
    }

    fn at(&self, places: &[usize], look: &mut dyn FnMut(PartView)) -> Result<(), Infallible> {
        places.iter().for_each(|i| look(self[*i].whole()));
        Ok(())
    }
}
