//! Shares over more candidates than fit into memory: the best over few of them, and a pass over all for those that
//! would improve it, until there are none (column generation, Dantzig & Wolfe 1960; for designs Böhning 1986, the
//! vertex exchange). Every pass gives the Kiefer–Wolfowitz gap over all candidates.

use std::collections::BTreeSet;

use numerics::dot;
use rayon::prelude::*;

use crate::certificate::{is_semidefinite, row_scaling};
use crate::{
    Bounds, Candidates, Design, Error, Evaluation, Objective, Options, Status, is_concave, solve_within,
};

/// Candidates that are read in blocks, repeatedly.
pub trait Blocks: Sync {
    /// Why a block cannot be read.
    type Error: From<Error> + Send;

    /// Number of blocks.
    fn blocks(&self) -> usize;

    /// The candidates of block `i`, all of the same dimensions.
    fn block(&self, i: usize) -> Result<Candidates, Self::Error>;
}

/// The best shares over all candidates of [`Blocks`].
#[derive(Clone, Debug)]
pub struct Streamed {
    /// The candidates with a share, by block and index in it, ascending.
    pub members: Vec<(usize, usize)>,
    /// Shares of these. `gap` and `status` are those over all candidates.
    pub design: Design,
    /// The mean of all candidates: the information of equal shares.
    pub mean: Candidates,
    /// Number of candidates.
    pub candidates: usize,
    /// Number of passes over all of them.
    pub passes: u32,
}

/// Candidates of the first optimisation.
const SAMPLE: usize = 2048;
/// Candidates of a block, and of all, that may join after a pass.
const JOINING: [usize; 2] = [16, 256];
/// Maximum number of passes.
const PASSES: u32 = 60;

/// Shares that maximise the D-criterion over all of `source`, to the gap in `options`.
///
/// # Errors
/// A block cannot be read; as [`crate::solve`].
pub fn solve_streamed<S: Blocks>(source: &S, options: &Options) -> Result<Streamed, S::Error> {
    let (mut working, mean, candidates) = survey(source)?;
    let scaling = Scaling::of(&working.candidates);
    let mut passes = 0;
    loop {
        let relaxed = solve_within(&working.candidates, &Bounds::default(), options)?;
        working.keep(|place| relaxed.shares[place] > 0.0);
        let mut design = solve_within(&working.candidates, &Bounds::default(), options)?;
        let pass = Pass::over(source, &weights(&working.candidates, &design.shares)?, &scaling)?;
        passes += 1;
        let p = working.candidates.dimension() as f64;
        design.gap = pass.largest - p;
        let reached = design.gap <= options.tolerance.max(LEAST_GAP) * p;
        let joined = !reached && passes < PASSES && working.join(pass.joining);
        if !joined {
            design.status = Status::of(reached, pass.concave && is_concave(&working.candidates));
            return Ok(Streamed { members: working.places, design, mean, candidates, passes });
        }
    }
}

/// Relative gap due to rounding over equal candidates.
const LEAST_GAP: f64 = 1e-12;

/// The working set of candidates, and their origins.
struct Working {
    places: Vec<(usize, usize)>,
    candidates: Candidates,
}

impl Working {
    fn keep(&mut self, kept: impl Fn(usize) -> bool) {
        let mut candidates = self.candidates.none();
        let mut places = Vec::new();
        for place in (0..self.places.len()).filter(|place| kept(*place)) {
            candidates.append(self.candidates.candidate(place));
            places.push(self.places[place]);
        }
        *self = Self { places, candidates };
    }

    /// Adds those that are not in the set yet; returns whether there were any.
    fn join(&mut self, joining: Vec<Joining>) -> bool {
        let new = joining.into_iter().filter(|one| !self.places.contains(&one.place)).collect::<Vec<_>>();
        let places = self.places.iter().enumerate();
        let mut all: Vec<((usize, usize), &[f64])> =
            places.map(|(i, place)| (*place, self.candidates.candidate(i))).collect();
        all.extend(new.iter().map(|one| (one.place, one.entries.as_slice())));
        all.sort_by_key(|(place, _)| *place);
        let mut candidates = self.candidates.none();
        all.iter().for_each(|(_, entries)| candidates.append(entries));
        *self = Self { places: all.into_iter().map(|(place, _)| place).collect(), candidates };
        !new.is_empty()
    }
}

/// An even sample of all candidates, their mean and their number.
fn survey<S: Blocks>(source: &S) -> Result<(Working, Candidates, usize), S::Error> {
    let each = SAMPLE.div_ceil(source.blocks().max(1)).max(1);
    let sample = |i: usize| -> Result<_, S::Error> {
        let block = source.block(i)?;
        let mut sum = Vec::new();
        block.sum(&vec![1.0; block.len()], &mut sum);
        let mut sample = Working { places: Vec::new(), candidates: block.none() };
        for place in sampled(&block, each) {
            sample.places.push((i, place));
            sample.candidates.append(block.candidate(place));
        }
        Ok((block.len(), sum, sample))
    };
    let blocks: Vec<_> = (0..source.blocks()).into_par_iter().map(sample).collect();
    let mut all: Option<(usize, Vec<f64>, Working)> = None;
    for block in blocks {
        let (count, sum, sample) = block?;
        match &mut all {
            None => all = Some((count, sum, sample)),
            Some((known, total, working)) => {
                *known += count;
                total.iter_mut().zip(&sum).for_each(|(total, more)| *total += more);
                working.places.extend(sample.places);
                (0..sample.candidates.len())
                    .for_each(|place| working.candidates.append(sample.candidates.candidate(place)));
            }
        }
    }
    let (candidates, sum, working) = all.filter(|(count, ..)| *count > 0).ok_or(Error::Empty)?;
    let mut mean = working.candidates.none();
    mean.append(&sum.iter().map(|entry| entry / candidates as f64).collect::<Vec<_>>());
    let (scaled, _) = mean.scaled()?;
    scaled.check_excitation()?;
    Ok((working, mean, candidates))
}

/// `each` evenly spaced indices of `block`, and the candidates with most information about every row, so that a
/// direction that few excite is not missed.
fn sampled(block: &Candidates, each: usize) -> BTreeSet<usize> {
    let evenly = (0..block.len()).step_by(block.len().div_ceil(each).max(1));
    let size = |q: usize, entry: usize| block.candidate(q)[entry].abs();
    let strongest = |entry: usize| {
        (0..block.len()).max_by(|a, b| size(*a, entry).total_cmp(&size(*b, entry)).then(b.cmp(a)))
    };
    let diagonal = block.blocks().flat_map(|(n, range)| (0..n).map(move |i| range.start + i * n + i));
    evenly.chain(diagonal.filter_map(strongest)).collect()
}

/// Factors that make every block symmetric, if there are any.
struct Scaling(Option<Vec<Vec<f64>>>);

impl Scaling {
    fn of(sample: &Candidates) -> Self {
        let of_block = |(n, range): (usize, std::ops::Range<usize>)| {
            row_scaling(n, (0..sample.len()).map(|q| &sample.candidate(q)[range.clone()]))
        };
        Self(sample.blocks().map(of_block).collect())
    }

    /// Whether all of these are symmetric and positive semidefinite with it.
    fn holds(&self, candidates: &Candidates) -> bool {
        let Some(factors) = &self.0 else { return false };
        let of_block = |((n, range), sums): ((usize, std::ops::Range<usize>), &Vec<f64>)| {
            (0..candidates.len()).all(|q| is_semidefinite(n, &candidates.candidate(q)[range.clone()], sums))
        };
        candidates.blocks().zip(factors).all(of_block)
    }
}

/// The weights of a candidate's entries in its sensitivity.
fn weights(candidates: &Candidates, shares: &[f64]) -> Result<Vec<f64>, Error> {
    let balanced = candidates.balanced()?;
    let mut at = Evaluation::default();
    let singular = || Error::Solver("the shares are singular".into());
    balanced.candidates.evaluate(shares, &mut at).ok_or_else(singular)?;
    let (mut weights, mut first) = (at.inverse_transposed, 0);
    for (n, range) in candidates.blocks() {
        for (e, weight) in weights[range].iter_mut().enumerate() {
            *weight /= balanced.rows[first + e / n] * balanced.columns[first + e % n];
        }
        first += n;
    }
    Ok(weights)
}

/// A candidate whose share should grow.
struct Joining {
    sensitivity: f64,
    place: (usize, usize),
    entries: Vec<f64>,
}

/// The result of a pass over all candidates for some shares.
struct Pass {
    largest: f64,
    joining: Vec<Joining>,
    concave: bool,
}

impl Pass {
    fn over<S: Blocks>(source: &S, weights: &[f64], scaling: &Scaling) -> Result<Self, S::Error> {
        let look = |i: usize| -> Result<Self, S::Error> {
            let block = source.block(i)?;
            let gains: Vec<f64> = (0..block.len()).map(|q| dot(weights, block.candidate(q))).collect();
            let join = |q: usize| Joining {
                sensitivity: gains[q],
                place: (i, q),
                entries: block.candidate(q).to_vec(),
            };
            let top = crate::certificate::largest(0..block.len(), &gains, JOINING[0]);
            let largest = gains.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            Ok(Self { largest, joining: top.into_iter().map(join).collect(), concave: scaling.holds(&block) })
        };
        let blocks: Vec<_> = (0..source.blocks()).into_par_iter().map(look).collect();
        let mut all = Self { largest: f64::NEG_INFINITY, joining: Vec::new(), concave: true };
        for block in blocks {
            let block = block?;
            all.largest = all.largest.max(block.largest);
            all.concave &= block.concave;
            all.joining.extend(block.joining);
        }
        all.joining.sort_by(|a, b| b.sensitivity.total_cmp(&a.sensitivity).then(a.place.cmp(&b.place)));
        all.joining.truncate(JOINING[1]);
        Ok(all)
    }
}
