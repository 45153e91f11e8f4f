use numerics::statistics::{quantile, quantile_interval, sorted, wilson};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::row::{Arm, Outcome, Row, Shared};
use super::stopping::{RoundGain, Stopping, gain, stopping};

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
        let own: Vec<&Row> =
            rows.iter().filter(|row| row.arm == arm && row.round as usize == round).collect();
        let errors = sorted(own.iter().map(|row| row.parameter_error));
        let count = |wanted: &dyn Fn(&Row) -> bool| own.iter().filter(|row| wanted(row)).count() as u64;
        let within = count(&|row| row.parameter_error.is_some_and(|error| error <= accuracy));
        ArmPoint {
            time_s: *end as f64 / rate_hz,
            median: quantile(&errors, 0.5),
            median_interval: Some(quantile_interval(&errors, 0.5)),
            q90: quantile(&errors, 0.9),
            q90_interval: Some(quantile_interval(&errors, 0.9)),
            predicted: quantile(&sorted(own.iter().map(|row| row.predicted_error)), 0.5),
            within: within as f64 / own.len().max(1) as f64,
            within_interval: wilson(within, own.len() as u64),
            not_identifiable: count(&|row| row.outcome == Outcome::NotIdentifiable),
            not_converged: count(&|row| row.outcome == Outcome::NotConverged),
            diverged: count(&|row| row.outcome == Outcome::Diverged),
            undesigned: count(&|row| row.shared == Shared::Even),
        }
    };
    ArmSummary { name: arm, points: ends.iter().enumerate().map(point).collect() }
}
