use std::convert::Infallible;

use ship::engine::{Diverged, RunView, check_diverged, simulate_one};
use ship::model::{DegreeOfFreedom, Model};
use thiserror::Error;

use super::{PartView, Parts};

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
#[derive(Clone, Debug, PartialEq, Eq, Error)]
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
