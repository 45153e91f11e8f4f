use thiserror::Error;
use vessel::{DegreeOfFreedom, Diverged, Model, RunView, check_diverged, simulate_one};

use super::deviations;

/// One sub-experiment of N samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its maneuver.
    pub label: String,
    /// What it was cut from: parts of one source are left out together.
    pub source: String,
    /// Inputs and measured disturbances: N × exogenous, row-major.
    pub exogenous: Vec<f64>,
    /// Measured states u, v \[m/s\], r \[rad/s\]: (N+1) × 3, row-major.
    pub measured: Vec<f64>,
    /// States that the instruments are formed with: (N+1) × 3. The measured ones are least squares.
    pub instrument_states: Vec<f64>,
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
    /// What it was cut from.
    pub recording: String,
    /// Sample within the part, and state.
    pub at: Diverged,
}

impl Part {
    /// A part whose instruments are its regressors.
    pub fn new(label: &str, source: &str, measured: RunView) -> Self {
        Self {
            label: label.to_owned(),
            source: source.to_owned(),
            exogenous: measured.exogenous.to_vec(),
            measured: measured.measured.to_vec(),
            instrument_states: measured.measured.to_vec(),
        }
    }

    /// Number of regression pairs N.
    pub fn samples(&self) -> usize {
        self.view().samples()
    }

    /// What was measured.
    pub fn view(&self) -> RunView<'_> {
        RunView::measured(&self.measured, &self.exogenous)
    }

    /// Simulates `model` with `parameters` over every part, each from its first measured state, and takes the states as
    /// instruments.
    ///
    /// # Errors
    /// The first part whose simulation diverges; no part is changed then.
    pub fn instrument(parts: &mut [Self], model: &Model, parameters: &[f64]) -> Result<(), LostInstruments> {
        let simulated: Vec<Vec<f64>> =
            parts.iter().map(|p| simulate_one(model, parameters, p.view().initial, &p.exogenous)).collect();
        for (part, states) in parts.iter().zip(&simulated) {
            if let Some(at) = check_diverged(states.iter().copied()) {
                let (maneuver, recording) = (part.label.clone(), part.source.clone());
                return Err(LostInstruments { maneuver, recording, at });
            }
        }
        parts.iter_mut().zip(simulated).for_each(|(part, states)| part.instrument_states = states);
        Ok(())
    }

    /// Takes the measured states as instruments: least squares.
    pub fn regress(parts: &mut [Self]) {
        parts.iter_mut().for_each(|part| part.instrument_states.clone_from(&part.measured));
    }

    /// How well the instruments' u, v, r follow the measured ones over `parts`: 100 (1 − RMSE/std) \[%\]. `None` where a state
    /// does not vary.
    pub fn instrument_fit(parts: &[Self]) -> Option<[f64; 3]> {
        let std = deviations(parts.iter().map(|p| p.measured.as_slice()));
        let (mut squares, mut samples) = ([0.0; 3], 0.0);
        for part in parts {
            for (z, y) in part.instrument_states.chunks_exact(3).zip(part.measured.chunks_exact(3)).skip(1) {
                (0..3).for_each(|d| squares[d] += (z[d] - y[d]) * (z[d] - y[d]));
                samples += 1.0;
            }
        }
        let fits = [0, 1, 2].map(|d: usize| 100.0 * (1.0 - (squares[d] / samples).sqrt() / std[d]));
        fits.iter().all(|f| f.is_finite()).then_some(fits)
    }
}
