use std::collections::BTreeMap;

use estimation::Estimator;
use estimation::pooled::{Pool, deviations};
use numerics::LANES;
use regression::pooled::{LostInstruments, Part, PooledRuns};
use ship::engine::RunView;

use super::counts::available;
use super::draw::Draw;
use super::prepared::Prepared;
use super::realize::{Realization, Realizer};
use super::scores::{PublishedLimits, SelectionScores};

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
        let (own, others) =
            realizations.split_at(realizations.partition_point(|r| r.design == optimized.design));
        let of = |draw: &Draw, own| SelectionScores::new(draw.design, own, self.options.published_limits);
        let designs = [of(optimized, own), of(random, others)];
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
