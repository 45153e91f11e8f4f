use regression::pooled::Part;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Errors of one model over some windows. Null where a window diverged, or there is none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparedErrors {
    /// Windows.
    pub windows: u64,
    /// Windows that diverged.
    pub diverged: u64,
    /// Samples that were simulated.
    pub samples: u64,
    /// Root mean square error of u.
    pub rmse_u: Option<f64>,
    /// Of v.
    pub rmse_v: Option<f64>,
    /// Of r.
    pub rmse_r: Option<f64>,
    /// 100 (1 − RMSE/std), 0 as good as the mean of the data; null where u does not vary.
    pub fit_u: Option<f64>,
    /// Of v.
    pub fit_v: Option<f64>,
    /// Of r.
    pub fit_r: Option<f64>,
    /// Mean of measured less simulated u.
    pub bias_u: Option<f64>,
    /// Of v.
    pub bias_v: Option<f64>,
    /// Of r.
    pub bias_r: Option<f64>,
    /// Norm of RMSE over the standard deviations of u, v, r in all recordings.
    pub error_norm: Option<f64>,
}

/// Those over one run or recording, against the standard deviations of its own states.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparedRecording {
    /// Its name.
    pub source: String,
    /// Its errors.
    pub errors: ComparedErrors,
}

impl ComparedErrors {
    /// Fits of u, v, r.
    pub fn fits(&self) -> [Option<f64>; 3] {
        [self.fit_u, self.fit_v, self.fit_r]
    }

    /// RMSE of u, v, r.
    pub fn rmse(&self) -> [Option<f64>; 3] {
        [self.rmse_u, self.rmse_v, self.rmse_r]
    }
}

/// Sums of errors over windows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    windows: u64,
    diverged: u64,
    samples: u64,
    errors: [f64; 3],
    squares: [f64; 3],
}

impl Sums {
    /// Adds a window with its simulated `states`, (N+1) × 3; `None`: it diverged.
    pub fn add(&mut self, window: &Part, states: Option<&[f64]>) {
        self.windows += 1;
        let Some(states) = states else {
            self.diverged += 1;
            return;
        };
        self.samples += window.samples() as u64;
        let pairs = window.measured.as_chunks::<3>().0.iter().zip(states.as_chunks::<3>().0);
        for (measured, simulated) in pairs.skip(1) {
            for d in 0..3 {
                let error = measured[d] - simulated[d];
                self.errors[d] += error;
                self.squares[d] += error * error;
            }
        }
    }

    pub fn merge(&mut self, other: &Self) {
        self.windows += other.windows;
        self.diverged += other.diverged;
        self.samples += other.samples;
        (0..3).for_each(|d| {
            self.errors[d] += other.errors[d];
            self.squares[d] += other.squares[d];
        });
    }

    /// The errors relative to the standard deviations `own` of these windows and `all` of all windows.
    pub fn errors(&self, own: [f64; 3], all: [f64; 3]) -> ComparedErrors {
        let Self { windows, diverged, samples, .. } = *self;
        let counted = ComparedErrors { windows, diverged, samples, ..ComparedErrors::default() };
        if diverged > 0 || samples == 0 {
            return counted;
        }
        let n = samples as f64;
        let rmse = self.squares.map(|sum| (sum / n).sqrt());
        let fit = |d: usize| (own[d] > 0.0).then(|| 100.0 * (1.0 - rmse[d] / own[d]));
        let norm = (0..3).map(|d| (rmse[d] / all[d]).powi(2)).sum::<f64>().sqrt();
        let ([rmse_u, rmse_v, rmse_r], [bias_u, bias_v, bias_r]) =
            (rmse.map(Some), self.errors.map(|sum| Some(sum / n)));
        let [fit_u, fit_v, fit_r] = [0, 1, 2].map(fit);
        let error_norm = Some(norm).filter(|norm| norm.is_finite());
        ComparedErrors {
            rmse_u,
            rmse_v,
            rmse_r,
            fit_u,
            fit_v,
            fit_r,
            bias_u,
            bias_v,
            bias_r,
            error_norm,
            ..counted
        }
    }
}
