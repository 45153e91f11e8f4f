use identification::Sums;
use identification::pooled::{Part, Regression};
use optimal_design::{Candidates, Options, solve};
use vessel::{Generator, Invalid, Model, Realized, check_diverged, simulate_one};

use crate::simulate::exogenous;

/// Designs experiments from a model and from what was sailed before.
pub struct Planner<'a> {
    model: &'a Model,
    /// Every maneuver at its own length.
    maneuvers: Vec<Realized>,
}

/// Random starts of a design beside equal shares: undisturbed moments are symmetric, so the problem is concave.
const STARTS: u32 = 0;

impl<'a> Planner<'a> {
    /// Over the maneuvers of `generator`.
    ///
    /// # Errors
    /// A maneuver that the model cannot hold.
    pub fn new(model: &'a Model, generator: &Generator) -> Result<Self, Invalid> {
        let one = |q: usize| generator.realize(q, generator.samples(q)?);
        let maneuvers = (0..generator.maneuvers().len()).map(one).collect::<Result<_, _>>()?;
        Ok(Self { model, maneuvers })
    }

    /// Number of maneuvers.
    pub fn maneuvers(&self) -> usize {
        self.maneuvers.len()
    }

    /// D-optimal shares of `remaining` samples for the model with parameters `theta`, beside what `sailed` tells already:
    /// M(w) = α M_sailed + (1 − α) Σ w_q M_q, α the share of the samples that were sailed. `None` where the model diverges
    /// in every maneuver or none of them excites it.
    pub fn shares(&self, theta: &[f64], sailed: Option<&Sums>, remaining: usize) -> Option<Vec<f64>> {
        let own = |maneuver: &Realized| {
            let exogenous = exogenous(self.model, &maneuver.inputs);
            let states = simulate_one(self.model, theta, maneuver.initial, &exogenous);
            let diverges = check_diverged(states.iter().copied()).is_some();
            (!diverges).then(|| sums(self.model, exogenous, states))
        };
        let sums: Vec<Option<Sums>> = self.maneuvers.iter().map(own).collect();
        let past = sailed.map_or(0.0, |sums| sums.samples as f64);
        let alpha = past / (past + remaining as f64);
        let lifted = self.model.degrees.iter().map(|degree| degree.terms.len() + 1).collect();
        let mut candidates = Candidates::new(lifted);
        let usable: Vec<usize> = (0..sums.len()).filter(|q| sums[*q].is_some()).collect();
        for sums in sums.iter().flatten() {
            candidates.push(&mixed(sums, sailed, alpha)).ok()?;
        }
        let options = Options { random_starts: STARTS, tolerance: 1e-8, ..Options::default() };
        let design = solve(&candidates, &options).ok()?;
        let mut shares = vec![0.0; self.maneuvers.len()];
        usable.into_iter().zip(design.shares).for_each(|(q, share)| shares[q] = share);
        Some(shares)
    }
}

/// Sums of undisturbed motion: instruments and regressors are the same.
pub fn sums(model: &Model, exogenous: Vec<f64>, states: Vec<f64>) -> Sums {
    Regression::of(model, &Part::new("", "", exogenous, states)).sums()
}

/// α M_sailed + (1 − α) M, all blocks one after the other.
fn mixed(sums: &Sums, sailed: Option<&Sums>, alpha: f64) -> Vec<f64> {
    let mean = |sums: &Sums, d: usize, k: usize| sums.degrees[d].a[k] / sums.samples.max(1) as f64;
    let entry = |d: usize, k: usize| {
        let before = sailed.map_or(0.0, |sailed| mean(sailed, d, k));
        alpha * before + (1.0 - alpha) * mean(sums, d, k)
    };
    let block = |d: usize| (0..sums.degrees[d].a.len()).map(move |k| (d, k));
    (0..sums.degrees.len()).flat_map(block).map(|(d, k)| entry(d, k)).collect()
}
