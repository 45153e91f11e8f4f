use std::collections::BTreeMap;

use files::{Document, Units};
use regression::MeanRemoval;
use regression::pooled::NominalSource;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use estimation::Estimator;
use validation::selection::{PublishedLimits, SelectionScores};

/// `selection.json`: models from sub-experiments picked by a design, against random picks of the same number.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SelectionDocument {
    /// The estimator.
    pub estimator: Estimator,
    /// How the instruments' mean is removed.
    pub mean_removal: MeanRemoval,
    /// Where the instruments' nominal model comes from; `least-squares` is the fit of all sub-experiments.
    pub nominal: NominalSource,
    /// Strength of the pull towards it.
    pub prior: f64,
    /// Whether the estimated intercepts were simulated too.
    pub intercepts: bool,
    /// Sub-experiments per realization.
    pub picks: u64,
    /// Seed of the picks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Of each maneuver in the optimized selection.
    pub counts: BTreeMap<String, u64>,
    /// Sub-experiments there are of each maneuver.
    pub available: BTreeMap<String, u64>,
    /// Number of sub-experiments, all of which every model is simulated over.
    pub parts: u64,
    /// Their samples.
    pub samples: u64,
    /// Standard deviations of the measured states over them.
    pub std_u: f64,
    /// Of sway speed.
    pub std_v: f64,
    /// Of yaw rate.
    pub std_r: f64,
    /// Norm of RMSE/std from which a model counts as degenerate; √3 is as bad as the mean of the data.
    pub degenerate_from: f64,
    /// Errors at which the figures of a published study end; absent where there is none to compare with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published_limits: Option<PublishedLimits>,
    /// 90 % quantile of the optimized error norm over that of the random one; null where either is infinite.
    pub ratio_q90: Option<f64>,
    /// The result, and what went wrong, in words.
    pub statements: Vec<String>,
    /// How well the instruments follow the measured u, v, r over the sub-experiments: 100 (1 − RMSE/std).
    pub instrument_fit: Option<[f64; 3]>,
    /// `optimized` and `random`.
    pub designs: Vec<SelectionScores>,
}

impl Document for SelectionDocument {
    const ID: &'static str = "selection";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("1", "prior picks counts available parts samples degenerate_from ratio_q90 realizations"),
        ("1", "not_identifiable diverged degenerate_share degenerate_share_interval share interval"),
        ("1", "seed error_norm"),
        ("m/s", "std_u std_v rmse_u rmse_v"),
        ("rad/s", "std_r rmse_r"),
        ("%", "instrument_fit"),
        ("m/s, m/s and rad/s as numbers", "rmse_norm"),
    ];
}
