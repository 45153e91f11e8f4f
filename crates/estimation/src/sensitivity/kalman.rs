use numerics::Lane;

use super::dynamics::{Dynamics, Flow, Local, Motion, NoiseModel};
use super::{Recordings, Unknowns};

#[derive(Clone, Debug)]
pub(crate) struct Gain<X, const N: usize> {
    rows: [[X; 3]; N],
    /// W with W Λ Wᵀ = 1 for the innovations' covariance Λ, lower triangle by rows.
    whitening: [X; 6],
}

impl<X: Unknowns, const N: usize> Gain<X, N> {
    #[inline(always)]
    pub(crate) fn correct(&self, z: &mut [X; N], error: &[X; 3]) {
        for (z, row) in z.iter_mut().zip(&self.rows) {
            *z += row[0] * error[0] + row[1] * error[1] + row[2] * error[2];
        }
    }

    #[inline(always)]
    pub(crate) fn correct_column(&self, s: &mut [Lane; N]) {
        let (u, v, r) = (Lane::ZERO - s[0], Lane::ZERO - s[1], Lane::ZERO - s[2]);
        for (s, row) in s.iter_mut().zip(&self.rows) {
            *s += row[0].lane() * u + row[1].lane() * v + row[2].lane() * r;
        }
    }
}

impl<const N: usize> Gain<Lane, N> {
    /// The diagonal of W, whose product is 1/√det Λ.
    pub(crate) fn scales(&self) -> [Lane; 3] {
        [self.whitening[0], self.whitening[2], self.whitening[5]]
    }

    /// W e.
    #[inline(always)]
    pub(crate) fn white(&self, e: &[Lane; 3]) -> [Lane; 3] {
        let w = &self.whitening;
        [w[0] * e[0], w[1] * e[0] + w[2] * e[1], w[3] * e[0] + w[4] * e[1] + w[5] * e[2]]
    }
}

/// The covariance of the states.
type P<const N: usize> = [[Lane; N]; N];

/// Variance of an unknown initial state over that of its measurement.
const UNKNOWN: f64 = 1e6;

/// An extended Kalman filter over recordings: its gains at samples 0 to N, and its innovations, (N+1) × 3.
pub(crate) fn filter<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    levels: &NoiseModel,
    known_start: bool,
) -> (Vec<Gain<Lane, N>>, Vec<Lane>) {
    filter_along(recordings, unknowns, &levels.spread(), known_start, |_| ())
}

/// The same with separate levels for every recording; `each` is called with the states at every sample, corrected by the measurement there.
pub(crate) fn filter_along<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    levels: &NoiseModel<Lane>,
    known_start: bool,
    each: impl FnMut(&[Lane; N]),
) -> (Vec<Gain<Lane, N>>, Vec<Lane>) {
    numerics::vectorized!(narrow: filtered::<N>(recordings, unknowns, levels, known_start, each))
}

#[inline(always)]
fn filtered<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    levels: &NoiseModel<Lane>,
    known_start: bool,
    mut each: impl FnMut(&[Lane; N]),
) -> (Vec<Gain<Lane, N>>, Vec<Lane>) {
    let (theta, offsets) = unknowns.split_at(recordings.model.parameters());
    let mut dynamics = Dynamics::<Lane, N>::new(recordings.model, theta, Some(levels));
    let noise = levels.measurement.map(|s| s * s);
    let mut z = [Lane::ZERO; N];
    for d in 0..3 {
        z[d] = recordings.initial[d] + offsets[d];
    }
    let mut p = start::<N>(levels, known_start);
    let last = recordings.longest();
    let mut gains = Vec::with_capacity(last + 1);
    let mut innovations = Vec::with_capacity(3 * last + 3);
    for k in 0..=last {
        let error = [0, 1, 2].map(|d: usize| recordings.measured[3 * k + d] - z[d]);
        let gain = gain(&p, &noise);
        innovations.extend_from_slice(&error);
        gain.correct(&mut z, &error);
        shrink(&mut p, &gain);
        each(&z);
        gains.push(gain);
        if k == last {
            break;
        }
        let local = dynamics.at(&z, recordings.exogenous(k));
        z = dynamics.next(&z, &local);
        p = moved(&dynamics.motion, &local, &p);
        add_noise(&mut p, &local, levels);
    }
    (gains, innovations)
}

pub(crate) fn start<const N: usize>(levels: &NoiseModel<Lane>, known: bool) -> P<N> {
    let mut p = [[Lane::ZERO; N]; N];
    if !known {
        for (d, std) in levels.measurement.into_iter().enumerate() {
            p[d][d] = Lane::splat(UNKNOWN) * (std * std);
        }
    }
    levels.processes::<N>().for_each(|(i, std, _)| add_draw(&mut p, i, std * std, levels.drift.is_some()));
    p
}

/// K = P Hᵀ Λ⁻¹ by the Cholesky factor of Λ = H P Hᵀ + R.
#[inline(always)]
pub(crate) fn gain<const N: usize>(p: &P<N>, noise: &[Lane; 3]) -> Gain<Lane, N> {
    let l00 = (p[0][0] + noise[0]).sqrt().recip();
    let l10 = p[1][0] * l00;
    let l20 = p[2][0] * l00;
    let l11 = (p[1][1] + noise[1] - l10 * l10).sqrt().recip();
    let l21 = (p[2][1] - l20 * l10) * l11;
    let l22 = (p[2][2] + noise[2] - l20 * l20 - l21 * l21).sqrt().recip();
    // The inverse of the lower factor; the diagonal is inverted already.
    let w1 = Lane::ZERO - l11 * l10 * l00;
    let w4 = Lane::ZERO - l22 * l21 * l11;
    let w3 = Lane::ZERO - l22 * (l20 * l00 + l21 * w1);
    let w = [l00, w1, l11, w3, w4, l22];
    let row = |p: &[Lane; N]| {
        let white = [w[0] * p[0], w[1] * p[0] + w[2] * p[1], w[3] * p[0] + w[4] * p[1] + w[5] * p[2]];
        [
            w[0] * white[0] + w[1] * white[1] + w[3] * white[2],
            w[2] * white[1] + w[4] * white[2],
            w[5] * white[2],
        ]
    };
    Gain { rows: std::array::from_fn(|i| row(&p[i])), whitening: w }
}

/// P − K H P, symmetric.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // Both triangles at once.
pub(crate) fn shrink<const N: usize>(p: &mut P<N>, gain: &Gain<Lane, N>) {
    let known = [p[0], p[1], p[2]];
    for i in 0..N {
        for j in 0..=i {
            let row = &gain.rows[i];
            let less = p[i][j] - (row[0] * known[0][j] + row[1] * known[1][j] + row[2] * known[2][j]);
            p[i][j] = less;
            p[j][i] = less;
        }
    }
}

/// A P Aᵀ.
#[inline(always)]
pub(crate) fn moved<const N: usize>(motion: &Motion<Lane, N>, local: &Local<Lane>, p: &P<N>) -> P<N> {
    // P is symmetric: its rows are its columns.
    let (mut half, mut whole) = ([[Lane::ZERO; N]; N], [[Lane::ZERO; N]; N]);
    for j in 0..N {
        let moved = motion.forward(local, &p[j]);
        for i in 0..N {
            half[i][j] = moved[i];
        }
    }
    for i in 0..N {
        whole[i] = motion.forward(local, &half[i]);
    }
    whole
}

#[inline(always)]
pub(crate) fn add_noise<const N: usize>(p: &mut P<N>, local: &Local<Lane>, levels: &NoiseModel<Lane>) {
    if let Flow::White { std } = levels.current {
        let variance = std * std;
        for (row, a) in p.iter_mut().zip(&local.slopes) {
            for (entry, b) in row.iter_mut().zip(&local.slopes) {
                *entry += variance * (a[0] * b[0] + a[1] * b[1]);
            }
        }
    }
    for (i, std, factor) in levels.processes::<N>() {
        add_draw(p, i, std * std * (Lane::ONE - factor * factor), levels.drift.is_some());
    }
}

/// Adds a draw of this variance of the process in state `i`; that of a sensor is measured at once.
#[inline(always)]
fn add_draw<const N: usize>(p: &mut P<N>, i: usize, variance: Lane, measured: bool) {
    p[i][i] += variance;
    if measured {
        let d = i + 3 - N;
        p[d][d] += variance;
        p[d][i] += variance;
        p[i][d] += variance;
    }
}
