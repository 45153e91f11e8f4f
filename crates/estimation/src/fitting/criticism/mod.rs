//! What is wrong with a fitted ship: signs of geometry, inputs that act late, and forces that she lacks.
//!
//! Signs come first. Each is turned by itself and the ship is fitted again from there ([`Turn`]). If no sign is wrong, the
//! fit is tested for what it lacks: products of motion and inputs as forces, and inputs that act later than they are logged.
//! A candidate has a number that is 0 in the model. Its score is the derivative of half the cost by that number, from which
//! what the fitted numbers and the starts of windows can explain is taken away: g = Σ Jᵀe, H = Σ JᵀJ. It would lower the
//! cost by g²/H. Windows, or pieces of them, are independent units: z = g/√V, V the sum of their squared scores. The
//! probability counts all candidates: signs of the units are drawn anew, and the largest |z| of a draw is compared.

mod candidates;
mod sign_test;

use numerics::scaled_inverse;
use numerics::statistics::log_chi_square_tail;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use ship::forces::{Channel, Forces};

use super::sums::{AT_ONCE, Reduced, WindowSums};
use super::{Fit, Pass, Problem, Unfit, at_bound, block};
use crate::criticism::{Absent, Criticism, LEVEL, Suspect, Verdict, change, number, statements};
use candidates::{CandidateBlock, Column, ForceProduct, Measure, products};
use sign_test::Alternative;

use sign_test::Lateness;

/// Candidates whose gain is at least this share of the largest may be what is missing, too.
const CLOSE: f64 = 0.8;
/// Most inputs for which lag and dead time are compared.
const MOST_LATE: usize = 3;

/// The channels of a ship, in the order of a row.
#[derive(Clone, Copy, Debug)]
pub struct Channels<'a> {
    /// Inputs, then measured disturbances.
    pub all: &'a [Channel],
    /// Number of inputs.
    pub inputs: usize,
}

/// Steps of a search after which numbers still have an effect.
const ASTRAY: usize = 3;
/// With fewer independent units for each number only gross faults show.
const FEW: usize = 2;

impl Problem<'_> {
    /// What is wrong with the ship of this `fit`: signs, and only where these are right what she lacks.
    ///
    /// # Errors
    /// A start of a window or a number that nothing determines.
    pub fn criticise(&self, fit: &Fit, channels: Channels) -> Result<Criticism, Unfit> {
        let mut criticism = Criticism { absent: self.signs(fit, channels.all), ..Criticism::default() };
        let wrong = criticism.wrong_signs().next().is_some();
        if !wrong {
            self.scored(fit, channels, &mut criticism)?;
        }
        sort(&mut criticism.absent);
        criticism.rejected = wrong || criticism.p_value.is_some_and(|p_value| p_value < LEVEL);
        criticism.verdict = if criticism.rejected { Verdict::Rejected } else { Verdict::NotRejected };
        criticism.statements = statements(&criticism, false);
        let numbers = self.forces.parameters().len();
        let few = criticism.units.filter(|units| !criticism.rejected && (*units as usize) < FEW * numbers);
        let few = few
            .map(|u| format!("{u} independent pieces for {numbers} numbers would show gross faults alone"));
        criticism.statements.extend(wrong.then(|| NOT_TESTED.to_owned()).or(few));
        Ok(criticism)
    }

    /// Why the fit from `theta` failed by `error`: a wrong sign, where one explains that it came to no end.
    pub fn explained(&self, error: Unfit, theta: &[f64], channels: Channels) -> Unfit {
        let steps = match error {
            Unfit::Unfinished(steps) => steps,
            // Where a wrong sign leads astray, numbers lose their effect.
            Unfit::Undetermined(_) => ASTRAY,
            _ => return error,
        };
        let Ok((fit, _)) = Pass::new(self, None).search(theta, steps.min(self.settings.most_steps)) else {
            return error;
        };
        let mut signs = self.signs(&fit, channels.all);
        sort(&mut signs);
        match signs.into_iter().next().filter(|sign| sign.candidate) {
            Some(sign) => Unfit::WrongSign(steps, sign.name),
            None => error,
        }
    }

    fn signs(&self, fit: &Fit, channels: &[Channel]) -> Vec<Absent> {
        let alternatives = Alternative::all(self.forces, channels);
        let count = alternatives.len();
        alternatives.iter().map(|alternative| self.sign_test(fit, alternative, count)).collect()
    }

    fn scored(&self, fit: &Fit, channels: Channels, criticism: &mut Criticism) -> Result<(), Unfit> {
        let inputs = inputs(self.forces, channels.inputs);
        let terms = products(self.forces, channels.all, channels.inputs);
        let (blocks, measures) = self.blocks(&inputs, &terms, channels.all)?;
        let (all, units) = Pass::new(self, fit.first).scores(fit, &blocks)?;
        let testable: Vec<&Score> = all.iter().flatten().collect();
        let mut probabilities = probabilities(&testable).into_iter();
        let mut judged = all.iter().map(|score| {
            let (score, p_value) = (score.as_ref()?, probabilities.next()?);
            let (value, error) = score.value();
            let log_p = log_chi_square_tail(score.standardised().powi(2), 1);
            let share = Some(fit.share(score.gain()));
            Some(Absent { share, ..Absent::scored(vec![value], vec![error], log_p, p_value) })
        });
        let names = inputs.iter().map(|input| channels.all[*input].name.clone());
        let mut late: Vec<Absent> = names
            .zip(judged.by_ref())
            .filter_map(|(name, tested)| {
                Some(Absent { kind: Suspect::Late, name, unit: "s".to_owned(), ..tested? })
            })
            .collect();
        for ((product, (unit, prime)), tested) in terms.into_iter().zip(measures).zip(judged) {
            let (degree, name) = (["surge", "sway", "yaw"][product.degree].to_owned(), product.text);
            match tested {
                Some(tested) => criticism.absent.push(Absent {
                    prime_value: prime.map(|one| tested.value[0] / one),
                    name,
                    degree: Some(degree),
                    unit,
                    ..tested
                }),
                None => criticism.hidden.push(format!("`{name}` in {degree}")),
            }
        }
        let tested = late.iter().chain(criticism.absent.iter().filter(|absent| absent.kind == Suspect::Term));
        criticism.p_value = tested.map(|absent| absent.p_value).reduce(f64::min);
        criticism.units = Some(units as u64);
        self.compare_late(fit, channels.all, &mut late);
        criticism.absent.extend(late);
        Ok(())
    }

    fn blocks(
        &self,
        inputs: &[usize],
        terms: &[ForceProduct],
        channels: &[Channel],
    ) -> Result<(Vec<CandidateBlock>, Vec<Measure>), Unfit> {
        let late = inputs.chunks(AT_ONCE).map(|chunk| CandidateBlock::Late(chunk.to_vec()));
        let (mut blocks, mut measures): (Vec<_>, Vec<_>) = (late.collect(), Vec::new());
        for chunk in terms.chunks(AT_ONCE) {
            let (block, more) = CandidateBlock::terms(self.forces, chunk, channels)?;
            blocks.push(block);
            measures.extend(more);
        }
        Ok((blocks, measures))
    }

    /// Says of inputs that act late for certain whether they do by a dead time or by a lag.
    fn compare_late(&self, fit: &Fit, channels: &[Channel], late: &mut [Absent]) {
        late.sort_by(|one, other| other.share.unwrap_or(0.0).total_cmp(&one.share.unwrap_or(0.0)));
        for input in late.iter_mut().filter(|input| input.p_value < LEVEL).take(MOST_LATE) {
            let Some(channel) = channels.iter().position(|channel| channel.name == input.name) else {
                continue;
            };
            let of = |kind: Lateness| {
                let (seconds, share) = self.delay_test(fit, channel, kind, input.value[0])?;
                Some((
                    format!("as a {kind} of {} s the cost changes by {}", number(seconds), change(share)),
                    share,
                ))
            };
            let later = input.value[0] > 0.0;
            let mut kinds: Vec<_> =
                [Lateness::DeadTime, Lateness::Lag].into_iter().filter(|_| later).filter_map(of).collect();
            kinds.sort_by(|one, other| other.1.total_cmp(&one.1));
            let kinds: Vec<String> = kinds.into_iter().map(|(words, _)| words).collect();
            let check = if later { "check its actuator and clocks" } else { "check clocks" };
            input.remedy =
                Some(std::iter::once(check.to_owned()).chain(kinds).collect::<Vec<_>>().join("; "));
        }
    }
}

/// Why there are no tests of lags and forces.
const NOT_TESTED: &str =
    "lags and missing forces are not tested: with a wrong sign they would make up for it";

/// Inputs whose lateness can be tested: those that do not go around.
fn inputs(forces: &Forces, count: usize) -> Vec<usize> {
    let description = forces.description();
    let azimuths = (0..description.thruster.len()).filter_map(|i| Some(forces.thruster_inputs(i).1?.channel));
    let winds = (0..description.wind.len()).map(|i| forces.wind_inputs(i)[1].channel);
    let around: Vec<usize> = azimuths.chain(winds).collect();
    (0..count).filter(|input| !around.contains(input)).collect()
}

/// Those that are not chance first, signs before others, then by their gain; marks those that may be what is missing.
fn sort(all: &mut [Absent]) {
    let is_sign = |absent: &Absent| absent.kind == Suspect::Sign;
    let certain = |absent: &Absent| if is_sign(absent) { absent.candidate } else { absent.p_value < LEVEL };
    let order = |absent: &Absent| (!certain(absent), !(certain(absent) && is_sign(absent)));
    let gain = |absent: &Absent| absent.share.unwrap_or(f64::NEG_INFINITY);
    all.sort_by(|one, other| order(one).cmp(&order(other)).then(gain(other).total_cmp(&gain(one))));
    let most = all.iter().find(|absent| !is_sign(absent)).map_or(0.0, gain);
    for absent in all.iter_mut().filter(|absent| !is_sign(absent)) {
        absent.candidate = certain(absent) && gain(absent) >= CLOSE * most;
    }
}

/// A candidate whose derivatives the fitted numbers explain but for this share cannot be told from them.
const LEFT: f64 = 1e-6;
/// Share of the weight of priors that is kept: more would let candidates make up for them.
const KEPT: f64 = 1e-4;
/// Windows are the independent units where there are so many for each number that they determine; else pieces are.
const ENOUGH: f64 = 4.0;

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Score {
    /// g: half the derivative of the cost by its number.
    pub gradient: f64,
    /// H: half its second derivative.
    pub curvature: f64,
    pub units: Vec<f64>,
}

impl Score {
    /// z: the gradient in its standard deviations.
    pub fn standardised(&self) -> f64 {
        self.gradient / self.variance().sqrt().max(f64::MIN_POSITIVE)
    }

    /// V.
    pub fn variance(&self) -> f64 {
        self.units.iter().map(|part| part * part).sum()
    }

    /// By how much the cost would fall if it were added.
    pub fn gain(&self) -> f64 {
        self.gradient * self.gradient / self.curvature
    }

    /// Its number if it were added, and the standard error of that.
    pub fn value(&self) -> (f64, f64) {
        (-self.gradient / self.curvature, self.variance().sqrt() / self.curvature)
    }
}

/// The inverse second derivatives of half the cost by the free numbers, and what is left of its first ones.
struct Fitted {
    free: Vec<usize>,
    inverse: Vec<f64>,
    gradient: Vec<f64>,
    used: f64,
}

/// The sums of a window, what is left of them by θ, and its columns of all candidates.
type Windowed<'a> = (&'a WindowSums, &'a Reduced, &'a Vec<Column>);

impl Pass<'_> {
    /// The scores of candidates, none where fitted numbers explain one, and the number of units.
    fn scores(&self, fit: &Fit, blocks: &[CandidateBlock]) -> Result<(Vec<Option<Score>>, usize), Unfit> {
        let groups: Vec<_> = self.groups.iter().zip(&fit.starts).collect();
        let each = groups.par_iter().map(|(group, starts)| self.columns(group, (&fit.theta, starts), blocks));
        let each = each.collect::<Result<Vec<_>, Unfit>>()?;
        let (sums, columns): (Vec<_>, Vec<_>) = each.into_iter().unzip();
        let reduced = self.determined(&sums)?;
        let fitted = self.fitted(fit, &sums, &reduced)?;
        let all = sums.iter().flatten().zip(reduced.iter().flatten()).zip(columns.iter().flatten());
        let windows: Vec<Windowed> = all.map(|((sums, reduced), columns)| (sums, reduced, columns)).collect();
        let whole = windows.len() as f64 >= ENOUGH * fitted.used;
        let count = blocks.iter().map(CandidateBlock::count).sum();
        let of = |j: usize| self.score(&fitted, &windows, j, whole);
        let all: Vec<Option<Score>> = (0..count).into_par_iter().map(of).collect();
        let units = match whole {
            true => windows.len(),
            false => windows.iter().map(|(sums, _, _)| sums.pieces.len()).sum(),
        };
        Ok((all, units))
    }

    fn fitted(&self, fit: &Fit, sums: &[Vec<WindowSums>], reduced: &[Vec<Reduced>]) -> Result<Fitted, Unfit> {
        let n = fit.theta.len();
        let (data, mut gradient) = self.information(n, sums, reduced);
        let pulls = self.prior_gradient(&fit.theta);
        let whole: Vec<f64> = gradient.iter().zip(&pulls).map(|(slope, [_, pull])| slope + pull).collect();
        let held = at_bound(self.forces, &fit.theta, &whole);
        gradient.iter_mut().zip(&pulls).for_each(|(sum, [_, slope])| *sum += KEPT * slope);
        let free: Vec<usize> = (0..n).filter(|i| !held[*i]).collect();
        let m = free.len();
        let mut bread = block(&data, n, &free);
        (0..m).for_each(|i| bread[i * m + i] += KEPT * pulls[free[i]][0]);
        let inverse = scaled_inverse(m, &bread).ok_or_else(|| self.undetermined(&free, &bread))?;
        let used = m as f64 - (0..m).map(|i| KEPT * inverse[i * m + i] * pulls[free[i]][0]).sum::<f64>();
        let gradient = free.iter().map(|i| gradient[*i]).collect();
        Ok(Fitted { free, inverse, gradient, used })
    }

    fn score(&self, fitted: &Fitted, windows: &[Windowed], j: usize, whole: bool) -> Option<Score> {
        let n = self.forces.parameters().len();
        let (mut total, mut square, mut gradient) = (vec![0.0; n], 0.0, 0.0);
        for (sums, _, columns) in windows {
            let (weight, column) = (self.weight(&sums.errors), &columns[j]);
            total.iter_mut().zip(&column.across).for_each(|(sum, entry)| *sum += weight * entry);
            square += weight * column.square;
            gradient += weight * column.scores.iter().sum::<f64>();
        }
        let across: Vec<f64> = fitted.free.iter().map(|i| total[*i]).collect();
        let m = across.len();
        // How the fitted numbers would follow the candidate.
        let follows: Vec<f64> =
            (0..m).map(|i| numerics::dot(&fitted.inverse[i * m..(i + 1) * m], &across)).collect();
        let curvature = square - numerics::dot(&follows, &across);
        if !(curvature > LEFT * square && curvature.is_finite()) {
            return None;
        }
        let gradient = gradient - numerics::dot(&follows, &fitted.gradient);
        let mut units = Vec::new();
        for (sums, reduced, columns) in windows {
            let weight = self.weight(&sums.errors);
            let pieces = sums.scores(reduced, n).into_iter().zip(&columns[j].scores).map(|(known, score)| {
                let known: f64 = fitted.free.iter().zip(&follows).map(|(i, part)| part * known[*i]).sum();
                weight * (score - known)
            });
            match whole {
                true => units.push(pieces.sum()),
                false => units.extend(pieces),
            }
        }
        // Numbers that the recordings determine use up units.
        let count = units.len() as f64;
        let correction = (count / (count - fitted.used).max(1.0)).sqrt();
        units.iter_mut().for_each(|unit| *unit *= correction);
        Some(Score { gradient, curvature, units })
    }
}

const DRAWS: usize = 2000;

/// For each score the probability that any is as large by chance: signs of units are drawn, the same for all.
fn probabilities(scores: &[&Score]) -> Vec<f64> {
    let rows = scores.first().map_or(0, |score| score.units.len());
    let deviations: Vec<f64> = scores.iter().map(|s| s.variance().sqrt().max(f64::MIN_POSITIVE)).collect();
    let standardised: Vec<Vec<f64>> = (0..rows)
        .map(|row| scores.iter().zip(&deviations).map(|(score, std)| score.units[row] / std).collect())
        .collect();
    let draws: Vec<f64> =
        (0..DRAWS as u64).into_par_iter().map(|seed| largest(&standardised, seed)).collect();
    let probability = |score: &&Score| {
        let as_large = draws.iter().filter(|draw| **draw >= score.standardised().abs()).count();
        (as_large + 1) as f64 / (DRAWS + 1) as f64
    };
    scores.iter().map(probability).collect()
}

fn largest(rows: &[Vec<f64>], seed: u64) -> f64 {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut sums = vec![0.0; rows.first().map_or(0, Vec::len)];
    let mut bits = 0;
    for (k, row) in rows.iter().enumerate() {
        if k % 64 == 0 {
            bits = random.next_u64();
        }
        let sign = if bits >> (k % 64) & 1 == 0 { 1.0 } else { -1.0 };
        sums.iter_mut().zip(row).for_each(|(sum, entry)| *sum += sign * entry);
    }
    sums.iter().fold(0.0, |most, sum| sum.abs().max(most))
}
