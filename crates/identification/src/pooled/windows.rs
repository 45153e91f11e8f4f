use numerics::statistics::spread;
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

    /// Simulates one model over all windows.
    pub fn score(&self, model: &[f64]) -> Score {
        let lanes: Vec<Lane> = model.iter().copied().map(Lane::splat).collect();
        let mut score = Score::default();
        for i in 0..self.len() {
            score.add(self.run(&lanes, i)[0], self.samples(i));
        }
        score
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

/// Errors of free simulations beside the standard deviations of what was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Root mean square errors in u, v \[m/s\], r \[rad/s\].
    pub rmse: [f64; 3],
    /// Standard deviations of the measured states, see [`deviations`].
    pub std: [f64; 3],
}

impl Errors {
    /// Of a [`Score`] without divergence, against `std`.
    pub fn of(score: &Score, std: [f64; 3]) -> Option<Self> {
        score.rmse().map(|rmse| Self { rmse, std })
    }

    /// 100 (1 − RMSE/std): 0 is as good as the mean of the data \[%\]. `None` for a state that does not vary.
    pub fn fits(&self) -> [Option<f64>; 3] {
        [0, 1, 2].map(|d: usize| (self.std[d] > 0.0).then(|| 100.0 * (1.0 - self.rmse[d] / self.std[d])))
    }

    /// The 2-norm of RMSE/std; `None` where a state does not vary.
    pub fn norm(&self) -> Option<f64> {
        let norm = (0..3).map(|d| (self.rmse[d] / self.std[d]).powi(2)).sum::<f64>().sqrt();
        norm.is_finite().then_some(norm)
    }
}

/// Standard deviations of u, v, r over samples 1 to N of several (N+1) × 3 states, as of a whole population.
pub fn deviations<'a>(measured: impl Iterator<Item = &'a [f64]>) -> [f64; 3] {
    let mut states: [Vec<f64>; 3] = Default::default();
    for rows in measured {
        for row in rows.chunks_exact(3).skip(1) {
            (0..3).for_each(|d| states[d].push(row[d]));
        }
    }
    states.map(|values| {
        let n = values.len() as f64;
        spread(&values).map_or(0.0, |s| s * ((n - 1.0) / n).sqrt())
    })
}
