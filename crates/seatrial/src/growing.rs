//! Forces that are added to a ship one after the other: chosen by their scores, verified on recordings that are left out.

use std::sync::Arc;

use estimation::fitting::{
    AbsentTerm, Channels, Criticism, Fit, Problem, RecordingView as Recording, Settings, Unfit,
};
use refusal::Invalid;
use regression::pooled::Part;
use ship::forces::{Channel, Description, Forces, TermSpec};
use ship::model::{ForceModel, Vessel};
use study::documents::TriedForce;

use crate::criticism::{channels, degree};

/// Most folds that recordings are dealt into.
const FOLDS: usize = 6;
/// A force is added where the cost of recordings left out falls by at least this share, and by more than its standard error.
const LEAST: f64 = 0.005;
/// Fewest recordings that can verify anything.
pub(crate) const FEWEST: usize = 3;

/// Recordings by name, in parts without gaps.
pub(crate) type Recorded = (String, Vec<Part>);

/// All parts of `sources`, as fits take them.
pub(crate) fn recordings<'r>(sources: impl IntoIterator<Item = &'r Recorded>) -> Vec<Recording<'r>> {
    let part =
        |name: &'r str, own: &'r Part| Recording { name, inputs: &own.exogenous, measured: &own.measured };
    sources.into_iter().flat_map(|(name, parts)| parts.iter().map(move |own| part(name, own))).collect()
}

/// A ship that forces are added to, and the recordings that say which.
pub(crate) struct ForwardSelection<'a> {
    pub(crate) sources: &'a [Recorded],
    pub(crate) settings: Settings,
    pub(crate) most: usize,
    /// Terms of surge, sway and yaw to try in place of the usual products.
    pub(crate) listed: Option<&'a [Vec<String>; 3]>,
}

/// The ship with what was added, what was tried, and why no more was.
pub(crate) struct GrownShip {
    pub(crate) vessel: Vessel,
    pub(crate) tried: Vec<TriedForce>,
    pub(crate) ended: Option<String>,
}

impl ForwardSelection<'_> {
    /// Adds forces to `vessel` until one does not help, nothing is missing beyond chance, or there are as many as were asked for.
    ///
    /// # Errors
    /// No fit.
    pub(crate) fn grown(&self, vessel: &Vessel) -> Result<GrownShip, Unfit> {
        let mut own = GrownShip { vessel: vessel.clone(), tried: Vec::new(), ended: None };
        if self.most > 0 && self.sources.len() < FEWEST {
            let count = self.sources.len();
            own.ended =
                Some(format!("no force was added: {count} recordings verify nothing, at least {FEWEST} do"));
            return Ok(own);
        }
        while own.tried.len() < self.most {
            let Some(forces) = &own.vessel.model.forces else { break };
            let all: Vec<usize> = (0..self.sources.len()).collect();
            let problem = self.problem(&forces.forces, &own.vessel, &all)?;
            let fit = problem.fit_from(&own.vessel.nominal)?;
            let channels = channels(&own.vessel);
            let inputs = own.vessel.model.inputs;
            let found = problem.criticise(&fit, Channels { all: &channels, inputs, listed: self.listed })?;
            let absent = match most_likely(&found) {
                Ok(absent) => absent,
                Err(ended) => {
                    own.ended = Some(ended);
                    break;
                }
            };
            let parameter = name(absent, &own.vessel);
            let richer = match with(&own.vessel, (absent, &parameter), &channels) {
                Ok(richer) => richer,
                Err(invalid) => {
                    own.ended = Some(format!("no further force is added: {invalid}"));
                    break;
                }
            };
            let tried = self.tried([&own.vessel, &richer], (absent, parameter), &fit);
            let added = tried.added;
            own.tried.push(tried);
            if !added {
                own.ended = Some(
                    "no other force is tried after one that recordings left out do not confirm".to_owned(),
                );
                break;
            }
            own.vessel = richer;
        }
        Ok(own)
    }

    /// The recordings at `places`.
    fn problem<'b>(
        &'b self,
        forces: &'b Forces,
        vessel: &Vessel,
        places: &[usize],
    ) -> Result<Problem<'b>, Unfit> {
        let recordings = recordings(places.iter().map(|i| &self.sources[*i]));
        Problem::new(forces, recordings, vessel.model.exogenous(), self.settings)
    }

    /// How the second of `ships`, which has `absent`, follows recordings that were left out of its fit and of that of the first.
    fn tried(
        &self,
        ships: [&Vessel; 2],
        (absent, parameter): (&AbsentTerm, String),
        fit: &Fit,
    ) -> TriedForce {
        let folds = FOLDS.min(self.sources.len());
        let gain = self.gain(ships, folds, fit);
        TriedForce {
            degree: degree(absent).to_owned(),
            term: absent.term.clone(),
            parameter,
            share_left_out: gain.map(|(share, _)| share),
            standard_error: gain.map(|(_, error)| error),
            folds: folds as u64,
            added: gain.is_some_and(|(share, error)| share > error && share >= LEAST),
        }
    }

    /// By which share the cost of recordings left out falls from the one ship to the other, and the standard error of that, over
    /// the folds in which the one has a fit that follows them; `None` where the other has none in some fold, or the one has none
    /// in all but one.
    fn gain(&self, [vessel, richer]: [&Vessel; 2], folds: usize, fit: &Fit) -> Option<(f64, f64)> {
        let (mut costs, mut gains) = (0.0, Vec::new());
        for fold in 0..folds {
            let of =
                |ship| self.left_out(ship, (fold, folds), fit, vessel).ok().filter(|own| own.is_finite());
            let new = of(richer)?;
            let Some(old) = of(vessel) else { continue };
            costs += old;
            gains.push(old - new);
        }
        let count = gains.len() as f64;
        let mean = gains.iter().sum::<f64>() / count;
        let square: f64 = gains.iter().map(|gain| (gain - mean).powi(2)).sum();
        let (one, error) = (costs / count, (square / (count * (count - 1.0))).sqrt());
        (gains.len() > 1 && one > 0.0).then_some((mean / one, error / one))
    }

    /// The cost of the recordings of a fold, by a fit of `ship` to the others that begins at `fit`, a fit of `of`.
    fn left_out(
        &self,
        ship: &Vessel,
        (fold, folds): (usize, usize),
        fit: &Fit,
        of: &Vessel,
    ) -> Result<f64, Unfit> {
        let (own, old) = (forces_of(ship)?, forces_of(of)?);
        let (out, kept): (Vec<usize>, Vec<usize>) = (0..self.sources.len()).partition(|i| i % folds == fold);
        let begun = carried(own, old, &fit.theta);
        let found = self.problem(own, ship, &kept)?.fit_from(&begun)?;
        let none = vec![None; own.parameters().len()];
        Ok(self.problem(own, ship, &out)?.with_priors(none).cost(&found.theta))
    }
}

/// What is most likely missing, or why nothing is added.
fn most_likely(found: &Criticism) -> Result<&AbsentTerm, String> {
    if found.has_wrong_sign() {
        return Err("no force is added while a sign is wrong".to_owned());
    }
    let late = found.late.first().filter(|own| found.rejects() && own.p_value < estimation::fitting::LEVEL);
    let first = found.terms.first().filter(|own| own.candidate);
    match (first, late) {
        (Some(first), Some(late)) if late.share > first.share => Err(format!(
            "no force is added while `{}` acts late by more than any force would explain",
            late.input
        )),
        (Some(first), _) => Ok(first),
        (None, _) => Err("no further force is missing beyond chance".to_owned()),
    }
}

fn forces_of(vessel: &Vessel) -> Result<&Forces, Unfit> {
    vessel.model.forces.as_ref().map(|own| &own.forces).ok_or(Unfit::NoParameter)
}

/// Numbers of the ship `old` for `new`, which has all of its own and others.
fn carried(new: &Forces, old: &Forces, theta: &[f64]) -> Vec<f64> {
    let value = |parameter: &ship::forces::Parameter| {
        let at = old.parameters().iter().position(|known| known.name == parameter.name);
        at.map_or(parameter.nominal, |at| theta[at])
    };
    new.parameters().iter().map(value).collect()
}

/// `vessel` with another force, whose number is 0 with a prior.
///
/// # Errors
/// A product that is no term.
fn with(vessel: &Vessel, named: (&AbsentTerm, &str), channels: &[Channel]) -> Result<Vessel, Invalid> {
    let Some(moved) = &vessel.model.forces else { return Ok(vessel.clone()) };
    let description = richer(moved.forces.description(), named, channels)?;
    let forces = Forces::new(&description, channels)?;
    let old = moved.forces.parameters();
    let nominal = carried(&forces, &moved.forces, &vessel.nominal);
    let truth = |parameter: &ship::forces::Parameter| {
        old.iter().position(|known| known.name == parameter.name).and_then(|at| vessel.value[at])
    };
    let value = forces.parameters().iter().map(truth).collect();
    let mut own = vessel.clone();
    own.model.forces = Some(Arc::new(ForceModel { forces, sample_s: moved.sample_s }));
    Ok(Vessel { nominal, value, ..own })
}

/// The ship with a term whose prior is the usual one of such terms, or as wide as the number that its score promises.
fn richer(
    own: &Description,
    (absent, parameter): (&AbsentTerm, &str),
    channels: &[Channel],
) -> Result<Description, Invalid> {
    let zero = Some(0.0);
    let (nominal, prime) = if absent.prime.is_some() { (None, zero) } else { (zero, None) };
    let spec = TermSpec {
        parameter: parameter.to_owned(),
        term: absent.term.clone(),
        nominal,
        prime,
        ..TermSpec::default()
    };
    let mut all = own.clone();
    all.terms_mut()[absent.degree].push(spec);
    let promised = (absent.value / absent.prime.unwrap_or(1.0)).abs();
    // What is usual holds for motion alone.
    let driven = absent.term.split(' ').any(|part| channels.iter().any(|own| own.name == plain(part)));
    let usual = (!driven).then(|| usual(&all, parameter, channels)).flatten();
    all.with_priors(&[(parameter.to_owned(), usual.unwrap_or(promised))], channels)
}

/// The name in a factor, without modulus and power.
fn plain(factor: &str) -> &str {
    factor.split('^').next().unwrap_or_default().trim_matches('|')
}

/// The usual deviation of the prior of a term alone, where there is one.
fn usual(all: &Description, parameter: &str, channels: &[Channel]) -> Option<f64> {
    let (known, named) = all.with_usual_priors(channels).ok()?;
    named.iter().any(|own| own == parameter).then_some(())?;
    let terms = [&known.surge, &known.sway, &known.yaw].into_iter().flatten();
    terms.into_iter().find(|own| own.parameter == parameter)?.prior
}

/// `N_u_v` of `u v` in yaw, `Y_v_absr` of `v |r|` in sway; with `_more` where the ship has such a name.
fn name(absent: &AbsentTerm, ship: &Vessel) -> String {
    let part = |own: &str| match own.strip_prefix('|').and_then(|own| own.split_once('|')) {
        Some((name, power)) => format!("abs{name}{power}"),
        None => own.replace('/', "per"),
    };
    let parts: Vec<String> = absent
        .term
        .split_whitespace()
        .map(|split_whitespace| part(split_whitespace).replace(['^', '*'], ""))
        .collect();
    let mut name = format!("{}_{}", ["X", "Y", "N"][absent.degree], parts.join("_"));
    while names(ship).any(|own| own == name) {
        name.push_str("_more");
    }
    name
}

/// Names of the numbers of all terms of `ship`.
fn names(ship: &Vessel) -> impl Iterator<Item = &str> {
    let own = ship.model.forces.iter().map(|own| own.forces.description());
    own.flat_map(|own| own.terms()).flatten().map(|own| own.parameter.as_str())
}

/// What was tried, in words.
pub(crate) fn statements(own: &GrownShip) -> Vec<String> {
    let tried = own.tried.iter().map(|own| {
        let verb = if own.added { "added" } else { "not added" };
        let gain = match own.share_left_out.zip(own.standard_error) {
            Some((share, error)) => {
                let change = format!("{:+.1}", -100.0 * share).replace('-', "−");
                format!("cost of recordings left out {change} ± {:.1} %", 100.0 * error)
            }
            None => "with it, or mostly without it, recordings left out have no fit or diverge".to_owned(),
        };
        format!(
            "{verb}: `{}` in {} (`{}`), {gain} in {} folds",
            own.term, own.degree, own.parameter, own.folds
        )
    });
    tried.chain(own.ended.clone()).collect()
}
