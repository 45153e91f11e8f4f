use estimation::{Quantiles, ScoreStatus, Share, rmse_norm};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One realization: the picked parts, and the score of its model.
#[derive(Clone, Debug, PartialEq)]
pub struct Realization {
    /// `optimized` or `random`.
    pub design: String,
    /// Its number.
    pub number: i32,
    /// Indices of the parts, ascending: `3 17 40`.
    pub picked: String,
    /// The status of its model over all parts.
    pub status: ScoreStatus,
    /// Free simulation over all parts: RMSE of u, v, r; absent without a model and if it diverged.
    pub rmse: Option<[f64; 3]>,
    /// Norm of RMSE/std.
    pub error_norm: Option<f64>,
    /// RMSE over the parts that were not picked.
    pub left_out_rmse: Option<[f64; 3]>,
    /// Norm of RMSE/std over them.
    pub left_out_norm: Option<f64>,
}

/// Norm of RMSE/std, √3, from which a model is degenerate: no better than the mean of the data.
pub const DEGENERATE: f64 = 1.732_050_807_568_877_2;

/// The realizations of one design. One without model, or whose simulation diverged, counts as infinite (null).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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

/// Quantiles over the realizations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
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

impl SelectionScores {
    /// Statistics of the `realizations` of one design.
    pub(super) fn new(design: &str, realizations: &[Realization], limits: Option<PublishedLimits>) -> Self {
        let with = |status: ScoreStatus| realizations.iter().filter(|r| r.status == status).count();
        let degenerate = |r: &&Realization| r.error_norm.is_none_or(|norm| norm >= DEGENERATE);
        let degenerate = Share::of(realizations.iter().filter(degenerate).count(), realizations.len());
        Self {
            design: design.to_owned(),
            realizations: realizations.len() as u64,
            not_identifiable: with(ScoreStatus::NotIdentifiable) as u64,
            diverged: with(ScoreStatus::Diverged) as u64,
            degenerate_share: degenerate.share,
            degenerate_share_interval: degenerate.interval,
            beyond_published: limits.map(|limits| SharesBeyond::of(realizations, limits)),
            overlapping: SelectionErrors::of(realizations, |r| (r.rmse, r.error_norm)),
            left_out: SelectionErrors::of(realizations, |r| (r.left_out_rmse, r.left_out_norm)),
        }
    }
}

/// RMSE and norm of RMSE/std of a realization.
type ErrorsOf = fn(&Realization) -> (Option<[f64; 3]>, Option<f64>);

impl SelectionErrors {
    fn of(all: &[Realization], errors: ErrorsOf) -> Self {
        let state = |d: usize| Quantiles::of(all.iter().map(|r| errors(r).0.map(|rmse| rmse[d])));
        Self {
            error_norm: Quantiles::of(all.iter().map(|r| errors(r).1)),
            rmse_norm: Quantiles::of(all.iter().map(|r| errors(r).0.map(rmse_norm))),
            rmse_u: state(0),
            rmse_v: state(1),
            rmse_r: state(2),
        }
    }
}

impl SharesBeyond {
    fn of(all: &[Realization], limits: PublishedLimits) -> Self {
        let share = |limit: f64, error: &dyn Fn([f64; 3]) -> f64| {
            Share::of(all.iter().filter(|r| r.rmse.is_none_or(|e| error(e) >= limit)).count(), all.len())
        };
        Self {
            norm: share(limits.rmse_norm, &rmse_norm),
            surge: share(limits.rmse_u, &|rmse| rmse[0]),
            sway: share(limits.rmse_v, &|rmse| rmse[1]),
            yaw: share(limits.rmse_r, &|rmse| rmse[2]),
        }
    }
}
