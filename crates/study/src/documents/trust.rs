use artifact::Document;
use identification::{EstimateStatus, Estimator, MeanRemoval};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `trust.json`: how far one pooled estimate can be trusted.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrustDocument {
    /// The estimator.
    pub estimator: Estimator,
    /// How the instruments' mean is removed.
    pub mean_removal: MeanRemoval,
    /// Where the instruments' nominal model comes from: `given`, `least-squares` or `estimate`.
    pub nominal: String,
    /// Strength of the pull towards the nominal model.
    pub prior: f64,
    /// Number of sub-experiments.
    pub parts: u64,
    /// Number of runs or recordings they were cut from.
    pub sources: u64,
    /// Regression pairs.
    pub samples: u64,
    /// Lags of Bartlett's weights in the standard errors.
    pub bandwidth: u64,
    /// Resamples of the bootstrap over sub-experiments.
    pub replicates: u64,
    /// What to know before using the estimate, in words.
    pub statements: Vec<String>,
    /// Surge, sway, yaw.
    pub degrees: Vec<TrustDegree>,
    /// Free simulation over every run or recording.
    pub runs: Vec<TrustRun>,
}

/// One degree of freedom.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrustDegree {
    /// `surge`, `sway` or `yaw`.
    pub name: String,
    /// Whether there is an estimate.
    pub status: EstimateStatus,
    /// Why it is not identifiable.
    pub reason: Option<String>,
    /// What the estimate was made with: `auto` takes one for each degree of freedom.
    pub estimator: Estimator,
    /// Condition number of the correlations between instruments and regressors; null where singular.
    pub condition: Option<f64>,
    /// Condition index of instruments and regressors with the intercept; from 30 on collinear. Null where singular.
    pub condition_index: Option<f64>,
    /// The direction that the data tell least about.
    pub weakest: String,
    /// Its parameters.
    pub parameters: Vec<TrustParameter>,
    /// Correlations between the estimates: row-major, as many rows as parameters.
    pub correlation: Option<Vec<f64>>,
    /// Whether the residuals are white: Ljung and Box.
    pub whiteness: Option<Whiteness>,
    /// The largest correlation of residuals with instruments at other times.
    pub instrument_residual: Option<InstrumentResidual>,
    /// How well the instruments follow the measured state: 100 (1 − RMSE/std) over the sub-experiments.
    pub instrument_fit: Option<f64>,
}

/// One parameter.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrustParameter {
    /// Name as in `vessel.toml`.
    pub name: String,
    /// Its term.
    pub term: String,
    /// Its unit.
    pub unit: String,
    /// The estimate.
    pub estimate: Option<f64>,
    /// Its standard error: sandwich with autocorrelation; of `output-error` with any correlation within a sub-experiment.
    pub standard_error: Option<f64>,
    /// Its standard deviation over the resamples.
    pub bootstrap_std: Option<f64>,
    /// 2.5 % of the resamples are below.
    pub bootstrap_low: Option<f64>,
    /// 2.5 % are above.
    pub bootstrap_high: Option<f64>,
    /// Size of the term without its mean over its size: 0 for a constant.
    pub variation: f64,
    /// Shea's partial R² of the instruments: 1 least squares, near 0 instruments that have lost the motion.
    pub instrument_strength: Option<f64>,
}

/// Ljung and Box's test.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Whiteness {
    /// Its statistic.
    pub statistic: f64,
    /// Number of lags.
    pub lags: u64,
    /// Probability of a larger one of white residuals.
    pub p_value: f64,
    /// Autocorrelation of neighbours.
    pub first_autocorrelation: f64,
}

/// A correlation of residuals with an instrument.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InstrumentResidual {
    /// The instrument's term.
    pub instrument: String,
    /// Samples by which the instrument comes earlier; below 0 later.
    pub lag: i64,
    /// The correlation.
    pub strongest: f64,
    /// Probability of a larger one, of all lags and instruments tried, under independence.
    pub p_value: f64,
}

/// Free simulation over one run or recording.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrustRun {
    /// Its name.
    pub source: String,
    /// Samples simulated.
    pub samples: u64,
    /// Simulations that diverged.
    pub diverged: u64,
    /// Root mean square errors and fits; null where a simulation diverged or there is no model.
    pub errors: Option<FreeRunErrors>,
}

/// Errors of free simulations. Fit: 100 (1 − RMSE/std), 0 as good as the mean of the data.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FreeRunErrors {
    /// Of surge speed.
    pub rmse_u: f64,
    /// Of sway speed.
    pub rmse_v: f64,
    /// Of yaw rate.
    pub rmse_r: f64,
    /// Of surge speed; null where it does not vary.
    pub fit_u: Option<f64>,
    /// Of sway speed.
    pub fit_v: Option<f64>,
    /// Of yaw rate.
    pub fit_r: Option<f64>,
}

impl FreeRunErrors {
    /// From errors and the standard deviations of the data.
    pub fn new(rmse: [f64; 3], std: [f64; 3]) -> Self {
        let fit = |d: usize| (std[d] > 0.0).then(|| 100.0 * (1.0 - rmse[d] / std[d]));
        Self {
            rmse_u: rmse[0],
            rmse_v: rmse[1],
            rmse_r: rmse[2],
            fit_u: fit(0),
            fit_v: fit(1),
            fit_r: fit(2),
        }
    }

    /// Fits of u, v, r.
    pub fn fits(&self) -> [Option<f64>; 3] {
        [self.fit_u, self.fit_v, self.fit_r]
    }
}

impl Document for TrustDocument {
    const ID: &'static str = "trust";
    const VERSION: u32 = 1;
    const UNITS: &'static [(&'static str, &'static str)] = &[
        ("prior", "1"),
        ("parts", "1"),
        ("sources", "1"),
        ("samples", "1"),
        ("bandwidth", "1"),
        ("replicates", "1"),
        ("condition", "1"),
        ("condition_index", "1"),
        ("estimate", "the parameter's unit"),
        ("standard_error", "the parameter's unit"),
        ("bootstrap_std", "the parameter's unit"),
        ("bootstrap_low", "the parameter's unit"),
        ("bootstrap_high", "the parameter's unit"),
        ("variation", "1"),
        ("instrument_strength", "1"),
        ("correlation", "1"),
        ("statistic", "1"),
        ("lags", "1"),
        ("p_value", "1"),
        ("first_autocorrelation", "1"),
        ("lag", "samples"),
        ("strongest", "1"),
        ("instrument_fit", "%"),
        ("diverged", "1"),
        ("rmse_u", "m/s"),
        ("rmse_v", "m/s"),
        ("rmse_r", "rad/s"),
        ("fit_u", "%"),
        ("fit_v", "%"),
        ("fit_r", "%"),
    ];
}
