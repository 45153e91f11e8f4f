//! Which of several estimators to use, from their errors on the same runs.

use numerics::statistics::{mean, paired_median, quantile, quantile_interval, sorted, spread, wilson};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Estimator;

/// An estimator that leaves a larger share of the runs without an estimate is not recommended.
pub const MOST_WITHOUT_ESTIMATE: f64 = 0.01;

/// An estimator on the runs of one design.
#[derive(Clone, Debug)]
pub struct Contender {
    /// Which.
    pub estimator: Estimator,
    /// Its errors, in the same order of runs for all contenders; `None` without an error.
    pub errors: Vec<Option<f64>>,
    /// Runs without an estimate.
    pub without_estimate: usize,
}

/// The recommendation from the runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Recommendation {
    /// The estimator of least median error among those that estimate nearly every run.
    pub least: Estimator,
    /// Its median error.
    pub median: f64,
    /// The others among those.
    pub others: Vec<Other>,
}

/// An estimator compared with that of least median error.
#[derive(Clone, Debug, PartialEq)]
pub struct Other {
    /// Which.
    pub estimator: Estimator,
    /// Median over the runs of its error less that of the least.
    pub difference: f64,
    /// 95 % interval of that median; infinite where there are too few runs for an end.
    pub interval: [f64; 2],
}

impl Recommendation {
    /// Compares the contenders run by run; `None` if each leaves too many runs without an estimate.
    pub fn new(contenders: &[Contender]) -> Option<Self> {
        let median = |c: &&Contender| quantile(&sorted(c.errors.iter().copied()), 0.5);
        let admitted: Vec<(&Contender, f64)> =
            contenders.iter().filter(|c| c.admitted()).filter_map(|c| Some((c, median(&c)?))).collect();
        let &(least, median) = admitted.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let others = admitted.iter().filter(|(c, _)| c.estimator != least.estimator);
        let others = others.filter_map(|(c, _)| Other::new(least, c)).collect();
        Some(Self { least: least.estimator, median, others })
    }

    /// The recommended estimator: that of least median error, if the runs distinguish it from each of the others.
    pub fn estimator(&self) -> Option<Estimator> {
        self.others.iter().all(Other::is_distinguished).then_some(self.least)
    }

    /// The estimator of least median error, and those that the runs cannot tell from it.
    pub fn candidates(&self) -> Vec<Estimator> {
        let close = self.others.iter().filter(|other| !other.is_distinguished()).map(|other| other.estimator);
        std::iter::once(self.least).chain(close).collect()
    }
}

impl Contender {
    fn admitted(&self) -> bool {
        self.without_estimate as f64 <= MOST_WITHOUT_ESTIMATE * self.errors.len() as f64
    }
}

impl Other {
    fn new(least: &Contender, other: &Contender) -> Option<Self> {
        let pairs = least.errors.iter().zip(&other.errors).map(|(least, other)| [*least, *other]);
        let [low, difference, high] = paired_median(pairs)?;
        Some(Self { estimator: other.estimator, difference, interval: [low, high] })
    }

    /// Whether its errors are the larger ones beyond chance: the interval of the difference lies above 0.
    fn is_distinguished(&self) -> bool {
        self.interval[0] > 0.0
    }
}

/// The error of one estimator less that of another on the same runs or recordings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairedDifference {
    /// Which.
    pub estimator: Estimator,
    /// The median difference; null where it is infinite.
    pub median: Option<f64>,
    /// 95 % interval of that median; null at an infinite end. An interval that contains 0 tells no difference.
    pub interval: [Option<f64>; 2],
}

impl From<&Other> for PairedDifference {
    fn from(other: &Other) -> Self {
        let finite = |value: f64| Some(value).filter(|v| v.is_finite());
        let Other { estimator, difference, interval } = other;
        Self { estimator: *estimator, median: finite(*difference), interval: interval.map(finite) }
    }
}

/// Quantiles over the runs; null where the quantile falls among runs without a value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Quantiles {
    /// The smallest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// 10 %.
    pub q10: Option<f64>,
    /// 50 %.
    pub median: Option<f64>,
    /// 95 % interval of the median: two of the values, by their ranks; null at an end that there are too few values for or
    /// that falls among runs without a value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub median_interval: Option<[Option<f64>; 2]>,
    /// 90 %.
    pub q90: Option<f64>,
    /// The same of the 90 % quantile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub q90_interval: Option<[Option<f64>; 2]>,
    /// 99 %.
    pub q99: Option<f64>,
    /// The largest.
    pub max: Option<f64>,
}

impl Quantiles {
    /// Quantiles of values, absent ones counted as infinite.
    pub fn of(values: impl Iterator<Item = Option<f64>>) -> Self {
        let sorted = sorted(values);
        Self {
            min: quantile(&sorted, 0.0),
            q10: quantile(&sorted, 0.1),
            median: quantile(&sorted, 0.5),
            median_interval: Some(quantile_interval(&sorted, 0.5)),
            q90: quantile(&sorted, 0.9),
            q90_interval: Some(quantile_interval(&sorted, 0.9)),
            q99: quantile(&sorted, 0.99),
            max: quantile(&sorted, 1.0),
        }
    }
}

/// A share of runs or realizations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Share {
    /// The share.
    pub share: f64,
    /// Its 95 % interval (Wilson's); null of nothing.
    pub interval: Option<[f64; 2]>,
}

impl Share {
    /// `count` of `total`.
    pub fn of(count: usize, total: usize) -> Self {
        Self { share: count as f64 / total.max(1) as f64, interval: wilson(count as u64, total as u64) }
    }
}

/// Standard errors are trusted if their relative difference from the spread that they predict is at most this.
pub const TRUSTED: f64 = 0.15;

/// One parameter over the runs with an estimate; relative figures are over |truth|, absent if that is unknown or 0.
#[derive(Clone, Debug, PartialEq)]
pub struct RepeatedEstimates {
    /// Mean estimate.
    pub mean: Option<f64>,
    /// Standard deviation of the estimates; none below two runs.
    pub spread: Option<f64>,
    /// Median of the standard errors that the runs report.
    pub predicted_se: Option<f64>,
    /// (mean − truth)/|truth|.
    pub relative_bias: Option<f64>,
    /// spread/|truth|.
    pub relative_spread: Option<f64>,
}

impl RepeatedEstimates {
    /// From the estimates and the standard errors of all runs.
    pub fn new(estimates: &[f64], standard_errors: &[f64], truth: Option<f64>) -> Self {
        let (mean, spread) = (mean(estimates), spread(estimates));
        let known = truth.filter(|truth| *truth != 0.0);
        Self {
            mean,
            spread,
            predicted_se: quantile(
                &sorted(standard_errors.iter().copied().filter(|error| !error.is_nan()).map(Some)),
                0.5,
            ),
            relative_bias: mean.zip(known).map(|(mean, truth)| (mean - truth) / truth.abs()),
            relative_spread: spread.zip(known).map(|(spread, truth)| spread / truth.abs()),
        }
    }

    /// Predicted standard error over the spread: near 1 if standard errors can be trusted.
    pub fn se_ratio(&self) -> Option<f64> {
        let spread = self.spread.filter(|spread| *spread > 0.0)?;
        Some(self.predicted_se? / spread)
    }

    /// Whether the standard errors are within [`TRUSTED`] of the spread.
    pub fn se_trusted(&self) -> bool {
        self.se_ratio().is_some_and(|ratio| (ratio - 1.0).abs() <= TRUSTED)
    }
}

/// 2-norms of relative bias, of relative spread, and of both, over the parameters that have both; `None` where none has.
pub fn relative_norms(parameters: &[RepeatedEstimates]) -> Option<[f64; 3]> {
    let both: Vec<[f64; 2]> =
        parameters.iter().filter_map(|p| Some([p.relative_bias?, p.relative_spread?])).collect();
    let norm = |i: usize| both.iter().map(|x| x[i] * x[i]).sum::<f64>().sqrt();
    let [bias, spread] = [norm(0), norm(1)];
    (!both.is_empty()).then(|| [bias, spread, libm::hypot(bias, spread)])
}
