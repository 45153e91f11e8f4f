//! Estimates: `estimate.json`.

use estimation::Estimator;
use estimation::criticism::Criticism;
use estimation::pooled::{DegreeTrust, ParameterTrust, Pool, Pooled, SourceErrors};
use files::{Document, Units};
use refusal::Invalid;
use regression::MeanRemoval;
use regression::pooled::NominalSource;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::{Constrained, Constraint, Model, Vessel};

use super::compare::LeftOutScores;
use super::refined::PromiseUpdate;
use super::search::SearchSummary;

/// `estimate.json`: what the estimates of all runs say together.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EstimateDocument {
    /// The estimator.
    pub estimator: Estimator,
    /// How the instruments' mean is removed.
    pub mean_removal: MeanRemoval,
    /// Seed of the campaign that the runs come from; absent for runs that were not simulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// How far `se_ratio` may be from 1 for standard errors to be trusted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trusted_within: Option<f64>,
    /// One entry per design, in the order of the trajectories.
    pub designs: Vec<DesignSummary>,
    /// Every estimator on the same runs, where they were compared; `designs` then is that of `estimator`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compared: Option<Vec<EstimatorSummary>>,
    /// Parameters that are fixed or tied to others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constrained: Vec<ConstrainedParameter>,
    /// Which model was made of all runs, and why; absent where every run has its own estimate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub structure: Option<ChosenStructure>,
    /// How far the estimate of all runs can be trusted; absent of a ship with forces and of a structure that was searched for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trust: Option<Trust>,
    /// How the structure was searched for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub search: Option<SearchSummary>,
    /// Estimators over runs or recordings that were left out, where that was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_out: Option<LeftOutScores>,
    /// What a design promised beside what the estimate leaves uncertain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub promise: Option<PromiseUpdate>,
}

refusal::choices! {
    /// Which model is made of all runs.
    pub enum ModelStructure {
        /// The terms or forces of the vessel.
        Own = "own",
        /// Some seven terms: resistance, drive and what steers.
        Core = "core",
        /// The terms, or forces, of a library that a search keeps.
        Library = "library",
        /// The fewest terms of it that follow recordings left out about as well.
        Few = "few",
        /// The average of ten models of few terms; of a ship with forces that of these and of terms.
        Average = "average",
    }
}

/// A structure, and why it was taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChosenStructure {
    /// Which one.
    pub chosen: ModelStructure,
    /// Why, in words.
    pub statement: String,
}

/// The estimates of one estimator.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EstimatorSummary {
    /// The estimator.
    pub estimator: Estimator,
    /// One entry per design, in the order of the trajectories.
    pub designs: Vec<DesignSummary>,
}

/// The estimates of one design.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignSummary {
    /// Name of the design: `optimized`, `random` …
    pub design: String,
    /// Number of runs.
    pub runs: u64,
    /// Runs with an estimate.
    pub identified: u64,
    /// Runs whose search for an estimate ended nowhere; absent for estimators that search for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_converged: Option<u64>,
    /// Runs that reject the model: something is missing beyond chance; absent where no run was asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rejected: Option<u64>,
    /// 2-norm of `relative_bias` over the parameters that have one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relative_bias: Option<f64>,
    /// 2-norm of `relative_spread` over the parameters that have one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relative_spread: Option<f64>,
    /// Root of the sum of their squares.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relative_rms: Option<f64>,
    /// Least `se_ratio` of all parameters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub se_ratio_min: Option<f64>,
    /// Largest `se_ratio` of all parameters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub se_ratio_max: Option<f64>,
    /// One entry per parameter, over the identified runs.
    pub parameters: Vec<ParameterSummary>,
    /// One entry per degree of freedom.
    pub degrees: Vec<DegreeSummary>,
}

/// One parameter over the runs of one design. The unit stands beside it.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterSummary {
    /// Name as in `vessel.toml`.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// True value, where `vessel.toml` has one.
    pub truth: Option<f64>,
    /// Nominal value.
    pub nominal: f64,
    /// Mean estimate (null without identified runs).
    pub mean: Option<f64>,
    /// Standard deviation of the estimates over the runs (null below two runs).
    pub spread: Option<f64>,
    /// Median of the predicted standard errors, 0 at a bound.
    pub predicted_se: Option<f64>,
    /// Runs whose estimate lies at a bound; absent without bounds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_bound: Option<u64>,
    /// (mean − truth)/|truth|; absent where the truth is not known or 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relative_bias: Option<f64>,
    /// spread/|truth|; absent as well.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relative_spread: Option<f64>,
    /// Predicted standard error over the spread: near 1 where standard errors can be trusted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub se_ratio: Option<f64>,
    /// Whether it is within `trusted_within` of 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub se_trusted: Option<bool>,
}

/// How well one degree of freedom was excited.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DegreeSummary {
    /// `surge`, `sway` or `yaw`.
    pub name: String,
    /// Median condition number of the scaled normal matrix over the runs.
    pub condition_median: Option<f64>,
    /// 95 % interval of that median; null at an end that there are too few runs for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition_median_interval: Option<[Option<f64>; 2]>,
    /// Its largest value.
    pub condition_max: Option<f64>,
    /// The parameter that dominates the weakest direction most often.
    pub weakest_parameter: String,
    /// Share of the runs in which it does.
    pub weakest_share: f64,
    /// 95 % interval of that share (Wilson's); absent without runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weakest_share_interval: Option<[f64; 2]>,
}

impl EstimateDocument {
    /// The mean estimate of its only design: θ in the order of `vessel`.
    ///
    /// # Errors
    /// Several designs; a parameter without an estimate.
    pub fn mean(&self, vessel: &Vessel) -> Result<Vec<f64>, Invalid> {
        let [design] = self.designs.as_slice() else {
            let given = format!("{} designs", self.designs.len());
            let remedy = "name an estimate.json of `estimate --fit together`";
            return Err(Invalid::new("data.designs", given, "one", remedy));
        };
        let value = |name: &str| {
            let mean = design.parameters.iter().find(|p| p.name == name).and_then(|p| p.mean);
            mean.ok_or_else(|| {
                let remedy = "estimate it, or name the vessel that the estimate is of";
                Invalid::new(format!("parameter `{name}`"), "no estimate", "one", remedy)
            })
        };
        vessel.model.parameter_names().map(value).collect()
    }

    /// That by `estimator`, with nothing said yet.
    pub fn new(estimator: Estimator, mean_removal: MeanRemoval) -> Self {
        Self {
            estimator,
            mean_removal,
            seed: None,
            trusted_within: None,
            designs: Vec::new(),
            compared: None,
            constrained: Vec::new(),
            structure: None,
            trust: None,
            search: None,
            left_out: None,
            promise: None,
        }
    }

    /// One estimate from all runs.
    pub fn pooled(vessel: &Vessel, estimator: Estimator, mean_removal: MeanRemoval, found: &Pooled) -> Self {
        let parameters = found.degrees.iter().flat_map(|d| &d.parameters).enumerate();
        let bounded = bounded(&vessel.model);
        let parameter = |(i, p): (usize, &ParameterTrust)| ParameterSummary {
            name: p.name.clone(),
            unit: p.unit.clone(),
            truth: vessel.value[i],
            nominal: vessel.nominal[i],
            mean: p.estimate,
            predicted_se: p.standard_error,
            at_bound: bounded[i].then_some(u64::from(p.at_bound)),
            ..ParameterSummary::default()
        };
        let design = DesignSummary {
            design: found.design.clone(),
            runs: 1,
            identified: u64::from(found.degrees.iter().all(|d| d.reason.is_none())),
            rejected: found.criticism.as_ref().map(|criticism| u64::from(criticism.rejected)),
            parameters: parameters.map(parameter).collect(),
            degrees: found.degrees.iter().map(DegreeSummary::from).collect(),
            ..DesignSummary::default()
        };
        Self {
            designs: vec![design],
            constrained: ConstrainedParameter::all(vessel, Some(found)),
            ..Self::new(estimator, mean_removal)
        }
    }
}

/// Which parameters of `model` have bounds.
pub(crate) fn bounded(model: &Model) -> Vec<bool> {
    let is_bounded = |bounds: &[f64; 2]| bounds.iter().any(|end| end.is_finite());
    let none = || vec![false; model.parameters()];
    model.bounds().map_or_else(none, |all| all.iter().map(is_bounded).collect())
}

impl From<&DegreeTrust> for DegreeSummary {
    fn from(found: &DegreeTrust) -> Self {
        Self {
            name: found.name.clone(),
            condition_median: found.condition,
            condition_max: found.condition,
            weakest_parameter: found.weakest_parameter().to_owned(),
            weakest_share: 1.0,
            ..Self::default()
        }
    }
}

impl Document for EstimateDocument {
    const ID: &'static str = "estimate";
    const VERSION: u32 = 2;
    const UNITS: Units = &[
        ("1", "runs identified not_converged rejected condition_median condition_max weakest_share"),
        ("1", "weakest_share_interval condition_median_interval seed trusted_within relative_bias"),
        ("1", "relative_spread relative_rms se_ratio se_ratio_min se_ratio_max at_bound factor"),
        ("1", "prior parts sources samples bandwidth replicates condition condition_index variation"),
        ("1", "instrument_strength correlation statistic lags p_value first_autocorrelation strongest"),
        (
            "1",
            "diverged error_ratio evidence below turns windows folds error_norm by_instruments differences",
        ),
        (
            "1",
            "terms chosen_by_folds loss excess ridge ridges fold margin search_norm base_norm average_norm",
        ),
        ("1", "over_search over_base models chosen recordings_each chosen_by_resamples searches failed"),
        ("1", "search_diverged"),
        ("1", "ratio after_another wanted reached share units prime_value"),
        ("the unit beside it", "visible_from std"),
        (
            "the parameter's unit",
            "truth nominal mean spread predicted_se bootstrap_std bootstrap_low bootstrap_high",
        ),
        (
            "the unit of what it belongs to",
            "estimate standard_error value low high lowest highest scale promised now",
        ),
        ("samples", "lag"),
        ("%", "instrument_fit fit_u fit_v fit_r score"),
        ("m/s", "rmse_u rmse_v noise_u noise_v current_std std_u std_v"),
        ("rad/s", "rmse_r noise_r std_r"),
        ("s", "current_time_s time_s window_s fitted_window_s every_s duration_s needed_s remaining_s"),
    ];
}

/// A parameter that is not estimated by itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstrainedParameter {
    /// Its name.
    pub name: String,
    /// Its term.
    pub term: String,
    /// Its unit.
    pub unit: String,
    /// Whether its value is known.
    pub fixed: bool,
    /// Else the parameter that it equals …
    pub tied_to: Option<String>,
    /// … times this factor.
    pub factor: Option<f64>,
    /// Its value; null where it follows from an estimate that there is not, or from one of each run.
    pub estimate: Option<f64>,
    /// Its standard error, where it follows from an estimate.
    pub standard_error: Option<f64>,
}

impl ConstrainedParameter {
    /// The constrained parameters of `vessel`, with their values from an estimate of all runs, if there is one.
    pub fn all(vessel: &Vessel, found: Option<&Pooled>) -> Vec<Self> {
        let estimates: Vec<(Option<f64>, Option<f64>)> = found.map_or(Vec::new(), |pooled| {
            let parameters = pooled.degrees.iter().flat_map(|d| &d.parameters);
            parameters.map(|p| (p.estimate, p.standard_error)).collect()
        });
        vessel.constrained.iter().map(|constrained| Self::of(vessel, constrained, &estimates)).collect()
    }

    fn of(vessel: &Vessel, constrained: &Constrained, estimates: &[(Option<f64>, Option<f64>)]) -> Self {
        let written = Self {
            name: constrained.name.clone(),
            term: constrained.term.text.clone(),
            unit: vessel.model.unit(constrained.degree, &constrained.term),
            fixed: true,
            tied_to: None,
            factor: None,
            estimate: None,
            standard_error: None,
        };
        match constrained.constraint {
            Constraint::Fixed(value) => Self { estimate: Some(value), ..written },
            Constraint::Tied { to, factor } => {
                let (estimate, error) = estimates.get(to).copied().unwrap_or_default();
                Self {
                    fixed: false,
                    tied_to: vessel.model.parameter_names().nth(to).map(str::to_owned),
                    factor: Some(factor),
                    estimate: estimate.map(|estimate| factor * estimate),
                    standard_error: error.map(|error| factor.abs() * error),
                    ..written
                }
            }
        }
    }
}

/// How far one pooled estimate can be trusted.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Trust {
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
    pub degrees: Vec<DegreeTrust>,
    /// Parameters that are fixed or tied to others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constrained: Vec<ConstrainedParameter>,
    /// Free simulation over every run or recording.
    pub runs: Vec<SourceErrors>,
    /// What the model lacks; absent where the model diverges or has no estimate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub criticism: Option<Criticism>,
}

impl Trust {
    /// The diagnostics of `found`, which `estimator` found from `pool` with instruments from `nominal`.
    pub fn new(
        pool: &Pool,
        nominal: NominalSource,
        (estimator, replicates): (Estimator, u32),
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
            degrees: found.degrees.clone(),
            constrained: ConstrainedParameter::all(pool.vessel, Some(found)),
            runs: found.sources.clone(),
            criticism: found.criticism.clone(),
        }
    }
}
