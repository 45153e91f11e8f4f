use identification::parameter_error;
use identification::pooled::Lifted;
use optimal_design::apportion;
use vessel::{
    Disturbances, Generator, Invalid, LANES, Lane, Model, Realized, Streams, check_diverged, simulate,
};

use super::SequentialFile;
use super::estimate::{Leg, estimate};
use super::planner::Planner;
use super::table::Row;
use crate::simulate::exogenous;

/// A way to spend the sea time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arm {
    /// Designed anew after every round from the estimate so far.
    Sequential,
    /// Designed once from the crude model.
    OneShot,
    /// Designed once from the true parameters: what nobody can do.
    Informed,
    /// Maneuvers drawn at random.
    Random,
}

impl Arm {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Sequential, Self::OneShot, Self::Informed, Self::Random];

    /// As in files.
    pub fn name(self) -> &'static str {
        ["sequential", "one-shot", "informed", "random"][self as usize]
    }
}

/// What all realizations share.
pub struct Trial<'a> {
    /// The model structure.
    pub model: &'a Model,
    /// True parameters.
    pub truth: Vec<f64>,
    /// Nominal parameters, about which crude models are drawn.
    pub nominal: Vec<f64>,
    /// The maneuvers.
    pub generator: &'a Generator,
    /// What disturbs the legs.
    pub disturbances: Disturbances,
    /// Designs.
    pub planner: Planner<'a>,
    /// Design from the true parameters.
    pub informed: Vec<f64>,
    /// What was asked for.
    pub config: &'a SequentialFile,
    /// Segments of a random experiment.
    pub random_segments: usize,
    /// Samples sailed by the end of every round.
    pub ends: Vec<usize>,
    /// The model with intercepts.
    pub lifted: Lifted,
    /// Standard deviations that output errors are weighted by.
    pub std: [f64; 3],
    /// Sampling rate \[Hz\].
    pub rate_hz: f64,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// An estimate with its standard errors.
struct Found {
    theta: Vec<f64>,
    standard_errors: Vec<f64>,
}

impl Found {
    /// 2-norm over the parameters of standard error over estimate.
    fn predicted_error(&self) -> f64 {
        let relative = self.standard_errors.iter().zip(&self.theta).map(|(error, theta)| error / theta);
        relative.map(|x| x * x).sum::<f64>().sqrt()
    }
}

/// Channel of the random stream that draws maneuvers.
const MANEUVER_CHANNEL: u32 = 100;

/// Maneuver and samples, one after the other.
type Plan = Vec<(usize, usize)>;

impl Trial<'_> {
    /// All rows of realization `number`: arms in order, rounds in order.
    ///
    /// # Errors
    /// A maneuver that the model cannot hold; true parameters with which the vessel diverges.
    pub fn realization(&self, number: u32) -> Result<Vec<Row>, Invalid> {
        let crude = self.crude(number);
        let mut rows = Vec::with_capacity(Arm::ALL.len() * self.ends.len());
        for arm in Arm::ALL {
            match arm {
                Arm::Sequential => rows.extend(self.in_rounds(number, &crude)?),
                _ => rows.extend(self.at_once(arm, number, &crude)?),
            }
        }
        Ok(rows)
    }

    /// The crude model of a realization.
    fn crude(&self, number: u32) -> Vec<f64> {
        let mut normals = vec![0.0; self.nominal.len()];
        Streams::new(self.seed, "crude nominal").normals(number, 0, &mut normals);
        let spread = self.config.nominal_spread;
        self.nominal.iter().zip(normals).map(|(theta, z)| theta * (spread * z).exp()).collect()
    }

    /// Design the rest of the time, sail a round of it, estimate, design the rest again.
    fn in_rounds(&self, number: u32, crude: &[f64]) -> Result<Vec<Row>, Invalid> {
        let mut known = crude.to_vec();
        let (mut legs, mut rows): (Vec<Leg>, Vec<Row>) = (Vec::new(), Vec::new());
        let total = self.ends.last().copied().unwrap_or(0);
        for (round, end) in self.ends.iter().enumerate() {
            let before = if round == 0 { 0 } else { self.ends[round - 1] };
            let sailed = if round == 0 { None } else { self.planner.sailed(&legs, &known) };
            let shares = self.planner.shares(&known, sailed.as_ref(), total - before);
            let designed = shares.is_some();
            let rest = plan(&shares.unwrap_or_else(|| self.even()), total - before);
            let plan = first(longest_first(rest), end - before);
            legs.push(self.sail(&format!("sequential {round}"), number, &plan)?);
            let found = self.found(&legs, &known);
            if let Some(found) = &found {
                known = self.learnt(crude, found);
            }
            rows.push(self.row(Arm::Sequential, number, round, found.as_ref(), designed));
        }
        Ok(rows)
    }

    /// The estimate from `legs`, by a model that was known before, with its predicted error.
    fn found(&self, legs: &[Leg], known: &[f64]) -> Option<Found> {
        let theta = estimate(&self.lifted, self.model, legs, known, self.std)?;
        let standard_errors = self.planner.sailed(legs, &theta)?.standard_errors(self.model)?;
        Some(Found { theta, standard_errors })
    }

    /// The model to design with: each parameter between the crude and the estimated one, as their variances have it.
    fn learnt(&self, crude: &[f64], found: &Found) -> Vec<f64> {
        let between = |((crude, theta), error): ((&f64, &f64), &f64)| {
            let own = (self.config.nominal_spread * crude).powi(2);
            let sum = own + error * error;
            if sum > 0.0 { crude + own / sum * (theta - crude) } else { *theta }
        };
        crude.iter().zip(&found.theta).zip(&found.standard_errors).map(between).collect()
    }

    /// One design, sailed for each of the durations.
    fn at_once(&self, arm: Arm, number: u32, crude: &[f64]) -> Result<Vec<Row>, Invalid> {
        let total = self.ends.last().copied().unwrap_or(0);
        let (shares, designed) = match arm {
            Arm::OneShot => {
                let shares = self.planner.shares(crude, None, total);
                let designed = shares.is_some();
                (shares.unwrap_or_else(|| self.even()), designed)
            }
            _ => (self.informed.clone(), true),
        };
        let one = |(round, end): (usize, &usize)| {
            let plan = if arm == Arm::Random { self.drawn(number, *end) } else { plan(&shares, *end) };
            let leg = self.sail(&format!("{} {round}", arm.name()), number, &plan)?;
            let found = self.found(&[leg], crude);
            Ok(self.row(arm, number, round, found.as_ref(), designed))
        };
        self.ends.iter().enumerate().map(one).collect()
    }

    fn row(&self, arm: Arm, number: u32, round: usize, found: Option<&Found>, designed: bool) -> Row {
        Row {
            arm,
            realization: number,
            round: round as u32,
            samples: self.ends[round],
            designed,
            parameter_error: found.and_then(|found| parameter_error(&found.theta, &self.truth)),
            predicted_error: found.map(Found::predicted_error),
        }
    }

    fn even(&self) -> Vec<f64> {
        vec![1.0 / self.planner.maneuvers() as f64; self.planner.maneuvers()]
    }

    /// Equally long segments, each of them any maneuver.
    fn drawn(&self, number: u32, samples: usize) -> Plan {
        let segments = self.random_segments.min(samples).max(1);
        let lengths = apportion(&vec![1.0 / segments as f64; segments], samples as u64);
        let streams = Streams::new(self.seed, &format!("random {samples}"));
        let drawn = streams.choices(number, MANEUVER_CHANNEL, self.planner.maneuvers() as u32, segments);
        drawn.into_iter().zip(lengths).map(|(q, n)| (q as usize, n as usize)).collect()
    }

    /// Sails `plan` from its first maneuver's initial state under this leg's own disturbances.
    fn sail(&self, leg: &str, number: u32, plan: &Plan) -> Result<Leg, Invalid> {
        let parts: Vec<Realized> =
            plan.iter().map(|(q, n)| self.generator.realize(*q, *n)).collect::<Result<_, _>>()?;
        let exogenous: Vec<f64> = parts.iter().flat_map(|part| exogenous(self.model, &part.inputs)).collect();
        let initial = parts.first().map_or([0.0; 3], |part| part.initial);
        let samples = plan.iter().map(|(_, n)| n).sum();
        let streams = Streams::new(self.seed, leg);
        let lanes = [number; LANES];
        let current = self.disturbances.current(&streams, lanes, samples, self.rate_hz);
        let truth: Vec<Lane> = self.truth.iter().map(|t| Lane::splat(*t)).collect();
        let mut states = vec![Lane::ZERO; 3 * (samples + 1)];
        simulate(self.model, &truth, initial.map(Lane::splat), &exogenous, &current, &mut states);
        if check_diverged(states.iter().map(|s| s[0])).is_some() {
            return Err(Invalid::new(
                "true parameters",
                "a simulation that diverges",
                "a stable vessel",
                "correct the `value`s",
            ));
        }
        self.disturbances.measure(&streams, lanes, &mut states);
        let mut measured: Vec<f64> = states.iter().map(|s| s[0]).collect();
        measured[..3].copy_from_slice(&initial);
        Ok(Leg { initial, exogenous, measured })
    }
}

/// Shares of `samples` in whole samples, in the dictionary's order.
fn plan(shares: &[f64], samples: usize) -> Plan {
    let counts = apportion(shares, samples as u64);
    counts.iter().enumerate().filter(|(_, n)| **n > 0).map(|(q, n)| (q, *n as usize)).collect()
}

/// The longest maneuver first: what is sailed before the next round is sailed at length.
fn longest_first(mut plan: Plan) -> Plan {
    plan.sort_by_key(|(q, n)| (std::cmp::Reverse(*n), *q));
    plan
}

/// The first `samples` samples of `plan`.
fn first(plan: Plan, samples: usize) -> Plan {
    let mut left = samples;
    let mut take = |(q, n): (usize, usize)| {
        let n = n.min(left);
        left -= n;
        (n > 0).then_some((q, n))
    };
    plan.into_iter().filter_map(&mut take).collect()
}
