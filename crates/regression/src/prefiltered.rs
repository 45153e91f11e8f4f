//! Instrumental variables with data prefiltered by the model's own low-pass filter.
//!
//! With measurement noise e the residual of the regression is about e(k+1) − a(k) e(k), a = 1 + ∂(φᵀθ)/∂(own state):
//! it is mostly differences of noise. After filtering regressors, instruments and increments with f(k) = a(k) f(k−1) + s(k),
//! the residual is e itself, and the estimate is close to that of least output error: the simplified refined
//! instrumental variables of Young & Jakeman, *Int. J. Control* 29 (1979), with a state-dependent pole.

use std::collections::BTreeMap;
use std::ops::Range;

use numerics::lanes::lane_of;
use numerics::{LANES, Lane, product, solve};
use ship::engine::Compiled;

use crate::estimate::{Run, Solved, ranges};
use crate::{Batch, DegreeSums, Estimate, MeanRemoval, Noise, Outcome, Sums};

/// Estimates every run of `batch`, whose instrument states were simulated with `parameters`, one lane each: these set
/// the filter's poles, clamped between 0 and 1 − 1/N. The filter starts at rest with every group of samples that has
/// its own intercept. Standard errors follow from `noise` if it is stated (a draw at the boundary of two groups
/// counts for both), else from the jackknife over ten blocks of a group's samples.
pub fn estimate_prefiltered(
    batch: &Batch,
    parameters: &[Lane],
    removal: MeanRemoval,
    noise: Option<&Noise>,
) -> Vec<Outcome> {
    let mut groups: BTreeMap<(usize, usize), [Degree; 3]> = BTreeMap::new();
    for (start, end) in (0..LANES).flat_map(|lane| ranges(batch, removal, lane)) {
        groups.entry((start, end)).or_insert_with(|| filtered(batch, parameters, start..end));
    }
    let centred = removal != MeanRemoval::None;
    let run = |lane: usize| {
        let sums = |(start, end): (usize, usize)| Sums {
            samples: (end - start) as u64,
            degrees: groups[&(start, end)].iter().map(|degree| degree.sums.lane(lane)).collect(),
        };
        Run { groups: ranges(batch, removal, lane).map(sums).collect(), centred }
    };
    let runs: Vec<Run> = (0..LANES).map(run).collect();
    let solved: Vec<Result<Solved, Outcome>> = runs.iter().map(Run::solution).collect();
    let mut meats = [const { Meats([const { Vec::new() }; 3]) }; LANES];
    for (range, degrees) in &groups {
        let group_of = |lane: usize| ranges(batch, removal, lane).position(|other| other == *range);
        add_meats(degrees, &mut meats, &runs, &solved, noise, group_of);
    }
    let finish = |(solved, meats): (Result<Solved, Outcome>, Meats)| {
        solved.map_or_else(std::convert::identity, |solved| {
            let standard_errors = solved.spread(&meats.0);
            let covariance = solved.covariance(&meats.0);
            Outcome::Identified(Estimate { parameters: solved.theta, standard_errors, covariance })
        })
    };
    solved.into_iter().zip(meats).map(finish).collect()
}

/// cov Σ ζᶜε of one run, p × p per degree of freedom; empty until something is added.
struct Meats([Vec<f64>; 3]);

impl Meats {
    fn add(&mut self, d: usize, entries: impl Iterator<Item = f64>) {
        if self.0[d].is_empty() {
            self.0[d].extend(entries);
        } else {
            self.0[d].iter_mut().zip(entries).for_each(|(all, entry)| *all += entry);
        }
    }
}

/// The filtered signals of one group of samples, of a degree of freedom with p parameters, p̃ = p + 1, and their sums.
struct Degree {
    parameters: usize,
    /// Filtered φ̃, ζ̃: N × p̃. The last column is the filtered 1.
    phi: Vec<Lane>,
    zeta: Vec<Lane>,
    /// Filtered Δy: N.
    target: Vec<Lane>,
    /// The filter's poles: N; ∂(increment)/∂(u, v, r): N × 3.
    poles: Vec<Lane>,
    slopes: Vec<Lane>,
    sums: DegreeSums<Lane>,
}

/// Sums of ζᶜφᵀ, p × p, and of ζᶜε over a block of samples.
struct SampleBlock {
    products: Vec<Lane>,
    scores: Vec<Lane>,
}

impl SampleBlock {
    fn new(p: usize) -> Self {
        Self { products: vec![Lane::ZERO; p * p], scores: vec![Lane::ZERO; p] }
    }

    /// A times the change of a run's estimate without this block: m with (I − A_b A⁻¹) m = Σ_b ζᶜε. Σ_b ζᶜε if the
    /// block alone determines a parameter.
    fn left_out(&self, lane: usize, inverse: &[f64]) -> Option<Vec<f64>> {
        let p = self.scores.len();
        let mut left = product(p, &lane_of(&self.products, lane), inverse);
        left.iter_mut().for_each(|entry| *entry = -*entry);
        (0..p).for_each(|i| left[i * p + i] += 1.0);
        let mut moved = lane_of(&self.scores, lane);
        let alone = moved.clone();
        Some(solve(p, &mut left, &mut moved).map_or(alone, |()| moved))
    }
}

/// The filtered signals of the samples `range`.
fn filtered(batch: &Batch, parameters: &[Lane], range: Range<usize>) -> [Degree; 3] {
    let mut degrees = [0, 1, 2].map(|d| Degree::new(batch, d, range.len()));
    let mut model = Compiled::new(batch.model, parameters);
    numerics::vectorized!(filter(&mut degrees, [&mut model.clone(), &mut model], batch, range));
    degrees
}

/// Adds the contribution of a group of samples to the `meats` of the runs that have an estimate and this group.
fn add_meats(
    degrees: &[Degree; 3],
    meats: &mut [Meats; LANES],
    runs: &[Run],
    solved: &[Result<Solved, Outcome>],
    noise: Option<&Noise>,
    group: impl Fn(usize) -> Option<usize>,
) {
    let mut first = 0;
    for (d, degree) in degrees.iter().enumerate() {
        let (p, centred) = (degree.parameters, runs[0].centred);
        let (mut theta, mut means) = (vec![Lane::ZERO; p + 1], vec![Lane::ZERO; p]);
        let mut is_filtered = [false; LANES];
        for lane in 0..LANES {
            let (Some(group), Ok(solved)) = (group(lane), &solved[lane]) else { continue };
            is_filtered[lane] = true;
            let sums = &runs[lane].groups[group].degrees[d];
            let solution = &solved.theta[first..first + p];
            theta.iter_mut().zip(solution).for_each(|(lanes, value)| lanes[lane] = *value);
            theta[p][lane] = sums.intercept(solution, centred);
            let centres = means.iter_mut().zip(sums.instrument_means(centred));
            centres.for_each(|(lanes, mean)| lanes[lane] = mean);
        }
        let means = &means;
        let lanes = (0..LANES).filter(|lane| is_filtered[*lane]);
        if let Some(noise) = noise {
            let meat = numerics::vectorized!(degree.responses(d, means, noise));
            lanes.for_each(|lane| meats[lane].add(d, meat.iter().map(|m| m[lane])));
        } else {
            let blocks = numerics::vectorized!(degree.blocks(&theta, means));
            for lane in lanes {
                if let Ok(solved) = &solved[lane] {
                    let left_out = |block: &SampleBlock| block.left_out(lane, solved.inverse(d));
                    let meat = jackknife(blocks.iter(), left_out).unwrap_or_else(|| vec![f64::NAN; p * p]);
                    meats[lane].add(d, meat.into_iter());
                }
            }
        }
        first += p;
    }
}

impl Degree {
    fn new(batch: &Batch, d: usize, samples: usize) -> Self {
        let degree = &batch.model.degrees[d];
        let p = degree.terms.len();
        let signal = |width: usize| Vec::with_capacity(samples * width);
        Self {
            parameters: p,
            phi: signal(p + 1),
            zeta: signal(p + 1),
            target: signal(1),
            poles: signal(1),
            slopes: signal(3),
            sums: DegreeSums::of(degree),
        }
    }

    /// Adds the latest sample to the sums.
    #[inline(always)]
    fn add(&mut self) {
        let p = self.parameters;
        let (phi, zeta) = (&self.phi[self.phi.len() - p - 1..], &self.zeta[self.zeta.len() - p - 1..]);
        self.sums.add_sample(&zeta[..p], &phi[..p], zeta[p], self.target[self.target.len() - 1]);
    }

    /// ζᶜ of instrument `i` at sample `k`; `mean` in units of the filtered 1.
    #[inline(always)]
    fn centred(&self, k: usize, i: usize, mean: Lane) -> Lane {
        let row = &self.zeta[k * (self.parameters + 1)..(k + 1) * (self.parameters + 1)];
        row[i] - mean * row[self.parameters]
    }

    /// Sums over each of ten blocks of samples. `theta`: with the intercept; `means`: of the instruments, in units of the
    /// filtered 1.
    #[inline(always)]
    fn blocks(&self, theta: &[Lane], means: &[Lane]) -> Vec<SampleBlock> {
        let (p, samples) = (self.parameters, self.target.len());
        let (mut blocks, mut block) = (Vec::with_capacity(BLOCKS), SampleBlock::new(p));
        for (k, target) in self.target.iter().enumerate() {
            let phi = &self.phi[k * (p + 1)..(k + 1) * (p + 1)];
            let mut residual = *target;
            for (f, t) in phi.iter().zip(theta) {
                residual = residual - *f * *t;
            }
            for (i, mean) in means.iter().enumerate() {
                let instrument = self.centred(k, i, *mean);
                block.scores[i] += instrument * residual;
                for (sum, f) in block.products[i * p..].iter_mut().zip(&phi[..p]) {
                    *sum += instrument * *f;
                }
            }
            if (k + 1) * BLOCKS / samples > k * BLOCKS / samples {
                blocks.push(std::mem::replace(&mut block, SampleBlock::new(p)));
            }
        }
        blocks
    }

    /// cov Σ ζᶜε from stated noise, to first order, p × p. With η(k) = ζᶜ(k) + a(k+1) η(k+1), Σ ζᶜε is Σ η times the
    /// residuals before the filter (see [`crate::meat`]): a draw of the own state's measurement error is multiplied
    /// by ζᶜ, of others and of the current by slope times η.
    #[inline(always)]
    fn responses(&self, d: usize, means: &[Lane], noise: &Noise) -> Vec<Lane> {
        let p = self.parameters;
        let variance = Lane::splat(noise.measurement[d].powi(2));
        let others = noise.others(d).map(Lane::splat);
        let (mut pole, mut eta) = (Lane::ZERO, vec![Lane::ZERO; p]);
        let (mut centred, mut meat) = (eta.clone(), vec![Lane::ZERO; p * p]);
        for k in (0..self.poles.len()).rev() {
            for i in 0..p {
                centred[i] = self.centred(k, i, means[i]);
                eta[i] = centred[i] + pole * eta[i];
            }
            pole = self.poles[k];
            let slopes = &self.slopes[3 * k..3 * k + 3];
            let mut share = Lane::ZERO;
            for i in 0..3 {
                share += others[i] * slopes[i] * slopes[i];
            }
            if k == 0 {
                share += variance * pole * pole;
            }
            for i in 0..p {
                let (by_own, by_others) = (variance * centred[i], share * eta[i]);
                for j in 0..p {
                    meat[i * p + j] += by_own * centred[j] + by_others * eta[j];
                }
            }
        }
        meat
    }
}

/// Filters the samples `range`.
#[inline(always)]
fn filter(
    degrees: &mut [Degree; 3],
    [simulated, measured]: [&mut Compiled<Lane>; 2],
    batch: &Batch,
    range: Range<usize>,
) {
    let width = batch.model.exogenous();
    let most = 1.0 - 1.0 / range.len() as f64;
    for k in range.clone() {
        let row = width * k..width * (k + 1);
        let instrument_exogenous = &batch.instrument_exogenous[row.clone()];
        simulated.look(batch.instrument_states.as_chunks().0[k], instrument_exogenous, None);
        measured.look(batch.measured.as_chunks().0[k], &batch.exogenous[row], None);
        let (slopes, known) = (simulated.slopes(), measured.known());
        let mut first = 0;
        for (d, degree) in degrees.iter_mut().enumerate() {
            let p = degree.parameters;
            let mut pole = Lane::ONE + slopes[d][d];
            for a in &mut pole.0 {
                *a = if *a > 0.0 { a.min(most) } else { 0.0 };
            }
            for i in 0..=p {
                let (f, z) = match i < p {
                    true => (measured.term(first + i), simulated.term(first + i)),
                    false => (Lane::ONE, Lane::ONE),
                };
                passed(&mut degree.phi, p + 1, pole, f);
                passed(&mut degree.zeta, p + 1, pole, z);
            }
            let increment = batch.measured[3 * (k + 1) + d] - batch.measured[3 * k + d];
            let increment = increment - known[d];
            passed(&mut degree.target, 1, pole, increment);
            degree.poles.push(pole);
            degree.slopes.extend(slopes[d]);
            degree.add();
            first += p;
        }
    }
}

/// Appends pole · (the value `width` entries ago) + `input`.
#[inline(always)]
fn passed(signal: &mut Vec<Lane>, width: usize, pole: Lane, input: Lane) {
    let before = signal.len().checked_sub(width).map_or(Lane::ZERO, |i| signal[i]);
    signal.push(pole * before + input);
}

/// Number of blocks of samples that are left out in turn.
pub const BLOCKS: usize = 10;
/// Quantile of Student's t with nine degrees of freedom over that of the normal distribution, for 95 % intervals.
const STUDENT: f64 = 2.262_157_163 / 1.959_963_985;

/// Jackknife covariance of an estimate, from its changes `without` each block, scaled so that 1.96 standard errors
/// give a 95 % interval. `None` if it is not finite.
pub fn jackknife<B>(
    blocks: impl ExactSizeIterator<Item = B>,
    without: impl Fn(B) -> Option<Vec<f64>>,
) -> Option<Vec<f64>> {
    let count = blocks.len() as f64;
    let share = STUDENT * STUDENT * (count - 1.0) / count;
    let mut covariance: Vec<f64> = Vec::new();
    for block in blocks {
        let moved = without(block)?;
        let p = moved.len();
        covariance.resize(p * p, 0.0);
        for (k, sum) in covariance.iter_mut().enumerate() {
            *sum += share * moved[k / p] * moved[k % p];
        }
    }
    covariance.iter().all(|c| c.is_finite()).then_some(covariance)
}
