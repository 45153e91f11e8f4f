//! One pass over the windows of a group: errors, their derivatives, and the sums of both.

use numerics::least_squares::huber;
use numerics::{LANES, Lane, vectorized};
use ship::forces::{Body, Dual, Real};

use super::{Inputs, Pass, Window, WindowGroup};

/// Unknowns by which derivatives are computed at once.
pub(crate) const AT_ONCE: usize = 13;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WindowErrors {
    pub squares: [f64; 3],
    pub samples: usize,
}

impl WindowErrors {
    /// Numbers that are compared.
    pub fn numbers(&self) -> f64 {
        (3 * self.samples) as f64
    }

    /// RMS error of u, v and r together.
    pub fn rms(&self) -> f64 {
        (self.squares.iter().sum::<f64>() / self.numbers()).sqrt()
    }

    pub fn cost(&self, knee: f64) -> f64 {
        huber(self.rms(), knee)[0]
    }

    /// The derivative of its cost by its mean square.
    pub fn slope(&self, knee: f64) -> f64 {
        huber(self.rms(), knee)[1]
    }
}

/// Sums of a window: of products of the derivatives of its errors, and of these with the errors, piece by piece.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WindowSums {
    pub errors: WindowErrors,
    pub products: Vec<f64>,
    pub pieces: Vec<Vec<f64>>,
}

/// Errors of a group of windows, and their derivatives by θ and then by the start of each window.
pub(crate) struct Derivatives {
    pub slopes: Vec<Lane>,
    /// Three errors for each sample, 0 after the end of a window.
    pub left: Vec<Lane>,
}

impl Pass<'_> {
    /// Errors of the windows of `group`, which start at `starts`.
    pub fn errors(&self, group: &WindowGroup, theta: &[f64], starts: &[[f64; 3]]) -> Vec<WindowErrors> {
        let theta: Vec<Lane> = theta.iter().map(|value| Lane::splat(*value)).collect();
        let body = self.forces.body(&theta);
        let mut squares = [Lane::ZERO; 3];
        vectorized!(squared(self, group, &body, start(starts), &mut squares));
        window_errors(group, squares)
    }

    /// The errors and sums of the windows of `group`, which start at `starts`.
    pub fn sums(&self, group: &WindowGroup, theta: &[f64], starts: &[[f64; 3]]) -> Vec<WindowSums> {
        self.sums_of(group, &self.derivatives(group, theta, starts))
    }

    /// The errors of the windows of `group`, which start at `starts`, and their derivatives.
    pub fn derivatives(&self, group: &WindowGroup, theta: &[f64], starts: &[[f64; 3]]) -> Derivatives {
        let unknowns = self.unknowns();
        let rows = 3 * (group.samples + 1);
        let mut slopes = vec![Lane::ZERO; rows * unknowns];
        let mut left = vec![Lane::ZERO; rows];
        for first in (0..unknowns).step_by(AT_ONCE) {
            let dual = |value: Lane, i: usize| Dual::<Lane, AT_ONCE>::unknown(value, i.wrapping_sub(first));
            let parameters: Vec<_> =
                theta.iter().enumerate().map(|(i, x)| dual(Lane::splat(*x), i)).collect();
            let begin = start(starts);
            let begin = [0, 1, 2].map(|d: usize| dual(begin[d], theta.len() + d));
            let body = self.forces.body(&parameters);
            let count = AT_ONCE.min(unknowns - first);
            let out = (&mut left[..], &mut slopes[first..]);
            vectorized!(columns(self, group, &body, begin, (count, unknowns), out));
        }
        Derivatives { slopes, left }
    }

    /// The sums of `derivatives`, those of the windows of `group`.
    pub fn sums_of(&self, group: &WindowGroup, derivatives: &Derivatives) -> Vec<WindowSums> {
        let (unknowns, Derivatives { slopes, left }) = (self.unknowns(), derivatives);
        let piece = self.settings.samples(self.settings.piece_s);
        let mut products = vec![Lane::ZERO; unknowns * unknowns];
        let mut gradients = vec![Lane::ZERO; (group.samples / piece + 1) * unknowns];
        let mut squares = [Lane::ZERO; 3];
        let sums = (&mut products[..], &mut gradients[..], &mut squares);
        vectorized!(accumulate(slopes, left, unknowns, 3 * piece, sums));
        let errors = window_errors(group, squares).into_iter().enumerate();
        errors
            .map(|(lane, errors)| {
                let at = |i: usize, j: usize| products[i.min(j) * unknowns + i.max(j)][lane];
                let pieces = gradients.chunks_exact(unknowns);
                WindowSums {
                    errors,
                    products: (0..unknowns * unknowns).map(|k| at(k / unknowns, k % unknowns)).collect(),
                    pieces: pieces.map(|piece| piece.iter().map(|sum| sum[lane]).collect()).collect(),
                }
            })
            .collect()
    }
}

fn window_errors(group: &WindowGroup, squares: [Lane; 3]) -> Vec<WindowErrors> {
    let of = |(lane, window): (usize, &Window)| WindowErrors {
        squares: squares.map(|square| square[lane]),
        samples: window.samples,
    };
    group.windows.iter().enumerate().map(of).collect()
}

pub(crate) fn start(starts: &[[f64; 3]]) -> [Lane; 3] {
    [0, 1, 2].map(|d: usize| numerics::lanes::lane(starts.len(), |i| starts[i][d]))
}

#[inline(always)]
fn follow<X: Real>(
    pass: &Pass,
    group: &WindowGroup,
    body: &Body<X>,
    state: [X; 3],
    lift: impl Fn(Lane) -> X,
    look: impl FnMut(usize, [X; 3]),
) {
    let acting = pass.late.then(|| {
        let rows: Vec<X> = group.inputs.iter().map(|input| lift(*input)).collect();
        body.acting(&rows, pass.width, pass.settings.sample_s)
    });
    let input = |at: usize| match &acting {
        Some(rows) => rows[at],
        None => lift(group.inputs[at]),
    };
    follow_acting(pass, group, body, state, input, look);
}

/// Calls `look` with the state in every sample, where `input` is what acts: an entry of the rows of inputs.
#[inline(always)]
pub(crate) fn follow_acting<X: Real>(
    pass: &Pass,
    group: &WindowGroup,
    body: &Body<X>,
    mut state: [X; 3],
    input: impl Fn(usize) -> X,
    mut look: impl FnMut(usize, [X; 3]),
) {
    let (width, sample_s) = (pass.width, pass.settings.sample_s);
    let next = if pass.settings.inputs == Inputs::Held { 0 } else { width };
    look(0, state);
    for k in 0..group.samples {
        let row = (group.before + k) * width;
        let end = row + next;
        state = body.steps(state, |i| [input(row + i), input(end + i)], sample_s);
        look(k + 1, state);
    }
}

/// 1 in windows that have sample `k`, else 0.
#[inline(always)]
pub(crate) fn counted(group: &WindowGroup, k: usize) -> [bool; LANES] {
    std::array::from_fn(|lane| group.windows.get(lane).is_some_and(|window| k <= window.samples))
}

#[inline(always)]
pub(crate) fn only(value: Lane, counted: [bool; LANES]) -> Lane {
    Lane(std::array::from_fn(|lane| if counted[lane] { value[lane] } else { 0.0 }))
}

#[inline(always)]
fn squared(pass: &Pass, group: &WindowGroup, body: &Body<Lane>, start: [Lane; 3], squares: &mut [Lane; 3]) {
    follow(
        pass,
        group,
        body,
        start,
        |state| state,
        |k, state| {
            let (counted, scales) = (counted(group, k), pass.scales(k));
            for (d, value) in state.into_iter().enumerate() {
                let error = (value - group.measured[3 * k + d]) * Lane::splat(scales[d]);
                let error = only(error, counted);
                squares[d] += error * error;
            }
        },
    );
}

#[inline(always)]
fn columns(
    pass: &Pass,
    group: &WindowGroup,
    body: &Body<Dual<Lane, AT_ONCE>>,
    start: [Dual<Lane, AT_ONCE>; 3],
    (count, width): (usize, usize),
    (left, slopes): (&mut [Lane], &mut [Lane]),
) {
    follow(pass, group, body, start, Dual::constant, |k, state| {
        let (counted, scales) = (counted(group, k), pass.scales(k));
        for (d, value) in state.into_iter().enumerate() {
            let (row, scale) = (3 * k + d, Lane::splat(scales[d]));
            left[row] = only((value.value - group.measured[row]) * scale, counted);
            for i in 0..count {
                slopes[row * width + i] = only(value.tangents[i] * scale, counted);
            }
        }
    });
}

#[inline(always)]
fn accumulate(
    slopes: &[Lane],
    left: &[Lane],
    width: usize,
    piece: usize,
    (products, gradients, squares): (&mut [Lane], &mut [Lane], &mut [Lane; 3]),
) {
    for (k, (row, error)) in slopes.chunks_exact(width).zip(left).enumerate() {
        squares[k % 3] += *error * *error;
        let gradient = &mut gradients[k / piece * width..][..width];
        for i in 0..width {
            let factor = row[i];
            gradient[i] += factor * *error;
            let sums = &mut products[i * width..][..width];
            for j in i..width {
                sums[j] += factor * row[j];
            }
        }
    }
}

// Normal equations of θ, from which the starts of windows are eliminated.

/// What a window says of θ once its start is chosen best, and how the start then follows θ.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Reduced {
    pub products: Vec<f64>,
    pub gradient: Vec<f64>,
    /// How the start changes with each of θ: 3 rows.
    pub follows: Vec<f64>,
    /// How it changes where θ stays.
    pub stays: [f64; 3],
}

/// Share that is added to the diagonal of a start that is singular to all digits.
const SINGULAR: f64 = 1e-9;

/// Sums over θ alone, `damping` added to the diagonal of the start; `None` where the start is not determined.
pub(crate) fn reduced(window: &WindowSums, n: usize, damping: f64) -> Option<Reduced> {
    let all = n + window.starts(n);
    let at = |i: usize, j: usize| window.products[i * all + j];
    let gradient: Vec<f64> = (0..all).map(|i| window.pieces.iter().map(|piece| piece[i]).sum()).collect();
    let mut products: Vec<f64> = (0..n * n).map(|k| at(k / n, k % n)).collect();
    if all == n {
        return Some(Reduced { products, gradient, follows: vec![0.0; 3 * n], stays: [0.0; 3] });
    }
    // Columns: θ, then the gradient.
    let mut sides: Vec<f64> = Vec::with_capacity(3 * (n + 1));
    for d in 0..3 {
        sides.extend((0..n).map(|i| at(n + d, i)));
        sides.push(gradient[n + d]);
    }
    let follows = window.solved_by_start(n, damping, &sides)?;
    let row = |d: usize| &follows[d * (n + 1)..][..n + 1];
    let mut left: Vec<f64> = gradient[..n].to_vec();
    for i in 0..n {
        for d in 0..3 {
            let across = at(i, n + d);
            left[i] -= across * row(d)[n];
            (0..n).for_each(|j| products[i * n + j] -= across * row(d)[j]);
        }
    }
    let start_step = [0, 1, 2].map(|d| -row(d)[n]);
    let follows = (0..3).flat_map(|d| row(d)[..n].iter().map(|follow| -follow)).collect();
    Some(Reduced { products, gradient: left, follows, stays: start_step })
}

impl WindowSums {
    /// Unknowns of its start, besides `n` of θ.
    pub fn starts(&self, n: usize) -> usize {
        self.pieces.first().map_or(0, |piece| piece.len() - n)
    }

    /// What solves the products of the start, with `damping` on the diagonal, for `sides`; `None` if it is undetermined.
    pub fn solved_by_start(&self, n: usize, damping: f64, sides: &[f64]) -> Option<Vec<f64>> {
        let starts = self.starts(n);
        let all = n + starts;
        let solved = |damping: f64| {
            let at = |k: usize| self.products[(n + k / starts) * all + n + k % starts];
            let mut square: Vec<f64> = (0..starts * starts).map(at).collect();
            (0..starts).for_each(|d| square[(starts + 1) * d] *= 1.0 + damping);
            let mut solution = sides.to_vec();
            numerics::solve(starts, &mut square, &mut solution).map(|()| solution)
        };
        // A window that is unstable, such as one astern, has a start of which one sum alone is told, to all digits.
        solved(damping).or_else(|| solved(damping.max(SINGULAR)))
    }

    /// Jᵀe of each piece, of θ alone: what the start makes of it is followed by `reduced`.
    pub fn scores(&self, reduced: &Reduced, n: usize) -> Vec<Vec<f64>> {
        let starts = self.starts(n);
        let score = |piece: &Vec<f64>| {
            (0..n)
                .map(|i| {
                    piece[i] + (0..starts).map(|d| reduced.follows[d * n + i] * piece[n + d]).sum::<f64>()
                })
                .collect()
        };
        self.pieces.iter().map(score).collect()
    }
}
