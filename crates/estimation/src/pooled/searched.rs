use std::convert::Infallible;
use std::ops::Range;

use numerics::lanes::lane;
use numerics::least_squares::{Ended, Expansion, Linearization, Minimum, Residuals, minimize};
use numerics::{LANES, Lane, Watch, quadratic, times};
use rayon::prelude::*;
use regression::jackknife;
use regression::pooled::{AnyParts, Faults, Part, Parts, Unread};
use ship::engine::SideBySide;
use ship::model::Model;

use crate::predictor::{
    ENDING, Linear, NoiseModel, Recordings, Unknown, Weighting, inverse, linearize, scaled_inverse, without,
};
use crate::sensitivity::{filter, with_states};

/// An estimate that minimises the errors of simulations or predictions.
#[derive(Clone, Debug, PartialEq)]
pub struct Searched {
    /// Parameters of the model, in its order.
    pub parameters: Vec<f64>,
    /// Their covariance, as many rows: (G − 1)/G Σ δ δᵀ with the change δ of the estimate if one of the G parts is
    /// left out, to first order (jackknife), so that errors may be correlated in any way within a part, and it is not
    /// too small for few parts. Zero for fixed parameters and those at a bound. Of one part that of white innovations, for
    /// [`Follow::Predicted`].
    pub covariance: Vec<f64>,
    /// Per parameter the effective number of parts: how many equally informative ones would give the same
    /// information; 0 for fixed ones.
    pub effective_parts: Vec<f64>,
    /// The current of every part \[m/s\], and its standard errors; empty if none is unknown.
    pub currents: Vec<[[f64; 2]; 2]>,
    /// Σ (e_d/std_d)², or of squared whitened innovations.
    pub squares: f64,
    /// Steps tried.
    pub steps: usize,
    /// Whether the search ended at a minimum.
    pub converged: bool,
}

impl Searched {
    pub(super) fn covariance_of(&self, places: Range<usize>) -> Vec<f64> {
        let all = self.parameters.len();
        let pairs = places.clone().flat_map(|i| places.clone().map(move |j| (i, j)));
        pairs.map(|(i, j)| self.covariance[i * all + j]).collect()
    }
}

/// Which errors of parts are minimised.
#[derive(Clone, Debug, PartialEq)]
pub enum Follow {
    /// Those of free simulations, each from its part's first measured state or one near it, in its own current.
    Simulated(Unknown),
    /// Those of predictions by a Kalman filter for these levels, with its gains at these parameters.
    Predicted(NoiseModel, Vec<f64>),
}

/// The scales of errors and steps of a search.
pub struct Scales {
    /// Standard deviations of the measured u, v, r.
    pub(super) std: [f64; 3],
    /// Per parameter, intercepts among them, the change that would matter; 0 fixes it.
    pub(super) sizes: Vec<f64>,
    /// Which errors are minimised.
    pub(super) follow: Follow,
}

impl Scales {
    /// Which errors are minimised.
    pub fn follow(&self) -> &Follow {
        &self.follow
    }
}

/// Minimises Σ (e_d/std_d)² of simulations over `parts`, or Σ of squared whitened innovations, by Levenberg and
/// Marquardt's method from `start` (parameters of `model`). `std`: of measured u, v, r. `sizes`: per parameter the
/// change that would matter; 0 fixes it. `None` if the start diverges or a parameter has no effect of its own.
///
/// # Errors
/// Parts that cannot be read; every step of the search reads them all.
pub fn least_errors<P: Parts>(
    model: &Model,
    parts: &P,
    start: &[f64],
    std: [f64; 3],
    sizes: &[f64],
    follow: &Follow,
) -> Result<Option<Searched>, P::Error> {
    let faults = Faults::default();
    let searched = least_errors_any(model, &faults.erased(parts), start, std, sizes, follow);
    searched.map_err(|unread| faults.take(unread))
}

pub(super) fn least_errors_any(
    model: &Model,
    parts: &AnyParts,
    start: &[f64],
    std: [f64; 3],
    sizes: &[f64],
    follow: &Follow,
) -> Result<Option<Searched>, Unread> {
    let free: Vec<usize> = (0..sizes.len()).filter(|i| sizes[*i] > 0.0).collect();
    let weights = std.map(|s| if s > 0.0 { s.powi(-2) } else { 0.0 });
    let (order, ambient) = (by_length(parts), vec![Vec::new(); parts.count()]);
    let from = free.iter().map(|i| start[*i]).collect();
    let asked = Question { model, held: start.to_vec(), free, weights, follow };
    let weights = asked.weighting();
    let mut problem = PooledProblem { asked, parts, order, ambient };
    let minima = minimize(&mut problem, vec![from], ENDING, &Watch::default())?.pop();
    let Some(minimum) = minima.filter(|end| matches!(end.status, Ended::Converged | Ended::Stalled)) else {
        return Ok(None);
    };
    Ok(problem.spread(&minimum)?.map(|(covariance, effective_parts, currents)| Searched {
        covariance,
        effective_parts,
        currents,
        squares: (0..3).map(|d| weights[d] * minimum.sums.squares[d]).sum(),
        parameters: problem.asked.whole(&minimum.point),
        steps: minimum.steps,
        converged: minimum.status == Ended::Converged,
    }))
}

struct PooledProblem<'a> {
    asked: Question<'a>,
    parts: &'a AnyParts<'a>,
    /// Indices of the parts: those of similar length share lanes.
    order: Vec<usize>,
    ambient: Vec<Vec<f64>>,
}

struct Question<'a> {
    model: &'a Model,
    held: Vec<f64>,
    free: Vec<usize>,
    weights: [f64; 3],
    follow: &'a Follow,
}

fn by_length(parts: &AnyParts) -> Vec<usize> {
    let mut order: Vec<usize> = (0..parts.count()).collect();
    order.sort_by_key(|i| std::cmp::Reverse(parts.samples(*i)));
    order
}

impl Question<'_> {
    fn whole(&self, point: &[f64]) -> Vec<f64> {
        let mut whole = self.held.clone();
        self.free.iter().zip(point).for_each(|(i, value)| whole[*i] = *value);
        whole
    }

    fn unknown(&self) -> Option<Unknown> {
        match self.follow {
            Follow::Simulated(unknown) => Some(*unknown).filter(|unknown| unknown.further().next().is_some()),
            Follow::Predicted(..) => None,
        }
    }

    /// The weights of the sums of parts: innovations are white, and settled parts are weighted already.
    fn weighting(&self) -> [f64; 3] {
        match (self.follow, self.unknown()) {
            (Follow::Simulated(_), None) => self.weights,
            _ => [1.0; 3],
        }
    }

    /// Linearises parts, [`LANES`] of them per thread, from their last own unknowns.
    fn settled(&self, parts: &[Part], ambient: &[Vec<f64>], whole: &[f64], spread: bool) -> Vec<Settled> {
        let settled = |(i, parts): (usize, &[Part])| {
            let group = SideBySide::of(&parts.iter().map(Part::view).collect::<Vec<_>>());
            let recordings = Recordings::of(self.model, &group);
            let mut settled: Vec<Settled> = match self.unknown() {
                None => self.linears(&recordings, whole).into_iter().map(Settled::from).collect(),
                Some(unknown) => {
                    let starts = &ambient[i * LANES..][..parts.len()];
                    let (recordings, parameters, weights) = (&recordings, whole, self.weights);
                    let places = unknown.further().map(|i| whole.len() + i).collect();
                    let ambient = Ambient { recordings, unknown, places, parameters, weights };
                    ambient.settled(&self.free, starts, spread)
                }
            };
            settled.truncate(group.runs);
            settled
        };
        parts.par_chunks(LANES).enumerate().flat_map_iter(settled).collect()
    }

    fn linears(&self, recordings: &Recordings, whole: &[f64]) -> Vec<Linear> {
        let lanes =
            |whole: &[f64]| -> Vec<Lane> { whole.iter().copied().chain([0.0; 3]).map(Lane::splat).collect() };
        match self.follow {
            Follow::Simulated(_) => linearize::<3>(recordings, &lanes(whole), &self.free, None, &[], false),
            Follow::Predicted(levels, at) => {
                with_states!(
                    levels.states(),
                    innovations(recordings, &lanes(whole), &lanes(at), &self.free, levels)
                )
            }
        }
    }
}

impl PooledProblem<'_> {
    /// Calls `look` with every linearised part, in order; with the spread of its own unknowns if requested.
    fn each(&self, point: &[f64], spread: bool, look: &mut dyn FnMut(Settled)) -> Result<(), Unread> {
        let whole = self.asked.whole(point);
        let together = LANES * rayon::current_num_threads();
        let mut waiting: Vec<Part> = Vec::with_capacity(together);
        let mut first = 0;
        let mut pass = |waiting: &mut Vec<Part>| {
            let ambient = &self.ambient[first..first + waiting.len()];
            self.asked.settled(waiting, ambient, &whole, spread).into_iter().for_each(&mut *look);
            first += waiting.len();
            waiting.clear();
        };
        self.parts.at(&self.order, &mut |part| {
            waiting.push(Part::new("", "", part.run));
            if waiting.len() == together {
                pass(&mut waiting);
            }
        })?;
        pass(&mut waiting);
        Ok(())
    }

    /// The covariance of all parameters, the effective number of parts for each, and the currents of the parts.
    fn spread(&self, minimum: &Minimum<Linear>) -> Result<Option<Spread>, Unread> {
        let weights = self.asked.weighting();
        let Ok(inverse) = inverse(minimum, weights) else { return Ok(None) };
        let places = &self.asked.free;
        let (all, free, parts) = (self.asked.held.len(), places.len(), self.parts.count() as f64);
        let (mut covariance, mut shares) = (vec![0.0; all * all], vec![[0.0; 2]; all]);
        let mut settled = Vec::new();
        self.each(&minimum.point, true, &mut |settled_part| {
            let (normal, gradient) = settled_part.linear.weighted(weights);
            // Without a part that alone determines a parameter there is no estimate: it is treated as hardly
            // informative.
            let moved = without(minimum, &settled_part.linear, weights)
                .unwrap_or_else(|_| times(&inverse, &gradient));
            for (i, (row, a)) in places.iter().zip(&moved).enumerate() {
                for (column, b) in places.iter().zip(&moved) {
                    covariance[row * all + column] += (parts - 1.0) / parts * a * b;
                }
                let share = quadratic(&inverse[i * free..(i + 1) * free], &normal);
                shares[*row] = [shares[*row][0] + share, shares[*row][1] + share * share];
            }
            settled.push(settled_part.without_sums());
        })?;
        if self.parts.count() == 1 && matches!(self.asked.follow, Follow::Predicted(..)) {
            let freedom = (3.0 * minimum.sums.samples - free as f64).max(1.0);
            let variance = minimum.sums.squares.iter().sum::<f64>() / freedom;
            let entries = inverse.iter().enumerate();
            entries.for_each(|(k, entry)| {
                covariance[places[k / free] * all + places[k % free]] = variance * entry
            });
        }
        let alike = |[sum, squares]: [f64; 2]| if squares > 0.0 { sum * sum / squares } else { 0.0 };
        let mut currents = Vec::new();
        if self.asked.unknown().is_some_and(|unknown| unknown.current.is_some()) {
            currents.resize(settled.len(), [[0.0; 2]; 2]);
            let pairs = places.iter().flat_map(|i| places.iter().map(move |j| i * all + j));
            let of_parameters: Vec<f64> = pairs.map(|k| covariance[k]).collect();
            let ordered = self.order.iter().zip(&settled);
            ordered.for_each(|(place, settled)| currents[*place] = settled.current(&of_parameters));
        }
        Ok(Some((covariance, shares.into_iter().map(alike).collect(), currents)))
    }
}

/// Whitened innovations of a filter for `levels`, linearised at `unknowns` with its gains along `at`.
fn innovations<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    at: &[Lane],
    free: &[usize],
    levels: &NoiseModel,
) -> Vec<Linear> {
    let (gains, _) = filter::<N>(recordings, at, levels, false);
    linearize(recordings, unknowns, free, Some(levels), &gains, true)
}

/// See the fields of [`Searched`]: covariance, effective parts, currents.
type Spread = (Vec<f64>, Vec<f64>, Vec<[[f64; 2]; 2]>);

impl Residuals<Linear, Unread> for PooledProblem<'_> {
    fn linearize(&mut self, asked: &[Linearization]) -> Result<Vec<(Expansion, Linear)>, Unread> {
        let weighting = Weighting::Fixed(self.asked.weighting());
        let mut totals = Vec::new();
        for Linearization { point, .. } in asked {
            let (mut total, mut ambient): (Option<Linear>, _) = (None, Vec::new());
            self.each(point, false, &mut |part| {
                match &mut total {
                    Some(total) => total.add(&part.linear),
                    None => total = Some(part.linear),
                }
                ambient.push(part.ambient);
            })?;
            totals.extend(total.map(|total| weighting.expansion(total)));
            self.ambient = ambient;
        }
        Ok(totals)
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        let all = self.asked.model.bounds();
        all.map_or(Vec::new(), |all| self.asked.free.iter().map(|i| all[*i]).collect())
    }
}

// The start of each part and its current: minimised out for any parameters, so that the errors depend on the parameters
struct Settled {
    pub linear: Linear,
    /// The offset of its start and the current, in the order of [`Unknown::further`].
    pub ambient: Vec<f64>,
    /// Derivatives of these by the parameters, a row for each unknown; and their covariance at known parameters.
    follows: Vec<f64>,
    known: Vec<f64>,
}

impl From<Linear> for Settled {
    fn from(linear: Linear) -> Self {
        Self { linear, ambient: Vec::new(), follows: Vec::new(), known: Vec::new() }
    }
}

impl Settled {
    fn without_sums(self) -> Self {
        Self { linear: Linear::default(), ..self }
    }

    /// The current, the last two of the unknowns, and its standard errors, with the parameters' `covariance`.
    pub(super) fn current(&self, covariance: &[f64]) -> [[f64; 2]; 2] {
        let q = self.ambient.len();
        let free = self.follows.len() / q;
        let error = |i: usize| {
            let through = quadratic(&self.follows[i * free..(i + 1) * free], covariance);
            (self.known[i * q + i] + through).max(0.0).sqrt()
        };
        let places = [q - 2, q - 1];
        [places.map(|i| self.ambient[i]), places.map(|i| if free > 0 { error(i) } else { 0.0 })]
    }
}

struct Ambient<'a> {
    recordings: &'a Recordings<'a>,
    unknown: Unknown,
    places: Vec<usize>,
    parameters: &'a [f64],
    weights: [f64; 3],
}

impl Residuals<Linear> for Ambient<'_> {
    fn linearize(&mut self, asked: &[Linearization]) -> Result<Vec<(Expansion, Linear)>, Infallible> {
        let weighting = Weighting::Fixed(self.weights);
        Ok(weighting.by_lane(asked, |points| self.linears(points, &self.places)))
    }
}

impl Ambient<'_> {
    /// Minimises the errors of the parts over their own unknowns from `starts`, empty at first, and linearises them by
    /// the `free` parameters; with their `spread` if requested.
    fn settled(mut self, free: &[usize], starts: &[Vec<f64>], spread: bool) -> Vec<Settled> {
        let start = |offsets: &Vec<f64>| match offsets.is_empty() {
            true => vec![0.0; self.places.len()],
            false => offsets.clone(),
        };
        let starts: Vec<Vec<f64>> = starts.iter().map(start).collect();
        let Ok(minima) = minimize(&mut self, starts, ENDING, &Watch::default());
        let points: Vec<Vec<f64>> = minima.into_iter().map(|minimum| minimum.point).collect();
        let all: Vec<usize> = free.iter().chain(&self.places).copied().collect();
        let blocks =
            spread.then(|| self.unknown.blocks(self.recordings, &self.unknowns(&points), &self.places));
        let linears = self.linears(&points, &all);
        let each = points.into_iter().zip(linears).enumerate();
        each.map(|(lane, (ambient, linear))| {
            let block_sums = blocks.iter().flatten().map(|block| &block[lane]).collect::<Vec<_>>();
            projected(&linear, ambient, self.weights, spread.then_some(block_sums.as_slice()))
        })
        .collect()
    }

    fn unknowns(&self, points: &[impl AsRef<[f64]>]) -> Vec<Lane> {
        let mut unknowns: Vec<Lane> = self.parameters.iter().copied().map(Lane::splat).collect();
        unknowns.resize(self.parameters.len() + 3 + 2, Lane::ZERO);
        for (i, place) in self.places.iter().enumerate() {
            unknowns[*place] = lane(points.len(), |run| points[run].as_ref()[i]);
        }
        unknowns
    }

    fn linears(&self, points: &[impl AsRef<[f64]>], free: &[usize]) -> Vec<Linear> {
        self.unknown.linearize(self.recordings, &self.unknowns(points), free)
    }
}

/// The errors of a part by its parameters alone, with its own unknowns projected out: with A B; Bᵀ N the weighted
/// normal matrix of both and g, h the gradients, A − B N⁻¹ Bᵀ and g − B N⁻¹ h. `blocks`: sums over blocks of samples
/// by these unknowns, if their covariance is requested, see [`jackknife`].
fn projected(linear: &Linear, ambient: Vec<f64>, weights: [f64; 3], blocks: Option<&[&Linear]>) -> Settled {
    let (normal, gradient) = linear.weighted(weights);
    let (n, q) = (gradient.len(), ambient.len());
    let p = n - q;
    let rows = |rows: std::ops::Range<usize>, columns: std::ops::Range<usize>| -> Vec<f64> {
        rows.flat_map(|i| columns.clone().map(move |j| (i, j))).map(|(i, j)| normal[i * n + j]).collect()
    };
    let (mut matrix, across) = (rows(0..p, 0..p), rows(p..n, 0..p));
    let (mut slope, mut cost) =
        (gradient[..p].to_vec(), (0..3).map(|d| weights[d] * linear.squares[d]).sum());
    let (mut follows, mut known) = (Vec::new(), Vec::new());
    if let Ok(inverse) = scaled_inverse(&rows(p..n, p..n), q) {
        let entry = |i: usize, j: usize| (0..q).map(|k| inverse[i * q + k] * across[k * p + j]).sum::<f64>();
        let reach: Vec<f64> = (0..q * p).map(|k| entry(k / p, k % p)).collect();
        let step = times(&inverse, &gradient[p..]);
        for k in 0..q {
            let coupling = &across[k * p..(k + 1) * p];
            for (i, b) in coupling.iter().enumerate() {
                slope[i] -= b * step[k];
                (0..p).for_each(|j| matrix[i * p + j] -= b * reach[k * p + j]);
            }
            cost -= gradient[p + k] * step[k];
        }
        if let Some(blocks) = blocks {
            let whole = rows(p..n, p..n);
            let without = |block: &Linear| {
                let (part, gradient) = block.weighted(weights);
                let others: Vec<f64> = whole.iter().zip(part).map(|(whole, entry)| whole - entry).collect();
                // An unknown that only one block determines uses all blocks' matrix.
                Some(times(&scaled_inverse(&others, q).unwrap_or_else(|_| inverse.clone()), &gradient))
            };
            known = jackknife(blocks.iter().copied(), without).unwrap_or_else(|| vec![f64::NAN; q * q]);
            follows = reach;
        }
    }
    // Weighted sums are in the first entry, the others are zero.
    let nothing = |of: &[f64]| vec![0.0; of.len()];
    let (no_slope, no_normal) = (nothing(&slope), nothing(&matrix));
    let linear = Linear {
        samples: linear.samples,
        squares: [cost, 0.0, 0.0],
        gradient: [slope, no_slope.clone(), no_slope],
        normal: [matrix, no_normal.clone(), no_normal],
    };
    Settled { linear, ambient, follows, known }
}
