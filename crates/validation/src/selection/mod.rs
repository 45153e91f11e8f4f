//! Models from sub-experiments that a design picked, against random picks of the same number.

mod scores;

use std::collections::BTreeMap;

use estimation::pooled::{InstrumentFit, NoEstimate, Pool, Score, deviations};
use estimation::{Estimator, ScoreStatus, free_runs};
use numerics::LANES;
use numerics::lanes::interleave;
use refusal::listed;
use regression::pooled::{
    Centring, LostInstruments, Options, Part, PooledRuns, PooledSums, Solution, Strength, fit, joined,
};
use regression::{MeanRemoval, Sums};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::Streams;

pub use scores::{DEGENERATE, PublishedLimits, Realization, SelectionErrors, SelectionScores, SharesBeyond};

/// The number of `parts` of each maneuver.
pub fn available(parts: &[Part]) -> BTreeMap<String, u64> {
    let mut available = BTreeMap::new();
    parts.iter().for_each(|part| *available.entry(part.label.clone()).or_insert(0) += 1);
    available
}

/// The random draw of a realization.
struct Draw {
    /// `optimized` or `random`.
    design: &'static str,
    streams: Streams,
    /// Per picked maneuver: its parts, and the number to pick.
    groups: Vec<(Vec<usize>, usize)>,
}

impl Draw {
    /// Picks `counts` parts of each maneuver, from parts with these `labels`.
    fn by_design(seed: u64, labels: &[&str], counts: &BTreeMap<String, u64>) -> Self {
        let group = |(name, count): (&String, &u64)| {
            let places = (0..labels.len()).filter(|i| labels[*i] == name).collect();
            (places, *count as usize)
        };
        Self::new(seed, "optimized", counts.iter().map(group).collect())
    }

    /// Picks `picks` of all `parts`.
    fn at_random(seed: u64, parts: usize, picks: usize) -> Self {
        Self::new(seed, "random", vec![((0..parts).collect(), picks)])
    }

    fn new(seed: u64, design: &'static str, groups: Vec<(Vec<usize>, usize)>) -> Self {
        Self { design, streams: Streams::new(seed, &format!("selection {design}")), groups }
    }

    /// The parts of a realization, ascending, none twice. Depends on the seed and the realization's number alone.
    fn realization(&self, number: u32) -> Vec<usize> {
        let mut picked = Vec::new();
        for (channel, (parts, count)) in self.groups.iter().enumerate() {
            let mut rest = parts.clone();
            for pick in 0..(*count).min(parts.len()) {
                let channel = (channel << 16 | pick) as u32;
                let place = self.streams.choices(number, channel, rest.len() as u32, 1)[0];
                picked.push(rest.swap_remove(place as usize));
            }
        }
        picked.sort_unstable();
        picked
    }
}

/// Instruments are poor below this fit of a state: the nominal simulation explains less than half of its deviations.
const POOR: f64 = 50.0;

/// Sums per part, and the fit of their instruments.
struct Prepared {
    /// With the regressors as instruments.
    pub ls: Vec<Sums>,
    /// With simulated instruments.
    pub iv: Option<Vec<Sums>>,
    /// Nominal parameters for a prior.
    pub nominal: Option<Vec<f64>>,
    pub instrument_fit: Option<[f64; 3]>,
    pub warnings: Vec<String>,
}

impl Prepared {
    fn new(pool: &Pool, runs: &PooledRuns, estimator: Estimator) -> Result<Self, LostInstruments> {
        let segments = runs.segments(pool.part_samples);
        let counts: Vec<usize> = segments.iter().map(Vec::len).collect();
        let parts: Vec<Part> = segments.into_iter().flatten().collect();
        let ls = merged(&sums(pool, &parts, None)?.1, &counts);
        let nominal = pool.nominal.parameters(&PooledSums::of(&ls, pool.removal));
        let theta = nominal.as_ref().map(|(theta, _)| theta.clone());
        let mut prepared = Self { ls, iv: None, nominal: theta, instrument_fit: None, warnings: Vec::new() };
        let (false, Some((theta, c))) = (estimator == Estimator::Ls, &nominal) else { return Ok(prepared) };
        let model = pool.model.layout().woven(theta, *c);
        match sums(pool, &parts, Some(&model)) {
            Ok((pooled, pools)) => {
                prepared.warn(pool, &parts, &model, &pooled.centring());
                prepared.iv = Some(merged(&pools, &counts));
            }
            Err(lost) if estimator == Estimator::Auto => prepared.warnings.push(lost.to_string()),
            Err(lost) => return Err(lost),
        }
        Ok(prepared)
    }

    /// Checks how well instruments simulated with `model` follow the data, and warns if they do not.
    fn warn(&mut self, pool: &Pool, parts: &[Part], model: &[f64], centring: &Centring) {
        let mut fit = InstrumentFit::of(parts.iter().map(|part| part.measured.as_slice()));
        let mut strengths: [Strength; 3] = Default::default();
        for (i, part) in parts.iter().enumerate() {
            // Parts that diverge were refused before.
            let Ok((regression, states)) = pool.regression(&part.whole(), Some(model)) else { continue };
            fit.add(&states, &part.measured);
            for (d, (strength, degree)) in strengths.iter_mut().zip(&regression.degrees).enumerate() {
                strength.add(i, degree, centring, d);
            }
        }
        self.instrument_fit = fit.found();
        self.warnings.extend(self.instrument_fit.and_then(|fits| poor(fits, weakest(pool, strengths))));
    }
}

/// The sums of all `parts`, and of each.
fn sums(
    pool: &Pool,
    parts: &Vec<Part>,
    simulated: Option<&[f64]>,
) -> Result<(PooledSums, Vec<Sums>), LostInstruments> {
    let mut pools = Vec::with_capacity(parts.len());
    match pool.sums(parts, simulated, |_, sums| pools.push(sums.clone())) {
        Ok(pooled) => Ok((pooled, pools)),
        Err(NoEstimate::Lost(lost)) => Err(lost),
    }
}

/// Adds the sums of the parts that a segment was cut into, `counts` each; instruments restart with every part.
fn merged(parts: &[Sums], counts: &[usize]) -> Vec<Sums> {
    let mut rest = parts;
    let mut merged = |count: &usize| {
        let pool;
        (pool, rest) = rest.split_at(*count);
        Sums::total(pool)
    };
    counts.iter().map(&mut merged).collect()
}

/// The term that its instrument explains least, with Shea's partial R².
fn weakest(pool: &Pool, strengths: [Strength; 3]) -> Option<(String, f64)> {
    let degree = |(d, strength): (usize, Strength)| {
        let terms = pool.vessel.model.degrees[d].terms.iter().map(|t| t.text.clone());
        terms.zip(strength.partial().unwrap_or_default()).collect::<Vec<_>>()
    };
    strengths.into_iter().enumerate().flat_map(degree).min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The warning that the instruments do not follow the motion.
fn poor(fits: [f64; 3], weakest: Option<(String, f64)>) -> Option<String> {
    let lost = ["u", "v", "r"].into_iter().zip(fits).filter(|(_, fit)| *fit < POOR);
    let lost: Vec<String> = lost.map(|(name, fit)| format!("{name} to {fit:.0} %")).collect();
    let explained = weakest.map_or(String::new(), |(term, share)| {
        format!(" and tells {:.1} % of `{term}` (partial R²)", 100.0 * share)
    });
    (!lost.is_empty()).then(|| {
        format!(
            "poor instruments: simulated from the first state of each part the nominal model follows {} only{explained}; \
             estimates divide by what instruments tell, so that those from few parts are free to diverge: improve the \
             structure, or use --estimator ls",
            listed(&lost)
        )
    })
}

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

/// Models from sub-experiments picked by a design, against random picks of the same number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Selection {
    /// The estimator.
    pub estimator: Estimator,
    /// How the instruments' mean is removed.
    pub mean_removal: MeanRemoval,
    /// Sub-experiments per realization.
    pub picks: u64,
    /// Seed of the picks.
    pub seed: u64,
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
        let first = group % self.each() * LANES;
        self.chunk(&self.draws[group / self.each()], first as u32, self.realizations_of(group))
    }

    /// The result of `realizations`, those of all groups in order.
    pub fn found(&self, draws: &[Realization]) -> Selection {
        let [optimized, random] = &self.draws;
        let (first, others) = draws.split_at(draws.partition_point(|r| r.design == optimized.design));
        let of = |draw: &Draw, all| SelectionScores::new(draw.design, all, self.options.published_limits);
        let designs = [of(optimized, first), of(random, others)];
        let mut statements = vec![conclusion(&designs)];
        statements.extend(self.prepared.warnings.clone());
        let [std_u, std_v, std_r] = self.std;
        Selection {
            estimator: self.options.estimator,
            mean_removal: self.pool.removal,
            picks: self.options.counts.values().sum(),
            seed: self.options.seed,
            counts: self.options.counts.clone(),
            available: available(&self.parts),
            parts: self.parts.len() as u64,
            samples: self.parts.iter().map(|p| p.samples() as u64).sum(),
            std_u,
            std_v,
            std_r,
            degenerate_from: DEGENERATE,
            published_limits: self.options.published_limits,
            instrument_fit: self.prepared.instrument_fit,
            ratio_q90: q90(&designs[0]).zip(q90(&designs[1])).map(|(optimized, random)| optimized / random),
            designs: designs.to_vec(),
            statements,
        }
    }

    /// Up to [`numerics::LANES`] realizations, from `first` on.
    fn chunk(&self, draw: &Draw, first: u32, count: usize) -> Vec<Realization> {
        let picked: Vec<Vec<usize>> = (0..count as u32).map(|i| draw.realization(first + i)).collect();
        let models: Vec<Option<Vec<f64>>> = picked.iter().map(|draw| self.model(draw)).collect();
        let scores = self.scores(&picked, &models);
        let realization = |i: usize| {
            let score = |which: usize| models[i].as_ref().map(|_| &scores[i][which]);
            let [rmse, left_out_rmse] = [0, 1].map(|which| score(which).and_then(Score::rmse));
            let [error_norm, left_out_norm] =
                [0, 1].map(|which| score(which).and_then(|score| score.norm(self.std)));
            Realization {
                design: draw.design.to_owned(),
                number: (first as usize + i) as i32,
                picked: picked[i].iter().map(usize::to_string).collect::<Vec<_>>().join(" "),
                status: match (&models[i], rmse) {
                    (None, _) => ScoreStatus::NotIdentifiable,
                    (Some(_), None) => ScoreStatus::Diverged,
                    (Some(_), Some(_)) => ScoreStatus::Scored,
                },
                rmse,
                error_norm,
                left_out_rmse,
                left_out_norm,
            }
        };
        (0..count).map(realization).collect()
    }

    /// Scores of the models, in lanes, over all parts and over those not `picked`.
    fn scores(&self, picked: &[Vec<usize>], models: &[Option<Vec<f64>>]) -> Vec<[Score; 2]> {
        let zero = vec![0.0; self.pool.model.parameters()];
        let lanes = interleave(&models.iter().map(|m| m.as_deref().unwrap_or(&zero)).collect::<Vec<_>>());
        let mut scores = vec![[Score::default(); 2]; picked.len()];
        for (place, part) in self.parts.iter().map(Part::view).enumerate() {
            let errors = free_runs(&self.pool.model, &lanes, part.exogenous, part.measured);
            for (lane, draw) in picked.iter().enumerate() {
                scores[lane][0].add(errors[lane], part.samples());
                if draw.binary_search(&place).is_err() {
                    scores[lane][1].add(errors[lane], part.samples());
                }
            }
        }
        scores
    }

    /// The parameters of the model from parts `picked`, intercepts among them.
    fn model(&self, picked: &[usize]) -> Option<Vec<f64>> {
        let (theta, intercepts) = joined(self.solutions(picked).each_ref().map(Option::as_ref))?;
        Some(self.pool.model.layout().woven(&theta, intercepts))
    }

    /// Collinear picks are estimated too (by `auto` with least squares): the study shows the errors.
    fn solutions(&self, picked: &[usize]) -> [Option<Solution>; 3] {
        let Prepared { ls, iv, nominal, .. } = &self.prepared;
        let fitted = |sums: &[Sums], options: Options| {
            let chosen: Vec<&Sums> = picked.iter().map(|i| &sums[*i]).collect();
            fit(&chosen, &options).map(|degree| degree.solution)
        };
        let options = |used: Estimator| self.pool.options(nominal.as_deref(), used);
        match (self.options.estimator, iv) {
            (Estimator::Ls, _) | (_, None) => fitted(ls, options(Estimator::Ls)),
            (Estimator::Auto, Some(iv)) => {
                let mut solutions = fitted(iv, options(Estimator::Iv));
                if solutions.iter().any(Option::is_none) {
                    for (solution, least) in solutions.iter_mut().zip(fitted(ls, options(Estimator::Ls))) {
                        *solution = solution.take().or(least);
                    }
                }
                solutions
            }
            (_, Some(iv)) => fitted(iv, Options { most: f64::INFINITY, ..options(Estimator::Iv) }),
        }
    }
}

fn q90(scores: &SelectionScores) -> Option<f64> {
    scores.overlapping.error_norm.q90
}

fn conclusion([optimized, random]: &[SelectionScores; 2]) -> String {
    let text = |scores: &SelectionScores| q90(scores).map_or("infinite".to_owned(), |q| format!("{q:.2}"));
    let [norm, random_norm] = [optimized, random].map(text);
    let [share, random_share] = [optimized, random].map(|scores| 100.0 * scores.degenerate_share);
    format!(
        "90 % quantile of the error norm: optimized {norm}, random {random_norm}; \
         degenerate: optimized {share:.1} %, random {random_share:.1} %"
    )
}
