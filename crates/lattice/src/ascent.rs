//! Prices that maximize the bound at the start: subgradient ascent with Polyak's step.

use crate::graph::Graph;
use crate::relaxation::{Bound, Prices, Table};
use crate::watch::{Walk, Watch};

/// Most rounds.
const ROUNDS: u64 = 60;
/// Approximate number of nodes visited in all rounds.
const WORK: u64 = 60_000_000;
/// Rounds without a better bound before the step is halved.
const PATIENCE: u32 = 4;
/// Smallest share of Polyak's step.
const SMALLEST_SHARE: f64 = 0.02;

/// The result of the ascent.
pub(crate) enum Ascent {
    /// No walk has so many informative moves in total.
    Infeasible,
    /// The cheapest walk of the relaxed problem has the right counts: an optimal plan.
    Optimal(u64, Walk),
    /// The best bound.
    Bound(Bound),
    Stopped,
}

/// Raises the bound at the start, at most to `upper`.
pub(crate) fn ascend(graph: &Graph, upper: Option<u64>, watch: &mut Watch) -> Ascent {
    let mut ascent = Climb::new(graph, upper);
    let rounds = (WORK / Table::entries(graph, None) as u64).clamp(4, ROUNDS);
    for _ in 0..rounds {
        match ascent.round(watch) {
            Round::On => {}
            Round::Enough => break,
            Round::End(end) => return end,
        }
    }
    let Climb { mut prices, best, .. } = ascent;
    prices.set(&best.1, graph.problem.required().iter().sum());
    match Table::new(graph, &prices, None, false, watch) {
        Some(table) => Ascent::Bound(Bound::new(graph, prices, table)),
        None => Ascent::Stopped,
    }
}

enum Round {
    On,
    Enough,
    End(Ascent),
}

struct Climb<'a> {
    graph: &'a Graph<'a>,
    upper: Option<u64>,
    required: Vec<u32>,
    uses: u32,
    prices: Prices,
    values: Vec<f64>,
    /// Best scaled bound and its prices.
    best: (i64, Vec<f64>),
    share: f64,
    idle: u32,
}

impl<'a> Climb<'a> {
    fn new(graph: &'a Graph<'a>, upper: Option<u64>) -> Self {
        let required = graph.problem.required();
        let values = vec![0.0; required.len()];
        let (prices, uses) = (Prices::zero(graph), required.iter().sum());
        Self { graph, upper, required, uses, prices, best: (-1, values.clone()), values, share: 1.0, idle: 0 }
    }

    fn round(&mut self, watch: &mut Watch) -> Round {
        self.prices.set(&self.values, self.uses);
        let Some(table) = Table::new(self.graph, &self.prices, None, true, watch) else {
            return Round::End(Ascent::Stopped);
        };
        let (uses, walk) = table.walk(self.graph, self.uses);
        if uses.iter().sum::<u32>() != self.uses {
            return Round::End(Ascent::Infeasible);
        }
        let bound = self.bound(&uses, &walk);
        watch.raise(self.prices.key(bound));
        let excess: Vec<f64> =
            self.required.iter().zip(&uses).map(|(&n, &u)| f64::from(n) - f64::from(u)).collect();
        if excess.iter().all(|&excess| excess == 0.0) {
            return Round::End(Ascent::Optimal(self.prices.key(bound), walk));
        }
        self.note(bound);
        if self.upper.is_some_and(|upper| self.prices.key(self.best.0) >= upper)
            || self.share < SMALLEST_SHARE
        {
            return Round::Enough;
        }
        self.step(bound, &excess);
        Round::On
    }

    /// The bound at the start, from its walk: cost plus the priced difference of required and actual uses.
    fn bound(&self, uses: &[u32], walk: &[u32]) -> i64 {
        let key: u64 = walk.iter().map(|&step| self.graph.price(step).0).sum();
        let difference = self.required.iter().zip(uses).map(|(&n, &u)| i64::from(n) - i64::from(u));
        let priced: i64 =
            difference.zip(&self.prices.values).map(|(difference, price)| difference * price).sum();
        key as i64 * self.prices.scale + priced
    }

    fn note(&mut self, bound: i64) {
        if bound > self.best.0 {
            self.best = (bound, self.values.clone());
            self.idle = 0;
            return;
        }
        self.idle += 1;
        if self.idle >= PATIENCE {
            self.idle = 0;
            self.share /= 2.0;
            self.values = self.best.1.clone();
        }
    }

    fn step(&mut self, bound: i64, excess: &[f64]) {
        let scale = self.prices.scale as f64;
        let hoped = self.best.0 as f64 * 1.1 + scale;
        let target = self.upper.map_or(hoped, |upper| upper as f64 * scale);
        let square: f64 = excess.iter().map(|excess| excess * excess).sum();
        let step = self.share * (target - bound as f64).max(0.0) / square;
        for (value, excess) in self.values.iter_mut().zip(excess) {
            *value += step * excess;
        }
    }
}
