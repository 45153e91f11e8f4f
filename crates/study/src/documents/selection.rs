use std::collections::BTreeMap;

use artifact::Document;
use numerics::statistics::wilson;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use identification::pooled::NominalSource;
use identification::{Estimator, MeanRemoval};

use super::Quantiles;

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

/// The realizations of one design. One without model, or whose simulation diverged, counts as infinite (null).
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SelectionScores {
    /// `optimized` or `random`.
    pub design: String,
    /// Number of realizations.
    pub realizations: u64,
    /// Realizations without model.
    pub not_identifiable: u64,
    /// Realizations whose simulation diverged.
    pub diverged: u64,
    /// Share of the realizations that are degenerate.
    pub degenerate_share: f64,
    /// 95 % interval of that share (Wilson's); absent without realizations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degenerate_share_interval: Option<[f64; 2]>,
    /// Shares of the realizations at or above `published_limits`, over all sub-experiments; one without model, or whose
    /// simulation diverged, is above all of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beyond_published: Option<SharesBeyond>,
    /// Over all sub-experiments, those picked included: the paper's protocol.
    pub overlapping: SelectionErrors,
    /// Over those that were not picked.
    pub left_out: SelectionErrors,
}

/// Errors at which the figures of a published study end.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedLimits {
    /// Norm of the RMSE as numbers.
    pub rmse_norm: f64,
    /// RMSE in surge.
    pub rmse_u: f64,
    /// RMSE in sway.
    pub rmse_v: f64,
    /// RMSE in yaw rate.
    pub rmse_r: f64,
}

/// Shares of the realizations that are at or above [`PublishedLimits`].
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SharesBeyond {
    /// By the norm of the RMSE as numbers.
    pub norm: Share,
    /// In surge.
    pub surge: Share,
    /// In sway.
    pub sway: Share,
    /// In yaw rate.
    pub yaw: Share,
}

/// A share of realizations.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Share {
    /// The share.
    pub share: f64,
    /// Its 95 % interval (Wilson's); null without realizations.
    pub interval: Option<[f64; 2]>,
}

impl Share {
    /// `count` of `total`.
    pub fn of(count: usize, total: usize) -> Self {
        Self { share: count as f64 / total.max(1) as f64, interval: wilson(count as u64, total as u64) }
    }
}

/// Quantiles over the realizations.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SelectionErrors {
    /// Norm of RMSE/std.
    pub error_norm: Quantiles,
    /// Norm of the RMSE as numbers: the paper's.
    pub rmse_norm: Quantiles,
    /// Of surge speed.
    pub rmse_u: Quantiles,
    /// Of sway speed.
    pub rmse_v: Quantiles,
    /// Of yaw rate.
    pub rmse_r: Quantiles,
}

impl Document for SelectionDocument {
    const ID: &'static str = "selection";
    const VERSION: u32 = 1;
    const UNITS: &'static [(&'static str, &'static str)] = &[
        ("prior", "1"),
        ("picks", "1"),
        ("counts", "1"),
        ("available", "1"),
        ("parts", "1"),
        ("samples", "1"),
        ("std_u", "m/s"),
        ("std_v", "m/s"),
        ("std_r", "rad/s"),
        ("degenerate_from", "1"),
        ("ratio_q90", "1"),
        ("instrument_fit", "%"),
        ("realizations", "1"),
        ("not_identifiable", "1"),
        ("diverged", "1"),
        ("degenerate_share", "1"),
        ("degenerate_share_interval", "1"),
        ("share", "1"),
        ("interval", "1"),
        ("seed", "1"),
        ("error_norm", "1"),
        ("rmse_norm", "m/s, m/s and rad/s as numbers"),
        ("rmse_u", "m/s"),
        ("rmse_v", "m/s"),
        ("rmse_r", "rad/s"),
    ];
}
