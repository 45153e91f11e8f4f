//! Statistics of many scores, as counts and exact sums: they do not depend on the order or grouping of merges, and
//! their memory does not grow with the number of runs.

mod histogram;

use estimation::{Estimator, RunScore, ScoreStatus};
use numerics::statistics::wilson;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use histogram::{Histogram, QUANTILE_ERROR};

/// Fractions of 1 that numbers are rounded to before they are added: 2⁴⁰.
const FRACTIONS: f64 = (1_u64 << 40) as f64;
/// Larger numbers are not added: 2³⁴ of them fit.
const MOST: f64 = (1_u64 << 53) as f64;

/// A sum of numbers, each rounded to a multiple of 2⁻⁴⁰: whole numbers are added, so any order gives the same. Written as that
/// whole number, in decimal digits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(with = "String", extend("pattern" = "^-?[0-9]+$"))]
pub struct ExactSum(i128);

impl ExactSum {
    /// Adds `number`, unless it is too large or NaN; returns whether it did.
    pub fn add(&mut self, number: f64) -> bool {
        let fits = number.abs() <= MOST;
        if fits {
            self.0 = self.0.saturating_add(whole(number * FRACTIONS));
        }
        fits
    }

    /// Adds another sum.
    pub fn merge(&mut self, other: Self) {
        self.0 = self.0.saturating_add(other.0);
    }

    /// The sum.
    pub fn value(self) -> f64 {
        self.0 as f64 / FRACTIONS
    }
}

/// `number` rounded, a half away from zero. Most numbers fit 64 bits, which is faster.
fn whole(number: f64) -> i128 {
    if number.abs() >= (1_u64 << 52) as f64 {
        return number.round() as i128;
    }
    let below = number as i64;
    let rest = number - below as f64;
    i128::from(below + i64::from(rest >= 0.5) - i64::from(rest <= -0.5))
}

impl TryFrom<String> for ExactSum {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse().map(Self).map_err(|_| format!("`{text}` is no whole number"))
    }
}

impl From<ExactSum> for String {
    fn from(sum: ExactSum) -> Self {
        sum.0.to_string()
    }
}

/// Bounds under which an estimate counts as good.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// On the parameter error: the 2-norm over the parameters of (θ̂ − θ)/θ, of θ̂ itself where θ is 0.
    pub parameter_error: f64,
    /// On the simulation error: the 2-norm of the RMSE in surge, sway and yaw.
    pub simulation_error: f64,
}

/// The errors of one kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Errors {
    /// Their histogram.
    pub histogram: Histogram,
    /// Their sum, in multiples of 2^-40.
    pub sum: ExactSum,
    /// How many are not in the sum: infinite, or too large for it.
    pub not_in_sum: u64,
}

/// What became of the runs of one design by one estimator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Counted {
    /// The design.
    pub design: String,
    /// The estimator.
    pub estimator: Estimator,
    /// Runs.
    pub runs: u64,
    /// Runs without an estimate: a direction was not excited.
    pub not_identifiable: u64,
    /// Runs without an estimate: a search ended nowhere.
    pub not_converged: u64,
    /// Runs whose model diverged.
    pub diverged: u64,
    /// Runs whose parameter error lies below its bound.
    pub parameter_errors_below: u64,
    /// Runs whose simulation error lies below its bound.
    pub simulation_errors_below: u64,
    /// Parameter errors.
    pub parameter_error: Errors,
    /// Simulation errors.
    pub simulation_error: Errors,
    /// RMSE in surge.
    pub rmse_u: Errors,
    /// RMSE in sway.
    pub rmse_v: Errors,
    /// RMSE in yaw rate.
    pub rmse_r: Errors,
}

/// Two estimators on the same runs of one design.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairCounts {
    /// The design.
    pub design: String,
    /// The one.
    pub one: Estimator,
    /// The other.
    pub other: Estimator,
    /// Runs whose parameter error lies below its bound by the one alone.
    pub only_one_below: u64,
    /// Runs whose parameter error lies below its bound by the other alone.
    pub only_other_below: u64,
    /// Parameter error of the other over that of the one, run by run; 1 where neither has one.
    pub ratio: Histogram,
}

/// What all runs say together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tally {
    /// Design by design, by every estimator.
    pub counted: Vec<Counted>,
    /// Design by design, every estimator after the first against those before it.
    pub pairs: Vec<PairCounts>,
}

impl Errors {
    fn add(&mut self, error: Option<f64>) {
        self.histogram.add(error);
        self.not_in_sum += u64::from(!error.is_some_and(|error| self.sum.add(error)));
    }

    fn merge(&mut self, other: &Self) {
        self.histogram.merge(&other.histogram);
        self.sum.merge(other.sum);
        self.not_in_sum += other.not_in_sum;
    }

    /// Their mean; `None` without errors, or if one is not in the sum.
    pub fn mean(&self) -> Option<f64> {
        let count = self.histogram.count();
        (count > 0 && self.not_in_sum == 0).then(|| self.sum.value() / count as f64)
    }
}

impl Counted {
    fn new(design: &str, estimator: Estimator) -> Self {
        Self {
            design: design.to_owned(),
            estimator,
            runs: 0,
            not_identifiable: 0,
            not_converged: 0,
            diverged: 0,
            parameter_errors_below: 0,
            simulation_errors_below: 0,
            parameter_error: Errors::default(),
            simulation_error: Errors::default(),
            rmse_u: Errors::default(),
            rmse_v: Errors::default(),
            rmse_r: Errors::default(),
        }
    }

    fn errors(&mut self) -> [&mut Errors; 5] {
        let Self { parameter_error, simulation_error, rmse_u, rmse_v, rmse_r, .. } = self;
        [parameter_error, simulation_error, rmse_u, rmse_v, rmse_r]
    }

    fn counts(&mut self) -> [&mut u64; 6] {
        let Self { runs, not_identifiable, not_converged, diverged, .. } = self;
        let (parameter, simulation) = (&mut self.parameter_errors_below, &mut self.simulation_errors_below);
        [runs, not_identifiable, not_converged, diverged, parameter, simulation]
    }

    fn add(&mut self, score: &RunScore, bounds: Bounds) {
        let [u, v, r] = score.rmse;
        let errors = [score.parameter_error, score.simulation_error, u, v, r];
        self.errors().into_iter().zip(errors).for_each(|(known, error)| known.add(error));
        let counts = [
            true,
            score.status == ScoreStatus::NotIdentifiable,
            score.status == ScoreStatus::NotConverged,
            score.status == ScoreStatus::Diverged,
            is_below(score.parameter_error, bounds.parameter_error),
            is_below(score.simulation_error, bounds.simulation_error),
        ];
        self.counts().into_iter().zip(counts).for_each(|(count, is)| *count += u64::from(is));
    }

    fn merge(&mut self, other: &mut Self) {
        self.errors().into_iter().zip(other.errors()).for_each(|(mine, other)| mine.merge(other));
        self.counts().into_iter().zip(other.counts()).for_each(|(mine, other)| *mine += *other);
    }

    /// Half the width of the wider of the two shares' 95 % intervals; 1 without runs.
    fn half_width(&self) -> f64 {
        let half = |count| wilson(count, self.runs).map_or(1.0, |[low, high]| 0.5 * (high - low));
        half(self.parameter_errors_below).max(half(self.simulation_errors_below))
    }
}

impl PairCounts {
    fn add(&mut self, one: &RunScore, other: &RunScore, bound: f64) {
        let [a, b] = [one, other].map(|score| is_below(score.parameter_error, bound));
        self.only_one_below += u64::from(a && !b);
        self.only_other_below += u64::from(b && !a);
        self.ratio.add(match (one.parameter_error, other.parameter_error) {
            (Some(one), Some(other)) if one == other => Some(1.0),
            (Some(one), Some(other)) => Some(other / one),
            (None, Some(_)) => Some(0.0),
            (Some(_), None) => None,
            (None, None) => Some(1.0),
        });
    }

    fn merge(&mut self, other: &Self) {
        self.only_one_below += other.only_one_below;
        self.only_other_below += other.only_other_below;
        self.ratio.merge(&other.ratio);
    }
}

fn is_below(error: Option<f64>, bound: f64) -> bool {
    error.is_some_and(|error| error < bound)
}

impl Tally {
    /// An empty tally.
    pub fn new(designs: &[&str], estimators: &[Estimator]) -> Self {
        let of = |design: &&str| estimators.iter().map(|e| Counted::new(design, *e)).collect::<Vec<_>>();
        let pair = |design: &str, other: usize, one: usize| PairCounts {
            design: design.to_owned(),
            one: estimators[one],
            other: estimators[other],
            only_one_below: 0,
            only_other_below: 0,
            ratio: Histogram::default(),
        };
        let pairs = designs.iter().flat_map(|design| {
            (0..estimators.len()).flat_map(move |other| (0..other).map(move |one| (*design, other, one)))
        });
        Self {
            counted: designs.iter().flat_map(of).collect(),
            pairs: pairs.map(|(design, other, one)| pair(design, other, one)).collect(),
        }
    }

    /// Counts `scores`: of whole runs, each by all estimators in their order.
    pub fn add(&mut self, scores: &[RunScore], bounds: Bounds) {
        let estimators = self.estimators();
        let pairs = estimators * (estimators - 1) / 2;
        for run in scores.chunks_exact(estimators) {
            let known = self.counted.iter().position(|counted| counted.design == run[0].design);
            let Some(design) = known.map(|first| first / estimators) else { continue };
            let counted = &mut self.counted[design * estimators..][..estimators];
            counted.iter_mut().zip(run).for_each(|(counted, score)| counted.add(score, bounds));
            let of_pairs = (0..estimators).flat_map(|other| (0..other).map(move |one| (one, other)));
            let pairs = &mut self.pairs[design * pairs..][..pairs];
            pairs.iter_mut().zip(of_pairs).for_each(|(pair, (one, other))| {
                pair.add(&run[one], &run[other], bounds.parameter_error);
            });
        }
    }

    /// Number of estimators of each design.
    fn estimators(&self) -> usize {
        let of_first = |counted: &&Counted| counted.design == self.counted[0].design;
        self.counted.iter().take_while(of_first).count().max(1)
    }

    /// Adds the counts of `other`; false if its designs or estimators differ.
    pub fn merge(&mut self, mut other: Self) -> bool {
        let key = |c: &Counted| (c.design.clone(), c.estimator);
        let same = self.counted.iter().map(key).eq(other.counted.iter().map(key))
            && self.pairs.len() == other.pairs.len();
        if same {
            self.counted.iter_mut().zip(&mut other.counted).for_each(|(mine, other)| mine.merge(other));
            self.pairs.iter_mut().zip(&other.pairs).for_each(|(mine, other)| mine.merge(other));
        }
        same
    }

    /// Half the width of the widest 95 % interval of all shares.
    pub fn half_width(&self) -> f64 {
        self.counted.iter().map(Counted::half_width).fold(0.0, f64::max)
    }
}
