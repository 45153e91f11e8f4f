//! Which of several estimators to use, from their errors on the same runs.

use numerics::statistics::{paired_median, quantile, sorted};
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
        Some(Self {
            least: least.estimator,
            median,
            others: others.filter_map(|(c, _)| Other::new(least, c)).collect(),
        })
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
        Self {
            estimator: other.estimator,
            median: finite(other.difference),
            interval: other.interval.map(finite),
        }
    }
}
