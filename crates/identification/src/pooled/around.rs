//! Where parts start, and water and wind around them, each its own: for any parameters those with the least errors, by which the
//! errors then are the parameters' alone (variable projection).

use std::convert::Infallible;

use numerics::lanes::lane;
use numerics::{LANES, Lane, quadratic, times};
use regression::jackknife;

use crate::predictor::{
    AROUND, Asked, Linear, Recordings, Residuals, STEPS, Unknown, Weighting, minimize, scaled_inverse,
};

/// A part with what is settled around it.
pub(super) struct Settled {
    /// Its errors by the parameters alone: what is around it follows them.
    pub linear: Linear,
    /// Its offset from the measured start and what is around it, the unknowns alone, in the order of [`Unknown::own`].
    pub around: Vec<f64>,
    /// How it follows the parameters, a row for each unknown; and its covariance where they are known.
    follows: Vec<f64>,
    known: Vec<f64>,
}

impl From<Linear> for Settled {
    fn from(linear: Linear) -> Self {
        Self { linear, around: Vec::new(), follows: Vec::new(), known: Vec::new() }
    }
}

impl Settled {
    /// The same without the sums, which are the most of it.
    pub(super) fn without_sums(self) -> Self {
        Self { linear: Linear::default(), ..self }
    }

    /// What is around it and standard errors of it, with the parameters' `covariance`, of all [`AROUND`].
    pub(super) fn around(&self, unknown: Unknown, covariance: &[f64]) -> [[f64; AROUND]; 2] {
        let q = self.around.len();
        let free = self.follows.len() / q.max(1);
        let mut all = [[0.0; AROUND]; 2];
        let places = unknown.own().enumerate().filter_map(|(i, own)| Some((i, own.checked_sub(3)?)));
        for (i, place) in places {
            all[0][place] = self.around[i];
            if free > 0 {
                let through = quadratic(&self.follows[i * free..(i + 1) * free], covariance);
                all[1][place] = (self.known[i * q + i] + through).max(0.0).sqrt();
            }
        }
        all
    }
}

/// Parts side by side, simulated with given parameters.
pub(super) struct Around<'a> {
    recordings: &'a Recordings<'a>,
    unknown: Unknown,
    /// Places of what is searched for among all unknowns.
    own: Vec<usize>,
    parameters: &'a [f64],
    weights: [f64; 3],
}

impl Residuals for Around<'_> {
    type Error = Infallible;

    fn linearize(&mut self, asked: &[Asked]) -> Result<Vec<Linear>, Infallible> {
        // Lanes of parts that are settled go along with the first.
        let own = |lane: usize| asked.iter().find(|own| own.problem == lane).or(asked.first());
        let points: Vec<&[f64]> = (0..LANES).filter_map(own).map(|own| own.point.as_slice()).collect();
        let found = self.linears(&points, &self.own);
        let wanted = |lane: &usize| asked.iter().any(|own| own.problem == *lane);
        Ok((0..LANES).zip(found).filter(|(lane, _)| wanted(lane)).map(|(_, own)| own).collect())
    }
}

impl<'a> Around<'a> {
    /// Of parts whose squared errors in u, v, r have these `weights`.
    pub(super) fn new(
        recordings: &'a Recordings<'a>,
        unknown: Unknown,
        parameters: &'a [f64],
        weights: [f64; 3],
    ) -> Self {
        let own = unknown.own().map(|i| parameters.len() + i).collect();
        Self { recordings, unknown, own, parameters, weights }
    }

    /// The parts with what has the least errors around them, to the `free` parameters. Searches begin at `starts`, one for each,
    /// which are empty at first. Where it makes no difference, or the simulation diverges, it stays. With their `spread` where that is wanted.
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
        each.map(|(lane, (around, linear))| {
            let own = blocks.iter().flatten().map(|block| &block[lane]).collect::<Vec<_>>();
            projected(&linear, around, self.weights, spread.then_some(&own))
        })
        .collect()
    }

    fn unknowns(&self, points: &[impl AsRef<[f64]>]) -> Vec<Lane> {
        let mut unknowns: Vec<Lane> = self.parameters.iter().copied().map(Lane::splat).collect();
        unknowns.resize(self.parameters.len() + 3 + AROUND, Lane::ZERO);
        for (i, place) in self.own.iter().enumerate() {
            unknowns[*place] = lane(points.len(), |run| points[run].as_ref()[i]);
        }
        unknowns
    }

    fn linears(&self, points: &[impl AsRef<[f64]>], free: &[usize]) -> Vec<Linear> {
        self.unknown.linearize(self.recordings, &self.unknowns(points), free)
    }
}

/// The errors of a part by its parameters alone, after those around it: with A B; Bᵀ N the weighted normal matrix of both and
/// g, h the gradients, A − B N⁻¹ Bᵀ and g − B N⁻¹ h. `blocks`: sums over blocks of samples by those around it, where their
/// covariance is wanted, see [`jackknife`].
fn projected(linear: &Linear, around: Vec<f64>, weights: [f64; 3], blocks: Option<&Vec<&Linear>>) -> Settled {
    let (normal, gradient) = linear.weighted(weights);
    let (n, q) = (gradient.len(), around.len());
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
            let beside = &across[k * p..(k + 1) * p];
            for (i, b) in beside.iter().enumerate() {
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
                // What one block alone tells of counts as what all tell little of.
                Some(times(&scaled_inverse(&others, q).unwrap_or_else(|_| inverse.clone()), &gradient))
            };
            known = jackknife(blocks.iter().copied(), without).unwrap_or_else(|| vec![f64::NAN; q * q]);
            follows = reach;
        }
    }
    // All weighed: in the first place, and nothing in the others.
    let nothing = |of: &[f64]| vec![0.0; of.len()];
    let (no_slope, no_normal) = (nothing(&slope), nothing(&own));
    let linear = Linear {
        samples: linear.samples,
        squares: [cost, 0.0, 0.0],
        gradient: [slope, no_slope.clone(), no_slope],
        normal: [own, no_normal.clone(), no_normal],
    };
    Settled { linear, around, follows, known }
}
