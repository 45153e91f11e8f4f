//! From a solved design to `design.json`.

use std::collections::BTreeMap;

use design::{
    Accuracy, AccuracyOf, Available, Bounds, Criterion, CriterionName, Design, Dictionary, Predicted,
    Restricted, Segments, Streamed, Whole,
};
use estimation::Estimator;
use estimation::refine::Forward;
use ship::model::{Source, Vessel};
use trial::arranging::Arranged;
use trial::moments::{Estimated, Moments, Promise};
use trial::refining::Refinement;

use super::design::{
    Accuracy as AccuracyDocument, Counts, CovarianceCriterion, DesignDocument, DesignPrior, DesignPromise,
    DesignStatus, Efficiency, Restricted as RestrictedDocument, Sequence, SequencePart, SolvedFigures,
    Unreached,
};
use super::refined::{RefinedDesign, RefinedExperiment, RefinedLimit};
use super::statements;

/// A solved design with its problem.
pub struct Solved<'a> {
    /// The maneuvers.
    pub dictionary: &'a Dictionary,
    /// Name of the criterion.
    pub name: CriterionName,
    /// The criterion.
    pub criterion: &'a Criterion,
    /// The estimator.
    pub estimated: Estimated,
    /// The best shares.
    pub design: &'a Design,
    /// The available amounts, if limited.
    pub available: Option<&'a Available>,
    /// Whole segments, if requested.
    pub segments: Option<(Segments, Whole)>,
    /// Samples of the experiment, if known.
    pub samples: Option<f64>,
    /// At most so many maneuvers, if requested.
    pub restricted: Option<(u64, &'a Restricted)>,
    /// Figures of merit, if given.
    pub figures: Option<SolvedFigures<'a>>,
    /// The time for a wanted accuracy, if requested.
    pub accuracy: Option<&'a Accuracy>,
    /// Order and lengths, if requested.
    pub sequence: Option<Arranged>,
    /// The result over all maneuvers of a table, if only those with a share are in the dictionary.
    pub streamed: Option<&'a Streamed>,
    /// The moments that the dictionary was made from.
    pub moments: &'a Moments,
}

impl From<Solved<'_>> for DesignDocument {
    fn from(solved: Solved) -> Self {
        let Solved { dictionary, criterion, design, .. } = solved;
        let named = |values: &[f64]| by_name(&dictionary.maneuvers, values);
        let (count, p) = (dictionary.maneuvers.len(), criterion.degree());
        let statement = statement(&solved);
        let parameters = dictionary.parameters();
        let log_det = match criterion {
            Criterion::Information(_) => Some(design.log_det),
            Criterion::Covariance(_) => dictionary.information.log_det(&design.shares),
        };
        let covariance = covariance(&solved);
        let equal_shares = match solved.streamed {
            Some(all) => design.efficiency(&all.mean, &[1.0], parameters),
            None => criterion.efficiency(design, &vec![1.0 / count as f64; count], parameters),
        };
        Self {
            criterion: solved.name,
            mean_removal: match solved.estimated {
                Estimated::Iv(removal) => Some(removal),
                Estimated::OutputError => None,
            },
            status: match &solved.restricted {
                Some(_) => DesignStatus::Restricted,
                None => design.status.into(),
            },
            statement,
            held: solved.moments.held.clone(),
            beyond: solved.moments.beyond.clone(),
            unreached: unreached(&solved),
            shares: named(&design.shares),
            sensitivities: named(&design.sensitivities),
            dimension: Some(p as u64),
            gap: Some(design.gap),
            relative_gap: Some(design.gap / p),
            log_det,
            efficiency: Some(Efficiency {
                equal_shares,
                single: named(&criterion.single_efficiencies(design, parameters)),
            }),
            counts: solved.segments.as_ref().map(|(_, whole)| by_name(&dictionary.maneuvers, &whole.counts)),
            counted: solved.segments.as_ref().map(|(segments, whole)| counts(design, segments, whole)),
            available: solved.available.map(|a| named(&a.shares)),
            promise: covariance.as_ref().and_then(|covariance| promise(&solved, covariance)),
            covariance,
            estimator: (solved.estimated == Estimated::OutputError).then_some(Estimator::OutputError),
            prior: prior(&solved),
            restricted: solved.restricted.map(|(most, found)| restriction(most, found)),
            figures: solved.figures.as_ref().map(|figures| figures.document(samples(&solved) as u64)),
            accuracy: solved.accuracy.map(|shortest| accuracy(shortest, range(&solved, shortest))),
            sequence: solved.sequence.map(Into::into),
            refined: None,
            order: dictionary.maneuvers.clone(),
            candidates: solved.streamed.map(|all| all.candidates as u64),
        }
    }
}

fn by_name<T: Copy>(names: &[String], values: &[T]) -> BTreeMap<String, T> {
    names.iter().cloned().zip(values.iter().copied()).collect()
}

/// Samples of the experiment, 1 if they are not known.
fn samples(solved: &Solved) -> f64 {
    solved.samples.map_or(1.0, f64::round).max(1.0)
}

fn covariance(solved: &Solved) -> Option<CovarianceCriterion> {
    let Criterion::Covariance(criterion) = solved.criterion else { return None };
    let samples = samples(solved);
    let names = || solved.dictionary.parameter_names().map(str::to_owned);
    let Predicted { value, standard_errors } =
        criterion.predicted(solved.dictionary, &solved.design.shares, samples)?;
    Some(CovarianceCriterion {
        name: solved.name,
        value,
        weights: names().zip(criterion.weights.iter().copied()).collect(),
        samples: samples as u64,
        standard_errors: names().zip(standard_errors).collect(),
    })
}

/// What the priors of a ship with forces contribute, if she has any.
fn prior(solved: &Solved) -> Option<DesignPrior> {
    let shares = solved.moments.prior_shares(&solved.design.shares, solved.samples?)?;
    let statement = statements::prior(&shares);
    Some(DesignPrior { shares, statement })
}

/// What an error of the parameters is as a promise, if these are a guess.
fn promised(solved: &Solved, parameter_error: f64) -> Option<Promise> {
    let used = |name: &str| is_used(solved, name);
    solved.moments.sampled.as_ref()?.promise(parameter_error, used)
}

/// Of an experiment of a known length; none where a parameter is zero, or of a criterion that predicts no errors.
fn promise(solved: &Solved, covariance: &CovarianceCriterion) -> Option<DesignPromise> {
    solved.samples?;
    let squares = solved.moments.squares(Source::Nominal).ok()?;
    let names = solved.dictionary.parameter_names();
    let relative = names.zip(squares).map(|(name, square)| covariance.standard_errors[name].powi(2) / square);
    promised(solved, relative.sum::<f64>().sqrt()).map(statements::promise)
}

/// The range of an accuracy, if it is the error of all parameters.
fn range(solved: &Solved, found: &Accuracy) -> Option<[f64; 2]> {
    let is_overall = found.wanted.of == AccuracyOf::Overall;
    is_overall.then(|| promised(solved, found.reached)).flatten().map(|promise| promise.range)
}

/// Whether a maneuver has a share.
fn is_used(solved: &Solved, name: &str) -> bool {
    let maneuvers = solved.dictionary.maneuvers.iter().zip(&solved.design.shares);
    maneuvers.into_iter().any(|(maneuver, share)| maneuver == name && *share > 0.0)
}

/// The maneuvers in use that many ships miss, if there are any.
fn unreached(solved: &Solved) -> Option<Unreached> {
    let sampled = solved.moments.sampled.as_ref()?;
    let motions = sampled.unreached(|name| is_used(solved, name));
    let statement = statements::unreached(&motions, sampled)?;
    Some(Unreached { from: sampled.from, ships: sampled.ships, motions, statement })
}

fn statement(solved: &Solved) -> String {
    match &solved.restricted {
        Some((_, restricted)) => statements::restricted(restricted),
        None => {
            let binds = |a: &Available| Bounds::new(&a.shares).is_ok_and(|bounds| bounds.bind());
            statements::certificate(solved.design, solved.criterion, solved.available.is_some_and(binds))
        }
    }
}

fn restriction(most_maneuvers: u64, found: &Restricted) -> RestrictedDocument {
    RestrictedDocument {
        most_maneuvers,
        method: found.method,
        gap: found.loss,
        statement: statements::restricted(found),
    }
}

fn counts(design: &Design, segments: &Segments, whole: &Whole) -> Counts {
    Counts {
        segments: segments.total,
        segment_samples: segments.samples,
        efficiency: whole.efficiency,
        method: whole.found.as_ref().map(|counts| counts.method),
        gap: Some(whole.loss),
        statement: Some(statements::counts(design, whole)),
    }
}

fn accuracy(accuracy: &Accuracy, range: Option<[f64; 2]>) -> AccuracyDocument {
    AccuracyDocument {
        wanted: accuracy.wanted.accuracy,
        of: accuracy.wanted.of,
        duration_s: accuracy.duration_s,
        samples: accuracy.samples,
        reached: accuracy.reached,
        range,
        holds_from_s: Some(accuracy.holds_from_s).filter(|from| from.is_finite()),
        curve: accuracy.curve.clone(),
        statement: statements::accuracy(accuracy, range),
    }
}

impl From<Arranged> for Sequence {
    fn from(arranged: Arranged) -> Self {
        let part =
            |(maneuver, n): &(String, usize)| SequencePart { maneuver: maneuver.clone(), samples: *n as u64 };
        Self {
            parts: arranged.parts.iter().map(part).collect(),
            samples: arranged.parts.iter().map(|(_, n)| *n as u64).sum(),
            value: arranged.value,
            statement: statements::sequence(&arranged),
            foretold: arranged.foretold,
            promised: arranged.promised,
        }
    }
}

// From refined inputs to the files that a campaign needs.

/// The maneuver's name.
const NAME: &str = "refined";

/// A refined experiment of a vessel, for files.
pub struct RefinedFiles<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// The experiment.
    pub found: &'a Refinement,
    /// Whether its parameters are a guess: nominal ones without true ones, and no estimates.
    pub is_guess: bool,
}

impl RefinedFiles<'_> {
    /// What was refined.
    fn refined(&self) -> RefinedDesign {
        let (start, limits, refined) = (&self.found.start, &self.found.limits, &self.found.refined);
        let rate_hz = self.vessel.sample_rate_hz;
        let moduli = |forward: &Forward, inputs: &[f64]| limits.moduli(&forward.states, inputs, rate_hz);
        let (first, last) = (moduli(&refined.before, &start.inputs), moduli(&refined.after, &refined.inputs));
        let limit = |i: usize| RefinedLimit {
            limit: limits.names[i].clone(),
            allowed: Some(limits.allowed[i]).filter(|limit| limit.is_finite()),
            before: first[i],
            after: last[i],
        };
        RefinedDesign {
            simulated_with: start.source,
            before: self.experiment(&refined.before),
            after: self.experiment(&refined.after),
            worth: self.found.efficiency(),
            slowed: start.slowed.clone(),
            limits: (0..limits.names.len()).map(limit).collect(),
            knot_s: self.found.knot as f64 / rate_hz,
            iterations: refined.iterations as u64,
            simulations: refined.evaluations as u64,
            settled: refined.settled,
        }
    }

    /// Refined inputs are played whatever the ship does.
    fn promise(&self) -> DesignPromise {
        statements::promise(Promise::of_guess(self.found.refined.after.parameter_error(), true))
    }

    fn samples(&self) -> usize {
        self.found.refined.inputs.len() / self.vessel.model.inputs.max(1)
    }

    fn by_parameter(&self, values: impl Iterator<Item = f64>) -> BTreeMap<String, f64> {
        self.vessel.model.parameter_names().map(str::to_owned).zip(values).collect()
    }

    fn experiment(&self, forward: &Forward) -> RefinedExperiment {
        RefinedExperiment {
            value: forward.value,
            measurement_value: forward.measurement_value,
            parameter_error: forward.parameter_error(),
            standard_errors: self.by_parameter(forward.standard_errors()),
        }
    }

    /// `inputs.csv`: a column per input, with digits that round-trip.
    pub fn inputs(&self) -> String {
        let model = &self.vessel.model;
        let mut text = model.input_names().join(",");
        for row in self.found.refined.inputs.chunks_exact(model.inputs.max(1)) {
            let cells: Vec<String> = row.iter().map(f64::to_string).collect();
            text.push('\n');
            text.push_str(&cells.join(","));
        }
        text.push('\n');
        text
    }

    /// `refined-dictionary.toml`: the experiment as one maneuver with the inputs of the file `inputs` beside it, and the limits that it keeps.
    pub fn dictionary(&self, inputs: &str) -> String {
        let signal = &self.found.limits.signal;
        let names = self.vessel.model.input_names();
        let [u, v, r] = signal.states;
        let ranges = names.iter().zip(&signal.inputs).map(|(name, range)| format!("{name:?} = {range:?}\n"));
        let rate_hz = self.vessel.sample_rate_hz;
        let limited = names.iter().zip(&signal.steps).filter(|(_, step)| step.is_finite());
        let rates = limited.map(|(name, step)| format!("{name:?} = {:?}\n", step * rate_hz));
        format!(
            "# Written by design --refine: the refined experiment as one maneuver.\n[[maneuver]]\nname = \"{NAME}\"\nkind = \
             \"inputs\"\nfile = {inputs:?}\nspeed_m_s = {:?}\nduration_s = {:?}\n\n[limits]\nu_m_s = {u:?}\nv_m_s = {v:?}\nr_rad_s = {r:?}\n[limits.inputs]\n{}[limits.rates]\n{}",
            self.found.start.initial[0],
            self.samples() as f64 / rate_hz,
            ranges.collect::<String>(),
            rates.collect::<String>(),
        )
    }

    /// The design with only the refined maneuver. Without a choice of shares there are no sensitivities, no gap and
    /// no efficiencies.
    pub fn design(&self) -> DesignDocument {
        let forward = &self.found.refined.after;
        let (samples, statement) = (self.samples() as u64, statements::refinement(self.found));
        DesignDocument {
            criterion: CriterionName::ARelative,
            mean_removal: None,
            status: DesignStatus::Refined,
            statement: statement.clone(),
            held: Vec::new(),
            beyond: Vec::new(),
            unreached: None,
            prior: None,
            promise: self.is_guess.then(|| self.promise()),
            shares: BTreeMap::from([(NAME.to_owned(), 1.0)]),
            order: vec![NAME.into()],
            candidates: None,
            sensitivities: BTreeMap::new(),
            dimension: None,
            gap: None,
            relative_gap: None,
            log_det: forward.log_det(samples),
            efficiency: None,
            counts: None,
            counted: None,
            available: None,
            covariance: Some(CovarianceCriterion {
                name: CriterionName::ARelative,
                value: forward.value,
                weights: self.by_parameter(self.found.start.weights.iter().copied()),
                samples,
                standard_errors: self.by_parameter(forward.standard_errors()),
            }),
            estimator: Some(Estimator::OutputError),
            restricted: None,
            figures: None,
            accuracy: None,
            sequence: Some(Sequence {
                foretold: None,
                promised: Vec::new(),
                parts: vec![SequencePart { maneuver: NAME.into(), samples }],
                samples,
                value: forward.log_value(samples),
                statement,
            }),
            refined: Some(self.refined()),
        }
    }
}
