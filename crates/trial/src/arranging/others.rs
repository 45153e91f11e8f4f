//! Where the search begins, and the trials that what it finds is compared with.

use std::collections::BTreeMap;

use refusal::Invalid;
use ship::engine::Streams;

use super::{Arranging, Kept, Promised, TrialKind, best_of};
use crate::campaign::{Parts, Plan, practice};

/// Random orders of the pieces that the search may begin with, and random trials that it is compared with.
const ORDERS: u32 = 30;
const TRIALS: u32 = 100;

impl Arranging<'_> {
    /// The pieces of `shares` at their maneuvers' own lengths, in turn, and random orders of these.
    pub(super) fn starts(&self, shares: &Plan, least: &BTreeMap<usize, usize>) -> Result<Vec<Plan>, Invalid> {
        let cut = |&(q, samples): &(usize, usize)| {
            let count = samples.div_ceil(self.generator.samples(q)?.max(1)).max(1);
            let is_table = self.generator.tables().contains_key(&q);
            let count = if is_table { 1 } else { count };
            Ok((0..count).map(|i| (q, samples * (i + 1) / count - samples * i / count)).collect())
        };
        let pieces: Vec<Plan> = shares.iter().map(cut).collect::<Result<_, Invalid>>()?;
        let turns = pieces.iter().map(Vec::len).max().unwrap_or(0);
        let in_turn: Plan =
            (0..turns).flat_map(|turn| pieces.iter().filter_map(move |all| all.get(turn).copied())).collect();
        let streams = Streams::new(self.seed, "orders");
        let shuffled = |order: u32| {
            let mut plan = in_turn.clone();
            let drawn = streams.choices(order, 0, u32::MAX, plan.len());
            (1..plan.len()).for_each(|i| plan.swap(i, drawn[i] as usize % (i + 1)));
            plan
        };
        let all = std::iter::once(in_turn.clone()).chain((0..ORDERS).map(shuffled));
        Ok(all.map(|plan| self.settled(plan, least)).collect())
    }

    /// The trial that was `found`, the `shares` in order, the best of random trials and today's practice, with what each promises: the
    /// best one first; none where nothing is foretold, and none but the first beyond the limits of generated maneuvers. The random
    /// trials and the practice have the maneuvers of the dictionary.
    pub(super) fn compared(
        &self,
        found: Plan,
        shares: Plan,
        least: &BTreeMap<usize, usize>,
        parts: &mut Parts,
    ) -> Result<Vec<(Plan, Promised)>, Invalid> {
        let samples = found.iter().map(|(_, samples)| samples).sum();
        let mut trials = vec![(TrialKind::Arranged, found), (TrialKind::Shares, shares)];
        trials.extend(self.random(samples, least, parts)?.map(|plan| (TrialKind::Random, plan)));
        let practice = practice(self.generator, samples).ok().map(|(plan, _)| plan);
        let known = |plan: &Plan| {
            let names = &self.dictionary.maneuvers;
            plan.iter().all(|(q, _)| names.contains(&self.generator.maneuvers()[*q].name))
        };
        trials.extend(practice.filter(known).map(|plan| (TrialKind::Practice, plan)));
        let mut compared = Vec::with_capacity(trials.len());
        for (trial, plan) in trials {
            parts.make(self.generator, &plan)?;
            let (initial, inputs) = parts.joined(&plan);
            let is_arranged = trial == TrialKind::Arranged;
            if !is_arranged && matches!(self.kept(&(initial, inputs.clone())), Kept::Beyond(_)) {
                continue;
            }
            let errors = self.foretold((initial, self.vessel.model.undisturbed(&inputs)));
            compared.push((plan, Promised { trial, errors }));
        }
        compared.retain(|(_, promised)| promised.errors.is_some());
        compared.sort_by(|(_, a), (_, b)| a.product().total_cmp(&b.product()));
        Ok(compared)
    }

    /// The best of trials of maneuvers that are drawn at random, each at its own length; none where tables leave samples that
    /// nothing fills.
    fn random(
        &self,
        samples: usize,
        least: &BTreeMap<usize, usize>,
        parts: &mut Parts,
    ) -> Result<Option<Plan>, Invalid> {
        let tables = self.generator.tables();
        let places: Vec<usize> = self.places()?.into_iter().filter(|q| !tables.contains_key(q)).collect();
        if places.is_empty() {
            return Ok(None);
        }
        let lengths: BTreeMap<usize, usize> = places
            .iter()
            .map(|q| Ok((*q, self.generator.samples(*q)?.max(1))))
            .collect::<Result<_, Invalid>>()?;
        let shortest = lengths.values().copied().min().unwrap_or(1);
        let streams = Streams::new(self.seed, "random trials");
        let drawn = |trial: u32| {
            let order = streams.choices(trial, 0, places.len() as u32, samples.div_ceil(shortest));
            let mut rest = samples;
            let piece = |place: u32| {
                let q = places[place as usize];
                let taken = rest.min(lengths[&q]);
                rest -= taken;
                (taken > 0).then_some((q, taken))
            };
            self.settled(order.into_iter().map_while(piece).collect(), least)
        };
        let plans: Vec<Plan> = (0..TRIALS).map(drawn).collect();
        let values = self.values(&plans, parts)?;
        Ok(best_of(&values).map(|best| plans[best].clone()))
    }
}
