use vessel::{Diverged, Model, RunView, check_diverged, simulate_one};

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

/// A nominal simulation that left every bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartDiverged {
    /// Index of the part.
    pub part: usize,
    /// Sample within the part, and state.
    pub at: Diverged,
}

impl Part {
    /// A part whose instruments are its regressors.
    pub fn new(label: &str, source: &str, exogenous: Vec<f64>, measured: Vec<f64>) -> Self {
        let instrument_states = measured.clone();
        Self { label: label.to_owned(), source: source.to_owned(), exogenous, measured, instrument_states }
    }

    /// Number of regression pairs N.
    pub fn samples(&self) -> usize {
        self.measured.len() / 3 - 1
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
    pub fn instrument(parts: &mut [Self], model: &Model, parameters: &[f64]) -> Result<(), PartDiverged> {
        let simulated: Vec<Vec<f64>> =
            parts.iter().map(|p| simulate_one(model, parameters, p.view().initial, &p.exogenous)).collect();
        for (part, states) in simulated.iter().enumerate() {
            if let Some(at) = check_diverged(states.iter().copied()) {
                return Err(PartDiverged { part, at });
            }
        }
        parts.iter_mut().zip(simulated).for_each(|(part, states)| part.instrument_states = states);
        Ok(())
    }

    /// Takes the measured states as instruments: least squares.
    pub fn regress(parts: &mut [Self]) {
        parts.iter_mut().for_each(|part| part.instrument_states.clone_from(&part.measured));
    }
}
