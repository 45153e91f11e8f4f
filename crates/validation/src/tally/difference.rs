use identification::Estimator;
use numerics::statistics::{paired_share_difference, share_difference};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Counted, PairCounts, Tally};

/// A share of runs less another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShareDifference {
    /// The difference.
    pub share: f64,
    /// Its 95 % interval (Newcombe's). One that contains 0 tells no difference.
    pub interval: [f64; 2],
    /// Whether both are shares of the same runs, which were counted together.
    pub paired: bool,
}

impl Tally {
    /// How much larger the share of parameter errors below their bound is by `counted` than by `baseline`, a design
    /// and an estimator. `None` for the baseline itself, if there is no baseline, and without runs.
    pub fn difference(&self, counted: &Counted, baseline: (&str, Estimator)) -> Option<ShareDifference> {
        let other = self.counted.iter().find(|c| (c.design.as_str(), c.estimator) == baseline)?;
        if (other.design == counted.design && other.estimator == counted.estimator) || counted.runs == 0 {
            return None;
        }
        let counts = |c: &Counted| [c.parameter_errors_below, c.runs];
        let [own, against] = [counts(counted), counts(other)];
        let interval = match self.alone(counted, other) {
            Some([only_own, only_other]) => {
                paired_share_difference(own[0].checked_sub(only_own)?, only_own, only_other, counted.runs)
            }
            None => share_difference(own, against),
        };
        let [share, baseline] = [own, against].map(|[count, runs]| count as f64 / runs as f64);
        let paired = self.alone(counted, other).is_some();
        interval.map(|interval| ShareDifference { share: share - baseline, interval, paired })
    }

    /// The number of common runs in which only the one is below its bound, and in which only the other is.
    fn alone(&self, one: &Counted, other: &Counted) -> Option<[u64; 2]> {
        let pairs = self.pairs.iter().filter(|p| p.design == one.design && p.design == other.design);
        let counts = |p: &PairCounts| {
            let both = [p.only_one_below, p.only_other_below];
            match (p.one, p.other) {
                pair if pair == (one.estimator, other.estimator) => Some(both),
                pair if pair == (other.estimator, one.estimator) => Some([both[1], both[0]]),
                _ => None,
            }
        };
        pairs.filter_map(counts).next()
    }
}
