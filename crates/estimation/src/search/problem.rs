use numerics::least_squares::{Expansion, huber};
use numerics::{LANES, Lane};
use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use regression::pooled::Part;
use ship::engine::{Compiled, RunView, SideBySide};
use ship::model::Model;

use super::{Recording, limit, squares};
use crate::pooled::deviations;
use crate::predictor::{Recordings, Step, free_sweep};

/// If the RMS of a window's errors over the states' standard deviations exceeds this, they count linearly instead of
/// squared: a single window may have a quarter of all squared errors.
const USUAL: f64 = 0.2;
/// Factor by which parameters of the base structure are penalised less than others; its square multiplies the ridge.
const KNOWN: f64 = 0.03;
/// Maximum number of chunks of windows for Jacobians: more than threads, and the same for any number of threads.
const CHUNKS: usize = 16;

/// Output errors of free simulations over windows, as a function of scaled parameters β: θ = β · size.
#[derive(Clone)]
pub(crate) struct WindowProblem<'a> {
    pub model: &'a Model,
    /// Longest first, so that neighbours are about equally long.
    windows: Vec<RunView<'a>>,
    std: [f64; 3],
    limit: [f64; 3],
    /// 0 for a term that is always 0.
    pub sizes: Vec<f64>,
    /// Bounds of θ, infinite at open ends; empty without bounds.
    bounds: Vec<[f64; 2]>,
    residuals: f64,
    thin: usize,
}

impl<'a> WindowProblem<'a> {
    pub fn new(model: &'a Model, recordings: &[&'a Recording], rate_hz: f64) -> Self {
        let mut windows: Vec<RunView> = recordings.iter().flat_map(|r| r.overlapping()).collect();
        windows.sort_by_key(|window| std::cmp::Reverse(window.samples()));
        let longest = windows.first().map_or(1, RunView::samples);
        let std = deviations(recordings.iter().flat_map(|r| &r.whole).map(|p| p.measured.as_slice()));
        let samples: usize = windows.iter().map(RunView::samples).sum();
        Self {
            model,
            limit: limit(recordings),
            sizes: sizes(model, recordings, rate_hz),
            bounds: model.bounds().unwrap_or_default(),
            residuals: (3 * samples).max(1) as f64,
            // States change little within a twentieth of a window.
            thin: (longest / 20).max(1),
            windows,
            std,
        }
    }

    /// The errors of single steps, whose minimum is the least-squares fit of the increments.
    pub fn increments(model: &'a Model, recordings: &[&'a Recording], rate_hz: f64) -> Self {
        let whole = recordings.iter().flat_map(|r| &r.whole).map(Part::view);
        let samples = whole.flat_map(|whole| (0..whole.samples()).map(move |k| whole.part(k..k + 1)));
        let windows: Vec<RunView> = samples.collect();
        let residuals = (3 * windows.len()).max(1) as f64;
        Self { windows, residuals, thin: 1, ..Self::new(model, recordings, rate_hz) }
    }

    /// The same errors over some `recordings` alone.
    pub fn only(&self, recordings: &[&'a Recording]) -> Self {
        let errors = Self::new(self.model, recordings, 1.0);
        Self { sizes: self.sizes.clone(), std: self.std, limit: self.limit, thin: self.thin, ..errors }
    }

    /// The same errors by parameters scaled by their effect: at `theta` the curvature along each is 1, larger for
    /// `known` ones, so that they are hardly penalised. Unchanged if the simulation fails.
    pub fn by_effect(mut self, theta: &[f64], known: &[bool]) -> Self {
        let beta = self.beta(theta);
        let Some(slopes) = self.expansion(&beta) else { return self };
        let p = self.sizes.len();
        for (i, size) in self.sizes.iter_mut().enumerate() {
            let effect = slopes.normal[i * p + i].sqrt();
            let held = if known[i] { KNOWN } else { 1.0 };
            *size = if effect > 0.0 { *size / (effect * held) } else { 0.0 };
        }
        self
    }

    /// The same with `sizes`.
    pub fn sized(self, sizes: Vec<f64>) -> Self {
        Self { sizes, ..self }
    }

    /// Number of errors.
    pub fn errors(&self) -> f64 {
        self.residuals
    }

    /// θ, within its bounds: exactly at a bound if β is.
    pub fn theta(&self, beta: &[f64]) -> Vec<f64> {
        let mut theta: Vec<f64> = beta.iter().zip(&self.sizes).map(|(beta, size)| beta * size).collect();
        for (i, [low, high]) in self.bounds.iter().enumerate() {
            let [least, most] = self.ends(i);
            theta[i] = match beta[i] {
                beta if beta <= least => *low,
                beta if beta >= most => *high,
                _ => theta[i].clamp(*low, *high),
            };
        }
        theta
    }

    /// Bounds of scaled parameter `i`. A term without effect cannot move.
    fn ends(&self, i: usize) -> [f64; 2] {
        let open = [f64::NEG_INFINITY, f64::INFINITY];
        let bounds = self.bounds.get(i).filter(|_| self.sizes[i] > 0.0);
        bounds.map_or(open, |bounds| bounds.map(|end| end / self.sizes[i]))
    }

    /// Bounds of β; empty without bounds.
    pub fn scaled_bounds(&self) -> Vec<[f64; 2]> {
        (0..self.bounds.len()).map(|i| self.ends(i)).collect()
    }

    /// Which of β lie at a bound.
    pub fn at_bound(&self, beta: &[f64]) -> Vec<bool> {
        beta.iter().enumerate().map(|(i, beta)| self.ends(i).contains(beta)).collect()
    }

    pub fn beta(&self, theta: &[f64]) -> Vec<f64> {
        let scaled = |(theta, size): (&f64, &f64)| if *size > 0.0 { theta / size } else { 0.0 };
        theta.iter().zip(&self.sizes).map(scaled).collect()
    }

    /// The loss, and the weights of the windows; `None` if a simulation exceeds the limits.
    pub fn look(&self, beta: &[f64]) -> Option<(f64, Vec<f64>)> {
        let theta: Vec<Lane> = self.theta(beta).into_iter().map(Lane::splat).collect();
        let groups: Vec<&[RunView]> = self.windows.chunks(LANES).collect();
        let errors = |group: &&[RunView]| squares(self.model, &theta, group, self.limit);
        let all_squares: Vec<Vec<Option<[f64; 3]>>> = groups.par_iter().map(errors).collect();
        let (mut loss, mut weights) = (0.0, Vec::with_capacity(self.windows.len()));
        for (group, squares) in groups.into_iter().zip(all_squares) {
            for (window, squares) in group.iter().zip(squares) {
                let squares = squares?;
                let n = (3 * window.samples()) as f64;
                let sum: f64 =
                    (0..3).filter(|d| self.std[*d] > 0.0).map(|d| squares[d] / self.std[d].powi(2)).sum();
                let [cost, weight] = huber((sum / n).sqrt(), USUAL);
                loss += n * cost;
                weights.push(weight);
            }
        }
        loss /= self.residuals;
        loss.is_finite().then_some((loss, weights))
    }

    /// The loss about a point.
    pub fn expansion(&self, beta: &[f64]) -> Option<Expansion> {
        let (loss, weights) = self.look(beta)?;
        self.slopes(beta, (loss, &weights))
    }

    /// The `loss` about a point with these `weights`, per error.
    pub fn slopes(&self, beta: &[f64], (loss, weights): (f64, &[f64])) -> Option<Expansion> {
        let p = beta.len();
        let theta: Vec<Lane> = self.theta(beta).into_iter().map(Lane::splat).collect();
        let groups: Vec<(&[RunView], &[f64])> =
            self.windows.chunks(LANES).zip(weights.chunks(LANES)).collect();
        let chunks: Vec<_> = groups.chunks(groups.len().div_ceil(CHUNKS).max(1)).collect();
        let parts: Vec<_> = chunks.par_iter().map(|groups| self.chunk_sums(&theta, groups)).collect();
        let (mut normal, mut gradient) = (vec![0.0; p * p], vec![0.0; p]);
        for (products, slope) in parts {
            normal.iter_mut().zip(products).for_each(|(sum, entry)| *sum += entry);
            gradient.iter_mut().zip(slope).for_each(|(sum, entry)| *sum += total(entry));
        }
        for i in 0..p {
            let size = self.sizes[i] / self.residuals;
            gradient[i] *= size;
            (0..p).for_each(|j| normal[i * p + j] *= size * self.sizes[j]);
        }
        let finite = normal.iter().chain(&gradient).all(|x| x.is_finite());
        finite.then_some(Expansion { cost: loss, unit: loss, normal, gradient })
    }

    /// Σ s sᵀ, at some samples, and Σ s e of `groups`, by θ.
    fn chunk_sums(&self, theta: &[Lane], groups: &[(&[RunView], &[f64])]) -> (Vec<f64>, Vec<Lane>) {
        let p = theta.len();
        let unknowns = [theta, &[Lane::ZERO; 3]].concat();
        let free: Vec<usize> = (0..p).collect();
        let mut products = Gram::new(p);
        let mut descent = vec![Lane::ZERO; p];
        for (windows, weights) in groups {
            let runs = SideBySide::of(windows);
            let recordings = Recordings::of(self.model, &runs);
            // Unused lanes repeat the last window.
            let weight = Lane(std::array::from_fn(|lane| weights.get(lane).map_or(0.0, |w| w.sqrt())));
            let scales = self.std.map(|std| if std > 0.0 { std.recip() } else { 0.0 });
            free_sweep(
                &recordings,
                &unknowns,
                &free,
                #[inline(always)]
                |step: Step<'_, Lane, 3>| {
                    if step.k == 0 {
                        return;
                    }
                    let counts = recordings.lasting(step.k) * weight;
                    let counted = step.k.is_multiple_of(self.thin);
                    for d in 0..3 {
                        let by = counts * Lane::splat(scales[d]);
                        let error = step.error[d] * by * by;
                        for (sum, s) in descent.iter_mut().zip(step.sensitivities) {
                            *sum += s[d] * error;
                        }
                        if counted {
                            for (i, s) in step.sensitivities.iter().enumerate() {
                                products.set(i, s[d] * by);
                            }
                            products.advance();
                        }
                    }
                },
            );
        }
        let curvature = products.finish().into_iter().map(|sum| self.thin as f64 * sum).collect();
        (curvature, descent)
    }
}

fn total(lane: Lane) -> f64 {
    lane.0.iter().sum()
}

/// rms(increment over 1 s) / rms(term), per parameter; 0 for a term that is always 0.
fn sizes(model: &Model, recordings: &[&Recording], rate_hz: f64) -> Vec<f64> {
    let second = (rate_hz.round() as usize).max(1);
    let (mut gained, mut pairs) = ([0.0; 3], 0.0_f64);
    let (mut squares, mut samples) = (vec![0.0; model.parameters()], 0.0_f64);
    let mut compiled = Compiled::new(model, &vec![0.0; model.parameters()]);
    let width = model.exogenous().max(1);
    for part in recordings.iter().flat_map(|r| &r.whole) {
        let states = part.measured.as_chunks::<3>().0;
        for (before, after) in states.iter().zip(states.iter().skip(second)) {
            (0..3).for_each(|d| gained[d] += (after[d] - before[d]).powi(2));
            pairs += 1.0;
        }
        for (state, exogenous) in states.iter().zip(part.exogenous.chunks_exact(width)) {
            compiled.look(*state, exogenous, None);
            squares.iter_mut().enumerate().for_each(|(i, sum)| *sum += compiled.term(i).powi(2));
            samples += 1.0;
        }
    }
    let gained = gained.map(|sum: f64| (sum / pairs.max(1.0)).sqrt());
    let size = |(square, d): (f64, usize)| {
        if square > 0.0 { gained[d] / (square / samples.max(1.0)).sqrt() } else { 0.0 }
    };
    squares.into_iter().zip(model.layout().degrees()).map(size).collect()
}

/// Rows that are multiplied at once: as many as fit the caches.
const ROWS: usize = 48;
/// Rows and columns of a tile, whose sums stay in registers.
const TILE: usize = 4;

/// Σ x xᵀ over rows of many signals. It is summed in tiles, so that each loaded number is used four times.
struct Gram {
    signals: usize,
    rows: Vec<f64>,
    filled: usize,
    sums: Vec<f64>,
}

impl Gram {
    pub fn new(signals: usize) -> Self {
        let columns = signals.next_multiple_of(TILE);
        let [rows, sums] = [columns * ROWS * LANES, columns * columns].map(|count| vec![0.0; count]);
        Self { signals, rows, filled: 0, sums }
    }

    /// Signal `i` in this row.
    #[inline(always)]
    pub fn set(&mut self, i: usize, value: Lane) {
        let first = (i * ROWS + self.filled) * LANES;
        self.rows[first..first + LANES].copy_from_slice(&value.0);
    }

    /// Moves to the next row, after every signal was set.
    #[inline(always)]
    pub fn advance(&mut self) {
        self.filled += 1;
        if self.filled == ROWS {
            self.multiply();
        }
    }

    #[inline(never)]
    fn multiply(&mut self) {
        self.filled = 0;
        let columns = self.signals.next_multiple_of(TILE);
        numerics::dispatch(Multiply { rows: &self.rows, columns, sums: &mut self.sums });
    }

    /// The sums over all rows and lanes: signals × signals.
    pub fn finish(mut self) -> Vec<f64> {
        for signal in self.rows.chunks_exact_mut(ROWS * LANES) {
            signal[self.filled * LANES..].fill(0.0);
        }
        self.multiply();
        let (n, columns) = (self.signals, self.signals.next_multiple_of(TILE));
        let upper = |k: usize| (k / n).min(k % n) * columns + (k / n).max(k % n);
        (0..n * n).map(|k| self.sums[upper(k)]).collect()
    }
}

struct Multiply<'a> {
    rows: &'a [f64],
    columns: usize,
    sums: &'a mut [f64],
}

impl WithSimd for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let signal = |i: usize| S::as_simd_f64s(&self.rows[i * ROWS * LANES..(i + 1) * ROWS * LANES]).0;
        for i in (0..self.columns).step_by(TILE) {
            let signals = [signal(i), signal(i + 1), signal(i + 2), signal(i + 3)];
            for j in (i..self.columns).step_by(TILE) {
                let others = [signal(j), signal(j + 1), signal(j + 2), signal(j + 3)];
                let tile = tile(simd, signals, others);
                for (a, row) in tile.iter().enumerate() {
                    for (b, sum) in row.iter().enumerate() {
                        self.sums[(i + a) * self.columns + j + b] += sum;
                    }
                }
            }
        }
    }
}

/// Products of four signals with four. Every lane has its own sum, so that bits are the same everywhere.
#[inline(always)]
fn tile<S: Simd>(simd: S, signals: [&[S::f64s]; TILE], others: [&[S::f64s]; TILE]) -> [[f64; TILE]; TILE] {
    let vectors = signals[0].len() / ROWS;
    let mut tile = [[0.0; TILE]; TILE];
    for vector in 0..vectors {
        let mut sums = [[simd.splat_f64s(0.0); TILE]; TILE];
        for row in 0..ROWS {
            let at = row * vectors + vector;
            let others = [others[0][at], others[1][at], others[2][at], others[3][at]];
            for (sums, signal) in sums.iter_mut().zip(signals) {
                for (sum, other) in sums.iter_mut().zip(others) {
                    *sum = simd.add_f64s(*sum, simd.mul_f64s(signal[at], other));
                }
            }
        }
        for (out, sums) in tile.iter_mut().zip(&sums) {
            for (out, sum) in out.iter_mut().zip(sums) {
                let lanes: &[f64] = pulp::bytemuck::cast_slice(std::slice::from_ref(sum));
                lanes.iter().for_each(|lane| *out += lane);
            }
        }
    }
    tile
}
