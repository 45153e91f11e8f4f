use std::collections::BTreeMap;

use vessel::{LANES, Lane};

use crate::residual::{Fitted, Group, ResidualSums};
use crate::solve::Normal;
use crate::sums::LaneSums;
use crate::{Batch, Direction, Excitation, Sums};

/// How the instruments' mean is removed: how many intercepts a degree of freedom has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeanRemoval {
    /// Not at all.
    None,
    /// Segment by segment: an intercept per segment.
    Batch,
    /// Over the whole run: one intercept.
    Complete,
}

/// An estimate of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// θ̂: surge, sway, yaw.
    pub parameters: Vec<f64>,
    /// Standard error of each.
    pub standard_errors: Vec<f64>,
}

/// What the estimation of one run came to.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// An estimate.
    Identified(Estimate),
    /// A direction is not excited: no estimate.
    NotIdentifiable(Direction),
    /// Fewer samples than unknowns.
    TooShort,
}

/// Estimates every run of a batch: instrumental variables, or least squares where the instruments are the measured
/// states. With it, how each degree of freedom was excited.
pub fn estimate(batch: &Batch, removal: MeanRemoval) -> Vec<Outcome> {
    fit(batch, removal, |_| ()).into_iter().map(|(outcome, ())| outcome).collect()
}

impl Outcome {
    /// [`estimate`], and per run the [`Excitation`] of surge, sway and yaw.
    pub fn with_excitation(batch: &Batch, removal: MeanRemoval) -> Vec<(Self, [Excitation; 3])> {
        fit(batch, removal, |normals| [0, 1, 2].map(|d: usize| normals[d].excitation()))
    }
}

fn fit<T>(batch: &Batch, removal: MeanRemoval, examine: impl Fn(&[Normal]) -> T) -> Vec<(Outcome, T)> {
    let mut runs = grouped_sums(batch, removal);
    let mut theta = vec![Lane::ZERO; batch.model.parameters()];
    let mut fits = Vec::with_capacity(LANES);
    for (lane, run) in runs.iter_mut().enumerate() {
        let normals: Vec<Normal> = (0..3).map(|d| run.normal(d, removal)).collect();
        let solved = run.solve(&normals, removal);
        if let Ok(solved) = &solved {
            theta.iter_mut().zip(&solved.theta).for_each(|(lanes, value)| lanes[lane] = *value);
        }
        fits.push((solved, examine(&normals)));
    }
    let groups: [&[Group]; LANES] = std::array::from_fn(|lane| runs[lane].groups.as_slice());
    let residuals = ResidualSums::over(batch, &Fitted { theta: &theta, groups });
    let finish = |(lane, (solved, examined)): (usize, (Result<Solved, Outcome>, T))| {
        let outcome = match solved {
            Ok(solved) => solved.finish(&residuals, lane, batch.samples()),
            Err(outcome) => outcome,
        };
        (outcome, examined)
    };
    fits.into_iter().enumerate().map(finish).collect()
}

/// The data of one run as the estimator groups it.
struct Run {
    sums: Vec<Sums>,
    groups: Vec<Group>,
}

/// Sums per run and group. A group is summed in one piece from its first to its last sample, so that a run's numbers do
/// not depend on where its neighbours' segments start; lanes with the same group share the pass over the data.
fn grouped_sums(batch: &Batch, removal: MeanRemoval) -> Vec<Run> {
    let whole: &[usize] = &[0];
    let starts = |lane: usize| if removal == MeanRemoval::Batch { batch.segments[lane] } else { whole };
    let mut known: BTreeMap<(usize, usize), LaneSums> = BTreeMap::new();
    let mut run = |lane: usize| {
        let ends = starts(lane).iter().skip(1).copied().chain([batch.samples()]);
        let mut run = Run { sums: Vec::new(), groups: Vec::new() };
        for (start, end) in starts(lane).iter().copied().zip(ends) {
            let sums = known.entry((start, end)).or_insert_with(|| LaneSums::over(batch, start..end));
            run.sums.push(sums.lane(lane));
            run.groups.push(Group { start, ..Group::default() });
        }
        run
    };
    (0..LANES).map(&mut run).collect()
}

/// θ̂ of one run and what its covariance needs.
struct Solved {
    theta: Vec<f64>,
    inverses: Vec<Vec<f64>>,
    intercepts: usize,
}

impl Run {
    fn normal(&self, d: usize, removal: MeanRemoval) -> Normal {
        Normal::new(self.sums.iter().map(|s| &s.degrees[d]), removal != MeanRemoval::None)
    }

    /// Solves all degrees of freedom and sets the groups' intercepts and means.
    fn solve(&mut self, normals: &[Normal], removal: MeanRemoval) -> Result<Solved, Outcome> {
        let centred = removal != MeanRemoval::None;
        let samples: u64 = self.sums.iter().map(|s| s.samples).sum();
        let intercepts = if centred { self.groups.len() } else { 0 };
        let mut solved = Solved { theta: Vec::new(), inverses: Vec::new(), intercepts };
        for (d, normal) in normals.iter().enumerate() {
            if samples <= (normal.b.len() + intercepts) as u64 {
                return Err(Outcome::TooShort);
            }
            let unexcited = |parameter| Outcome::NotIdentifiable(Direction { degree: d, parameter });
            let (theta, inverse) = normal.solve().map_err(unexcited)?;
            if !theta.iter().all(|t| t.is_finite()) {
                return Err(unexcited(0));
            }
            for (group, sums) in self.groups.iter_mut().zip(&self.sums) {
                group.set(d, &sums.degrees[d], &theta, centred);
            }
            solved.theta.extend(theta);
            solved.inverses.push(inverse);
        }
        Ok(solved)
    }
}

impl Group {
    /// Intercept (ΣΔy − Σφᵀθ)/N and instrument means Σζ/N of degree of freedom `d`.
    fn set(&mut self, d: usize, sums: &crate::DegreeSums, theta: &[f64], centred: bool) {
        let (p, lifted) = (theta.len(), theta.len() + 1);
        let n = sums.a[lifted * lifted - 1];
        let share = if centred && n > 0.0 { 1.0 / n } else { 0.0 };
        let predicted: f64 = theta.iter().zip(&sums.a[p * lifted..]).map(|(t, f)| t * f).sum();
        self.intercepts[d] = share * (sums.b[p] - predicted);
        self.means.extend((0..p).map(|i| share * sums.a[i * lifted + p]));
    }
}

impl Solved {
    /// Standard errors from A⁻¹ (γ₀ Σζᶜζᶜᵀ + γ₁ Σ neighbours) A⁻ᵀ.
    fn finish(self, residuals: &ResidualSums, lane: usize, samples: usize) -> Outcome {
        let mut standard_errors = Vec::with_capacity(self.theta.len());
        let mut place = 0;
        for (d, inverse) in self.inverses.iter().enumerate() {
            let p = inverse.len().isqrt();
            let freedom = (samples - p - self.intercepts) as f64;
            let gamma0 = residuals.lag0[d][lane] / freedom;
            let gamma1 = (residuals.lag1[d][lane] / freedom).clamp(-0.5 * gamma0, 0.5 * gamma0);
            let mut middle = vec![0.0; p * p];
            for i in 0..p {
                for j in i..p {
                    let (squares, neighbours) =
                        (residuals.squares[place][lane], residuals.neighbours[place][lane]);
                    middle[i * p + j] = gamma0 * squares + gamma1 * neighbours;
                    middle[j * p + i] = middle[i * p + j];
                    place += 1;
                }
            }
            standard_errors
                .extend((0..p).map(|i| quadratic(&inverse[i * p..(i + 1) * p], &middle).max(0.0).sqrt()));
        }
        Outcome::Identified(Estimate { parameters: self.theta, standard_errors })
    }
}

/// xᵀ B x.
fn quadratic(x: &[f64], b: &[f64]) -> f64 {
    let p = x.len();
    (0..p * p).map(|k| x[k / p] * b[k] * x[k % p]).sum()
}
