//! The order and lengths of a design's maneuvers, evaluated with the state carried over between them.
//!
//! Sequences of an output-error estimate that is to predict are judged by both of its errors: that of the parameters by the
//! criterion, and that of free runs over the validation maneuvers. The search then begins with the best of the shares in order, of
//! their pieces interleaved and of random orders of these, and what it finds is compared with the shares in order, with the best of
//! random trials and with today's practice: the trial that promises the smallest errors is taken.

mod foretold;
mod others;

use std::collections::BTreeMap;

use design::{Criterion, Dictionary};
use maneuver::{Exceeded, Generator, Limits};
use numerics::LANES;
use rayon::prelude::*;
use refusal::Invalid;
use ship::engine::{Streams, simulate_one};
use ship::model::Vessel;

use crate::campaign::{Parts, Plan, shared_out};
use crate::moments::{Estimated, Moments};

pub use foretold::{Foretold, Promised};

/// The data for evaluating a sequence of maneuvers.
pub struct Arranging<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// The maneuvers.
    pub generator: &'a Generator,
    /// The moments of the same maneuvers.
    pub moments: &'a Moments,
    /// The moments as a dictionary.
    pub dictionary: &'a Dictionary,
    /// The criterion.
    pub criterion: &'a Criterion,
    /// The estimate that the criterion is for.
    pub estimated: Estimated,
    /// Seed of the search.
    pub seed: u64,
}

/// The result of the search.
#[derive(Clone, Debug, PartialEq)]
pub struct Arranged {
    /// Maneuvers and samples, in order.
    pub parts: Vec<(String, usize)>,
    /// Value of the criterion with the state carried over.
    pub value: f64,
    /// By what fraction of the time its efficiency exceeds that of the same shares in the dictionary's order.
    pub gain: f64,
    /// Number of sequences evaluated.
    pub tried: usize,
    /// Whether the motion keeps the limits of generated maneuvers.
    pub limits: Kept,
    /// The errors that its output-error estimate is to have; none of other estimates, or in a current that lasts.
    pub foretold: Option<Foretold>,
    /// What each trial that was compared promises, the one that is taken first; empty where nothing is foretold.
    pub promised: Vec<Promised>,
}

refusal::choices! {
    /// A trial that a design is compared with.
    pub enum TrialKind {
        /// What the search found.
        Arranged = "arranged",
        /// The shares, in the dictionary's order.
        Shares = "shares",
        /// The best of random trials.
        Random = "random",
        /// Today's practice: the maneuvers that are written by hand, one after another.
        Practice = "practice",
    }
}

/// Whether the limits are kept between maneuvers.
#[derive(Clone, Debug, PartialEq)]
pub enum Kept {
    /// There are no limits.
    Unlimited,
    /// They are kept.
    Within,
    /// They are exceeded.
    Beyond(Exceeded),
}

/// The limits of generated maneuvers, if any.
pub(crate) fn generated_limits(generator: &Generator) -> Option<&Limits> {
    (0..generator.maneuvers().len()).rev().find_map(|q| generator.limits(q))
}

/// The lowest value that a gain is stated over.
const LOWEST: f64 = -1e3;
/// Neighbours that are evaluated in one round, and most rounds of the search.
const SEARCHED: (usize, usize) = (48, 90);
/// Of a ship with forces, of which one sequence takes ten times as long.
const SEARCHED_OF_FORCES: (usize, usize) = (16, 24);
/// Rounds without a better neighbour before steps are reduced.
const PATIENCE: usize = 3;
/// Most maneuvers that may be added, by sensitivity.
const JOINING: usize = 12;
/// Shortest piece of a maneuver, as a share of its own length: a crew gives no orders for seconds.
const LEAST: f64 = 0.15;

impl Arranging<'_> {
    /// The best sequence that a local search finds from the dictionary's order: segments trade samples,
    /// change places, or make room for others. Tables are played whole, so they trade no samples; no piece of another maneuver is
    /// shorter than 15 % of it. `shares` of the maneuvers, with their `sensitivities`.
    ///
    /// # Errors
    /// A generator without the dictionary's maneuvers; a motion that the model cannot hold; samples that whole plays of tables do
    /// not fill, or that do not tell every parameter.
    pub fn search(&self, shares: &[f64], sensitivities: &[f64], samples: usize) -> Result<Arranged, Invalid> {
        let places = self.places()?;
        let mut of_all = vec![0.0; self.generator.maneuvers().len()];
        places.iter().zip(shares).for_each(|(place, share)| of_all[*place] = *share);
        let least = self.least(&places)?;
        let mut now = self.settled(shared_out(&of_all, self.generator.tables(), samples)?, &least);
        let mut order: Vec<usize> = (0..places.len()).collect();
        order.sort_by(|a, b| sensitivities[*b].total_cmp(&sensitivities[*a]).then(a.cmp(b)));
        let joining: Vec<usize> = order.into_iter().take(JOINING).map(|q| places[q]).collect();
        let mut parts = Parts::default();
        let shares = now.clone();
        let start = self.values(std::slice::from_ref(&now), &mut parts)?[0];
        let (mut value, mut step, mut idle, mut tried) = (start, samples / 8, 0, 1);
        if self.is_joint() {
            let starts = self.starts(&now, &least)?;
            let values = self.values(&starts, &mut parts)?;
            tried += values.len();
            if let Some(best) = best_of(&values).filter(|best| values[*best] > value) {
                (now, value) = (starts[best].clone(), values[best]);
            }
        }
        for round in 0..self.searched().1 {
            let neighbours = self.neighbours(&now, (&joining, &least), step, round as u32);
            let values = self.values(&neighbours, &mut parts)?;
            tried += values.len();
            match best_of(&values).filter(|best| values[*best] > value + 1e-9 * value.abs().max(1.0)) {
                Some(best) => (now, value, idle) = (neighbours[best].clone(), values[best], 0),
                None => idle += 1,
            }
            if idle == PATIENCE {
                (step, idle) = (step / 2, 0);
                if step < 2 {
                    break;
                }
            }
        }
        if !value.is_finite() {
            let seconds = samples as f64 / self.vessel.sample_rate_hz;
            let value = format!("no sequence of {seconds} s that tells every parameter");
            let remedy = "lengthen the trial, fix parameters, or leave it out";
            return Err(Invalid::new("--arrange", value, "one", remedy));
        }
        let compared = if self.is_joint() {
            self.compared(now.clone(), shares, &least, &mut parts)?
        } else {
            Vec::new()
        };
        let promised: Vec<Promised> = compared.iter().map(|(_, promised)| *promised).collect();
        if let Some((plan, _)) = compared.into_iter().next().filter(|(plan, _)| *plan != now) {
            value = self.values(std::slice::from_ref(&plan), &mut parts)?[0];
            now = plan;
        }
        let gain = libm::exp((value - start.max(LOWEST)) / self.degree()) - 1.0;
        let (initial, inputs) = parts.joined(&now);
        let run = (initial, self.vessel.model.undisturbed(&inputs));
        let value = self.criterion_of(&run).unwrap_or(value);
        let foretold = promised.first().map_or_else(|| self.foretold(run), |first| first.errors);
        let limits = self.kept(&(initial, inputs));
        let name = |(q, n): &(usize, usize)| (self.generator.maneuvers()[*q].name.clone(), *n);
        Ok(Arranged { parts: now.iter().map(name).collect(), value, gain, tried, limits, foretold, promised })
    }

    /// Neighbours of a round, and rounds.
    fn searched(&self) -> (usize, usize) {
        if self.vessel.model.has_regressors() { SEARCHED } else { SEARCHED_OF_FORCES }
    }

    /// Whether the motion from `initial` under `inputs` keeps the limits.
    fn kept(&self, (initial, inputs): &([f64; 3], Vec<f64>)) -> Kept {
        let Some(limits) = generated_limits(self.generator) else { return Kept::Unlimited };
        let model = &self.vessel.model;
        let states = simulate_one(model, self.generator.parameters(), *initial, &model.undisturbed(inputs));
        limits.exceeded(model, &states, inputs, self.vessel.sample_rate_hz).map_or(Kept::Within, Kept::Beyond)
    }

    /// The generator's index of every maneuver of the dictionary.
    fn places(&self) -> Result<Vec<usize>, Invalid> {
        let known: BTreeMap<&str, usize> =
            self.generator.maneuvers().iter().enumerate().map(|(i, m)| (m.name.as_str(), i)).collect();
        let place = |name: &String| {
            known.get(name.as_str()).copied().ok_or_else(|| {
                let remedy = "name the dictionary that the moments were made with";
                Invalid::new("maneuvers", format!("no `{name}`"), "the maneuvers of the moments", remedy)
            })
        };
        self.dictionary.maneuvers.iter().map(place).collect()
    }

    /// Plans at a distance of one to three moves.
    fn neighbours(
        &self,
        now: &Plan,
        (joining, least): (&[usize], &BTreeMap<usize, usize>),
        step: usize,
        round: u32,
    ) -> Vec<Plan> {
        let streams = Streams::new(self.seed, "sequence");
        let neighbours = self.searched().0;
        let mut bits = streams.choices(round, 0, u32::MAX, 16 * neighbours).into_iter();
        let mut draw = move |below: usize| bits.next().unwrap_or(0) as usize % below.max(1);
        let neighbour = |_| {
            let mut plan = now.clone();
            for _ in 0..1 + draw(3) {
                let (from, to) = (draw(plan.len()), draw(plan.len()));
                match draw(if self.is_joint() { 8 } else { 5 }) {
                    0 => plan.swap(from, to),
                    1 => {
                        let part = plan.remove(from);
                        plan.insert(to.min(plan.len()), part);
                    }
                    2 => {
                        let new = joining[draw(joining.len())];
                        let taken = plan[from].1.min(step.max(4).max(least[&new]));
                        plan[from].1 -= taken;
                        plan.insert(to, (new, taken));
                    }
                    // Half a piece at another place, a piece once more, and another maneuver in its place
                    5 => {
                        let half = plan[from].1 / 2;
                        plan[from].1 -= half;
                        plan.insert(to, (plan[from].0, half));
                    }
                    6 => {
                        let (copied, taken) = (plan[from].0, plan[from].1.min(plan[to].1 / 2));
                        plan[to].1 -= taken;
                        plan.insert(draw(plan.len() + 1), (copied, taken));
                    }
                    7 => plan[from].0 = joining[draw(joining.len())],
                    _ => {
                        let taken = plan[from].1.min(1 + draw(step));
                        plan[from].1 -= taken;
                        plan[to].1 += taken;
                    }
                }
            }
            let plan = self.settled(plan, least);
            if self.is_whole(&plan) { plan } else { now.clone() }
        };
        (0..neighbours).map(neighbour).collect()
    }

    /// Whether every table is played at its own length.
    fn is_whole(&self, plan: &Plan) -> bool {
        let tables = self.generator.tables();
        plan.iter().all(|(q, n)| tables.get(q).is_none_or(|table| table.samples == *n))
    }

    /// Least samples of a piece of each of the maneuvers at `places`.
    fn least(&self, places: &[usize]) -> Result<BTreeMap<usize, usize>, Invalid> {
        let least = |&q: &usize| Ok((q, (LEAST * self.generator.samples(q)? as f64).ceil() as usize));
        places.iter().map(least).collect()
    }

    /// `plan` without parts of no samples, its neighbours of the same maneuver merged, except tables, and pieces that are too short
    /// lengthened or given to the longest of the others.
    fn settled(&self, plan: Plan, least: &BTreeMap<usize, usize>) -> Plan {
        let is_table = |q: usize| self.generator.tables().contains_key(&q);
        let mut plan = merged(plan, is_table);
        let too_short = |plan: &Plan| plan.iter().position(|(q, n)| !is_table(*q) && *n < least[q]);
        while let Some(short) = too_short(&plan) {
            let spare = |i: &usize| plan[*i].1.saturating_sub(least[&plan[*i].0]);
            let others = (0..plan.len()).filter(|i| *i != short && !is_table(plan[*i].0));
            let Some(longest) = others.max_by_key(spare) else { break };
            let missing = least[&plan[short].0] - plan[short].1;
            if missing <= plan[short].1.min(spare(&longest)) {
                plan[longest].1 -= missing;
                plan[short].1 += missing;
            } else {
                plan[longest].1 += plan[short].1;
                plan.remove(short);
            }
            plan = merged(plan, is_table);
        }
        plan
    }

    /// The criterion's value of every plan; minus infinity where it is undefined.
    fn values(&self, plans: &[Plan], parts: &mut Parts) -> Result<Vec<f64>, Invalid> {
        plans.iter().try_for_each(|plan| parts.make(self.generator, plan))?;
        let runs: Vec<([f64; 3], Vec<f64>)> = plans.iter().map(|plan| parts.joined(plan)).collect();
        let groups: Vec<Vec<f64>> = runs.par_chunks(LANES).map(|group| self.group(group)).collect();
        Ok(groups.into_iter().flatten().collect())
    }
}

/// Where the largest of `values` stands.
fn best_of(values: &[f64]) -> Option<usize> {
    (0..values.len()).max_by(|a, b| values[*a].total_cmp(&values[*b]))
}

/// Removes parts of no samples from `plan` and merges neighbours of the same maneuver unless it is played `whole`.
pub fn merged(plan: Plan, whole: impl Fn(usize) -> bool) -> Plan {
    let mut out: Plan = Vec::with_capacity(plan.len());
    for (maneuver, samples) in plan.into_iter().filter(|(_, n)| *n > 0) {
        match out.last_mut().filter(|(last, _)| *last == maneuver && !whole(maneuver)) {
            Some(last) => last.1 += samples,
            None => out.push((maneuver, samples)),
        }
    }
    out
}
