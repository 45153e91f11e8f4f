//! The start of each part and its current: minimised out for any parameters, so that the errors depend on the parameters
//! alone (variable projection).

use std::convert::Infallible;

use numerics::lanes::lane;
use numerics::{LANES, Lane, quadratic, times};
use regression::jackknife;

use crate::predictor::{
    Asked, Linear, Recordings, Residuals, STEPS, Unknown, Weighting, minimize, scaled_inverse,
};

/// A part with its own unknowns minimised out.
pub(super) struct Settled {
    /// Its errors by the parameters alone: its own unknowns follow them.
    pub linear: Linear,
    /// The offset of its start and the current, in the order of [`Unknown::own`].
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
    /// The same without the sums, which take most of the memory.
    pub(super) fn without_sums(self) -> Self {
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

/// Parts in lanes, simulated with given parameters.
pub(super) struct Ambient<'a> {
    recordings: &'a Recordings<'a>,
    unknown: Unknown,
    /// Indices of the estimated ones among all unknowns.
    own: Vec<usize>,
    parameters: &'a [f64],
    weights: [f64; 3],
}

impl Residuals for Ambient<'_> {
    type Error = Infallible;

    fn linearize(&mut self, asked: &[Asked]) -> Result<Vec<Linear>, Infallible> {
        // Idle lanes, of converged parts, repeat the point of the first.
        let own = |lane: usize| asked.iter().find(|own| own.problem == lane).or(asked.first());
        let points: Vec<&[f64]> = (0..LANES).filter_map(own).map(|own| own.point.as_slice()).collect();
        let found = self.linears(&points, &self.own);
        let wanted = |lane: &usize| asked.iter().any(|own| own.problem == *lane);
        Ok((0..LANES).zip(found).filter(|(lane, _)| wanted(lane)).map(|(_, own)| own).collect())
    }
}

impl<'a> Ambient<'a> {
    /// The problem of parts whose squared errors in u, v, r have these `weights`.
    pub(super) fn new(
        recordings: &'a Recordings<'a>,
        unknown: Unknown,
        parameters: &'a [f64],
        weights: [f64; 3],
    ) -> Self {
        let own = unknown.own().map(|i| parameters.len() + i).collect();
        Self { recordings, unknown, own, parameters, weights }
    }

    /// Minimises the errors of the parts over their own unknowns, and linearises them by the `free` parameters.
    /// Searches begin at `starts`, one per part, which are empty at first. Unknowns without effect, or of a diverging
    /// simulation, stay. Computes their `spread` if requested.
    pub(super) fn settled(mut self, free: &[usize], starts: &[Vec<f64>], spread: bool) -> Vec<Settled> {
        let start = |own: &Vec<f64>| match own.is_empty() {
            true => vec![0.0; self.own.len()],
            false => own.clone(),
        };
        let starts: Vec<Vec<f64>> = starts.iter().map(start).collect();
        let weighting = vec![Weighting::Fixed(self.weights); starts.len()];
        let Ok(minima) = minimize(&mut self, weighting, starts, STEPS);
        let points: Vec<Vec<f64>> = minima.into_iter().map(|minimum| minimum.point).collect();
        let all: Vec<usize> = free.iter().chain(&self.own).copied().collect();
        let blocks = spread.then(|| self.unknown.blocks(self.recordings, &self.unknowns(&points), &self.own));
        let linears = self.linears(&points, &all);
        let each = points.into_iter().zip(linears).enumerate();
        each.map(|(lane, (ambient, linear))| {
            let own = blocks.iter().flatten().map(|block| &block[lane]).collect::<Vec<_>>();
            projected(&linear, ambient, self.weights, spread.then_some(&own))
        })
        .collect()
    }

    fn unknowns(&self, points: &[impl AsRef<[f64]>]) -> Vec<Lane> {
        let mut unknowns: Vec<Lane> = self.parameters.iter().copied().map(Lane::splat).collect();
        unknowns.resize(self.parameters.len() + 3 + 2, Lane::ZERO);
        for (i, place) in self.own.iter().enumerate() {
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
fn projected(
    linear: &Linear,
    ambient: Vec<f64>,
    weights: [f64; 3],
    blocks: Option<&Vec<&Linear>>,
) -> Settled {
    let (normal, gradient) = linear.weighted(weights);
    let (n, q) = (gradient.len(), ambient.len());
    let p = n - q;
    let rows = |rows: std::ops::Range<usize>, columns: std::ops::Range<usize>| -> Vec<f64> {
        rows.flat_map(|i| columns.clone().map(move |j| (i, j))).map(|(i, j)| normal[i * n + j]).collect()
    };
    let (mut own, across) = (rows(0..p, 0..p), rows(p..n, 0..p));
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
                (0..p).for_each(|j| own[i * p + j] -= b * reach[k * p + j]);
            }
            cost -= gradient[p + k] * step[k];
        }
        if let Some(blocks) = blocks {
            let whole = rows(p..n, p..n);
            let without = |block: &Linear| {
                let (own, gradient) = block.weighted(weights);
                let others: Vec<f64> = whole.iter().zip(own).map(|(whole, own)| whole - own).collect();
                // An unknown that only one block determines uses all blocks' matrix.
                Some(times(&scaled_inverse(&others, q).unwrap_or_else(|_| inverse.clone()), &gradient))
            };
            known = jackknife(blocks.iter().copied(), without).unwrap_or_else(|| vec![f64::NAN; q * q]);
            follows = reach;
        }
    }
    // Weighted sums are in the first entry, the others are zero.
    let nothing = |of: &[f64]| vec![0.0; of.len()];
    let (no_slope, no_normal) = (nothing(&slope), nothing(&own));
    let linear = Linear {
        samples: linear.samples,
        squares: [cost, 0.0, 0.0],
        gradient: [slope, no_slope.clone(), no_slope],
        normal: [own, no_normal.clone(), no_normal],
    };
    Settled { linear, ambient, follows, known }
}
