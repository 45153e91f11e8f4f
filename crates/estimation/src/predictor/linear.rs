use numerics::least_squares::{Ending, Expansion, Linearization, Minimum};
use numerics::{LANES, Lane, times};
use regression::BLOCKS;
use ship::model::Model;

use crate::estimator::{AdditionalUnknowns, UnknownCurrent};
use crate::sensitivity::{
    Flow, Gain, NoiseModel, Products, Recordings, Sensitivities, Step, add_draws, add_start, backward, sweep,
};

/// Sums of squares and products of errors e and sensitivities s = ∂x̂/∂(unknown), per state u, v, r.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Linear {
    /// Number of samples.
    pub samples: f64,
    /// Σ e².
    pub squares: [f64; 3],
    /// Σ s e, an entry per free unknown.
    pub gradient: [Vec<f64>; 3],
    /// Σ s sᵀ, free × free row-major.
    pub normal: [Vec<f64>; 3],
}

impl Linear {
    pub(crate) fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        for d in 0..3 {
            self.squares[d] += other.squares[d];
            let pairs = self.gradient[d].iter_mut().zip(&other.gradient[d]);
            pairs.for_each(|(a, b)| *a += b);
            self.normal[d].iter_mut().zip(&other.normal[d]).for_each(|(a, b)| *a += b);
        }
    }

    pub(crate) fn finite(&self) -> bool {
        self.squares.iter().chain(self.normal.iter().flatten()).all(|x| x.is_finite())
    }

    /// Σ_d w_d (Σ s sᵀ, Σ s e).
    pub(crate) fn weighted(&self, weights: [f64; 3]) -> (Vec<f64>, Vec<f64>) {
        let mix = |parts: &[Vec<f64>; 3]| -> Vec<f64> {
            (0..parts[0].len()).map(|i| (0..3).map(|d| weights[d] * parts[d][i]).sum()).collect()
        };
        (mix(&self.normal), mix(&self.gradient))
    }
}

/// A point is a minimum where the next step would change the prediction by a hundred-thousandth of a standard deviation.
pub(crate) const ENDING: Ending = Ending { steps: 40, enough: 1e-5, damping: 1e-4 };

/// How squared errors are weighed.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Weighting {
    /// Σ_d w_d Σ e_d².
    Fixed([f64; 3]),
    /// Σ_d N log(Σ e_d² + N floor_d): maximum likelihood of white errors with unknown variances, whose weights are one
    /// over the errors' own mean squares.
    Likelihood([f64; 3]),
}

impl Weighting {
    /// The cost of errors whose sums of squares over `samples` samples are `squares`; of exact data its unit is at least 1e-16.
    pub(crate) fn cost(&self, squares: [f64; 3], samples: f64) -> Expansion {
        let [cost, unit] = match self {
            Self::Fixed(weights) => {
                let cost = (0..3).map(|d| weights[d] * squares[d]).sum::<f64>();
                [cost, (cost / (3.0 * samples).max(1.0)).max(1e-16)]
            }
            Self::Likelihood(floor) => {
                [(0..3).map(|d| samples * libm::log(squares[d] / samples + floor[d])).sum(), 1.0]
            }
        };
        Expansion { cost, unit, ..Expansion::default() }
    }

    /// The weights of errors whose sums of squares over `samples` samples are `squares`.
    pub(crate) fn weights(&self, squares: [f64; 3], samples: f64) -> [f64; 3] {
        match self {
            Self::Fixed(weights) => *weights,
            Self::Likelihood(floor) => [0, 1, 2].map(|d| (squares[d] / samples + floor[d]).recip()),
        }
    }

    pub(crate) fn expansion(&self, linear: Linear) -> (Expansion, Linear) {
        let (normal, gradient) = linear.weighted(self.weights(linear.squares, linear.samples));
        (Expansion { normal, gradient, ..self.cost(linear.squares, linear.samples) }, linear)
    }

    /// What `linears` gives at the points of the lanes; idle lanes, of finished problems, repeat the point of the first.
    pub(crate) fn by_lane(
        &self,
        asked: &[Linearization],
        linears: impl FnOnce(&[&[f64]]) -> Vec<Linear>,
    ) -> Vec<(Expansion, Linear)> {
        let request_of = |lane: usize| asked.iter().find(|request| request.problem == lane).or(asked.first());
        let points: Vec<&[f64]> = (0..LANES).filter_map(request_of).map(|r| r.point.as_slice()).collect();
        let all = linears(&points).into_iter().enumerate();
        let wanted = |lane: &usize| asked.iter().any(|request| request.problem == *lane);
        all.filter(|(lane, _)| wanted(lane)).map(|(_, linear)| self.expansion(linear)).collect()
    }
}

/// The inverse normal matrix of the free unknowns, zero for held ones, or an unknown without effect of its own.
pub(crate) fn inverse(minimum: &Minimum<Linear>, weights: [f64; 3]) -> Result<Vec<f64>, usize> {
    minimum.inverse(minimum.sums.weighted(weights).0)
}

/// The change of the unknowns if `part` is left out: H⁻¹g, H of the rest; or an unknown that the rest leaves open.
pub(crate) fn without(
    minimum: &Minimum<Linear>,
    part: &Linear,
    weights: [f64; 3],
) -> Result<Vec<f64>, usize> {
    let (left_out, gradient) = part.weighted(weights);
    let whole = minimum.sums.weighted(weights).0;
    let others = whole.iter().zip(left_out).map(|(whole, entry)| whole - entry).collect();
    Ok(times(&minimum.inverse(others)?, &gradient))
}

/// Linearises predictions at `unknowns`: the terms of the sum of squared errors and of its Gauss–Newton step, per
/// lane. With gains errors and sensitivities are whitened. Sample 0 counts where `from_start`.
pub(crate) fn linearize<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    free: &[usize],
    levels: Option<&NoiseModel>,
    gains: &[Gain<Lane, N>],
    from_start: bool,
) -> Vec<Linear> {
    let levels = levels.map(NoiseModel::spread);
    linearize_each(recordings, unknowns, free, levels.as_ref(), gains, from_start)
}

pub(crate) fn linearize_each<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    free: &[usize],
    levels: Option<&NoiseModel<Lane>>,
    gains: &[Gain<Lane, N>],
    from_start: bool,
) -> Vec<Linear> {
    let longest = recordings.longest();
    let even = recordings.samples.iter().all(|n| *n == longest);
    let mut products = [0; 3].map(|_| Products::<Lane>::new(free.len() + 1));
    sweep(
        recordings,
        unknowns,
        free,
        levels,
        gains,
        #[inline(always)]
        |step: Step<'_, Lane, N>| {
            if step.k == 0 && !from_start {
                return;
            }
            let (gain, mask) = (gains.get(step.k), (!even).then(|| recordings.lasting(step.k)));
            if gain.is_none() && mask.is_none() {
                for (d, products) in products.iter_mut().enumerate() {
                    products.scale(step.sensitivities, d, Lane::ONE);
                }
            } else {
                for (i, s) in step.sensitivities.iter().enumerate() {
                    set(&mut products, i, [s[0], s[1], s[2]], gain, mask);
                }
            }
            set(&mut products, free.len(), step.error, gain, mask);
            for products in &mut products {
                products.advance();
            }
        },
    );
    linears(products, recordings, from_start)
}

fn linears(products: [Products<Lane>; 3], recordings: &Recordings, from_start: bool) -> Vec<Linear> {
    let sums = products.map(|products| products.finish().square());
    let first = usize::from(!from_start);
    let p = sums[0].len().isqrt() - 1;
    let rows = |d: usize| sums[d].chunks_exact(p + 1);
    let linear = |lane: usize| Linear {
        samples: (recordings.samples[lane] + 1 - first) as f64,
        squares: [0, 1, 2].map(|d: usize| sums[d][p * (p + 1) + p][lane]),
        gradient: [0, 1, 2].map(|d: usize| rows(d).take(p).map(|row| row[p][lane]).collect()),
        normal: [0, 1, 2]
            .map(|d: usize| rows(d).take(p).flat_map(|row| &row[..p]).map(|sum| sum[lane]).collect()),
    };
    (0..LANES).map(linear).collect()
}

/// Sets signal `i` of every state, whitened with a gain, times `mask`.
#[inline(always)]
fn set<const N: usize>(
    products: &mut [Products<Lane>; 3],
    i: usize,
    signal: [Lane; 3],
    gain: Option<&Gain<Lane, N>>,
    mask: Option<Lane>,
) {
    let white = match gain {
        Some(gain) => gain.white(&signal),
        None => signal,
    };
    for (d, products) in products.iter_mut().enumerate() {
        products.set(i, if let Some(mask) = mask { white[d] * mask } else { white[d] });
    }
}

/// Sums over each of ten blocks of samples, by block and lane: free simulations, in a current of `levels` that is among
/// the unknowns, or white innovations if there are gains.
pub(crate) fn blocks<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    free: &[usize],
    levels: Option<&NoiseModel>,
    gains: &[Gain<Lane, N>],
    from_start: bool,
) -> Vec<Vec<Linear>> {
    let (rows, columns) = (recordings.longest() + 1, free.len() + 1);
    let new = || [0; 3].map(|_| Products::<Lane>::new(columns));
    let (mut products, mut blocks) = (new(), Vec::new());
    sweep(
        recordings,
        unknowns,
        free,
        levels.map(NoiseModel::spread).as_ref(),
        gains,
        |step: Step<'_, Lane, N>| {
            let counts = if step.k == 0 && !from_start { Lane::ZERO } else { recordings.lasting(step.k) };
            let white = |x: [Lane; 3]| {
                let white = gains.get(step.k).map_or(x, |gain| gain.white(&x));
                white.map(|x| x * counts)
            };
            let all = step.sensitivities.iter().map(|s| [s[0], s[1], s[2]]).chain([step.error]);
            for (i, signal) in all.map(white).enumerate() {
                (0..3).for_each(|d| products[d].set(i, signal[d]));
            }
            products.iter_mut().for_each(Products::advance);
            if (step.k + 1) * BLOCKS / rows > step.k * BLOCKS / rows {
                let full = std::mem::replace(&mut products, new());
                blocks.push(linears(full, recordings, from_start));
            }
        },
    );
    blocks
}

/// The contribution of `levels` to the covariance of Σ sᵀWe, to first order: every draw enters the states, adjoints are
/// the derivatives of the scores by the states. free × free lanes.
pub(crate) fn disturbed_scores<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    kept: &Sensitivities<Lane>,
    weights: [Lane; 3],
    levels: &NoiseModel,
) -> Vec<Lane> {
    let mut draws = Products::new(kept.free());
    let start = backward::<Lane, N>(
        recordings,
        unknowns,
        kept,
        weights,
        Some(levels),
        #[inline(always)]
        |local, adjoints: &[[Lane; N]]| add_draws(&mut draws, adjoints, local, levels),
    );
    add_start(&mut draws, &start, levels);
    draws.finish().square()
}

/// The start of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InitialState {
    /// At the recording's start, which is known.
    Known,
    /// Near it: its offset is estimated, and the first measurement counts.
    Estimated,
}

impl InitialState {
    /// The name in files.
    pub fn name(self) -> &'static str {
        ["known", "estimated"][self as usize]
    }
}

/// The unknowns of free simulations in addition to the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unknown {
    /// Where they start.
    pub initial: InitialState,
    /// The time between two samples \[s\] if a current is unknown, which is constant over ground: two unknowns \[m/s\],
    /// along and across the vessel at the start.
    pub current: Option<f64>,
}

impl From<InitialState> for Unknown {
    fn from(initial: InitialState) -> Self {
        Self { initial, current: None }
    }
}

impl Unknown {
    /// The unknowns of runs sampled every `interval_s` \[s\].
    pub fn new(initial: InitialState, additional: AdditionalUnknowns, interval_s: f64) -> Self {
        let current = (additional.current == UnknownCurrent::Earth).then_some(interval_s);
        Self { initial, current }
    }

    /// The unknowns that are estimated: the parameters of `model`, the initial state's offsets, the current.
    pub(super) fn free(self, model: &Model) -> Vec<usize> {
        let parameters = model.parameters();
        (0..parameters).chain(self.further().map(|i| parameters + i)).collect()
    }

    /// The estimated ones of those after the parameters: the initial state's offsets, and the current.
    pub(crate) fn further(self) -> impl Iterator<Item = usize> {
        let offsets = if self.initial == InitialState::Known { 0..0 } else { 0..3 };
        offsets.chain(if self.current.is_none() { 3..3 } else { 3..5 })
    }

    pub(super) fn start_counts(self) -> bool {
        self.initial == InitialState::Estimated
    }

    fn levels(self) -> Option<NoiseModel> {
        let lasting = |turning| Flow::Markov { std: 0.0, factor: 1.0, turning };
        let of = |current| NoiseModel { measurement: [0.0; 3], current, force: None, drift: None };
        self.current.map(lasting).map(of)
    }

    pub(crate) fn linearize(self, recordings: &Recordings, unknowns: &[Lane], free: &[usize]) -> Vec<Linear> {
        let counts = self.start_counts();
        match self.levels() {
            None => linearize::<3>(recordings, unknowns, free, None, &[], counts),
            levels => linearize::<5>(recordings, unknowns, free, levels.as_ref(), &[], counts),
        }
    }

    pub(crate) fn blocks(self, recordings: &Recordings, at: &[Lane], free: &[usize]) -> Vec<Vec<Linear>> {
        let counts = self.start_counts();
        match self.levels() {
            None => blocks::<3>(recordings, at, free, None, &[], counts),
            levels => blocks::<5>(recordings, at, free, levels.as_ref(), &[], counts),
        }
    }
}
