//! The order of the maneuvers and their lengths, judged with the state carried over from one to the next.

use std::collections::BTreeMap;
use std::path::Path;

use identification::{Batch, Noise, middle, moments, output_information};
use optimal_design::{Candidates, Covariance, CovariancePoint, Evaluation, Objective, apportion};
use rayon::prelude::*;
use vessel::{Generator, LANES, Lane, Limits, Realized, Streams, Vessel, check_diverged, simulate_one};

use super::criterion::{Criterion, CriterionName};
use super::matrices::Estimated;
use crate::documents::{ExpectedDisturbances, MomentsDocument, Sequence, SequencePart};
use crate::failure::Failure;
use crate::instruments::Removal;
use crate::simulate::exogenous;

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
/// What exceeding a limit by all of it costs, in the criterion's value.
const PENALTY: f64 = 20.0;

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

    fn limits(&self) -> Option<&Limits> {
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

    /// Values of up to [`LANES`] runs of equal length.
    fn group(&self, runs: &[([f64; 3], Vec<f64>)]) -> Vec<f64> {
        let model = &self.vessel.model;
        let exogenous: Vec<Vec<f64>> = runs.iter().map(|(_, inputs)| exogenous(model, inputs)).collect();
        let penalty = |i: usize| {
            let Some(limits) = self.limits() else { return 0.0 };
            let states = simulate_one(model, self.generator.parameters(), runs[i].0, &exogenous[i]);
            limits.exceeded(model, &states, &runs[i].1).map_or(0.0, |e| PENALTY * (e.found / e.allowed - 1.0))
        };
        let values = match self.estimated {
            Estimated::Iv(removal) => self.instrumental(runs, &exogenous, removal),
            Estimated::OutputError { current } => {
                (0..runs.len()).map(|i| self.output_error(runs[i].0, &exogenous[i], current)).collect()
            }
        };
        let judged = |(i, value): (usize, Option<f64>)| value.map_or(f64::NEG_INFINITY, |v| v - penalty(i));
        values.into_iter().enumerate().map(judged).collect()
    }

    fn disturbances(&self) -> Option<(&ExpectedDisturbances, Noise)> {
        let d = self.moments.disturbances.as_ref()?;
        let measurement = [d.std_u_m_s, d.std_v_m_s, d.std_r_rad_s];
        Some((d, Noise { measurement, current: d.current_std_m_s }))
    }

    /// θ in the model's order.
    fn ordered(&self, by_name: &BTreeMap<String, f64>) -> Option<Vec<f64>> {
        self.vessel.model.parameter_names().map(|name| by_name.get(name).copied()).collect()
    }

    fn output_error(&self, initial: [f64; 3], exogenous: &[f64], current: bool) -> Option<f64> {
        let (_, noise) = self.disturbances()?;
        let theta = self.ordered(&self.moments.output_error.as_ref()?.parameters)?;
        let noise = if current { noise } else { Noise { current: 0.0, ..noise } };
        let found = output_information(&self.vessel.model, &theta, initial, exogenous, &noise)?;
        let middle: Vec<f64> = found.measurement.iter().zip(&found.process).map(|(e, p)| e + p).collect();
        self.judge(vec![found.information.len().isqrt()], &found.information, Some(&middle))
    }

    fn instrumental(
        &self,
        runs: &[([f64; 3], Vec<f64>)],
        exogenous: &[Vec<f64>],
        removal: Removal,
    ) -> Vec<Option<f64>> {
        let nothing = vec![None; runs.len()];
        let model = &self.vessel.model;
        let theta = match self.disturbances() {
            Some((d, _)) => self.ordered(&d.parameters),
            None => Some(self.generator.parameters().to_vec()),
        };
        let Some(theta) = theta else { return nothing };
        let last = runs.len() - 1;
        let simulated = |theta: &[f64]| -> Vec<Vec<f64>> {
            let run = |i: usize| simulate_one(model, theta, runs[i].0, &exogenous[i]);
            (0..runs.len()).map(run).collect()
        };
        let lanes = |rows: &[Vec<f64>]| -> Vec<Lane> {
            (0..rows[0].len()).map(|k| Lane(std::array::from_fn(|lane| rows[lane.min(last)][k]))).collect()
        };
        let (own, nominal) = (simulated(&theta), simulated(&self.vessel.nominal));
        let (measured, instrument_states, inputs) = (lanes(&own), lanes(&nominal), lanes(exogenous));
        let batch = Batch {
            model,
            measured: &measured,
            instrument_states: &instrument_states,
            exogenous: &inputs,
            segments: [&[0]; LANES],
        };
        let found = moments(&batch);
        let middles = self.disturbances().map(|(_, noise)| middle(&batch, &theta, &noise));
        let sizes: Vec<usize> = model.degrees.iter().map(|d| d.terms.len() + 1).collect();
        let kept =
            sizes.iter().map(|n| if removal == Removal::Complete { *n } else { n - 1 }).collect::<Vec<_>>();
        let of = |i: usize| {
            let finite = |states: &[f64]| check_diverged(states.iter().copied()).is_none();
            if !(finite(&own[i]) && finite(&nominal[i])) {
                return None;
            }
            let cut = |matrices: &[Vec<f64>]| -> Vec<f64> {
                let of = |(matrix, (n, kept)): (&Vec<f64>, (&usize, &usize))| {
                    let (n, kept) = (*n, *kept);
                    (0..kept * kept).map(|e| matrix[e / kept * n + e % kept]).collect::<Vec<f64>>()
                };
                matrices.iter().zip(sizes.iter().zip(&kept)).flat_map(of).collect()
            };
            let middle = middles.as_ref().map(|m| cut(&m[i]));
            self.judge(kept.clone(), &cut(&found[i].matrices), middle.as_deref())
        };
        (0..runs.len()).map(of).collect()
    }

    /// The criterion of one experiment.
    fn judge(&self, dimensions: Vec<usize>, information: &[f64], middle: Option<&[f64]>) -> Option<f64> {
        let one = |entries: &[f64]| {
            let mut candidates = Candidates::new(dimensions.clone());
            candidates.push(entries).ok().map(|()| candidates)
        };
        let information = one(information)?;
        let Criterion::Covariance(criterion) = self.criterion else {
            let (scaled, offset) = information.scaled().ok()?;
            return scaled.value(&[1.0], &mut Evaluation::default()).map(|value| value + offset);
        };
        let middle = one(middle?)?;
        let covariance = match self.name {
            CriterionName::V => {
                let weights = self.moments.output_error.as_ref()?.g.clone()?;
                Covariance::of_matrices(&information, &middle, &[weights])
            }
            _ => Covariance::new(
                &information,
                &middle,
                &self.rows(&criterion.weights),
                criterion.covariance.norm(),
            ),
        };
        covariance.ok()?.value(&[1.0], &mut CovariancePoint::default())
    }

    /// Weights of all rows: 0 for intercepts.
    fn rows(&self, weights: &[f64]) -> Vec<f64> {
        let mut rest = weights.iter().copied();
        let mut rows = Vec::new();
        for degree in &self.vessel.model.degrees {
            rows.extend(rest.by_ref().take(degree.terms.len()));
            if self.estimated.has_intercepts() {
                rows.push(0.0);
            }
        }
        rows
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
