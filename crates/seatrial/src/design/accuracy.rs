//! How long an experiment has to be for a wanted accuracy.

use std::path::Path;

use design::{Bounds, Covariance, Norm, Options};
use vessel::Streams;

use super::criterion::{CovarianceCriterion, Criterion};
use super::matrices::{Estimated, information};
use crate::failure::Failure;
use crate::instruments::Removal;
use study::documents::{Accuracy, AccuracyPoint, MomentsDocument};

/// The accuracy that is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// The standard error, relative to the parameters.
    pub accuracy: f64,
    /// Whether of every parameter; else of all together, the root of the sum of squares.
    pub per_parameter: bool,
    /// The longest experiment \[s\].
    pub longest_s: f64,
    /// Segments of a random design.
    pub random_segments: u32,
    /// Seed of the random designs.
    pub seed: u64,
}

/// Random designs that the curve's median is of.
const RANDOM: u32 = 400;
/// Durations of the curve.
const POINTS: usize = 25;
/// Rounds of the search for the least largest error.
const ROUNDS: usize = 30;

/// What predicts standard errors: a covariance, where the parameters' rows are, and the squares that errors are relative to.
pub struct Errors<'a> {
    covariance: &'a Covariance,
    rows: Vec<usize>,
    squares: &'a [f64],
    per_parameter: bool,
}

impl<'a> Errors<'a> {
    /// `squares`: of the parameters.
    pub fn new(
        criterion: &'a CovarianceCriterion,
        moments: &MomentsDocument,
        estimated: Estimated,
        squares: &'a [f64],
        per_parameter: bool,
    ) -> Self {
        let (mut rows, mut next) = (Vec::new(), 0);
        for degree in &moments.degrees {
            rows.extend(next..next + degree.parameters.len());
            next += degree.parameters.len() + usize::from(estimated.has_intercepts());
        }
        Self { covariance: &criterion.covariance, rows, squares, per_parameter }
    }

    /// The variance of every parameter relative to its square, per sample.
    fn relative(&self, shares: &[f64]) -> Option<Vec<f64>> {
        let variances = self.covariance.variances(shares)?;
        Some(self.rows.iter().zip(self.squares).map(|(row, s)| variances[*row].max(0.0) / s).collect())
    }

    /// The squared accuracy for one sample; infinite where the shares excite not every parameter.
    fn of(&self, shares: &[f64]) -> f64 {
        let Some(relative) = self.relative(shares) else { return f64::INFINITY };
        match self.per_parameter {
            true => relative.iter().copied().fold(0.0, f64::max),
            false => relative.iter().sum(),
        }
    }
}

/// Shares whose largest relative error is least, and a bound that no shares are below (proved where the criterion is
/// concave): the weights of the sum of relative variances grow where they are largest.
///
/// # Errors
/// As the solver.
pub fn least_largest(
    errors: &Errors,
    bounds: &Bounds,
    options: &Options,
    make: impl Fn(&[f64]) -> Result<Covariance, Failure>,
    refuse: impl Fn(design::Error) -> Failure,
) -> Result<(Vec<f64>, f64), Failure> {
    let mut weights = vec![1.0 / errors.squares.len() as f64; errors.squares.len()];
    let (mut best, mut bound): (Option<(f64, Vec<f64>)>, f64) = (None, 0.0);
    let options = Options { random_starts: 0, tolerance: options.tolerance.max(1e-6), ..*options };
    for _ in 0..ROUNDS {
        let scaled: Vec<f64> = weights.iter().zip(errors.squares).map(|(w, s)| w / s).collect();
        let design = design::solve_covariance(&make(&scaled)?, bounds, &options).map_err(&refuse)?;
        let relative = errors.relative(&design.shares).unwrap_or_else(|| vec![f64::INFINITY; weights.len()]);
        bound = bound.max((-design.log_det).exp() * (1.0 - design.gap.max(0.0)));
        let largest = relative.iter().copied().fold(0.0, f64::max);
        if best.as_ref().is_none_or(|(known, _)| largest < *known) {
            best = Some((largest, design.shares));
        }
        weights.iter_mut().zip(&relative).for_each(|(w, r)| *w *= r / largest);
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|w| *w /= sum);
    }
    best.map(|(_, shares)| (shares, bound)).ok_or_else(|| refuse(design::Error::Empty))
}

/// Samples that reach the wanted accuracy at fixed shares.
pub fn samples(errors: &Errors, shares: &[f64], wanted: &Wanted) -> f64 {
    (errors.of(shares) / (wanted.accuracy * wanted.accuracy)).ceil()
}

/// Refuses an accuracy that is out of reach within `longest_s`, telling the best.
///
/// # Errors
/// No answer.
pub fn reachable(
    file: &Path,
    errors: &Errors,
    shares: &[f64],
    wanted: &Wanted,
    rate_hz: f64,
) -> Result<f64, Failure> {
    let samples = samples(errors, shares, wanted);
    if samples <= wanted.longest_s * rate_hz {
        return Ok(samples);
    }
    let best = (errors.of(shares) / (wanted.longest_s * rate_hz)).sqrt();
    let (of, needed) = (kind(wanted), samples / rate_hz);
    let need = if needed.is_finite() {
        format!("which takes {needed:.1} s")
    } else {
        "which no time gives".to_owned()
    };
    Err(Failure::NoAnswer(format!(
        "{}: --accuracy: found {} ({of}), {need}, expected one that {} s can reach: the best is {best:.4}; ask for that, or make \
         more time or better maneuvers available",
        file.display(),
        wanted.accuracy,
        wanted.longest_s
    )))
}

fn kind(wanted: &Wanted) -> &'static str {
    if wanted.per_parameter {
        "largest relative standard error"
    } else {
        "root of the sum of squared relative standard errors"
    }
}

/// The answer with its curve.
pub fn document(
    errors: &Errors,
    shares: &[f64],
    wanted: &Wanted,
    moments: &MomentsDocument,
    samples: f64,
    bound: Option<f64>,
    paper: Option<&[f64]>,
) -> Accuracy {
    let rate = moments.sample_rate_hz;
    let (own, count) = (errors.of(shares), moments.maneuvers.len());
    let paper = paper.map(|shares| errors.of(shares));
    let equal = errors.of(&vec![1.0 / count as f64; count]);
    let random = random(errors, count, wanted);
    let at = |one: f64, samples: f64| Some((one / samples).sqrt()).filter(|a| a.is_finite());
    let curve = (0..POINTS).map(|i| {
        let factor = 16.0_f64.powf(2.0 * i as f64 / (POINTS - 1) as f64 - 1.0);
        let n = (samples * factor).max(1.0);
        AccuracyPoint {
            duration_s: n / rate,
            design: (own / n).sqrt(),
            equal: at(equal, n),
            paper: paper.and_then(|p| at(p, n)),
            random: random.and_then(|r| at(r, n)),
        }
    });
    let needs = |one: f64| one / (wanted.accuracy * wanted.accuracy) / rate;
    let told = |what: &str, one: Option<f64>| match one.map(needs).filter(|s| s.is_finite()) {
        Some(seconds) => format!("; {what} need {seconds:.1} s"),
        None => String::new(),
    };
    let statement = format!(
        "{:.1} s reach a {} of {}{}{}{}{}.",
        samples / rate,
        kind(wanted),
        wanted.accuracy,
        told("the shares of the paper's criterion", paper),
        told("equal shares", Some(equal)),
        told(&format!("random designs of {} segments (median)", wanted.random_segments), random),
        bound.map_or(String::new(), |b| format!(
            "; no shares need less than {:.1} s where the problem is convex",
            needs(b)
        )),
    );
    Accuracy {
        wanted: wanted.accuracy,
        of: if wanted.per_parameter { "per-parameter" } else { "overall" }.into(),
        duration_s: samples / rate,
        samples: samples as u64,
        reached: (own / samples).sqrt(),
        bound_s: bound.map(needs),
        curve: curve.collect(),
        statement,
    }
}

/// Median over random designs: equally long segments, each of them any maneuver.
fn random(errors: &Errors, count: usize, wanted: &Wanted) -> Option<f64> {
    let streams = Streams::new(wanted.seed, "random designs");
    let segments = wanted.random_segments as usize;
    let of = |run: u32| {
        let mut shares = vec![0.0; count];
        for q in streams.choices(run, 0, count as u32, segments) {
            shares[q as usize] += 1.0 / segments as f64;
        }
        errors.of(&shares)
    };
    let mut all: Vec<f64> = (0..RANDOM).map(of).collect();
    all.sort_by(f64::total_cmp);
    Some(all[all.len() / 2]).filter(|m| m.is_finite())
}

/// Shares of the paper's criterion for the same moments, where there are any.
pub fn papers_shares(
    file: &Path,
    moments: &MomentsDocument,
    removal: Removal,
    bounds: &Bounds,
) -> Option<Vec<f64>> {
    let candidates = information(file, moments, Estimated::Iv(removal)).ok()?;
    let options = Options { random_starts: 0, tolerance: 1e-8, ..Options::default() };
    design::solve_within(&candidates, bounds, &options).ok().map(|design| design.shares)
}

/// Whether the criterion is one whose shares do not depend on how long the experiment is, for messages.
pub fn needs_covariance(criterion: &Criterion) -> Result<&CovarianceCriterion, Failure> {
    match criterion {
        Criterion::Covariance(c) => Ok(c),
        Criterion::Information(_) => Err(Failure::Usage(
            "--accuracy: found --criterion d-hessian, which predicts no standard errors, expected a criterion of the covariance; \
             leave --criterion out or take a-relative"
                .into(),
        )),
    }
}

/// The sum of relative variances with other weights, for [`least_largest`].
///
/// # Errors
/// As [`Covariance::new`].
pub fn reweighted(
    file: &Path,
    moments: &MomentsDocument,
    estimated: Estimated,
    weights: &[f64],
) -> Result<Covariance, Failure> {
    let information = information(file, moments, estimated)?;
    let middle = super::matrices::middle(file, moments, estimated)?;
    let mut rest = weights.iter().copied();
    let mut rows = Vec::new();
    for degree in &moments.degrees {
        rows.extend(rest.by_ref().take(degree.parameters.len()));
        if estimated.has_intercepts() {
            rows.push(0.0);
        }
    }
    let built = Covariance::new(&information, &middle, &rows, Norm::PowerMean(1.0));
    built.map_err(|e| super::refusal::no_design(file, moments, estimated, e))
}
