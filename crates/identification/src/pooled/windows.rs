use vessel::{LANES, Lane, Model};

use crate::{FreeRun, free_runs};

/// A piece of measured data that models are simulated over.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// Inputs and measured disturbances: N × exogenous, row-major.
    pub exogenous: Vec<f64>,
    /// Measured states: (N+1) × 3. The simulation starts at the first.
    pub measured: Vec<f64>,
}

impl Window {
    /// Number of samples N that are compared.
    pub fn samples(&self) -> usize {
        self.measured.len() / 3 - 1
    }
}

/// Windows, ready to be simulated by [`LANES`] models at a time.
#[derive(Clone, Debug)]
pub struct Windows {
    model: Model,
    windows: Vec<Window>,
}

impl Windows {
    /// For parameters of `model`.
    pub fn new(model: &Model, windows: &[Window]) -> Self {
        Self { model: model.clone(), windows: windows.to_vec() }
    }

    /// Simulates up to [`LANES`] models (one lane per parameter) over window `i`.
    pub fn run(&self, models: &[Lane], i: usize) -> [FreeRun; LANES] {
        let Window { exogenous, measured } = &self.windows[i];
        free_runs(&self.model, models, exogenous, measured)
    }

    /// Number of windows.
    pub fn len(&self) -> usize {
        self.windows.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.windows.is_empty()
    }

    /// Samples of window `i`.
    pub fn samples(&self, i: usize) -> usize {
        self.windows[i].samples()
    }
}

/// Squared errors of free simulations over several windows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// Sum of squared errors in u, v, r over the windows that did not diverge.
    pub squares: [f64; 3],
    /// Their samples.
    pub samples: u64,
    /// Windows that diverged.
    pub diverged: u64,
}

impl Score {
    /// Adds a window of `samples` samples.
    pub fn add(&mut self, found: FreeRun, samples: usize) {
        match found {
            FreeRun::Rmse(rmse) => {
                let n = samples as f64;
                self.squares.iter_mut().zip(rmse).for_each(|(s, e)| *s += n * e * e);
                self.samples += samples as u64;
            }
            FreeRun::Diverged(_) => self.diverged += 1,
        }
    }

    /// Adds other windows.
    pub fn merge(&mut self, other: &Self) {
        self.squares.iter_mut().zip(other.squares).for_each(|(s, o)| *s += o);
        self.samples += other.samples;
        self.diverged += other.diverged;
    }

    /// RMSE in u, v \[m/s\], r \[rad/s\]; `None` where a window diverged or there is none.
    pub fn rmse(&self) -> Option<[f64; 3]> {
        let whole = self.diverged == 0 && self.samples > 0;
        whole.then(|| self.squares.map(|s| (s / self.samples as f64).sqrt()))
    }
}
