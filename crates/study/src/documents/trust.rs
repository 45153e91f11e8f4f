use artifact::Document;
use identification::pooled::{
    self, CrossCorrelation, DegreeTrust, Errors, NominalSource, ParameterTrust, Pool, Pooled, SourceErrors,
};
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
    /// Where the instruments' nominal model comes from.
    pub nominal: NominalSource,
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

impl From<&Errors> for FreeRunErrors {
    fn from(errors: &Errors) -> Self {
        let ([rmse_u, rmse_v, rmse_r], [fit_u, fit_v, fit_r]) = (errors.rmse, errors.fits());
        Self { rmse_u, rmse_v, rmse_r, fit_u, fit_v, fit_r }
    }
}

impl FreeRunErrors {
    /// Fits of u, v, r.
    pub fn fits(&self) -> [Option<f64>; 3] {
        [self.fit_u, self.fit_v, self.fit_r]
    }
}

impl TrustDocument {
    /// What is known of `found`, which `estimator` found from `pool` with instruments from `nominal`.
    pub fn new(
        pool: &Pool,
        nominal: NominalSource,
        estimator: Estimator,
        replicates: u32,
        found: &Pooled,
    ) -> Self {
        Self {
            estimator,
            mean_removal: pool.removal,
            nominal,
            prior: pool.strength,
            parts: found.parts as u64,
            sources: found.sources.len() as u64,
            samples: found.samples,
            bandwidth: found.bandwidth as u64,
            replicates: u64::from(replicates),
            statements: found.statements.clone(),
            degrees: found.degrees.iter().map(TrustDegree::from).collect(),
            runs: found.sources.iter().map(TrustRun::from).collect(),
        }
    }
}

impl From<&DegreeTrust> for TrustDegree {
    fn from(found: &DegreeTrust) -> Self {
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        let residual = |c: &CrossCorrelation| InstrumentResidual {
            instrument: found.parameters[c.instrument].term.clone(),
            lag: c.lag,
            strongest: c.correlation,
            p_value: c.p_value,
        };
        Self {
            name: found.degree.name().to_owned(),
            status: match found.reason {
                None => EstimateStatus::Identified,
                Some(_) => EstimateStatus::NotIdentifiable,
            },
            reason: found.reason.clone(),
            estimator: found.estimator,
            condition: finite(found.condition),
            condition_index: finite(found.index),
            weakest: found.weakest.clone(),
            parameters: found.parameters.iter().map(TrustParameter::from).collect(),
            correlation: found.correlation.clone(),
            whiteness: found.whiteness.as_ref().map(Whiteness::from),
            instrument_residual: found.instrument_residual.as_ref().map(residual),
            instrument_fit: found.instrument_fit,
        }
    }
}

impl From<&ParameterTrust> for TrustParameter {
    fn from(found: &ParameterTrust) -> Self {
        Self {
            name: found.name.clone(),
            term: found.term.clone(),
            unit: found.unit.clone(),
            estimate: found.estimate,
            standard_error: found.standard_error,
            bootstrap_std: found.resampled.map(|r| r.std),
            bootstrap_low: found.resampled.map(|r| r.low),
            bootstrap_high: found.resampled.map(|r| r.high),
            variation: found.variation,
            instrument_strength: found.instrument_strength,
        }
    }
}

impl From<&pooled::Whiteness> for Whiteness {
    fn from(found: &pooled::Whiteness) -> Self {
        Self {
            statistic: found.statistic,
            lags: found.lags as u64,
            p_value: found.p_value,
            first_autocorrelation: found.first,
        }
    }
}

impl From<&SourceErrors> for TrustRun {
    fn from(found: &SourceErrors) -> Self {
        Self {
            source: found.source.clone(),
            samples: found.samples,
            diverged: found.diverged,
            errors: found.errors.as_ref().map(FreeRunErrors::from),
        }
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
