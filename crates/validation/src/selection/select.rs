use std::collections::BTreeMap;

use estimation::pooled::{Pool, deviations};
use estimation::{Estimator, Quantiles, ScoreStatus, Share, rmse_norm};
use numerics::LANES;
use regression::pooled::{LostInstruments, Part, PooledRuns};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::RunView;

use super::{Draw, Prepared, Realization, Realizer, available};

/// Options of a selection study.
#[derive(Clone, Debug, PartialEq)]
pub struct SelectionOptions {
    /// The estimator: `ls`, `iv` or `auto`.
    pub estimator: Estimator,
    /// Number of sub-experiments of each maneuver that the design picks.
    pub counts: BTreeMap<String, u64>,
    /// Realizations per design.
    pub realizations: u32,
    /// Seed of the picks.
    pub seed: u64,
    /// Errors at which the figures of a published study end.
    pub published_limits: Option<PublishedLimits>,
}

/// Models from picked sub-experiments.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Sub-experiments per realization.
    pub picks: u64,
    /// Number of sub-experiments of each maneuver.
    pub available: BTreeMap<String, u64>,
    /// Number of sub-experiments, all of which every model is simulated over.
    pub parts: usize,
    /// Their samples.
    pub samples: u64,
    /// Standard deviations of the measured u, v, r over them.
    pub std: [f64; 3],
    /// How well the instruments follow the measured u, v, r: 100 (1 − RMSE/std) \[%\].
    pub instrument_fit: Option<[f64; 3]>,
    /// Picked by the design, and at random.
    pub designs: [SelectionScores; 2],
    /// 90 % quantile of the optimized error norm over that of the random one; `None` if either is infinite.
    pub ratio_q90: Option<f64>,
    /// The result and the failures, in words.
    pub statements: Vec<String>,
}

/// Makes the realizations of a selection study, in groups that depend only on their number.
pub struct Selector<'a> {
    pool: &'a Pool<'a>,
    options: &'a SelectionOptions,
    prepared: Prepared,
    parts: Vec<Part>,
    /// Standard deviations of the measured u, v, r over the parts.
    std: [f64; 3],
    /// By the design, and at random.
    draws: [Draw; 2],
}

impl<'a> Selector<'a> {
    /// Computes the sums of the sub-experiments of `runs`.
    ///
    /// # Errors
    /// The nominal simulation diverges.
    pub fn new(
        pool: &'a Pool<'a>,
        runs: &PooledRuns,
        options: &'a SelectionOptions,
    ) -> Result<Self, LostInstruments> {
        let prepared = Prepared::new(pool, runs, options.estimator)?;
        let parts: Vec<Part> = runs.parts(None);
        let labels: Vec<&str> = parts.iter().map(|p| p.label.as_str()).collect();
        let picks = options.counts.values().sum::<u64>() as usize;
        let draws = [
            Draw::by_design(options.seed, &labels, &options.counts),
            Draw::at_random(options.seed, parts.len(), picks),
        ];
        let std = deviations(parts.iter().map(|p| p.measured.as_slice()));
        Ok(Self { pool, options, prepared, parts, std, draws })
    }

    /// Number of groups of one design.
    fn each(&self) -> usize {
        (self.options.realizations as usize).div_ceil(LANES)
    }

    /// Number of groups: those that the design picks, then those at random.
    pub fn groups(&self) -> usize {
        self.draws.len() * self.each()
    }

    /// Number of realizations of `group`.
    pub fn realizations_of(&self, group: usize) -> usize {
        LANES.min(self.options.realizations as usize - group % self.each() * LANES)
    }

    /// The realizations of `group`.
    pub fn group(&self, group: usize) -> Vec<Realization> {
        let Self { pool, prepared, std, .. } = self;
        let parts: Vec<RunView> = self.parts.iter().map(Part::view).collect();
        let estimator = self.options.estimator;
        let realizer = Realizer { pool, estimator, prepared, parts: &parts, std: *std };
        let first = group % self.each() * LANES;
        realizer.chunk(&self.draws[group / self.each()], first as u32, self.realizations_of(group))
    }

    /// The result of `realizations`, those of all groups in order.
    pub fn found(&self, realizations: &[Realization]) -> Selection {
        let [optimized, random] = &self.draws;
        let (first, others) =
            realizations.split_at(realizations.partition_point(|r| r.design == optimized.design));
        let of =
            |draw: &Draw, scores| SelectionScores::new(draw.design, scores, self.options.published_limits);
        let designs = [of(optimized, first), of(random, others)];
        let mut statements = vec![conclusion(&designs)];
        statements.extend(self.prepared.warnings.clone());
        Selection {
            picks: self.options.counts.values().sum(),
            available: available(&self.parts),
            parts: self.parts.len(),
            samples: self.parts.iter().map(|p| p.samples() as u64).sum(),
            std: self.std,
            instrument_fit: self.prepared.instrument_fit,
            ratio_q90: q90(&designs[0]).zip(q90(&designs[1])).map(|(optimized, random)| optimized / random),
            designs,
            statements,
        }
    }
}

fn q90(scores: &SelectionScores) -> Option<f64> {
    scores.overlapping.error_norm.q90
}

fn conclusion([optimized, random]: &[SelectionScores; 2]) -> String {
    let text = |scores: &SelectionScores| q90(scores).map_or("infinite".to_owned(), |q| format!("{q:.2}"));
    let share = |scores: &SelectionScores| 100.0 * scores.degenerate_share;
    format!(
        "90 % quantile of the error norm: optimized {}, random {}; degenerate: optimized {:.1} %, random {:.1} %",
        text(optimized),
        text(random),
        share(optimized),
        share(random)
    )
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
type Errors = fn(&Realization) -> (Option<[f64; 3]>, Option<f64>);

impl SelectionErrors {
    fn of(all: &[Realization], errors: Errors) -> Self {
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
            Share::of(
                all.iter().filter(|r| r.rmse.is_none_or(|rmse| error(rmse) >= limit)).count(),
                all.len(),
            )
        };
        Self {
            norm: share(limits.rmse_norm, &rmse_norm),
            surge: share(limits.rmse_u, &|rmse| rmse[0]),
            sway: share(limits.rmse_v, &|rmse| rmse[1]),
            yaw: share(limits.rmse_r, &|rmse| rmse[2]),
        }
    }
}
