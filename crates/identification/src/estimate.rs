use std::collections::BTreeMap;

use numerics::quadratic;
use vessel::{LANES, Lane, Number};

use crate::bounded::estimated;
use crate::residual::{Group, InstrumentSquares, ResidualSums};
use crate::solve::Normal;
use crate::sums::LaneSums;
use crate::{Batch, DegreeSums, Direction, Excitation, MeanRemoval, Sums};

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

/// What an estimate needs to know of the instruments alone: computed once for all batches that share model, instrument
/// states, inputs and segments.
pub struct Instruments {
    removal: MeanRemoval,
    /// By first sample and end of a group; lanes with the same group share the pass over the data. A group is summed in
    /// one piece, so that a run's numbers do not depend on where its neighbours' segments start.
    sums: BTreeMap<(usize, usize), LaneSums>,
    /// Per run its groups with the instruments' means, one per parameter.
    means: [Vec<Group>; LANES],
    squares: InstrumentSquares,
}

impl Instruments {
    /// The instruments of `batch`; what was measured does not matter.
    pub fn new<X: Number>(batch: &Batch<X>, removal: MeanRemoval) -> Self {
        let mut sums = BTreeMap::new();
        let means: [Vec<Group>; LANES] = std::array::from_fn(|lane| {
            let group = |(start, end): (usize, usize)| {
                let own = sums.entry((start, end));
                let own = own.or_insert_with(|| LaneSums::of_instruments(batch.any(), start..end)).lane(lane);
                let centred = removal != MeanRemoval::None;
                let means = own.degrees.iter().flat_map(|d| d.instrument_means(centred)).collect();
                Group { start, constants: means }
            };
            ranges(batch, removal, lane).map(group).collect()
        });
        let squares = InstrumentSquares::over(batch.any(), means.each_ref().map(Vec::as_slice));
        Self { removal, sums, means, squares }
    }

    /// Estimates every run of a batch with these instruments: instrumental variables, or least squares where they are the
    /// measured states.
    pub fn estimate<X: Number>(&self, batch: &Batch<X>) -> Vec<Outcome> {
        self.fit(batch, |_| ()).into_iter().map(|(outcome, ())| outcome).collect()
    }

    /// [`Instruments::estimate`], and per run the [`Excitation`] of surge, sway and yaw.
    pub fn estimate_with_excitation<X: Number>(&self, batch: &Batch<X>) -> Vec<(Outcome, [Excitation; 3])> {
        self.fit(batch, |normals| [0, 1, 2].map(|d: usize| normals[d].excitation()))
    }

    fn fit<X: Number, T>(&self, batch: &Batch<X>, examine: impl Fn(&[Normal; 3]) -> T) -> Vec<(Outcome, T)> {
        let sums: BTreeMap<_, LaneSums> =
            self.sums.iter().map(|(range, own)| (range, own.with_measured(batch.any()))).collect();
        let mut theta = vec![Lane::ZERO; batch.model.parameters()];
        let mut intercepts: [Vec<Group>; LANES] = [const { Vec::new() }; LANES];
        let mut fits = Vec::with_capacity(LANES);
        for lane in 0..LANES {
            let groups = ranges(batch, self.removal, lane).map(|range| sums[&range].lane(lane)).collect();
            let run = Run { groups, centred: self.removal != MeanRemoval::None };
            let normals = [0, 1, 2].map(|d| run.normal(d));
            let solved = run.solve(&normals);
            if let Ok(solved) = &solved {
                theta.iter_mut().zip(&solved.theta).for_each(|(lanes, value)| lanes[lane] = *value);
                intercepts[lane] = run.intercepts(&self.means[lane], &solved.theta);
            }
            fits.push((solved, examine(&normals)));
        }
        let residuals = ResidualSums::over(batch.any(), &theta, intercepts.each_ref().map(Vec::as_slice));
        let finish = |(lane, (solved, examined)): (usize, (Result<Solved, Outcome>, T))| {
            let errors = |solved: Solved| {
                let standard_errors =
                    solved.standard_errors(&residuals, &self.squares, lane, batch.samples());
                Outcome::Identified(Estimate { parameters: solved.theta, standard_errors })
            };
            (solved.map_or_else(std::convert::identity, errors), examined)
        };
        fits.into_iter().enumerate().map(finish).collect()
    }
}

/// First sample and end of each group of samples of a run that has an intercept of its own.
pub(crate) fn ranges<X: Number>(
    batch: &Batch<X>,
    removal: MeanRemoval,
    lane: usize,
) -> impl Iterator<Item = (usize, usize)> {
    let starts: &[usize] = if removal == MeanRemoval::Batch { batch.segments[lane] } else { &[0] };
    let ends = starts.iter().skip(1).copied().chain([batch.samples()]);
    starts.iter().copied().zip(ends)
}

/// The sums of one run, group by group.
pub(crate) struct Run {
    pub groups: Vec<Sums>,
    pub centred: bool,
}

/// θ̂ of one run and what its covariance needs.
pub(crate) struct Solved {
    pub theta: Vec<f64>,
    inverses: Vec<Vec<f64>>,
    intercepts: [usize; 3],
}

impl Run {
    fn normal(&self, d: usize) -> Normal {
        Normal::new(self.groups.iter().map(|s| &s.degrees[d]), self.centred)
    }

    /// Number of regression pairs.
    pub(crate) fn samples(&self) -> u64 {
        self.groups.iter().map(|s| s.samples).sum()
    }

    /// θ̂ of all degrees of freedom.
    pub(crate) fn solution(&self) -> Result<Solved, Outcome> {
        self.solve(&[0, 1, 2].map(|d| self.normal(d)))
    }

    /// Solves all degrees of freedom.
    fn solve(&self, normals: &[Normal; 3]) -> Result<Solved, Outcome> {
        let samples = self.samples();
        let intercepts = [0, 1, 2].map(|d| self.intercepts_of(d));
        let mut solved = Solved { theta: Vec::new(), inverses: Vec::new(), intercepts };
        for (d, normal) in normals.iter().enumerate() {
            if samples <= (normal.b.len() + intercepts[d]) as u64 {
                return Err(Outcome::TooShort);
            }
            let unexcited = |parameter| Outcome::NotIdentifiable(Direction { degree: d, parameter });
            let (theta, inverse) = normal.solve().map_err(unexcited)?;
            if estimated(&inverse, theta.len()) == 0 {
                return Err(unexcited(0));
            }
            solved.theta.extend(theta);
            solved.inverses.push(inverse);
        }
        Ok(solved)
    }

    /// How many intercepts degree of freedom `d` has.
    fn intercepts_of(&self, d: usize) -> usize {
        let constant = self.groups.first().is_some_and(|sums| sums.degrees[d].known.constant);
        if self.centred && !constant { self.groups.len() } else { 0 }
    }

    /// Three intercepts per group.
    fn intercepts(&self, groups: &[Group], theta: &[f64]) -> Vec<Group> {
        let of = |(group, sums): (&Group, &Sums)| {
            let mut theta = theta;
            let intercept = |degree: &DegreeSums| {
                let (own, rest) = theta.split_at(degree.parameters());
                theta = rest;
                degree.intercept(own, self.centred)
            };
            Group { start: group.start, constants: sums.degrees.iter().map(intercept).collect() }
        };
        groups.iter().zip(&self.groups).map(of).collect()
    }
}

impl Solved {
    /// From A⁻¹ (γ₀ Σζᶜζᶜᵀ + γ₁ Σ neighbours) A⁻ᵀ.
    fn standard_errors(
        &self,
        residuals: &ResidualSums,
        instruments: &InstrumentSquares,
        lane: usize,
        samples: usize,
    ) -> Vec<f64> {
        let mut pairs = instruments.squares.iter().zip(&instruments.neighbours);
        let middles = [0, 1, 2].map(|d: usize| {
            let p = self.inverses[d].len().isqrt();
            let freedom = (samples - estimated(&self.inverses[d], p) - self.intercepts[d]) as f64;
            let gamma0 = residuals.lag0[d][lane] / freedom;
            let gamma1 = (residuals.lag1[d][lane] / freedom).clamp(-0.5 * gamma0, 0.5 * gamma0);
            let mut middle = vec![0.0; p * p];
            for i in 0..p {
                for (j, (squares, neighbours)) in (i..p).zip(pairs.by_ref()) {
                    middle[i * p + j] = gamma0 * squares[lane] + gamma1 * neighbours[lane];
                    middle[j * p + i] = middle[i * p + j];
                }
            }
            middle
        });
        self.spread(&middles, [1.0; 3])
    }

    /// N over N less unknowns, per degree of freedom: what residuals that were fitted are too small by.
    pub(crate) fn fitted(&self, samples: u64) -> [f64; 3] {
        let own = |d: usize| estimated(&self.inverses[d], self.inverses[d].len().isqrt());
        let unknowns = |d: usize| own(d) + self.intercepts[d];
        [0, 1, 2].map(|d| samples as f64 / (samples as f64 - unknowns(d) as f64))
    }

    /// From A⁻¹ B A⁻ᵀ with B of each degree of freedom, p × p, times `factors`.
    pub(crate) fn spread(&self, middles: &[Vec<f64>; 3], factors: [f64; 3]) -> Vec<f64> {
        let mut standard_errors = Vec::with_capacity(self.theta.len());
        for ((inverse, middle), factor) in self.inverses.iter().zip(middles).zip(factors) {
            let p = inverse.len().isqrt();
            let variance = |row: &[f64]| (factor * quadratic(row, middle)).max(0.0);
            standard_errors.extend(inverse.chunks_exact(p).map(|row| variance(row).sqrt()));
        }
        standard_errors
    }
}
