//! Trials in rounds: design from current knowledge, run, estimate, design the next round; against designs made once.

mod planner;
mod trial;

use estimation::EstimateStatus;
use numerics::statistics::{mean, mean_interval, quantile, quantile_interval, sorted, wilson};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use planner::{GrowingRun, Knowledge, Planner, SoFar};
pub use trial::{Trial, ends, truth};

refusal::choices! {
    /// A way to spend the time of a trial.
    pub enum Arm {
        /// Designed anew for every round, with what the rounds before have told.
        Sequential = "sequential",
        /// Designed once, from the crude model.
        OneShot = "one-shot",
        /// Designed once, from the true parameters: what nobody can do.
        Informed = "informed",
        /// Maneuvers drawn at random.
        Random = "random",
    }
}

/// How the time of a plan was shared out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shared {
    /// By a design.
    Designed,
    /// Evenly: no design could be made with the model.
    Even,
    /// At random, as asked for.
    Drawn,
}

/// What became of an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// There is one.
    Identified,
    /// A direction is not excited.
    #[serde(rename = "not identifiable")]
    NotIdentifiable,
    /// The search did not converge.
    #[serde(rename = "not converged")]
    NotConverged,
    /// The nominal model diverges, with which the search begins.
    Diverged,
}

impl From<EstimateStatus> for Outcome {
    fn from(status: EstimateStatus) -> Self {
        match status {
            EstimateStatus::Identified
            | EstimateStatus::Rejected
            | EstimateStatus::Approximate
            | EstimateStatus::Waves
            | EstimateStatus::Diverges
            | EstimateStatus::OwnInstruments => Self::Identified,
            EstimateStatus::NotIdentifiable => Self::NotIdentifiable,
            EstimateStatus::NotConverged => Self::NotConverged,
        }
    }
}

/// An arm of a realization at the end of a round.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// How the time was spent.
    pub arm: Arm,
    /// Number of the realization.
    pub realization: u32,
    /// Round, from 0.
    pub round: u32,
    /// Samples so far.
    pub samples: usize,
    /// How the round's time was shared out.
    pub shared: Shared,
    /// What became of the estimate.
    pub outcome: Outcome,
    /// 2-norm over the parameters of (estimate − truth)/truth; `None` without an estimate.
    pub parameter_error: Option<f64>,
    /// What the estimate says of its own error: 2-norm of standard error over the parameter known by then.
    pub predicted_error: Option<f64>,
    /// What the crude model says of a one-shot trial beforehand; `None` for others and where that model diverges.
    pub expected_error: Option<f64>,
}

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
fn stopping(
    rows: &[Row],
    arm: Arm,
    promised: impl Fn(&Row) -> Option<f64>,
    accuracy: f64,
    rate_hz: f64,
) -> Stopping {
    let kept = |row: &Row| promised(row).is_some_and(|error| error <= accuracy);
    let of_arm: Vec<&Row> = rows.iter().filter(|row| row.arm == arm).collect();
    let trials = of_arm.chunk_by(|a, b| a.realization == b.realization);
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
fn gain(rows: &[Row], round: usize, samples: usize, rate_hz: f64) -> RoundGain {
    let errors = |arm: Arm| {
        let of_round = rows.iter().filter(move |row| row.arm == arm && row.round as usize == round);
        of_round.map(|row| row.parameter_error)
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

/// The summary of all realizations.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// One per arm, in the order of [`Arm::ALL`].
    pub arms: Vec<ArmSummary>,
    /// The trial in rounds over the one-shot trial, at the end of every round.
    pub gains: Vec<RoundGain>,
    /// For the trial in rounds and the one-shot trial.
    pub stopping: Vec<Stopping>,
}

/// One way to spend the time of a trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ArmSummary {
    /// Its name.
    pub name: Arm,
    /// One per round.
    pub points: Vec<ArmPoint>,
}

/// An arm after some time, over the realizations; those without an estimate count as infinite errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ArmPoint {
    /// Time at sea.
    pub time_s: f64,
    /// Median of the parameter error.
    pub median: Option<f64>,
    /// 95 % interval of that median; null at an end that there are too few realizations for, or that is infinite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub median_interval: Option<[Option<f64>; 2]>,
    /// Its 90 % quantile.
    pub q90: Option<f64>,
    /// 95 % interval of that quantile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub q90_interval: Option<[Option<f64>; 2]>,
    /// Median of the error that estimates predict of themselves.
    pub predicted: Option<f64>,
    /// Share of the realizations whose parameter error is within the accuracy.
    pub within: f64,
    /// 95 % interval of that share (Wilson's).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within_interval: Option<[f64; 2]>,
    /// Realizations with a direction that is not excited.
    pub not_identifiable: u64,
    /// Realizations whose search for an estimate did not converge.
    pub not_converged: u64,
    /// Realizations in which the nominal model diverges.
    pub diverged: u64,
    /// Realizations whose model allowed no design for the last round: all maneuvers shared it.
    pub undesigned: u64,
}

impl Summary {
    /// Summarizes `rows`: realizations, arms, rounds in order. `ends`: samples by the end of every round.
    pub fn new(rows: &[Row], ends: &[usize], accuracy: f64, rate_hz: f64) -> Self {
        let arms = Arm::ALL.into_iter().map(|arm| summary(rows, arm, ends, accuracy, rate_hz)).collect();
        let gains = ends.iter().enumerate().map(|(round, end)| gain(rows, round, *end, rate_hz)).collect();
        let stopping = vec![
            stopping(rows, Arm::Sequential, |row| row.predicted_error, accuracy, rate_hz),
            stopping(rows, Arm::OneShot, |row| row.expected_error, accuracy, rate_hz),
        ];
        Self { arms, gains, stopping }
    }
}

fn summary(rows: &[Row], arm: Arm, ends: &[usize], accuracy: f64, rate_hz: f64) -> ArmSummary {
    let point = |(round, end): (usize, &usize)| {
        let of_round: Vec<&Row> =
            rows.iter().filter(|row| row.arm == arm && row.round as usize == round).collect();
        let errors = sorted(of_round.iter().map(|row| row.parameter_error));
        let count = |wanted: &dyn Fn(&Row) -> bool| of_round.iter().filter(|row| wanted(row)).count() as u64;
        let within = count(&|row| row.parameter_error.is_some_and(|error| error <= accuracy));
        ArmPoint {
            time_s: *end as f64 / rate_hz,
            median: quantile(&errors, 0.5),
            median_interval: Some(quantile_interval(&errors, 0.5)),
            q90: quantile(&errors, 0.9),
            q90_interval: Some(quantile_interval(&errors, 0.9)),
            predicted: quantile(&sorted(of_round.iter().map(|row| row.predicted_error)), 0.5),
            within: within as f64 / of_round.len().max(1) as f64,
            within_interval: wilson(within, of_round.len() as u64),
            not_identifiable: count(&|row| row.outcome == Outcome::NotIdentifiable),
            not_converged: count(&|row| row.outcome == Outcome::NotConverged),
            diverged: count(&|row| row.outcome == Outcome::Diverged),
            undesigned: count(&|row| row.shared == Shared::Even),
        }
    };
    ArmSummary { name: arm, points: ends.iter().enumerate().map(point).collect() }
}
