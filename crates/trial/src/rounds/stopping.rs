use numerics::statistics::{mean, mean_interval, quantile, quantile_interval, sorted, wilson};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::row::{Arm, Row};

/// Errors of the trial in rounds over those of the one-shot trial after the same time in the same realization.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RoundGain {
    /// Time at sea.
    pub time_s: f64,
    /// Realizations in which both have an estimate.
    pub pairs: u64,
    /// Geometric mean of the ratio; below 1 rounds are better.
    pub ratio: Option<f64>,
    /// Lower end of its 95 % interval.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

/// Trials that end with the first round after which the error is said to be within the accuracy, or else after the whole
/// time: in rounds by the estimate's own word, one-shot by the crude model's, beforehand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stopping {
    /// `sequential` or `one-shot`.
    pub arm: Arm,
    /// Trials that end because the accuracy is promised.
    pub stopped: u64,
    /// Mean time at sea of all trials.
    pub mean_time_s: f64,
    /// 95 % interval of that mean.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean_time_interval_s: Option<[f64; 2]>,
    /// Median parameter error of all trials at their end.
    pub median_error: Option<f64>,
    /// 95 % interval of that median; null at an end that there are too few trials for, or that is infinite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub median_error_interval: Option<[Option<f64>; 2]>,
    /// Share of all trials whose error at their end is within the accuracy.
    pub within: f64,
    /// 95 % interval of that share (Wilson's).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within_interval: Option<[f64; 2]>,
    /// The same of those that were promised it.
    pub within_stopped: Option<f64>,
    /// 95 % interval of that share (Wilson's).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within_stopped_interval: Option<[f64; 2]>,
    /// Root mean square error over accuracy of those that were promised it: at most 1 where promises are kept.
    pub rms_over_accuracy: Option<f64>,
    /// 95 % interval of it, from that of the mean square.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms_over_accuracy_interval: Option<[f64; 2]>,
    /// Of those that were promised it, how many have no estimate and are in no mean square.
    pub without_estimate: u64,
}

/// Where trials of `arm` end if they stop after the first round with `promised` within `accuracy`, or else
/// after the whole time. `rows`: rounds in order.
pub(super) fn stopping(
    rows: &[Row],
    arm: Arm,
    promised: impl Fn(&Row) -> Option<f64>,
    accuracy: f64,
    rate_hz: f64,
) -> Stopping {
    let kept = |row: &Row| promised(row).is_some_and(|error| error <= accuracy);
    let own: Vec<&Row> = rows.iter().filter(|row| row.arm == arm).collect();
    let trials = own.chunk_by(|a, b| a.realization == b.realization);
    let ends: Vec<&Row> =
        trials.filter_map(|rounds| rounds.iter().find(|row| kept(row)).or(rounds.last()).copied()).collect();
    let stopped: Vec<&Row> = ends.iter().copied().filter(|row| kept(row)).collect();
    let good = |rows: &[&Row]| {
        rows.iter().filter(|row| row.parameter_error.is_some_and(|error| error <= accuracy)).count()
    };
    let within = |rows: &[&Row]| (!rows.is_empty()).then(|| good(rows) as f64 / rows.len() as f64);
    let interval = |rows: &[&Row]| wilson(good(rows) as u64, rows.len() as u64);
    let errors = sorted(ends.iter().map(|row| row.parameter_error));
    let squares: Vec<f64> =
        stopped.iter().filter_map(|row| Some((row.parameter_error? / accuracy).powi(2))).collect();
    let times: Vec<f64> = ends.iter().map(|row| row.samples as f64 / rate_hz).collect();
    Stopping {
        arm,
        stopped: stopped.len() as u64,
        mean_time_s: mean(&times).unwrap_or(0.0),
        mean_time_interval_s: mean_interval(&times),
        median_error: quantile(&errors, 0.5),
        median_error_interval: Some(quantile_interval(&errors, 0.5)),
        within: within(&ends).unwrap_or(0.0),
        within_interval: interval(&ends),
        within_stopped: within(&stopped),
        within_stopped_interval: interval(&stopped),
        rms_over_accuracy: mean(&squares).map(f64::sqrt),
        rms_over_accuracy_interval: mean_interval(&squares).map(|ends| ends.map(|end| end.max(0.0).sqrt())),
        without_estimate: (stopped.len() - squares.len()) as u64,
    }
}

/// Errors of the trial in rounds over those of the one-shot trial after `round`, which ends after `samples`.
pub(super) fn gain(rows: &[Row], round: usize, samples: usize, rate_hz: f64) -> RoundGain {
    let errors = |arm: Arm| {
        let own = rows.iter().filter(move |row| row.arm == arm && row.round as usize == round);
        own.map(|row| row.parameter_error)
    };
    let pairs = errors(Arm::Sequential).zip(errors(Arm::OneShot));
    let logs: Vec<f64> =
        pairs.filter_map(|(a, b)| Some(libm::log(a? / b?))).filter(|log| log.is_finite()).collect();
    let interval = mean_interval(&logs).map(|ends| ends.map(libm::exp));
    RoundGain {
        time_s: samples as f64 / rate_hz,
        pairs: logs.len() as u64,
        ratio: mean(&logs).map(libm::exp),
        low: interval.map(|[low, _]| low),
        high: interval.map(|[_, high]| high),
    }
}
