//! The order of the maneuvers and their lengths, judged with the state carried over from one to the next.

use std::collections::BTreeMap;
use std::path::Path;

use design::apportion;
use rayon::prelude::*;
use vessel::{Generator, LANES, Limits, Realized, Streams, Vessel, simulate_one};

use super::criterion::{Criterion, CriterionName};
use super::matrices::Estimated;
use crate::failure::Failure;
use crate::simulate::exogenous;
use study::documents::{MomentsDocument, Sequence, SequencePart};

/// Maneuver and samples, one after the other.
type Plan = Vec<(usize, usize)>;

/// What a sequence is judged with.
pub struct Sequencing<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// The maneuvers.
    pub generator: &'a Generator,
    /// The dictionary's file, for messages.
    pub dictionary_file: &'a Path,
    /// The moments of the same maneuvers.
    pub moments: &'a MomentsDocument,
    /// The criterion.
    pub name: CriterionName,
    /// The criterion with its weights.
    pub criterion: &'a Criterion,
    /// The estimate that it is about.
    pub estimated: Estimated,
    /// Seed of the search.
    pub seed: u64,
}

/// Neighbours that are judged in one round.
const NEIGHBOURS: usize = 48;
/// Rounds of the search at most.
const ROUNDS: usize = 90;
/// Rounds without a better neighbour before steps become smaller.
const PATIENCE: usize = 3;
/// Maneuvers that may join, the most sensitive.
const JOINING: usize = 12;

impl Sequencing<'_> {
    /// The best sequence that a local search finds from the dictionary's order: segments trade samples, change places, or make
    /// room for others. `shares`: of the maneuvers, with their `sensitivities`.
    ///
    /// # Errors
    /// A dictionary without the moments' maneuvers; a motion that the model cannot hold.
    pub fn search(&self, shares: &[f64], sensitivities: &[f64], samples: usize) -> Result<Sequence, Failure> {
        let places = self.places()?;
        let counts = apportion(shares, samples as u64);
        let used = (0..counts.len()).filter(|q| counts[*q] > 0);
        let mut now: Plan = used.map(|q| (places[q], counts[q] as usize)).collect();
        now.sort_unstable();
        let mut order: Vec<usize> = (0..places.len()).collect();
        order.sort_by(|a, b| sensitivities[*b].total_cmp(&sensitivities[*a]).then(a.cmp(b)));
        let joining: Vec<usize> = order.into_iter().take(JOINING).map(|q| places[q]).collect();
        let mut realized = BTreeMap::new();
        let start = self.values(std::slice::from_ref(&now), &mut realized)?[0];
        let (mut value, mut step, mut idle, mut tried) = (start, samples / 8, 0, 1);
        for round in 0..ROUNDS {
            let neighbours = self.neighbours(&now, &joining, step, round as u32);
            let values = self.values(&neighbours, &mut realized)?;
            tried += values.len();
            let best = (0..values.len()).max_by(|a, b| values[*a].total_cmp(&values[*b]));
            match best.filter(|best| values[*best] > value + 1e-9 * value.abs().max(1.0)) {
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
        self.document(&now, start, value, tried, &mut realized)
    }

    fn document(
        &self,
        plan: &Plan,
        start: f64,
        value: f64,
        tried: usize,
        realized: &mut BTreeMap<(usize, usize), Realized>,
    ) -> Result<Sequence, Failure> {
        let gain = ((value - start) / self.criterion.degree()).exp() - 1.0;
        let (initial, inputs) = self.joined(plan, realized)?;
        let exceeded = self.limits().and_then(|limits| {
            let exogenous = exogenous(&self.vessel.model, &inputs);
            let states = simulate_one(&self.vessel.model, self.generator.parameters(), initial, &exogenous);
            limits.exceeded(&self.vessel.model, &states, &inputs)
        });
        let limits = match (self.limits(), exceeded) {
            (None, _) => String::new(),
            (Some(_), None) => "; it keeps the limits of the generated maneuvers".into(),
            (Some(_), Some(e)) => format!(
                "; between maneuvers it reaches {:.3} where {} allows {}",
                e.found, e.limit, e.allowed
            ),
        };
        let name = |q: usize| self.generator.maneuvers()[q].name.clone();
        Ok(Sequence {
            parts: plan
                .iter()
                .map(|(q, n)| SequencePart { maneuver: name(*q), samples: *n as u64 })
                .collect(),
            samples: plan.iter().map(|(_, n)| *n as u64).sum(),
            value,
            statement: format!(
                "The best of {tried} sequences that a local search judged with the state carried over: worth {:.1} % more time than \
                 the same shares in the dictionary's order; not proved best{limits}.",
                100.0 * gain
            ),
        })
    }

    /// The generator's place of every maneuver of the moments.
    fn places(&self) -> Result<Vec<usize>, Failure> {
        let known: BTreeMap<&str, usize> =
            self.generator.maneuvers().iter().enumerate().map(|(i, m)| (m.name.as_str(), i)).collect();
        let place = |name: &String| {
            known.get(name.as_str()).copied().ok_or_else(|| {
                Failure::refuse(
                    self.dictionary_file,
                    "maneuvers",
                    &format!("no `{name}`"),
                    "the maneuvers of the moments",
                    "name the dictionary that the moments were made with",
                )
            })
        };
        self.moments.maneuvers.iter().map(|m| place(&m.name)).collect()
    }

    pub(super) fn limits(&self) -> Option<&Limits> {
        (0..self.generator.maneuvers().len()).rev().find_map(|q| self.generator.limits(q))
    }

    /// Plans a step away, each by one to three moves.
    fn neighbours(&self, plan: &Plan, joining: &[usize], step: usize, round: u32) -> Vec<Plan> {
        let streams = Streams::new(self.seed, "sequence");
        let mut bits = streams.choices(round, 0, u32::MAX, 16 * NEIGHBOURS).into_iter();
        let mut draw = move |below: usize| bits.next().unwrap_or(0) as usize % below.max(1);
        (0..NEIGHBOURS)
            .map(|_| {
                let mut plan = plan.clone();
                for _ in 0..1 + draw(3) {
                    let (from, to) = (draw(plan.len()), draw(plan.len()));
                    match draw(5) {
                        0 => plan.swap(from, to),
                        1 => {
                            let part = plan.remove(from);
                            plan.insert(to.min(plan.len()), part);
                        }
                        2 => {
                            let taken = plan[from].1.min(step.max(4));
                            let new = joining[draw(joining.len())];
                            plan[from].1 -= taken;
                            plan.insert(to, (new, taken));
                        }
                        _ => {
                            let taken = plan[from].1.min(1 + draw(step));
                            plan[from].1 -= taken;
                            plan[to].1 += taken;
                        }
                    }
                }
                joined(plan)
            })
            .collect()
    }

    /// The criterion's value of every plan; minus infinity where it is not defined.
    fn values(
        &self,
        plans: &[Plan],
        realized: &mut BTreeMap<(usize, usize), Realized>,
    ) -> Result<Vec<f64>, Failure> {
        let runs: Vec<([f64; 3], Vec<f64>)> =
            plans.iter().map(|plan| self.joined(plan, realized)).collect::<Result<_, _>>()?;
        let groups: Vec<Vec<f64>> = runs.par_chunks(LANES).map(|group| self.group(group)).collect();
        Ok(groups.into_iter().flatten().collect())
    }

    /// Initial state and inputs of a plan.
    fn joined(
        &self,
        plan: &Plan,
        realized: &mut BTreeMap<(usize, usize), Realized>,
    ) -> Result<([f64; 3], Vec<f64>), Failure> {
        let mut inputs = Vec::new();
        for part in plan {
            if !realized.contains_key(part) {
                let made = self.generator.realize(part.0, part.1);
                realized.insert(*part, made.map_err(|e| Failure::invalid(self.dictionary_file, &e))?);
            }
            inputs.extend_from_slice(&realized[part].inputs);
        }
        let initial = plan.first().map_or([0.0; 3], |part| realized[part].initial);
        Ok((initial, inputs))
    }
}

/// Without parts of no samples; neighbours of the same maneuver become one.
fn joined(plan: Plan) -> Plan {
    let mut out: Plan = Vec::with_capacity(plan.len());
    for (maneuver, samples) in plan.into_iter().filter(|(_, n)| *n > 0) {
        match out.last_mut().filter(|(last, _)| *last == maneuver) {
            Some(last) => last.1 += samples,
            None => out.push((maneuver, samples)),
        }
    }
    out
}
