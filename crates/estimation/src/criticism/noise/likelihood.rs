use numerics::{LANES, Lane, times};
use ship::engine::{Compiled, DIVERGED, RunView, SideBySide};
use ship::model::{Model, ParameterLayout};

use super::{Guess, side_by_side};
use crate::predictor::scaled_inverse;
use crate::sensitivity::{
    Local, Motion, NoiseModel, Products, Recordings, add_noise, current_of, filter_along, gain, moved,
    shrink, start, vessel_state, with_states,
};

/// Samples whose scales are multiplied before a logarithm is taken.
const TOGETHER: usize = 4;

/// Sums over runs of whitened errors w and sensitivities W, by lane for other levels.
pub(super) struct LikelihoodSums {
    products: Products<Lane>,
    logs: Lane,
    terms: usize,
}

/// Per sample the product of the scales, and the squared white errors without the part that the parameters explain.
pub(super) type Samples = Vec<[Lane; 2]>;

impl LikelihoodSums {
    pub fn new(terms: usize) -> Self {
        Self { products: Products::new(terms + 1), logs: Lane::ZERO, terms }
    }

    /// Twice the restricted log-likelihood up to a constant: −Σ log s − w⊥ᵀw⊥ − log|WᵀW|; and WᵀW, Wᵀw.
    #[allow(clippy::needless_range_loop)] // Cholesky's, of rows and columns.
    pub fn finish(self) -> Likelihoods {
        let p = self.terms;
        let all = self.products.finish().square();
        let entry = |i: usize, j: usize| all[i * (p + 1) + j];
        let mut lower = vec![Lane::ZERO; p * p];
        let (mut explained, mut volume, mut solved) = (Lane::ZERO, Lane::ZERO, vec![Lane::ZERO; p]);
        for j in 0..p {
            for i in j..p {
                let mut left = entry(i, j);
                (0..j).for_each(|k| left = left - lower[i * p + k] * lower[j * p + k]);
                lower[i * p + j] = if i == j { pivot(left, entry(i, i)) } else { left / lower[j * p + j] };
            }
            let mut left = entry(j, p);
            (0..j).for_each(|k| left = left - lower[j * p + k] * solved[k]);
            solved[j] = left / lower[j * p + j];
            explained += solved[j] * solved[j];
            volume += logarithm(lower[j * p + j]);
        }
        let likelihood = self.logs + self.logs + explained - entry(p, p) - volume - volume;
        let first = |i: usize, j: usize| entry(i, j)[0];
        let normal = (0..p * p).map(|k| first(k / p, k % p)).collect();
        let gradient = (0..p).map(|i| first(i, p)).collect();
        Likelihoods { likelihood, normal, gradient, squares: entry(p, p)[0] }
    }
}

pub(super) struct Likelihoods {
    pub likelihood: Lane,
    /// WᵀW, Wᵀw and wᵀw of the first lane.
    pub normal: Vec<f64>,
    pub gradient: Vec<f64>,
    pub squares: f64,
}

impl Likelihoods {
    /// The change of the parameters to the least white errors, and their standard errors.
    pub(super) fn change(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        let p = self.gradient.len();
        let inverse = scaled_inverse(&self.normal, p).ok()?;
        let errors = (0..p).map(|i| inverse[i * p + i].max(0.0).sqrt()).collect();
        Some((times(&inverse, &self.gradient), errors))
    }
}

/// Share of a square below which the rest is rounding.
const LEFT: f64 = 1e-13;

/// The root of the rest; NaN if that is zero.
fn pivot(left: Lane, whole: Lane) -> Lane {
    let mut root = left.sqrt();
    for lane in 0..numerics::LANES {
        if left[lane].is_nan() || left[lane] <= LEFT * whole[lane] {
            root[lane] = f64::NAN;
        }
    }
    root
}

fn logarithm(mut x: Lane) -> Lane {
    x.0.iter_mut().for_each(|x| *x = libm::log(*x));
    x
}

/// Adds the first `samples` of a run under `levels`. With a change of the parameters, the terms of each sample are stored.
pub(super) fn add_run<const N: usize>(
    sums: &mut LikelihoodSums,
    layout: ParameterLayout,
    line: &Line,
    samples: usize,
    levels: &NoiseModel<Lane>,
    known_start: bool,
    stored: Option<(&[f64], &mut Samples)>,
) {
    numerics::vectorized!(narrow: go_along::<N>(sums, layout, line, samples, levels, known_start, stored));
}

#[inline(always)]
fn go_along<const N: usize>(
    sums: &mut LikelihoodSums,
    layout: ParameterLayout,
    line: &Line,
    samples: usize,
    levels: &NoiseModel<Lane>,
    known_start: bool,
    mut stored: Option<(&[f64], &mut Samples)>,
) {
    let motion = Motion::<Lane, N>::new(Some(levels));
    let noise = levels.measurement.map(|s| s * s);
    let mut p = start::<N>(levels, known_start);
    let mut z = [Lane::ZERO; N];
    (0..3).for_each(|d| z[d] = Lane::splat(line.run.initial[d]));
    let degrees: Vec<usize> = layout.degrees().collect();
    let mut columns = vec![[Lane::ZERO; N]; degrees.len()];
    let mut white = vec![[Lane::ZERO; 3]; degrees.len() + 1];
    let (mut scale, mut waiting) = (Lane::ONE, 0);
    for k in 0..=samples {
        let y = &line.run.measured[3 * k..3 * k + 3];
        let error = [0, 1, 2].map(|d: usize| Lane::splat(y[d]) - z[d]);
        let gain = gain(&p, &noise);
        if k > 0 {
            for (white, s) in white.iter_mut().zip(&columns) {
                *white = gain.white(&[s[0], s[1], s[2]]);
            }
            white[degrees.len()] = gain.white(&error);
            for d in 0..3 {
                for (i, white) in white.iter().enumerate() {
                    sums.products.set(i, white[d]);
                }
                sums.products.advance();
            }
            let [a, b, c] = gain.scales();
            let own_scale = a * b * c;
            if let Some((change, kept)) = &mut stored {
                kept.push([own_scale, left(&white, change)]);
            }
            scale = scale * own_scale;
            waiting += 1;
            if waiting == TOGETHER {
                sums.logs += logarithm(scale);
                (scale, waiting) = (Lane::ONE, 0);
            }
        }
        if k == samples {
            break;
        }
        gain.correct(&mut z, &error);
        shrink(&mut p, &gain);
        let point = &line.points[k];
        let (middle, next, local) = about(&motion, point);
        z.iter_mut().zip(middle).for_each(|(z, middle)| *z = *z - middle);
        let moved_on = motion.forward(&local, &z);
        z = std::array::from_fn(|i| next[i] + moved_on[i]);
        let terms = &line.terms[k * degrees.len()..(k + 1) * degrees.len()];
        for ((s, d), term) in columns.iter_mut().zip(&degrees).zip(terms) {
            gain.correct_column(s);
            *s = motion.forward(&local, s);
            s[*d] += Lane::splat(*term);
        }
        p = moved(&motion, &local, &p);
        add_noise(&mut p, &local, levels);
    }
    sums.logs += logarithm(scale);
}

/// A point's states, those after it, and the propagation there. A current that is no state has a mean of zero.
#[inline(always)]
fn about<const N: usize>(motion: &Motion<Lane, N>, point: &PathPoint) -> ([Lane; N], [Lane; N], Local<Lane>) {
    let mut middle = [Lane::ZERO; N];
    (0..3).for_each(|d| middle[d] = Lane::splat(point.state[d]));
    let mut next = point.next;
    if current_of(&middle).is_some() {
        (middle[3], middle[4]) = (Lane::splat(point.current[0]), Lane::splat(point.current[1]));
    } else {
        for (next, slope) in next.iter_mut().zip(&point.slopes) {
            *next += slope[0] * point.current[0] + slope[1] * point.current[1];
        }
    }
    let local = motion.local(&middle, point.slopes.map(|row| row.map(Lane::splat)));
    (middle, motion.next(&middle, next.map(Lane::splat), &local), local)
}

/// Squares of the white errors, the last column, without the part that a change of the parameters explains.
#[inline(always)]
fn left(white: &[[Lane; 3]], change: &[f64]) -> Lane {
    let mut rest = white[change.len()];
    for (column, change) in white.iter().zip(change) {
        for d in 0..3 {
            rest[d] = rest[d] - column[d] * Lane::splat(*change);
        }
    }
    rest[0] * rest[0] + rest[1] * rest[1] + rest[2] * rest[2]
}

/// A run, with the model linearised about a causal path.
pub(super) struct Line<'a> {
    pub run: RunView<'a>,
    pub points: Vec<PathPoint>,
    /// φ of every parameter, by sample.
    pub terms: Vec<f64>,
}

#[derive(Clone, Copy)]
pub(super) struct PathPoint {
    pub state: [f64; 3],
    pub current: [f64; 2],
    pub next: [f64; 3],
    pub slopes: [[f64; 3]; 3],
}

impl<'a> Line<'a> {
    /// Linearises about the free simulation with `theta`; about the measured states if that diverges.
    pub fn free(model: &Model, theta: &[f64], run: RunView<'a>) -> Self {
        let (width, mut state) = (model.exogenous().max(1), run.initial);
        let mut compiled = Compiled::<f64>::new(model, theta);
        let mut path = vec![(state, [0.0; 2])];
        for row in run.exogenous.chunks_exact(width) {
            compiled.look(state, row, None);
            state = compiled.next(state, None);
            path.push((state, [0.0; 2]));
        }
        let near = |x: &f64| x.is_finite() && x.abs() <= DIVERGED;
        if !path.iter().all(|(state, _)| state.iter().all(near)) {
            path = run.measured.as_chunks::<3>().0.iter().map(|y| (*y, [0.0; 2])).collect();
        }
        Self::about(model, theta, run, path)
    }

    /// Linearises about the states and currents of a filter for `guess`; `None` if they are not finite.
    pub fn filtered(
        model: &Model,
        theta: &[f64],
        run: RunView<'a>,
        guess: &Guess,
        (rate_hz, known_start): (f64, bool),
    ) -> Option<Self> {
        let alike = SideBySide::of(&[run]);
        let recordings = Recordings::of(model, &alike);
        let unknowns: Vec<Lane> = theta.iter().copied().chain([0.0; 3]).map(Lane::splat).collect();
        let levels = guess.levels(rate_hz);
        let path = with_states!(levels.states(), path(&recordings, &unknowns, guess, rate_hz, known_start));
        let near = |x: &f64| x.is_finite() && x.abs() <= DIVERGED;
        let all = path.iter().all(|(state, current)| state.iter().chain(current).all(near));
        all.then(|| Self::about(model, theta, run, path))
    }

    fn about(model: &Model, theta: &[f64], run: RunView<'a>, path: Vec<([f64; 3], [f64; 2])>) -> Self {
        let (width, mut compiled) = (model.exogenous().max(1), Compiled::<f64>::new(model, theta));
        let mut terms = Vec::with_capacity(theta.len() * path.len());
        let rows = run.exogenous.chunks_exact(width);
        let point = |((state, current), row): (([f64; 3], [f64; 2]), &[f64])| {
            compiled.look(state, row, Some(current));
            terms.extend((0..theta.len()).map(|i| compiled.term(i)));
            PathPoint { state, current, next: compiled.next(state, None), slopes: compiled.slopes() }
        };
        let points = path.into_iter().zip(rows).map(point).collect();
        Self { run, points, terms }
    }

    /// Root mean square of the measured states less the path.
    pub fn errors(&self) -> [f64; 3] {
        let rows = || self.points.iter().zip(self.run.measured.as_chunks::<3>().0);
        let square = |d: usize| rows().map(|(point, y)| (y[d] - point.state[d]).powi(2)).sum::<f64>();
        [0, 1, 2].map(|d| (square(d) / self.points.len().max(1) as f64).sqrt())
    }
}

fn path<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    guess: &Guess,
    rate_hz: f64,
    known_start: bool,
) -> Vec<([f64; 3], [f64; 2])> {
    let levels = side_by_side(&[*guess; LANES], rate_hz);
    let mut path = Vec::with_capacity(recordings.longest() + 1);
    filter_along::<N>(
        recordings,
        unknowns,
        &levels,
        known_start,
        #[inline(always)]
        |z| {
            let current = current_of(z).map_or([0.0; 2], |current| current.map(|c| c[0]));
            path.push((vessel_state(z).map(|x| x[0]), current));
        },
    );
    path
}
