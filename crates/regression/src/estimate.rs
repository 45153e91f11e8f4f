use std::collections::BTreeMap;
use std::sync::OnceLock;

use numerics::lanes::lane_of;
use numerics::{LANES, Lane, Number, congruence, quadratic};

use crate::lane_sums::LaneSums;
use crate::meat::autocovariances;
use crate::solve::{Normal, SolvedLanes, estimated};
use crate::spans::columns::Kept;
use crate::spans::squares::{add_squares, put_residuals};
use crate::sums::{AnyBatch, Group, Groups, over_batch};
use crate::{Batch, DegreeSums, Direction, Excitation, MeanRemoval, Sums};

/// An estimate of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// θ̂: surge, sway, yaw.
    pub parameters: Vec<f64>,
    /// Standard error of each.
    pub standard_errors: Vec<f64>,
    /// Their covariance, as many rows, row-major; 0 between degrees of freedom, which are estimated separately.
    pub covariance: Vec<f64>,
}

/// The outcome of the estimation from one run: an [`Estimate`], or its parameters alone.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome<T = Estimate> {
    /// An estimate.
    Identified(T),
    /// A direction is not excited: no estimate.
    NotIdentifiable(Direction),
    /// Fewer samples than unknowns.
    TooShort,
}

/// Why a run has no estimate.
enum Unsolved {
    NotIdentifiable(Direction),
    TooShort,
}

impl Unsolved {
    fn outcome<T>(self) -> Outcome<T> {
        match self {
            Self::NotIdentifiable(direction) => Outcome::NotIdentifiable(direction),
            Self::TooShort => Outcome::TooShort,
        }
    }
}

/// The solutions of all lanes.
struct Fit {
    groups: Vec<[DegreeSums<Lane>; 3]>,
    normals: [Normal<Lane>; 3],
    solved: [SolvedLanes; 3],
    unsolved: Vec<Option<Unsolved>>,
    /// One lane per parameter.
    theta: Vec<Lane>,
}

/// The part of an estimate that depends on the instruments alone: computed once for all batches that share model,
/// instrument states, inputs and segments.
pub struct Instruments {
    removal: MeanRemoval,
    /// By first sample and end of a group; lanes with the same group share the pass over the data. A group is summed
    /// as a whole, so that a run's result does not depend on where its neighbours' segments start.
    sums: BTreeMap<(usize, usize), LaneSums>,
    /// Per run its groups with the instruments' means, one per parameter.
    means: [Vec<Group>; LANES],
    /// See [`squares`]; computed when first asked for: only standard errors need them.
    squares: OnceLock<[Vec<Lane>; 2]>,
    /// ζ, if the runs share it.
    kept: Kept,
    /// Which degrees of freedom have a term 1, whose parameter is the intercept.
    constant: [bool; 3],
}

impl Instruments {
    /// The instruments of `batch`; its measured states are not used.
    pub fn new<X: Number>(batch: &Batch<X>, removal: MeanRemoval) -> Self {
        let (mut sums, kept) = (BTreeMap::new(), Kept::of(batch.any()));
        let means: [Vec<Group>; LANES] = std::array::from_fn(|lane| {
            let group = |(start, end): (usize, usize)| {
                let entry = sums.entry((start, end));
                let entry = entry
                    .or_insert_with(|| LaneSums::of_instruments(batch.any(), &kept, start..end))
                    .lane(lane);
                let centred = removal != MeanRemoval::None;
                let means = entry.degrees.iter().flat_map(|d| d.instrument_means(centred)).collect();
                Group { start, constants: means }
            };
            ranges(batch, removal, lane).map(group).collect()
        });
        let constant = batch.model.degrees.each_ref().map(|degree| degree.constant().is_some());
        Self { removal, sums, means, squares: OnceLock::new(), kept, constant }
    }

    /// Estimates every run of a batch with these instruments: instrumental variables, or least squares if they are
    /// the measured states.
    pub fn estimate<X: Number>(&self, batch: &Batch<X>) -> Vec<Outcome> {
        self.outcomes(batch, self.fit(batch))
    }

    /// The parameters of [`Instruments::estimate`]. Their standard errors take as long as all the rest.
    pub fn parameters<X: Number>(&self, batch: &Batch<X>) -> Vec<Outcome<Vec<f64>>> {
        let Fit { unsolved, theta, .. } = self.fit(batch);
        let named = |(lane, unsolved): (usize, Option<Unsolved>)| match unsolved {
            Some(unsolved) => unsolved.outcome(),
            None => Outcome::Identified(lane_of(&theta, lane)),
        };
        unsolved.into_iter().enumerate().map(named).collect()
    }

    /// [`Instruments::estimate`], and per run the [`Excitation`] of surge, sway and yaw.
    pub fn estimate_with_excitation<X: Number>(&self, batch: &Batch<X>) -> Vec<(Outcome, [Excitation; 3])> {
        let fit = self.fit(batch);
        let excitation = |lane: usize| fit.normals.each_ref().map(|normal| normal.lane(lane).excitation());
        let excitations: Vec<_> = (0..LANES).map(excitation).collect();
        self.outcomes(batch, fit).into_iter().zip(excitations).collect()
    }

    /// Solves the normal equations of all runs.
    fn fit<X: Number>(&self, batch: &Batch<X>) -> Fit {
        let groups = self.groups(batch);
        let centred = self.removal != MeanRemoval::None;
        let normals = [0, 1, 2].map(|d: usize| Normal::new(groups.iter().map(|group| &group[d]), centred));
        let solved = normals.each_ref().map(Normal::solve_lanes);
        let unsolved: Vec<Option<Unsolved>> =
            (0..LANES).map(|lane| self.unsolved(&solved, batch.samples(), lane)).collect();
        let mut theta: Vec<Lane> = solved.iter().flat_map(|degree| degree.theta.iter().copied()).collect();
        for lane in (0..LANES).filter(|lane| unsolved[*lane].is_some()) {
            theta.iter_mut().for_each(|lanes| lanes[lane] = 0.0);
        }
        Fit { groups, normals, solved, unsolved, theta }
    }

    /// The estimates with their standard errors.
    fn outcomes<X: Number>(&self, batch: &Batch<X>, fit: Fit) -> Vec<Outcome> {
        let Fit { groups, solved, unsolved, theta, .. } = fit;
        let intercepts = self.intercepts(&groups, &theta);
        let intercepts = intercepts.each_ref().map(Vec::as_slice);
        let residuals = residuals(batch.any(), &self.kept, &theta, intercepts);
        let means = || self.means.each_ref().map(Vec::as_slice);
        let squares = self.squares.get_or_init(|| squares(batch.any(), &self.kept, means()));
        let (errors, meats) = self.standard_errors(squares, &solved, &residuals);
        let covariance = |lane: usize| {
            let pairs = solved.iter().zip(&meats);
            block_diagonal(pairs.map(|(degree, meat)| {
                congruence(degree.theta.len(), &lane_of(&degree.inverse, lane), &lane_of(meat, lane))
            }))
        };
        let named = |(lane, unsolved): (usize, Option<Unsolved>)| match unsolved {
            Some(unsolved) => unsolved.outcome(),
            None => Outcome::Identified(Estimate {
                parameters: lane_of(&theta, lane),
                standard_errors: lane_of(&errors, lane),
                covariance: covariance(lane),
            }),
        };
        unsolved.into_iter().enumerate().map(named).collect()
    }

    /// All sums of a batch. Runs with fewer groups than others have empty ones.
    fn groups<X: Number>(&self, batch: &Batch<X>) -> Vec<[DegreeSums<Lane>; 3]> {
        let sums: BTreeMap<_, LaneSums> = self
            .sums
            .iter()
            .map(|(range, sums)| (range, sums.with_measured(batch.any(), &self.kept)))
            .collect();
        if self.sums.len() == 1 {
            return sums.into_values().map(LaneSums::whole).collect();
        }
        let most = self.means.iter().map(Vec::len).max().unwrap_or(0);
        let mut groups = vec![batch.model.degrees.each_ref().map(DegreeSums::of); most];
        for lane in 0..LANES {
            for (group, range) in groups.iter_mut().zip(ranges(batch, self.removal, lane)) {
                sums[&range].put(lane, group);
            }
        }
        groups
    }

    /// Why a lane has no estimate.
    fn unsolved(&self, solved: &[SolvedLanes; 3], samples: usize, lane: usize) -> Option<Unsolved> {
        solved.iter().enumerate().find_map(|(degree, fit)| {
            let (p, inverse) = (fit.theta.len(), &fit.inverse);
            let held = || (0..p * p).all(|k| inverse[k][lane] == 0.0);
            if samples <= p + self.intercepts_of(degree, lane) {
                return Some(Unsolved::TooShort);
            }
            let unexcited = fit.unexcited[lane].or_else(|| held().then_some(0));
            unexcited.map(|parameter| Unsolved::NotIdentifiable(Direction { degree, parameter }))
        })
    }

    /// The number of intercepts of degree of freedom `d` of a lane.
    fn intercepts_of(&self, d: usize, lane: usize) -> usize {
        if self.removal != MeanRemoval::None && !self.constant[d] { self.means[lane].len() } else { 0 }
    }

    /// Three per run and group.
    fn intercepts(&self, groups: &[[DegreeSums<Lane>; 3]], theta: &[Lane]) -> [Vec<Group>; LANES] {
        let centred = self.removal != MeanRemoval::None;
        let of = |group: &[DegreeSums<Lane>; 3]| {
            let mut theta = theta;
            group.each_ref().map(|degree| {
                let (slopes, rest) = theta.split_at(degree.parameters());
                theta = rest;
                degree.intercept(slopes, centred)
            })
        };
        let lanes: Vec<[Lane; 3]> = groups.iter().map(of).collect();
        std::array::from_fn(|lane| {
            let groups = self.means[lane].iter().zip(&lanes);
            groups
                .map(|(group, lanes)| Group {
                    start: group.start,
                    constants: lanes.map(|constant| constant[lane]).to_vec(),
                })
                .collect()
        })
    }

    /// Of all lanes: from A⁻¹ B A⁻ᵀ with B = γ₀ Σζᶜζᶜᵀ + γ₁ Σ neighbours, which is returned, too, p × p for each
    /// degree of freedom.
    fn standard_errors(
        &self,
        [squares, neighbours]: &[Vec<Lane>; 2],
        solved: &[SolvedLanes; 3],
        residuals: &[Vec<Lane>; 3],
    ) -> (Vec<Lane>, Vec<Vec<Lane>>) {
        let samples = residuals[0].len();
        let freedom = |d: usize| {
            Lane(std::array::from_fn(|lane| {
                let p = solved[d].theta.len();
                let unknowns = estimated(p, |k| solved[d].inverse[k][lane]) + self.intercepts_of(d, lane);
                samples as f64 - unknowns as f64
            }))
        };
        let freedom = [0, 1, 2].map(freedom);
        let gammas = residuals.each_ref().map(|sequence| autocovariances(sequence));
        numerics::vectorized!({
            let (mut errors, mut meats) = (Vec::new(), Vec::new());
            let mut pairs = squares.iter().zip(neighbours);
            for (d, SolvedLanes { theta, inverse, .. }) in solved.iter().enumerate() {
                let p = theta.len();
                let factor = Lane::splat(samples as f64) / freedom[d];
                let [gamma0, gamma1] = gammas[d].map(|gamma| gamma * factor);
                let mut meat = vec![Lane::ZERO; p * p];
                for i in 0..p {
                    for (j, (squares, neighbours)) in (i..p).zip(pairs.by_ref()) {
                        meat[i * p + j] = gamma0 * *squares + gamma1 * *neighbours;
                        meat[j * p + i] = meat[i * p + j];
                    }
                }
                let variance = |row: &[Lane]| quadratic(row, &meat).each(Lane::ZERO, f64::max);
                errors.extend(inverse.chunks_exact(p.max(1)).map(|row| variance(row).sqrt()));
                meats.push(meat);
            }
            (errors, meats)
        })
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

/// θ̂ of one run and the terms of its covariance.
pub(crate) struct Solved {
    pub theta: Vec<f64>,
    inverses: Vec<Vec<f64>>,
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
        let normals = [0, 1, 2].map(|d| self.normal(d));
        let samples = self.samples();
        let mut solved = Solved { theta: Vec::new(), inverses: Vec::new() };
        for (d, normal) in normals.iter().enumerate() {
            if samples <= (normal.b.len() + self.intercepts_of(d)) as u64 {
                return Err(Outcome::TooShort);
            }
            let unexcited = |parameter| Outcome::NotIdentifiable(Direction { degree: d, parameter });
            let (theta, inverse) = normal.solve().map_err(unexcited)?;
            if estimated(theta.len(), |k| inverse[k]) == 0 {
                return Err(unexcited(0));
            }
            solved.theta.extend(theta);
            solved.inverses.push(inverse);
        }
        Ok(solved)
    }

    /// The number of intercepts of degree of freedom `d`.
    fn intercepts_of(&self, d: usize) -> usize {
        let constant = self.groups.first().is_some_and(|sums| sums.degrees[d].known.constant);
        if self.centred && !constant { self.groups.len() } else { 0 }
    }
}

impl Solved {
    /// A⁻¹ of a degree of freedom, p × p.
    pub(crate) fn inverse(&self, d: usize) -> &[f64] {
        &self.inverses[d]
    }

    /// From A⁻¹ B A⁻ᵀ with B of each degree of freedom, p × p.
    pub(crate) fn spread(&self, meats: &[Vec<f64>; 3]) -> Vec<f64> {
        let mut standard_errors = Vec::with_capacity(self.theta.len());
        for (inverse, meat) in self.inverses.iter().zip(meats) {
            let p = inverse.len().isqrt();
            let variance = |row: &[f64]| quadratic(row, meat).max(0.0);
            standard_errors.extend(inverse.chunks_exact(p).map(|row| variance(row).sqrt()));
        }
        standard_errors
    }

    /// The covariance of θ̂, of these meats.
    pub(crate) fn covariance(&self, meats: &[Vec<f64>; 3]) -> Vec<f64> {
        let pairs = self.inverses.iter().zip(meats);
        block_diagonal(pairs.map(|(inverse, meat)| congruence(inverse.len().isqrt(), inverse, meat)))
    }
}

/// The matrix with the square `blocks` along its diagonal, and zeros elsewhere, row-major.
fn block_diagonal(blocks: impl Iterator<Item = Vec<f64>>) -> Vec<f64> {
    let blocks: Vec<Vec<f64>> = blocks.collect();
    let all: usize = blocks.iter().map(|block| block.len().isqrt()).sum();
    let mut matrix = vec![0.0; all * all];
    let mut first = 0;
    for block in blocks {
        let p = block.len().isqrt();
        for (row, entries) in block.chunks_exact(p.max(1)).enumerate() {
            let at = (first + row) * all + first;
            matrix[at..at + p].copy_from_slice(entries);
        }
        first += p;
    }
    matrix
}

// The contribution of the residuals to the covariance of an estimate.
//
// θ̂ − θ = A⁻¹ Σ ζᶜ(k) ε(k). The residual contains e(k+1) − e(k), so it is correlated with its neighbours: its
// autocovariances γ₀, γ₁ are those of the likeliest moving average of order one.

/// Σ ζᶜζᶜᵀ and Σ (ζᶜ(k−1) ζᶜ(k)ᵀ + its transpose), upper triangles of each degree of freedom. `kept` is ζ, if stored. `means`: the
/// instruments' means per run and group.
fn squares(batch: AnyBatch, kept: &Kept, means: Groups) -> [Vec<Lane>; 2] {
    let degrees = batch.model().degrees.iter();
    let triangles = degrees.map(|d| d.terms.len() * (d.terms.len() + 1) / 2).sum();
    let mut sums = [0, 1].map(|_| vec![Lane::ZERO; triangles]);
    over_batch!(batch, |batch| {
        add_squares(&batch, kept, means, sums.each_mut().map(Vec::as_mut_slice));
    });
    sums
}

/// The residuals of `theta`, one lane per parameter: surge, sway, yaw. `kept` is ζ, if stored. `intercepts`: three per
/// run and group.
fn residuals(batch: AnyBatch, kept: &Kept, theta: &[Lane], intercepts: Groups) -> [Vec<Lane>; 3] {
    let mut all = [const { Vec::new() }; 3];
    over_batch!(batch, |batch| {
        put_residuals(&batch, kept, theta, intercepts, &mut all);
    });
    all
}
