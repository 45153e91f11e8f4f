use std::convert::Infallible;

use numerics::{congruence, dot, quadratic};
use vessel::DegreeOfFreedom;

use super::delivered::{beyond, covariance_of};
use super::entangled::entangled;
use super::run_sums::{Entry, Rounded, whole};
use super::statements::statements;
use super::trust::{Degree, judged};
use super::{
    DegreeFit, DegreeTrust, Delivered, NominalModel, Pool, PoolError, Pooled, PooledSums, RunSums, Solution,
    Status, Strength, joined,
};
use crate::{Estimator, Known, MeanRemoval};

/// What sums cannot tell.
const UNTOLD: &str = "from sums alone: standard errors are those of white residuals, too small where neighbouring residuals are \
     alike; whether they are white, what the model lacks, how large motions are, free simulations and the bootstrap need all runs \
     in one file";

/// The estimate of [`Estimator::Ls`] or [`Estimator::Iv`] from sums of any number of runs, which were made for it. Its standard
/// errors are those of white residuals, σ̂² G (Σζᶜζᶜᵀ) Gᵀ with σ̂² = Σε²/(N − p − intercepts).
///
/// # Errors
/// No degree of freedom that is identifiable.
pub fn estimate_merged(
    pool: &Pool,
    estimator: Estimator,
    sums: &RunSums,
    design: &str,
) -> Result<Pooled, PoolError<Infallible>> {
    let layout = pool.vessel.model.layout();
    let rounded: Option<Vec<Rounded>> =
        (0..3).map(|d| sums.degrees[d].rounded(layout.terms(d).len())).collect();
    let Some(rounded) = rounded else {
        return Err(PoolError::NotIdentifiable(vec!["sums that are no finite numbers".to_owned()]));
    };
    let known = |d: usize| Known::of(&pool.vessel.model.degrees[d]);
    let of = |instrument: fn(usize) -> Entry| {
        let degrees = rounded.iter().enumerate().map(|(d, own)| own.sums(instrument, known(d)));
        let mut pooled = PooledSums::new(pool.removal);
        pooled.add(&whole(degrees, sums.samples));
        pooled
    };
    let data = of(Entry::Zeta);
    let nominal = match &pool.nominal {
        NominalModel::Known(theta) => Some(theta.as_slice()),
        NominalModel::Fitted => None,
    };
    let degrees = data.fit(&pool.options(nominal, estimator));
    let least_squares = of(Entry::Phi).fit(&pool.options(nominal, Estimator::Ls));
    check(pool, &degrees)?;
    let (mut trust, mut increment_std) = (Vec::with_capacity(3), [0.0; 3]);
    for (d, own) in DegreeOfFreedom::ALL.into_iter().zip(&rounded) {
        let (fit, place) = (&degrees[d as usize], d as usize);
        let (numbers, std) = numbers(pool, &data, own, fit, place);
        trust.push(judged(pool, d, fit, estimator, &numbers));
        increment_std[place] = std;
    }
    let delivered = delivered(pool, sums, [&degrees, &least_squares], &trust, increment_std);
    let alike = delivered.iter().flat_map(|own| entangled(own, pool.model.layout()));
    let told = [UNTOLD.to_owned()].into_iter().chain(statements(&trust)).chain(alike).collect();
    Ok(Pooled {
        design: design.to_owned(),
        parts: sums.parts as usize,
        samples: sums.samples,
        bandwidth: 0,
        statements: told,
        degrees: trust,
        sources: Vec::new(),
        delivered,
        criticism: None,
    })
}

fn check(pool: &Pool, degrees: &[DegreeFit; 3]) -> Result<(), PoolError<Infallible>> {
    if degrees.iter().any(|d| d.status == Status::Bounded) {
        return Err(PoolError::Bounded(pool.unidentified(degrees)));
    }
    if degrees.iter().all(|d| d.solution.is_none()) {
        return Err(PoolError::NotIdentifiable(pool.unidentified(degrees)));
    }
    Ok(())
}

/// What is known of degree of freedom `d`, and the standard deviation of its residuals.
fn numbers(pool: &Pool, data: &PooledSums, own: &Rounded, fit: &DegreeFit, d: usize) -> (Degree, f64) {
    let p = data.total().degrees[d].parameters();
    let centred =
        Centred { own, p, share: data.total().degrees[d].share(pool.removal == MeanRemoval::Complete) };
    let of = |a: fn(usize) -> Entry, b: fn(usize) -> Entry| centred.matrix(a, b);
    let moments = [of(Entry::Phi, Entry::Phi), of(Entry::Zeta, Entry::Zeta), of(Entry::Zeta, Entry::Phi)];
    let squares = |solution: &Solution| centred.residual_squares(&solution.theta);
    let samples = data.total().samples;
    let covariance = |solution: &Solution| {
        let unknowns = data.centring().unknowns(d, &solution.gain, p) as u64;
        let variance = squares(solution) / samples.saturating_sub(unknowns).max(1) as f64;
        let mut middle = centred.matrix(Entry::Zeta, Entry::Zeta);
        middle.iter_mut().for_each(|entry| *entry *= variance);
        congruence(p, &solution.gain, &middle)
    };
    let solution = fit.solution.as_ref();
    let degree = Degree {
        covariance: solution.map(covariance),
        whiteness: None,
        crossed: None,
        strength: Strength::of(p, moments).partial(),
        diagnosis: data.diagnose(d),
        instrument_fit: None,
        bootstrap: None,
    };
    (degree, solution.map_or(0.0, |solution| (squares(solution) / samples.max(1) as f64).sqrt()))
}

/// Sums of products without the means that are removed.
struct Centred<'a> {
    own: &'a Rounded,
    p: usize,
    /// 1/N; 0 where no mean is removed.
    share: f64,
}

impl Centred<'_> {
    fn at(&self, a: Entry, b: Entry) -> f64 {
        self.own.at(a, b) - self.share * self.own.at(a, Entry::One) * self.own.at(b, Entry::One)
    }

    fn matrix(&self, a: fn(usize) -> Entry, b: fn(usize) -> Entry) -> Vec<f64> {
        (0..self.p * self.p).map(|k| self.at(a(k / self.p), b(k % self.p))).collect()
    }

    /// Σε² of Δy − φᵀθ without its mean, where that is removed.
    fn residual_squares(&self, theta: &[f64]) -> f64 {
        let moved: Vec<f64> = (0..self.p).map(|i| self.at(Entry::Phi(i), Entry::Increment)).collect();
        let gained = quadratic(theta, &self.matrix(Entry::Phi, Entry::Phi));
        (self.at(Entry::Increment, Entry::Increment) - 2.0 * dot(&moved, theta) + gained).max(0.0)
    }
}

fn delivered(
    pool: &Pool,
    sums: &RunSums,
    [degrees, least_squares]: [&[DegreeFit; 3]; 2],
    trust: &[DegreeTrust],
    increment_std: [f64; 3],
) -> Option<Delivered> {
    let of = |degrees: &[DegreeFit; 3]| joined(degrees.each_ref().map(|degree| degree.solution.as_ref()));
    let (theta, intercepts) = of(degrees)?;
    Some(Delivered {
        theta,
        constant: beyond(&pool.model, intercepts),
        covariance: covariance_of(trust),
        least_squares: of(least_squares).map(|(theta, own)| (theta, beyond(&pool.model, own))),
        increment_std,
        output_rmse: None,
        surroundings: Vec::new(),
        recordings: Vec::new(),
        covered: sums.covered.clone(),
    })
}
