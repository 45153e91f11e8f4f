use ship::forces::{Channel, Forces};

use super::chance::probabilities;
use super::columns::{Block, Measure};
use super::late::{LateInput, Lateness};
use super::products::{Product, listed, products};
use super::scores::{Score, Scores};
use super::turn::Alternative;
use super::turned::TurnedSign;
use crate::fitting::pass::Pass;
use crate::fitting::sums::AT_ONCE;
use crate::fitting::{Fit, Problem, Unfit};

/// A model is rejected where chance makes any candidate look as likely with less than this probability.
pub const LEVEL: f64 = 0.05;
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
    /// Terms of surge, sway and yaw to test in place of the usual products.
    pub listed: Option<&'a [Vec<String>; 3]>,
}

impl Channels<'_> {
    /// The products to test.
    fn products(&self, forces: &Forces) -> Result<Vec<Product>, Unfit> {
        match self.listed {
            Some(lists) => listed(forces, self.all, lists),
            None => Ok(products(forces, self.all, self.inputs)),
        }
    }

    /// The number of products that `forces` lacks.
    ///
    /// # Errors
    /// A listed text that is no term.
    pub fn lacking(&self, forces: &Forces) -> Result<usize, Unfit> {
        self.products(forces).map(|own| own.len())
    }
}

/// A product that an equation lacks.
#[derive(Clone, Debug, PartialEq)]
pub struct AbsentTerm {
    /// 0 surge, 1 sway, 2 yaw.
    pub degree: usize,
    /// As it is written.
    pub term: String,
    /// Its number if it were added, in SI units.
    pub value: f64,
    /// The standard error of that.
    pub standard_error: f64,
    /// Its SI unit.
    pub unit: String,
    /// What one of the prime system is in SI units; none with channels that the prime system does not scale.
    pub prime: Option<f64>,
    /// By which share the cost would fall.
    pub share: f64,
    /// How probable it is in a right model that any candidate seems as likely.
    pub p_value: f64,
    /// Whether it may be what is missing: no other lowers the cost by much more.
    pub candidate: bool,
}

/// What is wrong with a fitted ship.
#[derive(Clone, Debug, PartialEq)]
pub struct Criticism {
    /// Signs that were turned, the one with the lowest cost first.
    pub signs: Vec<TurnedSign>,
    /// Inputs, the one that lowers the cost most first. None where a sign is wrong.
    pub late: Vec<LateInput>,
    /// Products, those that are not chance first, and then by how much they lower the cost. None where a sign is wrong.
    pub terms: Vec<AbsentTerm>,
    /// Candidates that the fitted numbers explain, in words.
    pub hidden: Vec<String>,
    /// Independent units of the scores.
    pub units: usize,
    /// Whether these are whole windows; else pieces of them.
    pub whole: bool,
    /// How probable it is in a right model that any candidate seems as likely; none where a sign is wrong.
    pub p_value: Option<f64>,
}

impl Criticism {
    /// Whether a sign is wrong.
    pub fn has_wrong_sign(&self) -> bool {
        self.signs.iter().any(|own| own.wrong)
    }

    /// Whether something is wrong beyond chance.
    pub fn rejects(&self) -> bool {
        self.has_wrong_sign() || self.p_value.is_some_and(|own| own < LEVEL)
    }
}

impl Problem<'_> {
    /// What is wrong with the ship of this `fit`.
    ///
    /// # Errors
    /// A start of a window or a number that nothing determines.
    pub fn criticise(&self, fit: &Fit, channels: Channels) -> Result<Criticism, Unfit> {
        let signs = self.signs(fit, channels.all);
        let mut found = Criticism {
            signs,
            late: Vec::new(),
            terms: Vec::new(),
            hidden: Vec::new(),
            units: 0,
            whole: false,
            p_value: None,
        };
        if !found.has_wrong_sign() {
            self.scored(fit, channels, &mut found)?;
        }
        Ok(found)
    }

    /// Why the fit from `theta` failed by `error`: a wrong sign, where one explains that it came to no end.
    pub fn explained(&self, error: Unfit, theta: &[f64], channels: Channels) -> Unfit {
        let Unfit::Unfinished(steps) = error else { return error };
        let Ok((fit, _)) = Pass::new(self, None).search(theta, self.settings.most_steps) else {
            return error;
        };
        let first = self.signs(&fit, channels.all).into_iter().find(|own| own.wrong);
        first.map_or(error, |own| Unfit::WrongSign(steps, own.turn.to_string()))
    }

    fn signs(&self, fit: &Fit, channels: &[Channel]) -> Vec<TurnedSign> {
        let alternatives = Alternative::all(self.forces, channels);
        let count = alternatives.len();
        let mut signs: Vec<TurnedSign> =
            alternatives.iter().map(|alternative| self.turned(fit, alternative, count)).collect();
        let gain = |own: &TurnedSign| own.share.unwrap_or(f64::NEG_INFINITY);
        signs.sort_by(|one, other| gain(other).total_cmp(&gain(one)));
        signs
    }

    /// Adds scores of late inputs and of products.
    fn scored(&self, fit: &Fit, channels: Channels, found: &mut Criticism) -> Result<(), Unfit> {
        let inputs = inputs(self.forces, channels.inputs);
        let terms = channels.products(self.forces)?;
        let (blocks, measures) = self.blocks(&inputs, &terms, channels.all)?;
        let Scores { all, units, whole } = Pass::new(self, fit.first).scores(fit, &blocks)?;
        let testable: Vec<&Score> = all.iter().flatten().collect();
        let mut probabilities = probabilities(&testable).into_iter();
        let judged = all.iter().map(|own| own.as_ref().zip(own.as_ref().and_then(|_| probabilities.next())));
        let (late, others): (Vec<_>, Vec<_>) = judged.enumerate().partition(|(i, _)| *i < inputs.len());
        found.p_value =
            late.iter().chain(&others).filter_map(|(_, own)| own.map(|(_, p)| p)).reduce(f64::min);
        found.late = late
            .into_iter()
            .filter_map(|(i, own)| own.map(|own| late_input(&channels.all[inputs[i]].name, own, fit)))
            .collect();
        self.compare_late(fit, channels.all, &mut found.late);
        for ((product, measure), (_, own)) in terms.iter().zip(measures).zip(others) {
            match own {
                Some(own) => found.terms.push(absent(product, measure, own, fit)),
                None => found.hidden.push(label(product)),
            }
        }
        sort(&mut found.terms);
        (found.units, found.whole) = (units, whole);
        Ok(())
    }

    fn blocks(
        &self,
        inputs: &[usize],
        terms: &[Product],
        channels: &[Channel],
    ) -> Result<(Vec<Block>, Vec<Measure>), Unfit> {
        let mut blocks: Vec<Block> = inputs.chunks(AT_ONCE).map(|own| Block::Late(own.to_vec())).collect();
        let mut measures = Vec::new();
        for chunk in terms.chunks(AT_ONCE) {
            let (block, more) = Block::terms(self.forces, chunk, channels)?;
            blocks.push(block);
            measures.extend(more);
        }
        Ok((blocks, measures))
    }

    /// Lag and dead time of the inputs that act late beyond chance.
    fn compare_late(&self, fit: &Fit, channels: &[Channel], late: &mut [LateInput]) {
        late.sort_by(|one, other| other.share.total_cmp(&one.share));
        let certain = late.iter_mut().filter(|own| own.p_value < LEVEL && own.late_s > 0.0);
        for own in certain.take(MOST_LATE) {
            let Some(channel) = channels.iter().position(|channel| channel.name == own.input) else {
                continue;
            };
            let of =
                |kind| self.late(fit, channel, kind, own.late_s).map(|(time, share)| (kind, time, share));
            let mut kinds: Vec<_> = [Lateness::DeadTime, Lateness::Lag].into_iter().filter_map(of).collect();
            kinds.sort_by(|one, other| other.2.total_cmp(&one.2));
            own.best = kinds.first().copied();
            own.other = kinds.get(1).map(|(_, _, share)| *share);
        }
    }
}

/// Inputs whose lateness can be tested: those that do not go around.
fn inputs(forces: &Forces, count: usize) -> Vec<usize> {
    let description = forces.description();
    let azimuths = (0..description.thruster.len()).filter_map(|i| Some(forces.thruster_inputs(i).1?.channel));
    let winds = (0..description.wind.len()).map(|i| forces.wind_inputs(i)[1].channel);
    let around: Vec<usize> = azimuths.chain(winds).collect();
    (0..count).filter(|own| !around.contains(own)).collect()
}

fn late_input(name: &str, (score, p_value): (&Score, f64), fit: &Fit) -> LateInput {
    let (late_s, standard_error) = score.value();
    let share = fit.share(score.gain());
    LateInput { input: name.to_owned(), late_s, standard_error, share, p_value, best: None, other: None }
}

fn absent(
    product: &Product,
    (unit, prime): Measure,
    (score, p_value): (&Score, f64),
    fit: &Fit,
) -> AbsentTerm {
    let (value, standard_error) = score.value();
    AbsentTerm {
        degree: product.degree,
        term: product.text.clone(),
        value,
        standard_error,
        unit,
        prime,
        share: fit.share(score.gain()),
        p_value,
        candidate: false,
    }
}

fn label(product: &Product) -> String {
    format!("`{}` in {}", product.text, ["surge", "sway", "yaw"][product.degree])
}

/// Those that are not chance first, then by their gain; marks those that may be what is missing.
fn sort(terms: &mut [AbsentTerm]) {
    let certain = |own: &AbsentTerm| own.p_value < LEVEL;
    terms.sort_by(|one, other| certain(other).cmp(&certain(one)).then(other.share.total_cmp(&one.share)));
    let most = terms.first().filter(|term| certain(term)).map(|own| own.share);
    for own in terms.iter_mut() {
        own.candidate = certain(own) && most.is_some_and(|most| own.share >= CLOSE * most);
    }
}
