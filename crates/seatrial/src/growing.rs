//! Forces that are added to a ship one after the other: chosen by their scores, verified on recordings that are left out.

use std::sync::Arc;

use estimation::criticism::{Absent, Criticism, LEVEL, Suspect};
use estimation::fitting::{Channels, Fit, Problem, RecordingView, Settings, Unfit};
use refusal::Invalid;
use regression::pooled::Part;
use ship::forces::{Channel, Description, Forces, Parameter, TermSpec};
use ship::model::{DegreeOfFreedom, ForceModel, Vessel};
use study::documents::{FittedParameter, ModelDocument, TriedForce};

use crate::criticism::channels;

/// Most folds that recordings are dealt into.
const FOLDS: usize = 6;
/// A force is added where the cost of recordings left out falls by at least this share, and by more than its standard error.
const LEAST: f64 = 0.005;
/// Fewest recordings that can verify anything.
pub(crate) const FEWEST: usize = 3;

/// Recordings by name, in parts without gaps.
pub(crate) type Recorded = (String, Vec<Part>);

/// All parts of `sources`, as fits take them.
pub(crate) fn recordings<'r>(sources: impl IntoIterator<Item = &'r Recorded>) -> Vec<RecordingView<'r>> {
    let all = sources.into_iter().flat_map(|(name, parts)| parts.iter().map(move |part| (name, part)));
    all.map(|(name, part)| RecordingView { name, inputs: &part.exogenous, measured: &part.measured })
        .collect()
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
    pub(crate) fn grown(&self, vessel: &Vessel) -> Result<GrownShip, Unfit> {
        let count = self.sources.len();
        let few = (self.most > 0 && count < FEWEST)
            .then(|| format!("no force was added: {count} recordings verify nothing, at least {FEWEST} do"));
        let mut grown = GrownShip { vessel: vessel.clone(), tried: Vec::new(), ended: few };
        while grown.ended.is_none() && grown.tried.len() < self.most && grown.vessel.model.forces.is_some() {
            let next = self.next(&grown.vessel)?.and_then(|(richer, tried)| {
                let added = tried.added;
                grown.tried.push(tried);
                let unconfirmed = "no other force is tried after one that recordings left out do not confirm";
                added.then_some(richer).ok_or_else(|| unconfirmed.to_owned())
            });
            match next {
                Ok(richer) => grown.vessel = richer,
                Err(ended) => grown.ended = Some(ended),
            }
        }
        Ok(grown)
    }

    /// `vessel` with the force that is most likely missing, and how it was tried; or why no more is added.
    fn next(&self, vessel: &Vessel) -> Result<Result<(Vessel, TriedForce), String>, Unfit> {
        let forces = forces_of(vessel)?;
        let all: Vec<usize> = (0..self.sources.len()).collect();
        let problem = self.problem(forces, vessel, &all)?;
        let fit = problem.fit_from(&vessel.nominal)?;
        let (channels, inputs) = (channels(vessel), vessel.model.inputs);
        let criticism = problem.criticise(&fit, Channels { all: &channels, inputs, listed: self.listed })?;
        Ok(most_likely(&criticism).and_then(|absent| {
            let parameter = name(absent, vessel);
            let richer = with(vessel, (absent, &parameter), &channels)
                .map_err(|invalid| format!("no further force is added: {invalid}"))?;
            let tried = self.tried([vessel, &richer], (absent, parameter), &fit);
            Ok((richer, tried))
        }))
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
    fn tried(&self, ships: [&Vessel; 2], (absent, parameter): (&Absent, String), fit: &Fit) -> TriedForce {
        let folds = FOLDS.min(self.sources.len());
        let gain = self.gain(ships, folds, fit);
        TriedForce {
            degree: absent.degree.clone().unwrap_or_default(),
            term: absent.name.clone(),
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
                |ship| self.left_out(ship, (fold, folds), fit, vessel).ok().filter(|cost| cost.is_finite());
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
        let (new, old) = (forces_of(ship)?, forces_of(of)?);
        let (out, kept): (Vec<usize>, Vec<usize>) = (0..self.sources.len()).partition(|i| i % folds == fold);
        let begun = carried(new, old, &fit.theta);
        let refit = self.problem(new, ship, &kept)?.fit_from(&begun)?;
        let none = vec![None; new.parameters().len()];
        Ok(self.problem(new, ship, &out)?.with_priors(none).cost(&refit.theta))
    }
}

/// What is most likely missing, or why nothing is added.
fn most_likely(criticism: &Criticism) -> Result<&Absent, String> {
    if criticism.wrong_signs().next().is_some() {
        return Err("no force is added while a sign is wrong".to_owned());
    }
    match criticism.absent.first().filter(|absent| absent.p_value < LEVEL) {
        Some(late) if late.kind == Suspect::Late => Err(format!(
            "no force is added while `{}` acts late by more than any force would explain",
            late.name
        )),
        Some(first) if first.kind == Suspect::Term => Ok(first),
        _ => Err("no further force is missing beyond chance".to_owned()),
    }
}

/// The place of the equation that a term is missing in.
fn place(absent: &Absent) -> usize {
    DegreeOfFreedom::ALL.iter().position(|d| absent.degree.as_deref() == Some(d.name())).unwrap_or(0)
}

fn forces_of(vessel: &Vessel) -> Result<&Forces, Unfit> {
    vessel.model.forces.as_ref().map(|moved| &moved.forces).ok_or(Unfit::NoParameter)
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
fn with(vessel: &Vessel, named: (&Absent, &str), channels: &[Channel]) -> Result<Vessel, Invalid> {
    let Some(moved) = &vessel.model.forces else { return Ok(vessel.clone()) };
    let description = richer(moved.forces.description(), named, channels)?;
    let forces = Forces::new(&description, channels)?;
    let old = moved.forces.parameters();
    let nominal = carried(&forces, &moved.forces, &vessel.nominal);
    let truth = |parameter: &ship::forces::Parameter| {
        old.iter().position(|known| known.name == parameter.name).and_then(|at| vessel.value[at])
    };
    let value = forces.parameters().iter().map(truth).collect();
    let mut ship = vessel.clone();
    ship.model.forces = Some(Arc::new(ForceModel { forces, sample_s: moved.sample_s }));
    Ok(Vessel { nominal, value, ..ship })
}

/// The ship with a term whose prior is the usual one of such terms, or as wide as the number that its score promises.
fn richer(
    description: &Description,
    (absent, parameter): (&Absent, &str),
    channels: &[Channel],
) -> Result<Description, Invalid> {
    let zero = Some(0.0);
    let (nominal, prime) = if absent.prime_value.is_some() { (None, zero) } else { (zero, None) };
    let spec = TermSpec {
        parameter: parameter.to_owned(),
        term: absent.name.clone(),
        nominal,
        prime,
        ..TermSpec::default()
    };
    let mut all = description.clone();
    all.terms_mut()[place(absent)].push(spec);
    let promised = absent.prime_value.unwrap_or(absent.value[0]).abs();
    // What is usual holds for motion alone.
    let driven = absent.name.split(' ').any(|p| channels.iter().any(|channel| channel.name == plain(p)));
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
    named.iter().any(|name| name == parameter).then_some(())?;
    let terms = [&known.surge, &known.sway, &known.yaw].into_iter().flatten();
    terms.into_iter().find(|term| term.parameter == parameter)?.prior
}

/// `N_u_v` of `u v` in yaw, `Y_v_absr` of `v |r|` in sway; with `_more` where the ship has such a name.
fn name(absent: &Absent, ship: &Vessel) -> String {
    let part = |factor: &str| match factor.strip_prefix('|').and_then(|factor| factor.split_once('|')) {
        Some((name, power)) => format!("abs{name}{power}"),
        None => factor.replace('/', "per"),
    };
    let parts: Vec<String> =
        absent.name.split_whitespace().map(|factor| part(factor).replace(['^', '*'], "")).collect();
    let mut name = format!("{}_{}", ["X", "Y", "N"][place(absent)], parts.join("_"));
    while names(ship).any(|other| other == name) {
        name.push_str("_more");
    }
    name
}

/// Names of the numbers of all terms of `ship`.
fn names(ship: &Vessel) -> impl Iterator<Item = &str> {
    let descriptions = ship.model.forces.iter().map(|moved| moved.forces.description());
    descriptions.flat_map(|description| description.terms()).flatten().map(|term| term.parameter.as_str())
}

/// What was tried, in words.
pub(crate) fn statements(grown: &GrownShip) -> Vec<String> {
    let tried = grown.tried.iter().map(|force| {
        let verb = if force.added { "added" } else { "not added" };
        let gain = match force.share_left_out.zip(force.standard_error) {
            Some((share, error)) => {
                let change = format!("{:+.1}", -100.0 * share).replace('-', "−");
                format!("cost of recordings left out {change} ± {:.1} %", 100.0 * error)
            }
            None => "with it, or mostly without it, recordings left out have no fit or diverge".to_owned(),
        };
        format!(
            "{verb}: `{}` in {} (`{}`), {gain} in {} folds",
            force.term, force.degree, force.parameter, force.folds
        )
    });
    tried.chain(grown.ended.clone()).collect()
}

/// The estimates of a former fit of the same ship, or of a sister of another size by the prime system, for each free
/// number of `vessel`.
///
/// # Errors
/// A model without forces, another description, or a number that the prime system does not scale.
pub fn former(vessel: &Vessel, model: &ModelDocument) -> Result<Vec<f64>, Invalid> {
    let (Some(moved), Some(fitted)) = (&vessel.model.forces, &model.forces) else {
        let remedy = "name the model of a fit of forces";
        return Err(Invalid::new("`data.forces`", "terms per sample", "forces", remedy));
    };
    let forces: &Forces = &moved.forces;
    let theirs = fitted.description()?;
    check_alike(forces.description(), &theirs)?;
    let sizes = [forces.description(), &theirs].map(|d| (d.ship.length_m, d.ship.draught_m));
    let same = sizes[0] == sizes[1];
    let mean = |parameter: &Parameter| {
        let estimate = fitted.parameters.iter().find(|e| e.name == parameter.name).ok_or_else(|| {
            let (thing, found) = (format!("parameter `{}`", parameter.name), "a number that was known");
            Invalid::new(thing, found, "one that was estimated", "fix it in this vessel, too")
        })?;
        scaled(parameter, estimate, same)
    };
    forces.parameters().iter().map(mean).collect()
}

/// A former estimate in the system of `own`.
fn scaled(parameter: &Parameter, found: &FittedParameter, same: bool) -> Result<f64, Invalid> {
    match (parameter.prime, found.prime_value) {
        _ if same && parameter.unit == found.unit => Ok(found.value),
        (Some(one), Some(prime)) => Ok(prime * one / parameter.scale),
        _ if same => Ok(found.si_value / parameter.scale),
        _ => {
            let (thing, found) =
                (format!("parameter `{}`", parameter.name), format!("a number in {}", parameter.si_unit));
            let expected = "numbers of the prime system: the ships differ in size";
            Err(Invalid::new(thing, found, expected, "fix it, or take a former fit of this ship"))
        }
    }
}

/// Refuses ships with other terms or components.
fn check_alike(ours: &Description, theirs: &Description) -> Result<(), Invalid> {
    let (ours, theirs) = (parts(ours), parts(theirs));
    let count = ours.len().max(theirs.len());
    let part = |of: &[String], i: usize| of.get(i).cloned().unwrap_or_else(|| "nothing".to_owned());
    match (0..count).find(|i| ours.get(*i) != theirs.get(*i)) {
        None => Ok(()),
        Some(i) => {
            let expected = format!("{}, as this vessel has", part(&ours, i));
            let remedy = "take a former fit of the same terms and components";
            Err(Invalid::new("`data.forces.description`", part(&theirs, i), expected, remedy))
        }
    }
}

/// What a ship's forces consist of, without numbers.
fn parts(of: &Description) -> Vec<String> {
    let area = of.ship.area.map_or("Ld", |area| area.name());
    let coriolis = of.ship.coriolis.map_or("without-munk", |coriolis| coriolis.name());
    let mut all = vec![format!("area `{area}`, coriolis `{coriolis}`")];
    for (degree, terms) in [("surge", &of.surge), ("sway", &of.sway), ("yaw", &of.yaw)] {
        let part = |term: &TermSpec| format!("`{}` {} in {degree}", term.parameter, term.term);
        all.extend(terms.iter().map(part));
    }
    all.extend(of.propeller.iter().map(|p| format!("propeller `{}` of input `{}`", p.name, p.input)));
    all.extend(of.rudder.iter().map(|r| format!("rudder `{}` of input `{}`", r.name, r.input)));
    all.extend(of.thruster.iter().map(|t| format!("thruster `{}` of input `{}`", t.name, t.input)));
    let harmonics = |wind: &ship::forces::WindSpec| [wind.surge.len(), wind.sway.len(), wind.yaw.len()];
    all.extend(of.wind.iter().map(|wind| format!("wind `{}` of {:?} harmonics", wind.name, harmonics(wind))));
    all.extend(of.crossflow.iter().map(|crossflow| format!("crossflow `{}`", crossflow.name)));
    all
}
